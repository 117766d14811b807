"""A motion platform as its user describes it: reach, speed, acceleration, thresholds, braking law.

The file is TOML; degrees appear only in names with `deg`. Everything that leaves this module through
`Platform.limits` is in SI units and radians.
"""

import math
from dataclasses import dataclass
from typing import Any, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from otolith.core.errors import InputError
from otolith.core.frames import AXES, Dof
from otolith.platforms.bounds import (
    Acceleration,
    BrakingTime,
    Delay,
    Gain,
    Radius,
    Speed,
    Threshold,
    Tilt,
    TiltAcceleration,
    TiltRate,
    Travel,
    refuse,
)
from otolith.platforms.geometry import HexapodTable
from otolith.platforms.hexapod import Hexapod
from otolith.platforms.validation_messages import sentence, toml_fields

INVARIANCE = 2.0  # smallest c_v²/c_u, see `Braking`


class _Table(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)


class Translation(_Table):
    """Limits of surge, sway or heave about the neutral pose."""

    position_m: Travel  # (low, high) [m]; one number x means ±x
    velocity_mps: Speed  # ± [m/s]
    acceleration_mps2: Acceleration  # ± [m/s²]
    # ± [m/s²] on the command; None for the limit of the acceleration
    command_mps2: Acceleration | None = None


class Rotation(_Table):
    """Limits of roll, pitch or yaw about the neutral pose, in the axes of `otolith.core.frames`."""

    angle_deg: Tilt  # (low, high) [deg]; one number x means ±x
    rate_degps: TiltRate | None = None  # ± [deg/s] limit of the machine
    acceleration_degps2: TiltAcceleration | None = None  # ± [deg/s²] limit of the machine


class TiltCoordination(_Table):
    """Tilt rates below which tilting is not perceived as rotation; defaults from Table B.5's discussion."""

    pitch_degps: Threshold = 3.0  # [deg/s]
    roll_degps: Threshold = 2.6  # [deg/s]


class Braking(_Table):
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


class Workspace(_Table):
    """Limits that several axes share."""

    circle_m: Radius | None = None  # surge² + sway² ≤ circle² [m]


class Actuators(_Table):
    """Lag and dead time of the platform's axes, for the plant `actuator`."""

    lag_s: Delay = 0.01  # [s] T of eq. 4.9
    dead_time_s: Delay = 0.01  # [s] before a command takes effect


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisLimits:
    """Limits of one axis of a degree of freedom, in the sign of its model; SI units and radians."""

    position: tuple[float, float]  # (low, high) [m or rad]
    velocity: (
        float  # ± [m/s or rad/s]; for a tilt the smaller of the machine's limit and the perception threshold
    )
    acceleration: float  # ± [m/s² or rad/s²]; infinite if the file gives none
    command: float  # ± [m/s² or rad/s²] on the commanded acceleration


class Platform(_Table):
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

    @model_validator(mode="after")
    def _must_move(self) -> Self:
        if not self.axes:
            raise refuse(f"at least one of {', '.join(AXES)}", field="the set of axes", value="empty")
        return self

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
        tables = [self._table(dof, index) for index in dof.axes]
        return tuple(
            _along(table) if isinstance(table, Translation) else self._about(dof, sign, table)
            for sign, table in zip(dof.signs, tables, strict=True)
        )

    def can_cue(self, dof: Dof) -> bool:
        """Return whether the platform has all axes of a degree of freedom, with the limits that it needs."""
        try:
            self.limits(dof)
        except InputError:
            return False
        return True

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
        low, high = sorted(math.radians(sign * angle) for angle in table.angle_deg)
        rates = [] if table.rate_degps is None else [table.rate_degps]
        if dof.is_pair:
            rates.append(getattr(self.tilt_coordination, f"{AXES[dof.rotation]}_degps"))
        acceleration = _radians_or_unlimited(table.acceleration_degps2)
        return AxisLimits(
            position=(low, high),
            velocity=math.radians(min(rates)),
            acceleration=acceleration,
            command=acceleration,
        )


def _along(table: Translation) -> AxisLimits:
    return AxisLimits(
        position=table.position_m,
        velocity=table.velocity_mps,
        acceleration=table.acceleration_mps2,
        command=table.acceleration_mps2 if table.command_mps2 is None else table.command_mps2,
    )


def _radians_or_unlimited(degrees: float | None) -> float:
    return math.inf if degrees is None else math.radians(degrees)


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
