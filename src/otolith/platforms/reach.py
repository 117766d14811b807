"""Where six legs can go: along each axis alone, across two axes at once, and how firmly they stand there.

The ranges of single axes are what data sheets print. They are not the workspace: the cuts show how one
axis takes from another.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from otolith.core.arrays import Bools, Mat, Vec
from otolith.core.frames import AXES
from otolith.core.jit import kernel
from otolith.core.motion import place_of
from otolith.platforms.hexapod import Hexapod
from otolith.platforms.kinematics import inverse

FAR: Final = (6.0, 6.0, 6.0, 1.5, 1.5, 1.5)  # [m, rad] where the search along an axis ends
STRIDES: Final = 600  # of the search; a leg may leave its stroke and come back only beyond one
BEYOND: Final = 1.25  # times the single ranges that a cut shows
HALVINGS: Final = 45  # of a stride, to 1e-15 m
CUTS: Final = (
    ("surge", "pitch"),
    ("sway", "roll"),
    ("surge", "sway"),
    ("surge", "heave"),
    ("roll", "pitch"),
    ("heave", "yaw"),
)


@kernel
def _within(pose: Vec, joints: Mat, anchors: Mat, low: float, high: float) -> bool:
    place, lengths = np.empty(7), np.empty(6)
    place_of(pose, place)
    inverse(place, joints, anchors, lengths, np.empty((6, 6)), np.empty((6, 3)))
    outside = 0
    for i in range(6):
        if not low <= lengths[i] <= high:  # so written, a NaN is outside
            outside += 1
    return outside == 0


@kernel
def excursion(
    joints: Mat, anchors: Mat, stroke: tuple[float, float], axis: int, far: float, strides: int
) -> float:
    """How far [m or rad] one axis goes from the neutral pose towards `far` before a leg ends; with its sign.

    Zero where the neutral pose itself is out of reach.
    """
    low, high = stroke
    pose, reached = np.zeros(6), 0.0
    if not _within(pose, joints, anchors, low, high):
        return 0.0
    for k in range(1, strides + 1):
        pose[axis] = far * k / strides
        if not _within(pose, joints, anchors, low, high):
            beyond = pose[axis]
            for _ in range(HALVINGS):
                pose[axis] = 0.5 * (reached + beyond)
                if _within(pose, joints, anchors, low, high):
                    reached = pose[axis]
                else:
                    beyond = pose[axis]
            return reached
        reached = pose[axis]
    return reached


def reach(hexapod: Hexapod) -> dict[str, tuple[float, float]]:
    """Lowest and highest position [m or rad] of every axis moving alone from the neutral pose."""
    return {
        axis: (
            excursion(hexapod.joints, hexapod.anchors, hexapod.stroke, i, -FAR[i], STRIDES),
            excursion(hexapod.joints, hexapod.anchors, hexapod.stroke, i, FAR[i], STRIDES),
        )
        for i, axis in enumerate(AXES)
    }


def axis_speeds(hexapod: Hexapod) -> Vec:
    """Leg speed (6,) that a speed of 1 m/s or 1 rad/s of each axis needs in the neutral pose."""
    speeds: Vec = np.abs(hexapod.pose_jacobian(np.zeros(6))).max(axis=0)
    return speeds


@dataclass(frozen=True, slots=True, kw_only=True)
class Cut:
    """The workspace across two axes, the other four neutral."""

    axes: tuple[str, str]
    first: Vec  # (n,) [m or rad] of the first axis
    second: Vec  # (m,) of the second
    inside: Bools  # (m, n) whether every leg is within its stroke
    condition: Mat  # (m, n) condition number of the Jacobian, nan outside


def cut(hexapod: Hexapod, axes: tuple[str, str], *, n: int = 81) -> Cut:
    """The workspace across two axes on a grid of n × n poses, a little beyond their single ranges."""
    ranges = reach(hexapod)
    first, second = (np.linspace(BEYOND * ranges[axis][0], BEYOND * ranges[axis][1], n) for axis in axes)
    poses = np.zeros((n, n, 6))
    poses[:, :, AXES.index(axes[0])] = first
    poses[:, :, AXES.index(axes[1])] = second[:, None]
    inside = hexapod.reaches(poses.reshape(-1, 6)).reshape(n, n)
    condition = np.full((n, n), np.nan)
    condition[inside] = hexapod.conditions(poses[inside])
    return Cut(axes=axes, first=first, second=second, inside=inside, condition=condition)


def box_share(hexapod: Hexapod, *, samples: int = 20_000, seed: int = 0) -> float:
    """Share of the box of all single ranges that the legs can reach; it is small, which is the point."""
    ranges = np.array(list(reach(hexapod).values()))
    poses = np.random.default_rng(seed).uniform(ranges[:, 0], ranges[:, 1], (samples, 6))
    return float(np.mean(hexapod.reaches(poses)))
