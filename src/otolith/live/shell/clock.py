"""A loop by the clock: absolute deadlines; what was missed is skipped and counted, never caught up."""

import ctypes
import time
from collections.abc import Iterator
from typing import Final

from otolith.core.errors import OtolithError
from otolith.live.core.times import Times

_MONOTONIC: Final = 1
_ABSOLUTE: Final = 1
_INTERRUPTED: Final = 4  # EINTR


class _Timespec(ctypes.Structure):
    _fields_ = (("seconds", ctypes.c_long), ("nanoseconds", ctypes.c_long))


class NoClock(OtolithError):
    """The system has no clock that live operation was tested with."""


class Ticks:
    """Yields the time [ns] once per period, as near to its deadline as the system wakes us.

    Parameters
    ----------
    period_ns : [ns].
    """

    def __init__(self, period_ns: int) -> None:
        self._period_ns = period_ns
        self.skipped = 0  # periods in which nobody woke us
        self.late = Times()  # from every deadline to the moment in which we were awake
        try:
            self._sleep = ctypes.CDLL(None).clock_nanosleep
        except (AttributeError, OSError, TypeError) as error:
            raise NoClock("live operation needs clock_nanosleep, which Linux has") from error

    def __iter__(self) -> Iterator[int]:
        deadline = time.monotonic_ns() + self._period_ns
        while True:
            self._wait(deadline)
            now = time.monotonic_ns()
            self.late.note(now - deadline)
            yield now
            behind = max(0, (time.monotonic_ns() - deadline) // self._period_ns)
            self.skipped += behind
            deadline += (behind + 1) * self._period_ns

    def _wait(self, deadline: int) -> None:
        until = _Timespec(deadline // 1_000_000_000, deadline % 1_000_000_000)
        while self._sleep(_MONOTONIC, _ABSOLUTE, ctypes.byref(until), None) == _INTERRUPTED:
            pass  # a signal came; the deadline is absolute
