"""The supervisor's watch over the output: a thread that wakes every 2 ms, and is quick to end a session.

A dead output sends nothing any more, and a hung one must not go on later, when the device has parked itself
meanwhile: both are a fault, which is latched here and ends both processes. What then acts is the device's own
watchdog.
"""

import contextlib
import os
import select
import signal
import threading
import time
from collections.abc import Callable
from typing import Any, Final

from otolith.live.core.watchdog import LOOK_NS, MS, OUTPUT_LATE_NS, OUTPUT_NS, Silence
from otolith.live.shell.memory import Channel

PRIORITY: Final = 30  # real-time, above those who are watched


class OutputWatch(threading.Thread):
    """Watches the output process, and latches a fault.

    Parameters
    ----------
    output : the process. others : those that end with it.
    reports : where it gives its signs of life.
    latched : is called with the reason, after both processes were killed.
    """

    def __init__(
        self, output: Any, reports: Channel, *, others: tuple[Any, ...], latched: Callable[[str], None]
    ) -> None:
        super().__init__(name="otolith watch", daemon=True)
        self._output, self._others, self._reports, self._latched = output, others, reports, latched
        self._over = threading.Event()
        self.limit_ns = OUTPUT_LATE_NS  # of silence
        self._silence = Silence(2 * LOOK_NS)

    def end(self) -> None:
        """End the watch."""
        self._over.set()
        self.join()

    def run(self) -> None:
        """Look every 2 ms, and at once where the process ends."""
        try:
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))  # of this thread alone
            self.limit_ns = OUTPUT_NS
        except OSError:  # refused to the output too, which says so; it then has more time
            pass
        ended = select.poll()
        ended.register(self._output.sentinel, select.POLLIN)
        while not self._over.is_set():
            gone = bool(ended.poll(LOOK_NS // MS))
            if self._reports.finished:
                return
            silent = self._silence.look(time.monotonic_ns(), self._reports.published)
            if gone or silent > self.limit_ns:
                self._latch("died" if gone else f"has said nothing for {silent // MS} ms")
                return

    def _latch(self, what: str) -> None:
        for process in (self._output, *self._others):
            with contextlib.suppress(ProcessLookupError):  # it is dead
                os.kill(process.pid, signal.SIGKILL)
        self._latched(f"the output {what}; packets have ended, and the device's own watchdog acts")
