"""Numbers of a platform file, each checked against bounds within which it is plausible.

The bounds admit a desk rig and the largest driving simulators (20 m of rail), and reject degrees for radians,
millimetres for metres, and a misplaced decimal point.
"""

import math
from dataclasses import dataclass
from typing import Annotated

from pydantic import BeforeValidator
from pydantic_core import PydanticCustomError


def refuse(bound: str, *, field: str = "", value: object = None) -> PydanticCustomError:
    """Return the error that pydantic passes on.

    Parameters
    ----------
    field, value : given if they differ from those of the checked field.
    """
    return PydanticCustomError("bound", "must be {bound}", {"bound": bound, "field": field, "value": value})


@dataclass(frozen=True, slots=True)
class Within:
    """A positive quantity between two bounds, both included."""

    low: float
    high: float
    unit: str
    too_low: str = ""  # the unit in which a smaller value is probably meant
    too_high: str = ""  # the unit in which a larger value is probably meant

    def number(self, value: object) -> float:
        """Return `value` as a float within the bounds; pydantic turns the error into its own."""
        number = self.finite(value)
        if number <= 0.0:
            raise refuse(f"greater than 0 {self.unit}".strip())
        if not self.low <= number <= self.high:
            meant = self.too_low if number < self.low else self.too_high
            question = f" (is it in {meant}?)" if meant else ""
            raise refuse(f"between {self.low:g} and {self.high:g} {self.unit}".strip() + question)
        return number

    def interval(self, value: object) -> tuple[float, float]:
        """Return an interval: a number x gives (−x, x), and a pair must contain zero, the neutral pose."""
        if not isinstance(value, list | tuple):
            number = self.number(value)
            return -number, number
        if len(value) != 2:
            raise refuse(f"one number, or [low, high], in {self.unit}")
        low, high = (self.finite(end) for end in value)
        if not low < 0.0 < high:
            raise refuse(f"[low, high] with low < 0 < high, in {self.unit}")
        return -self.number(-low), self.number(high)

    def finite(self, value: object) -> float:
        """Return `value` as a finite float of any sign."""
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise refuse(f"a number in {self.unit}" if self.unit else "a number")
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            raise refuse(f"a finite number in {self.unit}" if self.unit else "a finite number")
        return number


_TRAVEL = Within(0.005, 20.0, "m", "km", "mm")
_TILT = Within(1.0, 89.0, "deg", "rad")

# Radians are caught by the lower bounds: 57 deg = 1 rad, 57 deg/s = 1 rad/s, 286 deg/s2 = 5 rad/s2.
Travel = Annotated[tuple[float, float], BeforeValidator(_TRAVEL.interval)]  # [m]
Radius = Annotated[float, BeforeValidator(_TRAVEL.number)]  # [m]
Speed = Annotated[float, BeforeValidator(Within(0.005, 20.0, "m/s", "km/s", "mm/s").number)]  # [m/s]
Acceleration = Annotated[float, BeforeValidator(Within(0.05, 50.0, "m/s2", "g", "mm/s2").number)]  # [m/s²]
Tilt = Annotated[tuple[float, float], BeforeValidator(_TILT.interval)]  # [deg]
TiltRate = Annotated[float, BeforeValidator(Within(1.0, 500.0, "deg/s", "rad/s").number)]  # [deg/s]
TiltAcceleration = Annotated[
    float, BeforeValidator(Within(5.0, 10_000.0, "deg/s2", "rad/s2").number)
]  # [deg/s²]
Threshold = Annotated[float, BeforeValidator(Within(0.5, 10.0, "deg/s", "rad/s").number)]  # [deg/s]
Gain = Annotated[float, BeforeValidator(Within(0.01, 10.0, "").number)]  # [-]
BrakingTime = Annotated[float, BeforeValidator(Within(0.05, 20.0, "s", "", "ms").number)]  # [s]
Delay = Annotated[float, BeforeValidator(Within(1e-4, 1.0, "s", "", "ms").number)]  # [s]
