"""One axis of a platform as its file describes it, and its limits as the algorithms read them."""

import math
from dataclasses import dataclass

from pydantic import BaseModel, ConfigDict

from otolith.platforms.bounds import Acceleration, Speed, Tilt, TiltAcceleration, TiltRate, Travel


class Table(BaseModel):
    """A table of a platform's file; a field that nothing reads is refused."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisLimits:
    """Limits of one axis of a degree of freedom, in the sign of its model; SI units and radians."""

    position: tuple[float, float]  # (low, high) [m or rad]
    velocity: (
        float  # ± [m/s or rad/s]; for a tilt the smaller of the machine's limit and the perception threshold
    )
    acceleration: float  # ± [m/s² or rad/s²]; infinite if the file gives none
    command: float  # ± [m/s² or rad/s²] on the commanded acceleration


class Translation(Table):
    """Limits of surge, sway or heave about the neutral pose."""

    position_m: Travel  # (low, high) [m]; one number x means ±x
    velocity_mps: Speed  # ± [m/s]
    acceleration_mps2: Acceleration  # ± [m/s²]
    # ± [m/s²] on the command; None for the limit of the acceleration
    command_mps2: Acceleration | None = None

    @property
    def limits(self) -> AxisLimits:
        """Return the limits of the axis."""
        return AxisLimits(
            position=self.position_m,
            velocity=self.velocity_mps,
            acceleration=self.acceleration_mps2,
            command=self.acceleration_mps2 if self.command_mps2 is None else self.command_mps2,
        )


class Rotation(Table):
    """Limits of roll, pitch or yaw about the neutral pose, in the axes of `otolith.core.frames`."""

    angle_deg: Tilt  # (low, high) [deg]; one number x means ±x
    rate_degps: TiltRate | None = None  # ± [deg/s] limit of the machine
    acceleration_degps2: TiltAcceleration | None = None  # ± [deg/s²] limit of the machine

    def limits(self, sign: float, rates_degps: list[float]) -> AxisLimits:
        """Return the limits of the axis.

        Parameters
        ----------
        sign : of the model's angle relative to the platform's.
        rates_degps : [deg/s] rates of which the smallest limits the axis; at least one.
        """
        low, high = sorted(math.radians(sign * angle) for angle in self.angle_deg)
        given = self.acceleration_degps2
        acceleration = math.inf if given is None else math.radians(given)
        return AxisLimits(
            position=(low, high),
            velocity=math.radians(min(rates_degps)),
            acceleration=acceleration,
            command=acceleration,
        )
