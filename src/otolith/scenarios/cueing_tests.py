"""The input of the Objective Motion Cueing Test: one axis at one frequency at a time.

The test is Attachment F of ICAO Doc 9625 (Hosman & Advani, The Aeronautical Journal 120, 2016). The ten tests
and the twelve frequencies are those of the standard. Its amplitudes were not available. Those of `Amplitudes`
are our own, of a size that is reported to be usual, and can all be changed.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from otolith.core.frames import AXES
from otolith.scenarios.scenario import Scenario
from otolith.scenarios.waves import Along, FadeIn, Sine

FREQUENCIES: Final = tuple(10.0 ** (0.2 * k - 1.0) for k in range(12))  # [rad/s] 0.100, 0.158, … 15.849


@dataclass(frozen=True, slots=True)
class MotionTest:
    """One of the ten tests: the axis along which the vehicle moves, and the axis of what should be felt."""

    number: int
    driven: str  # a name of `otolith.core.frames.AXES`
    felt: str

    @property
    def name(self) -> str:
        """Return a name such as "pitch to surge", or "heave" if both axes are equal."""
        return self.driven if self.driven == self.felt else f"{self.driven} to {self.felt}"

    @property
    def unit(self) -> str:
        """Return the unit of the modulus; translations are specific forces, rotations are rates."""
        numerator, denominator = (
            "(rad/s)" if axis in AXES[3:] else "(m/s²)" for axis in (self.felt, self.driven)
        )
        return "" if numerator == denominator else f"{numerator}/{denominator}"


TESTS: Final = (
    MotionTest(1, "pitch", "pitch"),
    MotionTest(2, "pitch", "surge"),
    MotionTest(3, "roll", "roll"),
    MotionTest(4, "roll", "sway"),
    MotionTest(5, "yaw", "yaw"),
    MotionTest(6, "surge", "surge"),
    MotionTest(7, "surge", "pitch"),
    MotionTest(8, "sway", "sway"),
    MotionTest(9, "sway", "roll"),
    MotionTest(10, "heave", "heave"),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Amplitudes:
    """Amplitudes of the sinusoid: the largest angle within all three bounds, or a specific force."""

    angle: float = math.radians(6.0)  # [rad]
    rate: float = math.radians(1.0)  # [rad/s]
    angular_acceleration: float = math.radians(10.0)  # [rad/s²]
    force: float = 1.0  # [m/s²]

    def of(self, axis: str, omega: float) -> float:
        """Return the amplitude along `axis` at omega [rad/s]: a force [m/s²] or a rate [rad/s]."""
        if axis not in AXES[3:]:
            return self.force
        return omega * min(self.angle, self.rate / omega, self.angular_acceleration / omega**2)


@dataclass(frozen=True, slots=True, kw_only=True)
class Sweep:
    """How long each frequency is driven: transients decay first, then whole periods are measured."""

    # [s] least time to settle, and at least one period; the sinusoid grows in its first half
    settle: float = 30.0
    measured: float = 10.0  # [s] least time of measurement, and at least two periods

    def times(self, omega: float) -> tuple[float, float]:
        """Return the times [s] to settle and to measure at omega [rad/s], the latter in whole periods."""
        period = 2.0 * math.pi / omega
        return max(self.settle, period), max(2, math.ceil(self.measured / period)) * period


def sinusoid(axis: str, omega: float, amplitude: float, sweep: Sweep) -> Scenario:
    """Return a scenario that drives one axis by amplitude · sin(ω t), faded in, for the duration of `sweep`.

    Parameters
    ----------
    axis : a name of `otolith.core.frames.AXES`; a translation is driven by specific force, a rotation by its
        rate.
    amplitude : [m/s² or rad/s].
    """
    settle, measured = sweep.times(omega)
    wave = FadeIn(Sine(amplitude, omega / (2.0 * math.pi)), start=0.0, rise=0.5 * settle)
    index = AXES.index(axis)
    signal, still = Along(index % 3, wave), Along(index % 3, _nothing)
    force, rate = (signal, still) if index < 3 else (still, signal)
    return Scenario(
        name=f"{axis} at {omega:.3f} rad/s",
        duration=settle + measured,
        specific_force=force,
        angular_rate=rate,
        origin="ICAO Doc 9625, Attachment F",
    )


def _nothing(t: np.ndarray) -> np.ndarray:
    return np.zeros(np.shape(t))
