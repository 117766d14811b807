"""Predictions without memory: hold, decay, and the oracle that knows the future.

Each is a frozen value with its parameters, so that a run's file can store it; `begin` makes the predictor.
Row k of a prediction is what is wanted at the end of the (k + 1)-th coming period: three specific forces
[m/s²] and three angular rates [rad/s] in the driver's frame, as in `otolith.interfaces.Reference`.
"""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Final, NamedTuple, Self

import numpy as np

from otolith.compiled import PREDICT
from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError
from otolith.core.jit import kernel
from otolith.core.methods import Bound
from otolith.interfaces import Reference

NO_PREVIEW: Final = np.empty((0, 3))


def now(reference: Reference) -> Vec:
    """Return what is wanted now (6,): specific force, then angular rate."""
    return np.concatenate([reference.specific_force, reference.angular_rate])


def previewed(reference: Reference) -> Mat:
    """Return the known forces of the next periods (K, 3); K = 0 if there are none."""
    known = reference.preview
    return NO_PREVIEW if known is None else np.ascontiguousarray(known, dtype=np.float64)


class _Simple(NamedTuple):
    period: float  # [s]
    time: float  # [s] in which a force falls to 37 %; infinite if it is held
    used: float  # largest number of rows of the known future that are used


@kernel
def _ahead(of: Any, now: Vec, preview: Mat, coming: Mat) -> int:
    """Write what will be wanted (n, 6): the known future if there is one, otherwise the present value."""
    used = int(min(float(min(len(coming), len(preview))), of.used))
    for k in range(len(coming)):
        share = 1.0 if of.time == np.inf else math.exp(-of.period / of.time * (k + 1.0))
        for i in range(3):
            coming[k, i] = preview[min(k, used - 1), i] if used > 0 else share * now[i]
            coming[k, 3 + i] = now[3 + i]
    return 0


@lru_cache(maxsize=64)
def _method(period: float, time: float, used: float) -> Bound:
    return PREDICT.bind(_ahead, _Simple(period, time, used))


class _Memoryless:
    """A prediction that is its own predictor, since it remembers nothing."""

    __slots__ = ()

    @property
    def foresees(self) -> float:
        """Return 0 s, since no future forces are needed."""
        return 0.0

    def begin(self) -> Self:
        """Return the predictor, which is the value itself."""
        return self

    def reset(self) -> None:
        """Do nothing, since there is no past to forget."""

    def compiled(self, dt: float) -> Bound:
        """Return the method of this prediction for periods of dt [s]."""
        raise NotImplementedError

    def ahead(self, reference: Reference, dt: float, n: int) -> Mat:
        """Return what will be wanted at the ends of the next n periods of dt [s], (n, 6)."""
        coming = np.empty((n, 6))
        _ahead(self.compiled(dt).held, now(reference), previewed(reference), coming)
        return coming


@dataclass(frozen=True, slots=True)
class Hold(_Memoryless):
    """The present value is wanted forever: the thesis's assumption, exact for a constant force."""

    def compiled(self, dt: float) -> Bound:
        """Return the method of this prediction for periods of dt [s]."""
        return _method(dt, np.inf, 0.0)


@dataclass(frozen=True, slots=True)
class Decay(_Memoryless):
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

    def compiled(self, dt: float) -> Bound:
        """Return the method of this prediction for periods of dt [s]."""
        return _method(dt, self.time, 0.0)


@dataclass(frozen=True, slots=True)
class Oracle(_Memoryless):
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
        """Return how far ahead the loop must give forces [s]."""
        return self.time

    def compiled(self, dt: float) -> Bound:
        """Return the method of this prediction for periods of dt [s]."""
        return _method(dt, np.inf, max(1.0, np.rint(self.time / dt)))
