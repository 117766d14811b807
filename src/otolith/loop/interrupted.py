"""References with outages, to test how an algorithm behaves in an outage and whether it recovers."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from otolith.interfaces import Command, Cueing, PlatformState, Reference


@dataclass(frozen=True, slots=True, kw_only=True)
class Outage:
    """A stretch of time in which every wanted force reads `value` instead of its true value."""

    start: float  # [s] from the run's start
    end: float  # [s]
    value: float = np.nan  # [m/s²]; NaN: the force is missing


class Interrupted:
    """A cueing algorithm that receives its reference with outages."""

    def __init__(self, cueing: Cueing, outages: Sequence[Outage]) -> None:
        self._cueing, self._outages, self._decisions = cueing, tuple(outages), 0

    @property
    def period(self) -> float:
        """Time between two decisions [s]."""
        return self._cueing.period

    def reset(self, state: PlatformState) -> None:
        """Start from `state`, at time 0."""
        self._decisions = 0
        self._cueing.reset(state)

    def step(self, state: PlatformState, reference: Reference) -> Command:
        """Pass on the reference, changed during an outage."""
        now = self._decisions * self.period
        self._decisions += 1
        for outage in self._outages:
            if outage.start - 1e-9 <= now < outage.end - 1e-9:
                reference = replace(reference, specific_force=np.full(3, outage.value), preview=None)
        return self._cueing.step(state, reference)
