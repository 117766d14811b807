"""Judges what was sent, after the fact, by code of its own: plain numpy and scipy, nothing of the gate.

Positions and lengths are compared with their limits directly; speeds and accelerations of axes and legs are
taken from differences of consecutive set-points, whatever the set-points say about themselves.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.spatial.transform import Rotation as Attitude

from otolith.core.arrays import Bools, Mat, Vec
from otolith.core.frames import AXES
from otolith.live.messages import State
from otolith.live.world import Row
from otolith.platforms import Platform
from otolith.platforms.axes import Rotation, Translation
from otolith.platforms.hexapod import Hexapod

ROUNDING: Final = 1e-3  # share of a limit that differences of set-points may show beyond it
SAME: Final = 1e-9  # [m, rad] poses that do not differ
ENGAGED_AT: Final = np.array([1e-3] * 3 + [np.radians(0.1)] * 3)  # first set-point and measured pose


@dataclass(frozen=True, slots=True)
class Violation:
    """One thing that must never happen, and when it first did."""

    what: str
    seconds: float
    value: float
    bound: float

    def __str__(self) -> str:
        """Return one sentence."""
        return f"{self.what} is {self.value:.6g} at {self.seconds:.3f} s, must be at most {self.bound:.6g}"


def audit(trace: Sequence[Row], platform: Platform) -> list[Violation]:
    """Return what a trace violates: at most the first of each kind."""
    time = np.array([1e-9 * row.time_ns for row in trace])
    motion = np.array([row.motion for row in trace])  # (n, 3, 6)
    cued = np.array([row.state in {State.ENGAGED, State.HOLDING} for row in trace])
    powered = np.array([row.moves and row.sent for row in trace])
    found = [*_axes(time, motion, cued, platform), *_moves(time, motion, powered)]
    if platform.hexapod is not None:
        found += _legs(time, motion[:, 0], powered, platform)
    found += _still(trace, time)
    return found + _first(trace, time)


def _axes(time: Vec, motion: Mat, cued: Bools, platform: Platform) -> list[Violation]:
    """Compare pose, speed and acceleration of every axis with the platform's file, where it is cued."""
    found = []
    pose = motion[:, 0]
    both = cued[1:] & cued[:-1]
    dt = np.diff(time)
    speed, strength = np.diff(pose, axis=0) / dt[:, None], np.diff(motion[:, 1], axis=0) / dt[:, None]
    for axis, name in enumerate(AXES):
        low, high, fastest, strongest = _limits(getattr(platform, name))
        found += _beyond(f"{name} [m, rad] above its reach", time, np.where(cued, pose[:, axis], low), high)
        found += _beyond(
            f"{name} [m, rad] below its reach", time, np.where(cued, -pose[:, axis], -high), -low
        )
        found += _beyond(f"speed of {name}", time[1:], np.where(both, abs(speed[:, axis]), 0.0), fastest)
        found += _beyond(
            f"acceleration of {name}", time[1:], np.where(both, abs(strength[:, axis]), 0.0), strongest
        )
    if platform.circle is not None:
        distance = np.where(cued, np.hypot(pose[:, 0], pose[:, 1]), 0.0)
        found += _beyond("surge and sway together [m]", time, distance, platform.circle)
    return found


def _limits(table: Translation | Rotation | None) -> tuple[float, float, float, float]:
    if table is None:
        return 0.0, 0.0, 0.0, 0.0
    if isinstance(table, Translation):
        return *table.position_m, table.velocity_mps, max(table.acceleration_mps2, table.command_mps2 or 0.0)
    low, high = np.radians(table.angle_deg)
    rates = (table.rate_degps, table.acceleration_degps2)
    fastest, strongest = (np.inf if rate is None else float(np.radians(rate)) for rate in rates)
    return float(low), float(high), fastest, strongest


def _moves(time: Vec, motion: Mat, powered: Bools) -> list[Violation]:
    """Compare the change of pose with the speeds that the set-points state: a jump shows here."""
    dt = np.diff(time)[:, None]
    both = powered[1:] & powered[:-1]
    mean = 0.5 * (motion[1:, 1] + motion[:-1, 1])
    bend = 0.25 * dt * np.abs(motion[1:, 2] - motion[:-1, 2])  # of a speed that is no straight line
    jump = np.abs(np.diff(motion[:, 0], axis=0) - dt * mean) - dt * bend
    return _beyond("jump of the set-point [m, rad]", time[1:], np.where(both, jump.max(axis=1), 0.0), 1e-6)


def _legs(time: Vec, pose: Mat, powered: Bools, platform: Platform) -> list[Violation]:
    hexapod = platform.six_legs()
    low, high = hexapod.stroke
    lengths = coordinates(pose, hexapod)
    dt = np.diff(time)
    speed = np.where((powered[1:] & powered[:-1])[:, None], np.diff(lengths, axis=0) / dt[:, None], 0.0)
    between = 0.5 * (dt[1:] + dt[:-1])  # mean speeds count half-way between two set-points
    strength = np.abs(np.diff(speed, axis=0)) / between[:, None]
    three = powered[2:] & powered[1:-1] & powered[:-2]
    longest = np.where(powered, lengths.max(axis=1), low)
    shortest = np.where(powered, lengths.min(axis=1), high)
    return [
        *_beyond("longest leg, or highest crank [m]", time, longest, high),
        *_beyond("shortest leg, or lowest crank [m], negative", time, -shortest, -low),
        *_beyond("speed of a leg [m/s]", time[1:], np.abs(speed).max(axis=1), hexapod.speed),
        *_beyond(
            "acceleration of a leg [m/s²]",
            time[2:],
            np.where(three, strength.max(axis=1), 0.0),
            hexapod.acceleration,
        ),
    ]


def coordinates(pose: Mat, hexapod: Hexapod) -> Mat:
    """Return leg lengths, or the arcs of cranks' tips, (n, 6) [m] of poses (n, 6); NaN out of a rod's reach.

    The angle of a crank solves f cos φ + e sin φ = g, with e, f and g of the usual form.
    """
    cranks = hexapod.cranks
    if cranks is None:
        return leg_lengths(pose, hexapod.joints, hexapod.anchors)
    ways = _ways(pose, hexapod.joints, hexapod.anchors)
    e, f = (np.einsum("nki,ik->ni", ways, one) for one in (cranks.quarter, cranks.zero))
    g = (np.sum(ways**2, axis=1) + cranks.radius**2 - cranks.rod**2) / (2.0 * cranks.radius)
    share = g / np.hypot(e, f)
    rise = np.arcsin(np.where(np.abs(share) <= 1.0, share, np.nan))
    angles = (rise if cranks.push else np.pi - rise) - np.arctan2(f, e)
    arcs: Mat = cranks.radius * ((angles + np.pi) % (2.0 * np.pi) - np.pi)
    return arcs


def leg_lengths(pose: Mat, joints: Mat, anchors: Mat) -> Mat:
    """Return leg lengths (n, 6) [m] of poses (n, 6), by scipy's rotations."""
    lengths: Mat = np.linalg.norm(_ways(pose, joints, anchors), axis=1)
    return lengths


def _ways(pose: Mat, joints: Mat, anchors: Mat) -> Mat:
    """Return the vectors (n, 3, 6) [m] from anchors to joints."""
    turned = Attitude.from_euler("ZYX", pose[:, 5:2:-1]).as_matrix() @ joints.T  # (n, 3, 6)
    ways: Mat = pose[:, :3, None] + turned - anchors.T
    return ways


def _still(trace: Sequence[Row], time: Vec) -> list[Violation]:
    """Nothing moves in idle, checking and parked; in fault no set-points are sent, or they brake."""
    speed = [
        float(np.abs(row.motion[1]).max()) if row.state in {State.IDLE, State.CHECKING, State.PARKED} else 0.0
        for row in trace
    ]
    return _beyond("speed of the set-point at rest", time, np.array(speed), 0.0)


def _first(trace: Sequence[Row], time: Vec) -> list[Violation]:
    """The first set-point that the device follows is the pose that it reported last."""
    far = np.zeros(len(trace))
    for k in range(1, len(trace)):
        if trace[k].moves and not trace[k - 1].moves:
            off = np.abs(trace[k].motion[0] - trace[k].reported) / ENGAGED_AT
            far[k] = float(off.max())
    return _beyond("first set-point from the measured pose, in tolerances", time, far, 1.0)


def _beyond(what: str, time: Vec, values: Vec, bound: float) -> list[Violation]:
    """Return the first value beyond a bound, if there is one."""
    room = ROUNDING * abs(bound) + SAME
    over = np.flatnonzero(~(values <= bound + room))
    if not len(over):
        return []
    worst = over[np.argmax(values[over])]
    return [Violation(what, float(time[over[0]]), float(values[worst]), float(bound))]
