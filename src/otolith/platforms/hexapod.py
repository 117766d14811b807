"""A six-legged platform: the legs of a pose, the pose of six legs, and the poses that are refused.

Legs either extend, or are rods of fixed length on cranks that turn. What a servo moves has one coordinate in
metres for both: the length of a linear leg, or the arc that a crank's tip has travelled from the zero angle,
which is radius times angle. Strokes, speeds, accelerations and forces are those of this coordinate.

Poses, twists and accelerations (6,) are those of `otolith.interfaces.PlatformState`: of the motion reference
point, relative to the neutral pose. Quaternions are used internally. `otolith.platforms.kinematics` has the
numerics.
"""

import math
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from otolith.core.arrays import Bools, Mat, Vec, freeze
from otolith.core.rotation import place_of, pose_of, velocity_of
from otolith.platforms.kinematics import (
    Actuators,
    forward,
    jacobians_along,
    leg_motion,
    lengths_along,
)
from otolith.platforms.unreachable import (
    CrankOutsideRange,
    LeansTooFar,
    LegOutsideStroke,
    NoPose,
    RodDoesNotReach,
    Singular,
)

TOLERANCE: Final = 1e-13  # [m] on leg lengths; double precision has 2e-16 at a metre
MOST: Final = 30  # largest number of Newton iterations; from the neutral pose 4 or 5 suffice
# Condition number of the scaled Jacobian of legs or rods of a singular pose or worse; good poses have 2 to 5
SINGULAR_CONDITION: Final = 50.0
# Share n·t of a tip's motion along its rod below which a crank counts as at its dead centre: 6 deg from it
DEAD_CENTRE: Final = 0.1


@dataclass(frozen=True, slots=True, kw_only=True)
class LegMotion:
    """The motion of the legs in a moving pose."""

    length: Vec  # (6,) [m] of linear legs; arcs of the tips of cranks
    speed: Vec  # (6,) [m/s]
    acceleration: Vec  # (6,) [m/s²]


@dataclass(frozen=True, slots=True, kw_only=True)
class Cranks:
    """Six cranks of equal size; each turns about a shaft and moves a rod of fixed length."""

    zero: Mat  # (6, 3) unit vectors along the cranks at angle 0, in world
    quarter: Mat  # (6, 3) unit vectors along them a quarter of a turn later
    radius: float  # [m] from the shaft to the rod's joint
    rod: float  # [m] from joint to joint
    push: bool = True  # whether growing angles push the rods (one branch) or pull them (the other)

    def __post_init__(self) -> None:
        freeze(self, zero=(6, 3), quarter=(6, 3))

    def plain(self) -> dict[str, Any]:
        """Return what drawing needs as plain JSON values, in m."""
        directions = {"zero": self.zero.tolist(), "quarter": self.quarter.tolist()}
        return directions | {"radius": self.radius, "rod": self.rod, "push": 1 if self.push else -1}


@dataclass(frozen=True, slots=True, kw_only=True)
class Drives:
    """How what drives the legs is told to people: as lengths of legs in m, or as angles of cranks in deg."""

    kind: str  # "leg" or "crank"
    unit: str  # m or deg
    size: float  # of one metre of a coordinate, in this unit
    span: tuple[float, float]  # lowest and highest, in this unit


@dataclass(frozen=True, slots=True, kw_only=True)
class Hexapod:
    """Six legs between a base and a platform; SI units, axes of `otolith.core.frames`.

    Examples
    --------
    >>> import numpy as np
    >>> from otolith.platforms import load
    >>> hexapod = load("davsi").six_legs()
    >>> pose = np.array([0.1, 0.0, -0.05, 0.0, 0.05, 0.1])
    >>> np.abs(hexapod.pose_of(hexapod.lengths(pose)) - pose).max() < 1e-12
    np.True_
    """

    joints: Mat  # (6, 3) [m] on the platform, from the reference point, in the platform's frame
    # (6, 3) [m] joints of linear legs on the base, or shafts of cranks, from the neutral reference point, in
    # world
    anchors: Mat
    head: Vec  # (3,) [m] of the driver, from the reference point, in the platform's frame
    stroke: tuple[float, float]  # [m] shortest and longest leg, or lowest and highest arc of a crank
    speed: float  # ± [m/s] of a leg
    acceleration: float  # ± [m/s²] of a leg
    force: float  # ± [N] of a leg
    leg_mass: float  # [kg] moving along each leg; of a crank its inertia over the square of its radius
    stiffness: float  # [N/m] of a leg's servo
    damping: float  # [N s/m] of a leg's servo
    mass: float  # [kg] of platform and payload
    centre: Vec  # (3,) [m] of mass, from the reference point, in the platform's frame
    inertia: Vec  # (3,) [kg m²] about the centre of mass, along the platform's axes
    lean_base: float = math.pi  # [rad] largest angle of a leg from the axis of its joint at the base …
    lean_platform: float = math.pi  # … and at the platform; π if the joints set no limit
    # Whether these axes are the z axes of base and platform instead of the neutral legs
    upright: bool = False
    cranks: Cranks | None = None  # None if the legs are linear

    def __post_init__(self) -> None:
        freeze(self, joints=(6, 3), anchors=(6, 3), head=(3,), centre=(3,), inertia=(3,))

    @property
    def size(self) -> float:
        """Return the mean distance [m] of the platform's joints from their centre, the arm of rotations."""
        return float(np.mean(np.linalg.norm(self.joints - self.joints.mean(axis=0), axis=1)))

    @property
    def lean(self) -> tuple[float, float]:
        """Return the largest angles [rad] of a leg at its base joint and at its platform joint."""
        return self.lean_base, self.lean_platform

    @property
    def actuators(self) -> Actuators:
        """Return the geometry as kernels take it."""
        cranks = self.cranks
        if cranks is None:
            none = np.zeros((6, 3))
            return Actuators(np.array([self.joints, self.anchors, none, none]), 0.0, 0.0, 1.0)
        places = np.array([self.joints, self.anchors, cranks.zero, cranks.quarter])
        return Actuators(places, cranks.radius, cranks.rod, 1.0 if cranks.push else -1.0)

    @property
    def drives(self) -> Drives:
        """Return how the drives of the legs are told to people."""
        low, high = self.stroke
        if self.cranks is None:
            return Drives(kind="leg", unit="m", size=1.0, span=(low, high))
        size = math.degrees(1.0 / self.cranks.radius)
        return Drives(kind="crank", unit="deg", size=size, span=(size * low, size * high))

    def angles(self, lengths: Mat) -> Mat:
        """Return the crank angles [rad] of coordinates [m] of any shape."""
        if self.cranks is None:
            raise ValueError("linear legs have no crank angles")
        return np.asarray(lengths, dtype=np.float64) / self.cranks.radius

    def positions(self, pose: Vec) -> Vec:
        """Return what the drives of a pose (6,) are told: leg lengths (6,) [m] or crank angles (6,) [rad]."""
        lengths = self.lengths(pose)
        return lengths if self.cranks is None else self.angles(lengths)

    def tips(self, lengths: Vec) -> Mat:
        """Return the lower ends (n, 6, 3) [m] of the legs with coordinates (n, 6), in world."""
        if self.cranks is None:
            return np.broadcast_to(self.anchors, (len(lengths), 6, 3))
        angles = self.angles(lengths)[..., None]
        along = np.cos(angles) * self.cranks.zero + np.sin(angles) * self.cranks.quarter
        tips: Mat = self.anchors + self.cranks.radius * along
        return tips

    def leans(self, poses: Mat) -> Mat:
        """Return how far (n, 2, 6) [rad] every leg leans at its joints, at base (or crank) and platform.

        Leaning is the angle from a joint's axis, see `joint_axes`; at a crank, the angle from the crank's
        plane.
        """
        poses = np.asarray(poses, dtype=np.float64)
        R = _rotations(poses).transpose(0, 2, 1)  # (n, 3, 3)
        legs = self.rods(poses)  # (n, 6, 3)
        lower, upper = self.joint_axes
        below = _between(np.broadcast_to(lower, legs.shape), legs)
        if self.cranks is not None:
            below = np.abs(0.5 * math.pi - below)
        return np.stack([below, _between(upper @ R, legs)], axis=1)

    @property
    def joint_axes(self) -> tuple[Mat, Mat]:
        """Return the axes (6, 3) from which leaning is counted: in world at the base, in the platform's frame
        above.

        A rod's joint on its crank turns freely about a bolt that is parallel to the shaft. There the axis is
        the shaft, and leaning is counted from the plane of the crank, at right angles to it.
        """
        axes = np.tile([0.0, 0.0, 1.0], (6, 1)) if self.upright else self.rods(np.zeros((1, 6)))[0]
        return (axes if self.cranks is None else np.cross(self.cranks.zero, self.cranks.quarter)), axes

    def rods(self, poses: Mat) -> Mat:
        """Return the vectors (n, 6, 3) [m] along legs, or rods of cranks, of poses (n, 6), from below."""
        R = _rotations(poses).transpose(0, 2, 1)
        rods: Mat = poses[:, None, :3] + self.joints @ R - self.tips(self.lengths(poses))
        return rods

    def lengths(self, pose: Vec) -> Vec:
        """Return the coordinates (6,) [m] of a pose (6,), or (n, 6) of poses (n, 6).

        Where the rod of a crank does not reach, the coordinate is NaN.
        """
        poses = np.ascontiguousarray(np.atleast_2d(pose), dtype=np.float64)
        lengths = np.empty(poses.shape)
        lengths_along(poses, self.actuators, lengths)
        return lengths.reshape(np.shape(pose))

    def leg_motion(self, pose: Vec, twist: Vec, acceleration: Vec) -> LegMotion:
        """Return lengths, speeds and accelerations of the legs of a pose in motion."""
        motion = np.empty((3, 6))
        leg_motion(pose, twist, acceleration, self.actuators, motion)
        return LegMotion(length=motion[0], speed=motion[1], acceleration=motion[2])

    def jacobian(self, pose: Vec) -> Mat:
        """Return J (6, 6) of leg speeds = J (v, ω), with velocity and angular rate in world."""
        jacobian: Mat = self._jacobians(np.asarray(pose)[None])[0]
        return jacobian

    def _jacobians(self, poses: Mat) -> Mat:
        poses = np.ascontiguousarray(poses, dtype=np.float64)
        jacobians = np.empty((len(poses), 6, 6))
        jacobians_along(poses, self.actuators, jacobians)
        return jacobians

    def pose_jacobian(self, pose: Vec) -> Mat:
        """Return ∂lengths/∂pose (6, 6), with roll, pitch and yaw instead of the angular rate."""
        E = np.empty((6, 6))
        for column, unit in zip(E.T, np.eye(6), strict=True):
            velocity = np.empty(6)
            velocity_of(np.asarray(pose, dtype=np.float64), unit, velocity)
            column[:] = velocity
        product: Mat = self.jacobian(pose) @ E
        return product

    def condition(self, pose: Vec) -> float:
        """Return the condition number [-] of the legs' Jacobian, with rotations as paths at the joints'
        radius.

        This scaling gives all entries one unit. Without it, the number would depend on the unit of length. Of
        cranks, it is that of their rods, as if these were legs that extend: `leverages` has the rest.
        """
        return float(self.conditions(np.asarray(pose)[None])[0])

    def conditions(self, poses: Mat) -> Vec:
        """Return the condition numbers (n,) of poses (n, 6), see `condition`; NaN if a rod does not reach."""
        jacobians, numbers = self.scaled_jacobians(poses), np.full(len(poses), np.nan)
        found = np.isfinite(jacobians).all(axis=(1, 2))
        numbers[found] = np.linalg.cond(jacobians[found])
        return numbers

    def scaled_jacobians(self, poses: Mat) -> Mat:
        """Return dimensionless Jacobians (n, 6, 6) of legs or rods, with rotations as paths at the joints."""
        jacobians = self._jacobians(poses)
        if self.cranks is not None:
            jacobians /= np.linalg.norm(jacobians[:, :, :3], axis=2, keepdims=True)
        scaled: Mat = jacobians / np.array([1.0, 1.0, 1.0, *[self.size] * 3])
        return scaled

    def leverages(self, poses: Mat) -> Mat:
        """Return |n·t| (n, 6): how much of the motion of a crank's tip is along its rod; 1 for linear legs.

        It is 0 at the dead centre of a crank, where its two branches meet and its rod reaches no further.
        """
        if self.cranks is None:
            return np.ones((len(poses), 6))
        leverages: Mat = 1.0 / np.linalg.norm(self._jacobians(poses)[:, :, :3], axis=2)
        return leverages

    def pose_of(self, lengths: Vec, near: Vec | None = None) -> Vec:
        """Return the pose (6,) of leg lengths (6,) [m] that Newton's method reaches from `near`.

        The default of `near` is the neutral pose.

        Raises
        ------
        NoPose : there is none nearby, or it is singular.
        """
        place = np.empty(7)
        place_of(np.zeros(6) if near is None else np.asarray(near, dtype=np.float64), place)
        wanted = np.asarray(lengths, dtype=np.float64)
        outcome = forward(wanted, self.actuators, place, TOLERANCE, MOST)
        if outcome < 0:
            why = "is singular on the way" if outcome == -1 else f"was found in {MOST} Newton steps"
            shown = ", ".join(f"{length:.4f}" for length in wanted)
            raise NoPose(f"no pose of the leg lengths {shown} m {why}")
        pose = np.empty(6)
        pose_of(place, pose)
        return pose

    def reaches(self, poses: Mat) -> Bools:
        """Return for each pose (n, 6) whether the legs can make and hold it (n,).

        Every leg must be within its stroke and lean no further than its joints allow, the condition number
        must be below `SINGULAR_CONDITION`, and the Jacobian's determinant must have the same sign as in the
        neutral pose: between poses of different signs lies one in which the legs hold nothing. No crank may
        be at its dead centre.
        """
        poses = np.asarray(poses, dtype=np.float64)
        lengths, (low, high) = self.lengths(poses), self.stroke
        found: Bools = np.all((lengths >= low) & (lengths <= high), axis=-1)
        found[found] = self.holds(poses[found])
        return found

    def holds(self, poses: Mat) -> Bools:
        """Return for each pose (n, 6) whether no joint leans too far and the Jacobian is regular (n,)."""
        jacobians, neutral = self.scaled_jacobians(poses), self.scaled_jacobians(np.zeros((1, 6)))
        firm = np.linalg.cond(jacobians) < SINGULAR_CONDITION
        same: Bools = firm & (np.sign(np.linalg.det(jacobians)) == np.sign(np.linalg.det(neutral)))
        if self.cranks is not None:
            same &= np.all(self.leverages(poses) > DEAD_CENTRE, axis=1)
        if min(self.lean) < math.pi:
            same &= np.all(self.leans(poses) <= np.array(self.lean)[:, None], axis=(1, 2))
        return same

    def check(self, pose: Vec, *, condition: float = SINGULAR_CONDITION) -> None:
        """Refuse a pose that the legs cannot make or hold.

        Raises
        ------
        LegOutsideStroke, CrankOutsideRange : names the actuator that is furthest beyond its range.
        RodDoesNotReach : names a crank of which no angle, or only one near its dead centre, serves.
        LeansTooFar : names the leg that leans furthest beyond its joint's limit.
        Singular : the condition number is not below `condition`.
        """
        pose = np.asarray(pose, dtype=np.float64)
        self._check_range(self.lengths(pose))
        if self.cranks is not None:
            leverages = self.leverages(pose[None])[0]
            if not leverages.min() > DEAD_CENTRE:
                raise RodDoesNotReach(
                    int(np.argmin(leverages)), leverage=float(leverages.min()), bound=DEAD_CENTRE
                )
        for joint, leans, most in zip(
            ("base", "platform"), self.leans(pose[None])[0], self.lean, strict=True
        ):
            if not leans.max() <= most:
                raise LeansTooFar(int(np.argmax(leans)), joint, float(leans.max()), most)
        found = self.condition(pose)
        if not found < condition:
            raise Singular(found, condition)

    def _check_range(self, lengths: Vec) -> None:
        low, high = self.stroke
        beyond = np.maximum(low - lengths, lengths - high)
        worst = int(np.argmax(np.where(np.isnan(beyond), np.inf, beyond)))
        if beyond[worst] <= 0.0:
            return
        if self.cranks is None:
            raise LegOutsideStroke(worst, float(lengths[worst]), self.stroke)
        if math.isnan(lengths[worst]):
            raise RodDoesNotReach(worst)
        angle, low, high = (one / self.cranks.radius for one in (float(lengths[worst]), *self.stroke))
        raise CrankOutsideRange(worst, angle, (low, high))


def _rotations(poses: Mat) -> Mat:
    """Return the rotations (n, 3, 3) from the platform's frame to world of poses (n, 6): yaw, pitch, roll."""
    (r, p, y), (R, P, Y) = np.cos(poses[:, 3:].T), np.sin(poses[:, 3:].T)
    rows = [
        [y * p, y * P * R - Y * r, y * P * r + Y * R],
        [Y * p, Y * P * R + y * r, Y * P * r - y * R],
        [-P, p * R, p * r],
    ]
    return np.moveaxis(np.array(rows), -1, 0)


def _between(axes: Mat, legs: Mat) -> Mat:
    """Return the angles (n, 6) [rad] between vectors (n, 6, 3), by the tangent: exact if small."""
    across = np.linalg.norm(np.cross(axes, legs), axis=-1)
    angles: Mat = np.arctan2(across, np.sum(axes * legs, axis=-1))
    return angles
