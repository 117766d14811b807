"""Six legs as a platform file describes them, and the resulting hexapod.

Legs are linear, or rods on cranks (`otolith.platforms.crank_table`). Joints are given either as two circles
of three pairs each, or as twelve points, which covers both symmetric machines from a catalogue and irregular
rigs. They are checked like the rest of the file: an error is one sentence with field, value, bound and unit.
"""

import math
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator

from otolith.core.arrays import Mat, Vec
from otolith.platforms.bounds import Radius, Within, refuse
from otolith.platforms.crank_table import CrankTable
from otolith.platforms.hexapod import DEAD_CENTRE, SINGULAR_CONDITION, Hexapod

_LENGTH = Within(0.05, 20.0, "m", "km", "mm")
_POINT_M = 20.0  # [m] largest coordinate of a point


def _span(value: object) -> tuple[float, float]:
    """Return the shortest and longest length of a leg [m]."""
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise refuse("[shortest, longest], in m")
    low, high = (_LENGTH.number(end) for end in value)
    if not low < high:
        raise refuse("[shortest, longest] with shortest < longest, in m")
    return low, high


def _point(value: object) -> tuple[float, float, float]:
    """Return three coordinates [m]."""
    if not isinstance(value, list | tuple) or len(value) != 3:
        raise refuse("a point [x, y, z], in m")
    x, y, z = (_LENGTH.finite(coordinate) for coordinate in value)
    if max(abs(x), abs(y), abs(z)) > _POINT_M:
        raise refuse(f"a point within {_POINT_M:g} m (is it in mm?)")
    return x, y, z


def _six_points(value: object) -> tuple[tuple[float, float, float], ...]:
    if not isinstance(value, list | tuple) or len(value) != 6:
        raise refuse("six points [x, y, z], in m")
    return tuple(_point(point) for point in value)


def _three_inertias(value: object) -> tuple[float, float, float]:
    if not isinstance(value, list | tuple) or len(value) != 3:
        raise refuse("[roll, pitch, yaw], in kg m2")
    kind = Within(1e-3, 1e6, "kg m2")
    x, y, z = (kind.number(moment) for moment in value)
    if max(x, y, z) > x + y + z - max(x, y, z):
        raise refuse("moments of which none exceeds the sum of the others, as of any body")
    return x, y, z


Span = Annotated[tuple[float, float], BeforeValidator(_span)]  # [m]
Point = Annotated[tuple[float, float, float], BeforeValidator(_point)]  # [m]
SixPoints = Annotated[tuple[tuple[float, float, float], ...], BeforeValidator(_six_points)]  # [m]
Inertias = Annotated[tuple[float, float, float], BeforeValidator(_three_inertias)]  # [kg m²]
Height = Annotated[float, BeforeValidator(_LENGTH.number)]  # [m]
# In radians, 180 and 59 deg are 3.14 and 1.03: below the lower bounds, so that no such angle passes.
Cone = Annotated[float, BeforeValidator(Within(3.2, 180.0, "deg", "rad").number)]  # [deg] from the axis
HalfAngle = Annotated[float, BeforeValidator(Within(1.05, 59.0, "deg", "rad").number)]  # [deg]
Spacing = Annotated[float, BeforeValidator(Within(60.0, 150.0, "deg", "rad").number)]  # [deg]
LegSpeed = Annotated[float, BeforeValidator(Within(0.005, 20.0, "m/s", "km/s", "mm/s").number)]  # [m/s]
LegAcceleration = Annotated[float, BeforeValidator(Within(0.05, 200.0, "m/s2", "", "mm/s2").number)]  # [m/s²]
Force = Annotated[float, BeforeValidator(Within(1.0, 1e6, "N", "kN").number)]  # [N]
Mass = Annotated[float, BeforeValidator(Within(0.05, 1e5, "kg", "t").number)]  # [kg]
Stiffness = Annotated[float, BeforeValidator(Within(10.0, 1e10, "N/m", "N/mm").number)]  # [N/m]
Damping = Annotated[float, BeforeValidator(Within(1.0, 1e9, "N s/m", "N s/mm").number)]  # [N s/m]


class _Table(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)


class Circles(_Table):
    """Joints in three pairs on two circles; a platform pair faces a gap between two base pairs.

    With `forward` = "platform" a platform pair points forward and a base pair backward; with "base" it is the
    other way round. `spacing_deg` is the angle from the pair on the symmetry plane to each of the other two.
    """

    base_radius_m: Radius
    base_half_angle_deg: HalfAngle  # half the angle of one pair, seen from the centre
    platform_radius_m: Radius
    platform_half_angle_deg: HalfAngle
    base_spacing_deg: Spacing = 120.0
    platform_spacing_deg: Spacing = 120.0
    forward: Literal["platform", "base"] = "platform"

    def points(self) -> tuple[Mat, Mat]:
        """Return base and platform joints (6, 3) [m], each in its circle's plane; leg k joins the k-th."""
        turn = 0.0 if self.forward == "platform" else 180.0
        p, s = self.platform_half_angle_deg, self.platform_spacing_deg
        b, t = self.base_half_angle_deg, self.base_spacing_deg
        on_platform = [p, s - p, s + p, -s - p, -s + p, -p]
        on_base = [180 - t - b, 180 - t + b, 180 - b, 180 + b, 180 + t - b, 180 + t + b]
        return (
            _on_circle(self.base_radius_m, np.array(on_base) + turn),
            _on_circle(self.platform_radius_m, np.array(on_platform) + turn),
        )


class Joints(_Table):
    """Twelve joints as points about the base's and the platform's own centre; leg k joins the k-th two.

    On the base of a machine with cranks, they are the centres of the shafts, each in the plane of its crank.
    """

    base_m: SixPoints
    platform_m: SixPoints

    def points(self) -> tuple[Mat, Mat]:
        """Return base and platform joints (6, 3) [m]."""
        return np.array(self.base_m), np.array(self.platform_m)


class JointAngles(_Table):
    """How far the legs may lean in their joints: a cone about each joint's axis.

    A ball or universal joint is mounted in some direction and can turn away from it only by a limited angle.
    With `about` = "neutral" the direction is that of its leg in the neutral pose. With "normal" it is the z
    axis, of the base for base joints and of the platform for platform joints.

    A rod's joint on its crank turns freely about a bolt that is parallel to the shaft. There `base_deg` is
    how far the rod may lean out of the plane of its crank, whatever `about` says.
    """

    base_deg: Cone = 180.0
    platform_deg: Cone = 180.0
    about: Literal["neutral", "normal"] = "neutral"


class Legs(_Table):
    """The limits of each leg, and its servo: force = stiffness · error + damping · speed error + weight."""

    length_m: Span  # [shortest, longest]
    speed_mps: LegSpeed  # ± [m/s]
    acceleration_mps2: LegAcceleration  # ± [m/s²]
    force_n: Force  # ± [N]
    mass_kg: Mass  # [kg] mass of rod and drive that moves along the leg
    stiffness_npm: Stiffness  # [N/m]
    damping_nspm: Damping  # [N s/m]


class Payload(_Table):
    """Everything that moves with the platform, as one rigid body."""

    mass_kg: Mass
    centre_m: Point  # centre of mass, from the motion reference point
    inertia_kgm2: Inertias  # [roll, pitch, yaw] about the centre of mass


class HexapodTable(_Table):
    """The table `[hexapod]` of a platform file."""

    source: str = Field(default="", max_length=200)  # origin of the geometry, if it needs an explanation
    # Whether the legs belong to another machine and serve only the plants; no figure shows them
    lent: bool = False
    neutral_height_m: Height  # height of the platform joints' centre above the base joints' centre
    reference_point_m: Point = (0.0, 0.0, 0.0)  # motion reference point, from the platform joints' centre
    head_m: Point | None = None  # the driver's head, from the motion reference point
    circles: Circles | None = None
    joints: Joints | None = None
    joint_angles: JointAngles | None = None
    legs: Legs | None = None
    cranks: CrankTable | None = None
    payload: Payload

    @model_validator(mode="after")
    def _must_stand(self) -> Self:
        hexapod = self.hexapod()
        lengths, (low, high) = hexapod.lengths(np.zeros(6)), hexapod.stroke
        if self.cranks is not None:
            _must_turn(hexapod, self.cranks, lengths)
        elif not (low < lengths.min() and lengths.max() < high):
            shown = f"{lengths.min():.4g} to {lengths.max():.4g} m long"
            raise refuse(f"within {low:g} to {high:g} m", field="legs in the neutral pose", value=shown)
        leans = np.degrees(hexapod.leans(np.zeros((1, 6)))[0])
        for name, found, most in zip(("base", "platform"), leans, np.degrees(hexapod.lean), strict=True):
            if not found.max() < most:
                shown, bound = f"{found.max():.3g} deg", f"below {most:g} deg"
                raise refuse(bound, field=f"leaning at the {name}'s joints in the neutral pose", value=shown)
        condition = hexapod.condition(np.zeros(6))
        if not condition < SINGULAR_CONDITION:
            bound = f"below {SINGULAR_CONDITION:g}: such legs cannot hold the platform"
            raise refuse(bound, field="condition number in the neutral pose", value=f"{condition:.3g}")
        return self

    def _limits(self) -> dict[str, Any]:
        """Return limits and servo of the legs, or cranks, in the fields of `Hexapod`."""
        if self.cranks is not None:
            return self.cranks.limits()
        if self.legs is None:
            return {}
        return {
            "stroke": self.legs.length_m,
            "speed": self.legs.speed_mps,
            "acceleration": self.legs.acceleration_mps2,
            "force": self.legs.force_n,
            "leg_mass": self.legs.mass_kg,
            "stiffness": self.legs.stiffness_npm,
            "damping": self.legs.damping_nspm,
        }

    def _points(self) -> tuple[Mat, Mat]:
        geometry = self.circles or self.joints
        if geometry is None or (self.circles and self.joints):
            found = "absent" if geometry is None else "both given"
            raise refuse("one of circles and joints", field="the geometry", value=found)
        return geometry.points()

    def hexapod(self) -> Hexapod:
        """Return the machine in SI units, about its motion reference point in the neutral pose."""
        base, platform = self._points()
        if (self.legs is None) is (self.cranks is None):
            found = "absent" if self.legs is None else "both given"
            raise refuse("one of legs and cranks", field="what moves the platform", value=found)
        reference, lean = np.array(self.reference_point_m), self.joint_angles or JointAngles()
        return Hexapod(
            joints=platform - reference,
            anchors=base - reference - np.array([0.0, 0.0, self.neutral_height_m]),
            head=np.zeros(3) if self.head_m is None else np.array(self.head_m),
            cranks=None if self.cranks is None else self.cranks.cranks(base),
            **self._limits(),
            mass=self.payload.mass_kg,
            centre=np.array(self.payload.centre_m),
            inertia=np.array(self.payload.inertia_kgm2),
            lean_base=math.radians(lean.base_deg),
            lean_platform=math.radians(lean.platform_deg),
            upright=lean.about == "normal",
        )


def _must_turn(hexapod: Hexapod, cranks: CrankTable, arcs: Vec) -> None:
    """Refuse cranks whose rods do not reach in the neutral pose, or only outside their range of angles."""
    rods, spans = cranks.rod_m, _rod_spans(hexapod)
    low, high = float(spans[:, 0].max()), float(spans[:, 1].min())
    if np.isnan(arcs).any():
        inner = math.ceil(1e4 * low) / 1e4, math.floor(1e4 * high) / 1e4  # ends that are themselves within
        bound = f"between {inner[0]:g} and {inner[1]:g} m, to reach the platform's joints in the neutral pose"
        if low > high:
            needs = f"one crank needs at least {low:.4g} m and another at most {high:.4g} m"
            bound = f"one that reaches all joints in the neutral pose, but {needs}"
        raise refuse(bound, field="cranks.rod_m", value=f"{rods:g}")
    angles, (least, most) = np.degrees(hexapod.angles(arcs)), cranks.angle_deg
    if not (least < angles.min() and angles.max() < most):
        shown = f"at {angles.min():.4g} to {angles.max():.4g} deg"
        raise refuse(f"within {least:g} to {most:g} deg", field="cranks in the neutral pose", value=shown)
    leverage = float(hexapod.leverages(np.zeros((1, 6))).min())
    if not leverage > DEAD_CENTRE:
        bound = f"above {DEAD_CENTRE:g}: a crank is near its dead centre"
        raise refuse(bound, field="n·t of cranks in the neutral pose", value=f"{leverage:.3g}")


def _rod_spans(hexapod: Hexapod) -> Mat:
    """Return the least and largest distance (6, 2) [m] of a turning tip from its neutral joint."""
    if hexapod.cranks is None:
        raise ValueError("linear legs have no rods")
    ends, rho = hexapod.joints - hexapod.anchors, hexapod.cranks.radius
    in_plane = np.hypot(
        np.sum(ends * hexapod.cranks.zero, axis=1), np.sum(ends * hexapod.cranks.quarter, axis=1)
    )
    square = np.sum(ends**2, axis=1) + rho**2
    spans: Mat = np.sqrt(np.column_stack([square - 2.0 * rho * in_plane, square + 2.0 * rho * in_plane]))
    return spans


def _on_circle(radius: float, degrees: Mat) -> Mat:
    angle = degrees * math.pi / 180.0
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.zeros(len(angle))])
