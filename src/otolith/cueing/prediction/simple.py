"""Predictions without memory: hold, decay, and the oracle that knows the future.

Each is a frozen value with its parameters, so that a run's file can store it; `begin` makes the predictor.
Row k of a prediction is what is wanted at the end of the (k + 1)-th coming period: three specific forces
[m/s²] and three angular rates [rad/s] in the driver's frame, as in `otolith.interfaces.Reference`.
"""

from dataclasses import dataclass

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError
from otolith.interfaces import Reference


def now(reference: Reference) -> Vec:
    """Return what is wanted now (6,): specific force, then angular rate."""
    return np.concatenate([reference.specific_force, reference.angular_rate])


@dataclass(frozen=True, slots=True)
class Hold:
    """The present value is wanted forever: the thesis's assumption, exact for a constant force."""

    @property
    def foresees(self) -> float:
        """Nothing ahead is needed: 0 s."""
        return 0.0

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
    """Forces decay exponentially, rates are held.

    A platform with this assumption turns back in time. For a force within its reach the cost is small,
    because the assumption is renewed at every decision.

    Raises
    ------
    InputError : the time is not positive and finite.
    """

    time: float = 0.8  # [s] in which a force decays to 37 %

    def __post_init__(self) -> None:
        if not 0.0 < self.time < np.inf:
            raise InputError("time of the decay", f"{self.time} s", "greater than 0 and finite")

    @property
    def foresees(self) -> float:
        """Nothing ahead is needed: 0 s."""
        return 0.0

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
    """The future itself, as far as the loop knows it: for studies, never live.

    It bounds what any predictor can gain. Beyond the known future the last value is held; `time` limits how
    much of it is used.

    Raises
    ------
    InputError : the time is not positive.
    """

    time: float = 60.0  # [s] largest part of the future that is used

    def __post_init__(self) -> None:
        if not self.time > 0.0:
            raise InputError("time of the oracle", f"{self.time} s", "greater than 0")

    @property
    def foresees(self) -> float:
        """How much of the future the loop has to hand over [s]."""
        return self.time

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
