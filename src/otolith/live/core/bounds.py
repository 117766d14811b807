"""The limits of a platform as the gate reads them, and the room that a park pose needs besides."""

import math
from typing import Any, Final, NamedTuple

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.frames import AXES, DOFS, Dof
from otolith.platforms import Platform
from otolith.platforms.axes import Rotation, Translation
from otolith.safety.law import Reach

SPEED: Final = np.array([0.2] * 3 + [0.1] * 3)  # [m/s, rad/s] of moves from and to rest …
ACCELERATION: Final = np.array([1.0] * 3 + [0.5] * 3)  # … and [m/s², rad/s²]
PAD: Final = np.array([2e-3] * 3 + [3.5e-3] * 3)  # [m, rad] around a park pose, to brake in


class Bounds(NamedTuple):
    """The limits, in a form that kernels can read; what a platform's file does not give is infinite."""

    low: Vec  # (6,) [m ×3, rad ×3]
    high: Vec  # (6,)
    twist: Vec  # (6,) [m/s ×3, rad/s ×3]
    acceleration: Vec  # (6,) [m/s² ×3, rad/s² ×3]
    jerk: Vec  # (6,) [m/s³ ×3, rad/s³ ×3]
    lag: float  # T [s]
    circle: float  # [m] of surge and sway together
    joints: Mat  # (6, 3) [m], or (0, 3) without legs
    anchors: Mat  # (6, 3) [m]
    stroke: tuple[float, float]  # [m]
    leg_speed: float  # [m/s]
    leg_acceleration: float  # [m/s²]
    # (4, 6, 3) unit vectors: along the cranks at angle 0 and a quarter of a turn later, in world; those from
    # which legs lean, in world below and in the platform's frame above
    frames: Mat
    radius: float  # [m] of the cranks; 0 for linear legs
    rod: float  # [m]
    push: float  # +1 if growing angles push the rods, −1 if they pull them
    lean: tuple[float, float]  # [rad] largest angles from these, below and above; π if there is no limit


def dofs_of(platform: Platform) -> tuple[Dof, ...]:
    """Return the degrees of freedom for which the platform's file gives all axes and limits."""
    return tuple(
        dof
        for dof in DOFS.values()
        if all(AXES[axis] in platform.axes for axis in dof.axes) and (dof.is_pair or _limited(platform, dof))
    )


def _limited(platform: Platform, dof: Dof) -> bool:
    table = getattr(platform, AXES[dof.axes[0]])
    if isinstance(table, Translation):
        return True
    return table.rate_degps is not None and table.acceleration_degps2 is not None


def bounds_of(platform: Platform, lag: float) -> Bounds:
    """Return the machine's limits; axes that nothing moves stay at zero."""
    low, high, twist, acceleration, jerk = np.zeros((5, 6))
    for axis in {axis for dof in dofs_of(platform) for axis in dof.axes}:
        table = getattr(platform, AXES[axis])
        low[axis], high[axis], twist[axis], acceleration[axis] = _of(table)
        jerk[axis] = 2.0 * acceleration[axis] / lag if lag > 0.0 else math.inf
    circle = math.inf if platform.circle is None else platform.circle
    if platform.hexapod is None:
        return Bounds(low, high, twist, acceleration, jerk, lag, circle, *_no_legs())
    hexapod = platform.six_legs()
    of, axes = hexapod.actuators, np.array(hexapod.joint_axes)
    legs = (hexapod.joints, hexapod.anchors, hexapod.stroke, hexapod.speed, hexapod.acceleration)
    frames = np.concatenate([of.places[2:], axes / np.linalg.norm(axes, axis=2, keepdims=True)])
    cranks = (frames, of.radius, of.rod, of.push, hexapod.lean)
    return Bounds(low, high, twist, acceleration, jerk, lag, circle, *legs, *cranks)


def _no_legs() -> tuple[Any, ...]:
    """Return what stands in for the fields of legs where there are none."""
    none = np.empty((0, 3))
    legs = (none, none, (-math.inf, math.inf), math.inf, math.inf)
    return *legs, np.empty((4, 0, 3)), 0.0, 0.0, 1.0, (math.pi, math.pi)


def _of(table: Translation | Rotation) -> tuple[float, float, float, float]:
    """Return the ends of an axis, its speed and its acceleration in SI units."""
    if isinstance(table, Translation):
        strongest = max(table.acceleration_mps2, table.command_mps2 or 0.0)
        return *table.position_m, table.velocity_mps, strongest
    low, high = (math.radians(end) for end in table.angle_deg)
    rate = math.inf if table.rate_degps is None else math.radians(table.rate_degps)
    strongest = math.inf if table.acceleration_degps2 is None else math.radians(table.acceleration_degps2)
    return low, high, rate, strongest


def widened(bounds: Bounds, park: Vec) -> Bounds:
    """Return bounds that contain a pose; an axis that only this pose needs moves gently."""
    new = (park != 0.0) & (bounds.twist == 0.0)
    low, high = _room(bounds.low, bounds.high, park)
    return bounds._replace(
        low=low,
        high=high,
        twist=np.where(new, SPEED, bounds.twist),
        acceleration=np.where(new, ACCELERATION, bounds.acceleration),
        jerk=np.where(new, math.inf, bounds.jerk),
        circle=max(bounds.circle, math.hypot(park[0], park[1]) + PAD[0]),
    )


def widened_reach(reach: Reach, park: Vec) -> Reach:
    """Return the law's limits of axes with a reach that contains a pose; see `widened`."""
    new = (park != 0.0) & (reach.command == 0.0)
    low, high = _room(np.where(new, 0.0, reach.low), np.where(new, 0.0, reach.high), park)
    return reach._replace(
        low=low,
        high=high,
        speed=np.where(new, SPEED, reach.speed),
        command=np.where(new, ACCELERATION, reach.command),
        circle=max(reach.circle, math.hypot(park[0], park[1]) + PAD[0]),
    )


def _room(low: Vec, high: Vec, park: Vec) -> tuple[Vec, Vec]:
    """Return a reach that contains a pose and the neutral one, each with a little room along its axes."""
    pad = np.where(park != 0.0, PAD, 0.0)
    return np.minimum(low, np.minimum(park, 0.0) - pad), np.maximum(high, np.maximum(park, 0.0) + pad)
