"""Axes that follow their commands with a dead time and the first-order lag of eq. 4.9.

This extends the simplified dynamics of chapter 5. Networks, drives and interpolators give every platform a
dead time. A controller that does not model it tracks less well and violates limits.
"""

from collections import deque
from typing import Final

import numpy as np

from otolith.core.errors import InputError
from otolith.interfaces import Command, Outcome, PlatformState, Status
from otolith.plant.ideal import Ideal
from otolith.platforms import Platform

EDGE: Final = 1e-9  # [s] times that differ by less are equal

_NOTHING: Final = Command(
    acceleration=np.zeros(6),
    pose=np.zeros(6),
    twist=np.zeros(6),
    plan=np.zeros((0, 6)),
    outcome=Outcome(status=Status.DECIDED),
)


class Actuator:
    """The ideal platform, whose commands take effect `dead_time` [s] after they are given.

    The solution is exact, even if the dead time is not a whole number of steps.
    """

    def __init__(
        self, lag: float = 0.01, dead_time: float = 0.01, *, head: tuple[float, float, float] | None = None
    ) -> None:
        if not 0.0 <= dead_time <= 1.0:
            raise InputError("plant dead time", dead_time, "between 0 and 1 s")
        self._axes, self.dead_time = Ideal(lag, head=head), dead_time
        self.reset(PlatformState())

    def reset(self, state: PlatformState) -> None:
        """Set the platform to `state`, with no pending command."""
        self._axes.reset(state)
        self._now, self._in_effect = 0.0, _NOTHING
        self._coming: deque[tuple[float, Command]] = deque()

    def step(self, command: Command, dt: float) -> PlatformState:
        """Follow the commands that were given a dead time ago, for dt [s]."""
        start, end = self._now, self._now + dt
        if not self._coming or self._coming[-1][1] is not command:
            self._coming.append((start + self.dead_time, command))
        while self._coming and self._coming[0][0] <= end - EDGE:
            due, coming = self._coming.popleft()
            self._follow(due - self._now)
            self._now, self._in_effect = max(self._now, due), coming
        state = self._follow(end - self._now)
        self._now = end
        return state

    def _follow(self, duration: float) -> PlatformState:
        """Hold the current command; durations are rounded so that their discretisation is cached."""
        return self._axes.step(self._in_effect, round(max(0.0, duration), 12))


def actuator(platform: Platform) -> Actuator:
    """Return the actuators that the platform's file describes."""
    described = platform.actuators
    return Actuator(described.lag_s, described.dead_time_s, head=platform.head)
