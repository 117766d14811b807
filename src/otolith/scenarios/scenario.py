"""A scenario: what the driver should feel, as a function of time."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError

MAX_SCALE: Final = 10.0


def _still(t: Vec) -> Vec:
    return np.zeros((len(t), 3))


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
        force, rate, more_force, more_rate = (
            self.specific_force,
            self.angular_rate,
            other.specific_force,
            other.angular_rate,
        )
        return replace(
            self,
            duration=max(self.duration, other.duration),
            specific_force=lambda t: force(t) + more_force(t),
            angular_rate=lambda t: rate(t) + more_rate(t),
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
        force, rate, foreseen = self.specific_force, self.angular_rate, self.foreseen
        return replace(
            self,
            specific_force=lambda t: factor * force(t),
            angular_rate=lambda t: factor * rate(t),
            foreseen=foreseen and (lambda now, dt, n: factor * foreseen(now, dt, n)),
            origin=f"{self.origin}, scaled by {factor:g}",
        )
