"""A motion platform as its user describes it: reach, speed, acceleration, thresholds, braking law.

The file is TOML; degrees appear only in names with `deg`. Everything that leaves this module through
`Platform.limits` is in SI units and radians.
"""

import math
from collections.abc import Iterable
from typing import Any, Self

from pydantic import (
    Field,
    SerializerFunctionWrapHandler,
    ValidationError,
    model_serializer,
    model_validator,
)

from otolith.core.arrays import Vec
from otolith.core.errors import InputError
from otolith.core.frames import AXES, Dof, bases_of
from otolith.platforms.axes import AxisLimits, Rotation, Table, Translation
from otolith.platforms.bounds import BrakingTime, Delay, Gain, Radius, Threshold, refuse
from otolith.platforms.carriers import Base
from otolith.platforms.geometry import HexapodTable
from otolith.platforms.hexapod import Hexapod
from otolith.platforms.validation_messages import sentence, toml_fields

INVARIANCE = 2.0  # smallest c_v²/c_u, see `Braking`


class TiltCoordination(Table):
    """Tilt rates below which tilting is not perceived as rotation; defaults from Table B.5's discussion."""

    pitch_degps: Threshold = 3.0  # [deg/s]
    roll_degps: Threshold = 2.6  # [deg/s]


class Braking(Table):
    """The braking law s + c_v v T + c_u a T²/2 within ±s_max (eq. C.2), for both travel and tilt.

    With e = s_max − s the active law is (c_u T²/2) e″ + c_v T e′ + e = 0. It comes to rest without crossing
    the limit only if it does not oscillate: c_v² ≥ 2 c_u. (The thesis requires > 1, eq. C.1; between 1 and 2
    the limit is overshot.) The defaults are those of the thesis, below eqs. 4.7 and 4.8.
    """

    c_v: Gain = 1.0
    c_w: Gain = 1.0  # the c_v of the tilt
    c_u: Gain = 0.45
    position_s: BrakingTime = 2.5  # T of the travel [s]
    tilt_s: BrakingTime = 0.5  # T of the tilt [s]

    @model_validator(mode="after")
    def _must_not_oscillate(self) -> Self:
        for name in ("c_v", "c_w"):
            ratio = getattr(self, name) ** 2 / self.c_u
            if ratio < INVARIANCE:
                raise refuse(
                    f"at least {INVARIANCE:g}, or the braking law oscillates and overshoots the limit",
                    field=f"{name}^2/c_u",
                    value=round(ratio, 4),
                )
        return self


class Workspace(Table):
    """Limits that several axes share."""

    circle_m: Radius | None = None  # surge² + sway² ≤ circle² [m]


class Actuators(Table):
    """Lag and dead time of the platform's axes, for the plant `actuator`."""

    lag_s: Delay = 0.01  # [s] T of eq. 4.9
    dead_time_s: Delay = 0.01  # [s] before a command takes effect


class Platform(Table):
    """A motion platform. Axes that the machine does not have are left out of its file.

    Examples
    --------
    >>> from otolith.core.frames import SURGE_PITCH
    >>> from otolith.platforms import load
    >>> travel, tilt = load("davsi").limits(SURGE_PITCH)
    >>> travel.velocity
    0.81
    """

    name: str = Field(min_length=1, max_length=80)
    description: str = ""
    surge: Translation | None = None
    sway: Translation | None = None
    heave: Translation | None = None
    roll: Rotation | None = None
    pitch: Rotation | None = None
    yaw: Rotation | None = None
    tilt_coordination: TiltCoordination = TiltCoordination()
    braking: Braking = Braking()
    workspace: Workspace = Workspace()
    actuators: Actuators = Actuators()
    hexapod: HexapodTable | None = None
    base: Base | None = None

    @model_validator(mode="after")
    def _must_move(self) -> Self:
        if not self.axes:
            raise refuse(f"at least one of {', '.join(AXES)}", field="the set of axes", value="empty")
        return self

    @model_validator(mode="after")
    def _must_be_free_above_the_middle(self) -> Self:
        """Refuse interference with the base at rest: algorithms that leave it there know of none."""
        for number, one in enumerate(() if self.base is None else self.base.interference):
            field = f"base.interference.{number}"
            for axis in ("surge", "sway", "heave"):
                if (value := getattr(one, axis)) != 0.0 and getattr(self, axis) is None:
                    raise refuse(f"0: the platform has no {axis}", field=f"{field}.{axis}", value=value)
            if one.at_most_m < (farthest := self.farthest(one.weights)):
                bound = f"at least {farthest:.4g} m: above the middle of its base the platform must be free"
                raise refuse(bound, field=f"{field}.at_most_m", value=one.at_most_m)
        return self

    @model_serializer(mode="wrap")
    def _without_what_is_absent(self, plain: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Leave out a base that a platform does not have, so that digests of platforms stay as they were."""
        values: dict[str, Any] = plain(self)
        return {name: value for name, value in values.items() if name != "base" or value is not None}

    @property
    def axes(self) -> tuple[str, ...]:
        """Return the names of the platform's axes, in the order of `otolith.core.frames.AXES`."""
        return tuple(axis for axis in AXES if getattr(self, axis) is not None)

    @property
    def circle(self) -> float | None:
        """Return the radius [m] of the circle that limits surge and sway together; None if there is none."""
        return self.workspace.circle_m

    @property
    def head(self) -> tuple[float, float, float] | None:
        """Return the driver's head [m] from the motion reference point; None if the file does not give it."""
        return None if self.hexapod is None else self.hexapod.head_m

    def farthest(self, weights: Vec) -> float:
        """Return the largest sum [m] of the platform's own places on its base, times weights (6,) or more."""
        along = []
        for axis, weight in zip(AXES[:3], weights.tolist(), strict=False):
            table = getattr(self, axis)
            along.append(0.0 if table is None else max(weight * end for end in table.position_m))
        plane = along[0] + along[1]
        if self.circle is not None:
            plane = min(plane, self.circle * math.hypot(weights[0], weights[1]))
        return float(plane + along[2])

    def six_legs(self) -> Hexapod:
        """Return the legs and the body that they move.

        Raises
        ------
        InputError : the file describes no legs.
        """
        if self.hexapod is None:
            raise InputError(
                f"[hexapod] of platform {self.name}", "missing", "in its file for its legs to be used"
            )
        return self.hexapod.hexapod()

    def limits(self, dof: Dof) -> tuple[AxisLimits, ...]:
        """Return the limits of every axis of a degree of freedom; of a pair: translation, then tilt.

        Raises
        ------
        InputError : the platform lacks one of the axes, or its file gives no rate or acceleration of a
            rotation that is cued on its own.
        """
        if dof.is_base:
            return (self._moved_base().limits(dof),)
        tables = [self._table(dof, index) for index in dof.axes]
        return tuple(
            table.limits if isinstance(table, Translation) else self._about(dof, sign, table)
            for sign, table in zip(dof.signs, tables, strict=True)
        )

    def can_cue(self, dof: Dof) -> bool:
        """Return whether the platform has all axes of a degree of freedom, with the limits that it needs."""
        try:
            self.limits(dof)
        except InputError:
            return False
        return True

    def bases(self, dofs: Iterable[Dof]) -> tuple[Dof, ...]:
        """Return the axes of the base that carry degrees of freedom; none without a base."""
        return () if self.base is None else tuple(dof for dof in bases_of(dofs) if dof in self.base.dofs)

    def boxed(self) -> "Platform":
        """Return the platform with a square inside its circle as limits of surge and sway.

        A circle is not a linear constraint and couples the two, so the thesis also uses a box inside it (0.35
        m, eq. 4.17). A platform without a circle is returned unchanged.
        """
        if self.circle is None:
            return self
        side = self.circle / math.sqrt(2.0)
        sides: dict[str, Any] = {"workspace": Workspace()}
        for axis in ("surge", "sway"):
            table = getattr(self, axis)
            if table is not None:
                low, high = table.position_m
                ends = (max(low, -side), min(high, side))
                sides[axis] = table.model_copy(update={"position_m": ends})
        return self.model_copy(update=sides)

    def _moved_base(self) -> Base:
        if self.base is None:
            raise InputError(f"[base] of platform {self.name}", "missing", "in its file for it to be moved")
        return self.base

    def _table(self, dof: Dof, index: int) -> Translation | Rotation:
        axis = AXES[index]
        table: Translation | Rotation | None = getattr(self, axis)
        wanted = f"in its file for {'it' if axis == dof.name else dof.name} to be cued"
        if table is None:
            raise InputError(f"{axis} of platform {self.name}", "missing", wanted)
        if isinstance(table, Translation) or dof.is_pair:
            return table
        if table.rate_degps is None or table.acceleration_degps2 is None:
            raise InputError(f"rate or acceleration of {axis} of platform {self.name}", "missing", wanted)
        return table

    def _about(self, dof: Dof, sign: float, table: Rotation) -> AxisLimits:
        """Return the limits of a rotation; a tilt also stays below the threshold of perception."""
        rates = [] if table.rate_degps is None else [table.rate_degps]
        if dof.is_pair:
            rates.append(getattr(self.tilt_coordination, f"{AXES[dof.rotation]}_degps"))
        return table.limits(sign, rates)


def parse_platform(text: str, source: str) -> Platform:
    """Read a platform from the text of its TOML file.

    Parameters
    ----------
    source : name of the file, for errors.

    Raises
    ------
    InputError : the text is not TOML, or a field is unknown, missing, or out of bounds. If several fields are
        wrong, the message names one of them.
    """
    fields = toml_fields(text, source)
    try:
        return Platform.model_validate(fields)
    except ValidationError as error:
        raise sentence(error, Platform, source) from None
