"""Predictions without a memory: hold, decay, and the oracle that is given the future.

Each is a frozen value with its parameters, so that a run's file can hold it; `begin` makes the predictor.
A predictor's row k is what is wanted at the end of the (k + 1)-th coming period: three specific forces
[m/s²] and three angular rates [rad/s] in the driver's frame, as in `otolith.interfaces.Reference`.
"""

from dataclasses import dataclass

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError
from otolith.interfaces import Reference


def now(reference: Reference) -> Vec:
    """What is wanted at this moment (6,): specific force, then angular rate."""
    return np.concatenate([reference.specific_force, reference.angular_rate])


@dataclass(frozen=True, slots=True)
class Hold:
    """What is wanted now is wanted for ever: the thesis's assumption, exact for a standing force."""

    def begin(self) -> "Hold":
        """Return the predictor, which is the value itself, since it remembers nothing."""
        return self

    def reset(self) -> None:
        """Do nothing, since there is no past to forget."""

    def ahead(self, reference: Reference, dt: float, n: int) -> Mat:  # noqa: ARG002 (the role has it)
        """Return the present value n times, (n, 6)."""
        coming = np.empty((n, 6))
        coming[:] = now(reference)
        return coming


@dataclass(frozen=True, slots=True)
class Decay:
    """Forces die away exponentially, rates are held.

    A platform that assumes so turns back in time; for a force within its reach this costs little, since
    the assumption is renewed at every decision.

    Raises
    ------
    InputError : the time is not positive and finite.
    """

    time: float = 0.8  # [s] in which a force falls to 37 %

    def __post_init__(self) -> None:
        if not 0.0 < self.time < np.inf:
            raise InputError("time of the decay", f"{self.time} s", "greater than 0 and finite")

    def begin(self) -> "Decay":
        """Return the predictor, which is the value itself, since it remembers nothing."""
        return self

    def reset(self) -> None:
        """Do nothing, since there is no past to forget."""

    def ahead(self, reference: Reference, dt: float, n: int) -> Mat:
        """Return the decaying forces and the present rates, (n, 6)."""
        coming = np.empty((n, 6))
        coming[:] = now(reference)
        coming[:, :3] *= np.exp(-dt / self.time * np.arange(1.0, n + 1.0))[:, None]
        return coming


@dataclass(frozen=True, slots=True)
class Oracle:
    """The future itself, as far as it is known to the loop: for studies, never live.

    It is a bound on what any predictor can win. Where the known future ends, its last value is held; with
    a `time`, only so much of it is used.

    Raises
    ------
    InputError : the time is not positive.
    """

    time: float = 60.0  # [s] of the future that is used at most

    def __post_init__(self) -> None:
        if not self.time > 0.0:
            raise InputError("time of the oracle", f"{self.time} s", "greater than 0")

    def begin(self) -> "Oracle":
        """Return the predictor, which is the value itself, since it remembers nothing."""
        return self

    def reset(self) -> None:
        """Do nothing, since there is no past to forget."""

    def ahead(self, reference: Reference, dt: float, n: int) -> Mat:
        """Return the known future forces and the present rates, (n, 6)."""
        coming = np.empty((n, 6))
        coming[:] = now(reference)
        if reference.preview is None or not len(reference.preview):
            return coming
        used = min(n, len(reference.preview), max(1, round(min(self.time / dt, float(n)))))
        coming[:used, :3] = reference.preview[:used]
        coming[used:, :3] = reference.preview[used - 1]
        return coming
