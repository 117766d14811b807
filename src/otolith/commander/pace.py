"""The pace of a run: which time of the run is due now, at a speed that may change."""

import math
import time
from collections.abc import Callable
from typing import Final

LATE: Final = 0.05  # [s] behind which a run counts as late
LOST: Final = 0.5  # [s] behind which the pace gives up what was lost, in place of racing after it


class Pace:
    """Follows real time at a speed.

    Parameters
    ----------
    speed : seconds of the run per second; 0 for as fast as possible.
    """

    def __init__(self, speed: float, now: Callable[[], float] = time.monotonic) -> None:
        self.speed, self._now = speed, now
        self._began, self._from = now(), 0.0
        self.behind = 0.0  # [s] of real time
        self.missed = 0  # times that the run was late

    def begin(self, reached: float) -> None:
        """Go on from a time of the run [s], from now on."""
        self._began, self._from, self.behind = self._now(), reached, 0.0

    def due(self) -> float:
        """Return the time of the run [s] that should be reached by now."""
        if self.speed == 0.0:
            return math.inf
        return self._from + self.speed * (self._now() - self._began)

    def reached(self, time_of_run: float) -> None:
        """Note what was reached, and how late that is."""
        if self.speed == 0.0:
            return
        late, self.behind = self.behind > LATE, (self.due() - time_of_run) / self.speed
        if self.behind > LATE and not late:
            self.missed += 1
        if self.behind > LOST:
            self.begin(time_of_run)

    def wait(self, next_time: float) -> float:
        """Return how long to sleep [s] until a time of the run is due."""
        return 0.0 if self.speed == 0.0 else max(0.0, (next_time - self.due()) / self.speed)
