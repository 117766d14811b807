"""Six cranks as a platform file describes them: motors that turn, and rods of fixed length to the platform.

A crank is told by the place of its shaft, by where it points at the angle 0, by its own length and by that of
its rod. Most rigs have level shafts, so that a direction in the plan is enough; shafts of any direction are
given as vectors.
"""

import math
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, model_validator

from otolith.core.arrays import Mat, Vec
from otolith.platforms.bounds import Within, refuse
from otolith.platforms.hexapod import Cranks

_ANGLE = Within(3.2, 175.0, "deg", "rad")  # 175 deg are 3.05 rad
_PERPENDICULAR = 1e-6  # largest cosine between a shaft and the crank on it
UP = np.array([0.0, 0.0, 1.0])


def _range(value: object) -> tuple[float, float]:
    """Return the lowest and highest angle [deg]; one number x means ±x."""
    if not isinstance(value, list | tuple):
        number = _ANGLE.number(value)
        return -number, number
    if len(value) != 2:
        raise refuse("one number, or [lowest, highest], in deg")
    low, high = (_ANGLE.finite(end) for end in value)
    for end in (low, high):
        if end != 0.0:
            _ANGLE.number(abs(end))
    if not low < high:
        raise refuse("[lowest, highest] with lowest < highest, in deg")
    return low, high


def _six_angles(value: object) -> tuple[float, ...]:
    if not isinstance(value, list | tuple) or len(value) != 6:
        raise refuse("six directions, in deg")
    angles = tuple(_ANGLE.finite(angle) for angle in value)
    if max(abs(angle) for angle in angles) > 360.0:
        raise refuse("six directions within ±360 deg")
    if min(angles) < max(angles) and max(abs(angle) for angle in angles) <= 2.0 * math.pi:
        raise refuse("six directions in deg, of which one at least is above 6.3 (are they in rad?)")
    return angles


def _six_directions(value: object) -> tuple[tuple[float, ...], ...]:
    if not isinstance(value, list | tuple) or len(value) != 6:
        raise refuse("six directions [x, y, z]")
    return tuple(_direction(one) for one in value)


def _direction(value: object) -> tuple[float, ...]:
    if not isinstance(value, list | tuple) or len(value) != 3:
        raise refuse("six directions [x, y, z]")
    direction = np.array([Within(0.0, 0.0, "").finite(one) for one in value])
    length = float(np.linalg.norm(direction))
    if not 1e-3 < length < 1e3:
        raise refuse("six directions [x, y, z], each of a length between 0.001 and 1000")
    return tuple((direction / length).tolist())


CrankRadius = Annotated[float, BeforeValidator(Within(0.005, 2.0, "m", "", "mm").number)]  # [m]
Rod = Annotated[float, BeforeValidator(Within(0.02, 5.0, "m", "", "mm").number)]  # [m]
Range = Annotated[tuple[float, float], BeforeValidator(_range)]  # [deg]
Zero = Annotated[float, BeforeValidator(Within(-90.0, 90.0, "deg").finite)]  # [deg]
Six = Annotated[tuple[float, ...], BeforeValidator(_six_angles)]  # [deg]
Directions = Annotated[tuple[tuple[float, ...], ...], BeforeValidator(_six_directions)]
# In radians, the lower bounds are 3 turns per second and 16 turns per second²: faster than rigs turn.
CrankSpeed = Annotated[float, BeforeValidator(Within(20.0, 10_000.0, "deg/s", "rad/s").number)]
CrankAcceleration = Annotated[float, BeforeValidator(Within(100.0, 1e6, "deg/s2", "rad/s2").number)]
Torque = Annotated[float, BeforeValidator(Within(0.05, 1e5, "N m").number)]
CrankInertia = Annotated[float, BeforeValidator(Within(1e-6, 1e3, "kg m2").number)]
CrankStiffness = Annotated[float, BeforeValidator(Within(1.0, 1e9, "N m/rad").number)]
CrankDamping = Annotated[float, BeforeValidator(Within(0.01, 1e8, "N m s/rad").number)]


class CrankTable(BaseModel):
    """The table `[hexapod.cranks]`: six equal cranks, their limits and their servos.

    Where they point at angle 0 is told in one of three ways: `points`, along the line through the two shafts
    of a pair, away from each other or towards each other; `heading_deg`, six directions in the plan, from
    forward to the left; or `shaft` and `zero`, six vectors each. The first two have level shafts, and
    positive angles raise the crank.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    radius_m: CrankRadius  # from the shaft to the rod's joint on the crank
    rod_m: Rod  # from this joint to the platform's
    points: Literal["apart", "together"] | None = None
    heading_deg: Six | None = None
    shaft: Directions | None = None  # positive angles turn right-handed about it
    zero: Directions | None = None  # along the crank at angle 0
    zero_deg: Zero = 0.0  # of level shafts: how far a crank points above the horizontal at angle 0
    branch: Literal["push", "pull"] = "push"  # whether growing angles push the rod, or pull it
    angle_deg: Range  # (lowest, highest)
    speed_degps: CrankSpeed  # ±
    acceleration_degps2: CrankAcceleration  # ±
    torque_nm: Torque  # ± at the shaft, behind the gear
    inertia_kgm2: CrankInertia  # of crank, gear and motor, as felt at the shaft
    stiffness_nmprad: CrankStiffness  # of the servo, at the shaft
    damping_nmsprad: CrankDamping

    @model_validator(mode="after")
    def _must_point(self) -> Self:
        given = [name for name in ("points", "heading_deg", "shaft") if getattr(self, name) is not None]
        if len(given) != 1:
            found = "missing" if not given else f"{' and '.join(given)} given"
            raise refuse("one of points, heading_deg and shaft", field="where the cranks point", value=found)
        if (self.shaft is None) is not (self.zero is None):
            missing = "zero" if self.zero is None else "shaft"
            raise refuse("given: shaft and zero belong together", field=missing, value="missing")
        if self.shaft is not None and self.zero is not None:
            slant = np.abs(np.sum(np.array(self.shaft) * np.array(self.zero), axis=1))
            if slant.max() > _PERPENDICULAR:
                off = math.degrees(math.asin(min(1.0, float(slant.max()))))
                raise refuse("at right angles to shaft", field="zero", value=f"{off:.3g} deg off")
            if self.zero_deg != 0.0:
                raise refuse("left out: only level shafts have one", field="zero_deg", value=self.zero_deg)
        return self

    def cranks(self, shafts: Mat) -> Cranks:
        """Return the cranks on shafts at points (6, 3) [m]."""
        zero, quarter = self._directions(shafts)
        return Cranks(
            zero=zero, quarter=quarter, radius=self.radius_m, rod=self.rod_m, push=self.branch == "push"
        )

    def _directions(self, shafts: Mat) -> tuple[Mat, Mat]:
        """Return the directions (6, 3) of the cranks at angle 0 and a quarter of a turn later."""
        if self.shaft is not None and self.zero is not None:
            zero = np.array(self.zero)
            return zero, np.cross(np.array(self.shaft), zero)
        level, tilt = self._level(shafts), math.radians(self.zero_deg)
        c, s = math.cos(tilt), math.sin(tilt)
        return c * level + s * UP, c * UP - s * level

    def _level(self, shafts: Mat) -> Mat:
        """Return level unit vectors (6, 3) along the plan of the cranks."""
        if self.heading_deg is not None:
            headings = np.radians(self.heading_deg)
            return np.column_stack([np.cos(headings), np.sin(headings), np.zeros(6)])
        partner = shafts.reshape(3, 2, 3)[:, ::-1].reshape(6, 3)
        apart: Vec = (shafts - partner) * [1.0, 1.0, 0.0]
        lengths = np.linalg.norm(apart, axis=1, keepdims=True)
        if not lengths.min() > 0.0:
            raise refuse(
                "two different shafts in each pair, or heading_deg", field="points", value=self.points
            )
        level: Mat = apart / lengths
        return level if self.points == "apart" else -level

    def limits(self) -> dict[str, float | tuple[float, float]]:
        """Return limits and servo along the paths of the tips, in the fields of `Hexapod`."""
        rho, (low, high) = self.radius_m, (math.radians(end) for end in self.angle_deg)
        return {
            "stroke": (rho * low, rho * high),
            "speed": rho * math.radians(self.speed_degps),
            "acceleration": rho * math.radians(self.acceleration_degps2),
            "force": self.torque_nm / rho,
            "leg_mass": self.inertia_kgm2 / rho**2,
            "stiffness": self.stiffness_nmprad / rho**2,
            "damping": self.damping_nmsprad / rho**2,
        }
