"""A scenario: what the driver should feel, as a function of time."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError

MAX_SCALE: Final = 10.0


def _still(t: Vec) -> Vec:
    return np.zeros((len(t), 3))


@dataclass(frozen=True, slots=True)
class _Sum:
    """The sum of two signals; a value, so that a scenario can be sent to another process."""

    one: Callable[..., Mat]
    other: Callable[..., Mat]

    def __call__(self, t: Vec) -> Mat:
        return self.one(t) + self.other(t)


@dataclass(frozen=True, slots=True)
class _Scaled:
    """A signal, or what is foreseen of one, times a factor."""

    factor: float
    signal: Callable[..., Mat]

    def __call__(self, *arguments: Any) -> Mat:
        return self.factor * self.signal(*arguments)


@dataclass(frozen=True, slots=True)
class _Later:
    """A signal, or what is foreseen of one, from a later moment on."""

    begin: float  # [s]
    signal: Callable[..., Mat]

    def __call__(self, t: Any, *arguments: Any) -> Mat:
        return self.signal(t + self.begin, *arguments)


@dataclass(frozen=True, slots=True, kw_only=True)
class Scenario:
    """Specific force and angular rate to be felt, in the driver's frame, over a period of time.

    The signals are functions of time, not samples, so controller and plant may each evaluate them at their
    own rate. Where a signal jumps at t, its value at exactly t is the one after the jump.
    """

    name: str
    duration: float  # [s]
    specific_force: Callable[[Vec], Vec]  # (n,) [s] -> (n, 3) [m/s²], without the standing 1 g
    angular_rate: Callable[[Vec], Vec] = field(default=_still)  # (n,) [s] -> (n, 3) [rad/s]
    # (time now [s], period [s], n) -> (k, 3) [m/s²], k ≤ n: what is foreseen, from what is known by now, for
    # the ends of the next periods; None where nothing is
    foreseen: Callable[[float, float, int], Mat] | None = None
    origin: str = ""  # its source: a table of the thesis, a file, a formula

    def combined_with(self, other: "Scenario") -> "Scenario":
        """Return the sum of both, with forces and rates added; it lasts as long as the longer one.

        The name stays: the purpose is one signal along several axes. Nothing is foreseen of the sum.
        """
        return replace(
            self,
            duration=max(self.duration, other.duration),
            specific_force=_Sum(self.specific_force, other.specific_force),
            angular_rate=_Sum(self.angular_rate, other.angular_rate),
            foreseen=None,
        )

    def scaled(self, factor: float) -> "Scenario":
        """Return the scenario with force and rate multiplied by `factor`.

        Raises
        ------
        InputError : the factor is not within (0, 10].
        """
        if not 0.0 < factor <= MAX_SCALE:
            raise InputError("scale", factor, f"greater than 0 and at most {MAX_SCALE:g}")
        if factor == 1.0:
            return self
        return replace(
            self,
            specific_force=_Scaled(factor, self.specific_force),
            angular_rate=_Scaled(factor, self.angular_rate),
            foreseen=self.foreseen and _Scaled(factor, self.foreseen),
            origin=f"{self.origin}, scaled by {factor:g}",
        )

    def part(self, begin: float, end: float) -> "Scenario":
        """Return what is between two times [s] as a scenario that starts at 0.

        Raises
        ------
        InputError : the times are not in order, or not within the scenario.
        """
        if not 0.0 <= begin < end <= self.duration:
            bound = f"two times in order within 0 and {self.duration:g} s"
            raise InputError(f"part of {self.name}", f"{begin:g} to {end:g} s", bound)
        return replace(
            self,
            name=f"{self.name}, {begin:g} to {end:g} s",
            duration=end - begin,
            specific_force=_Later(begin, self.specific_force),
            angular_rate=_Later(begin, self.angular_rate),
            foreseen=self.foreseen and _Later(begin, self.foreseen),
        )
