"""Starts a session, passes on the operator's words, tells what happens, and brings it to an end.

A lock that the system releases with its holder keeps a second session from the same device. The controller
may end at any time: the output then brakes and returns. When the output ends, nothing is sent any more, and
the device's own watchdog acts.
"""

import contextlib
import fcntl
import multiprocessing
import os
import queue
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Final

from otolith.core.errors import OtolithError
from otolith.live.messages import Report, State, Word
from otolith.live.shell.memory import Channel, pack_words, unpack_report
from otolith.live.shell.processes import Session, run_controller, run_output

STARTS: Final = 300.0  # [s] that a start may take: a cold compiler
ENDS: Final = 60.0  # [s] that returning and parking may take
NAMES: Final = ("plans", "reports", "words")


class Occupied(OtolithError):
    """Another session drives this device."""


class DidNotStart(OtolithError):
    """A process of the session ended before it was ready."""


@contextlib.contextmanager
def only_session(device: tuple[str, int]) -> Iterator[None]:
    """Hold the lock of a device.

    Raises
    ------
    Occupied : another process holds it.
    """
    host, port = device
    path = Path(tempfile.gettempdir()) / f"otolith-live-{host}-{port}.lock"
    with path.open("a+") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            file.seek(0)
            raise Occupied(
                f"device {host}:{port} is driven by process {file.read().strip()} already"
            ) from None
        file.truncate(0)
        file.write(str(os.getpid()))
        file.flush()
        yield


class Live:
    """A running session.

    Parameters
    ----------
    tell : is called with every sentence about it.
    """

    def __init__(self, session: Session, tell: Callable[[str], None]) -> None:
        self._context = multiprocessing.get_context("spawn")
        self._names = {name: f"otolith-{os.getpid()}-{name}" for name in NAMES}
        self._channels = {name: Channel(where, create=True) for name, where in self._names.items()}
        self._reports = self._channels["reports"]
        self._said: Any = self._context.Queue()
        self._tell, self._session = tell, session
        self._children: dict[str, Any] = {}
        self.report: Report | None = None

    def start(self) -> None:
        """Start both processes and wait until they are ready.

        Raises
        ------
        DidNotStart : one of them is not.
        """
        for name, run in (("controller", run_controller), ("output", run_output)):
            ready = self._context.Event()
            arguments = (self._session, self._names, ready, self._said)
            child = self._context.Process(target=run, args=arguments, name=f"otolith {name}")
            child.start()
            self._children[name] = child
            begin = time.monotonic()
            while not ready.wait(0.05):
                if not child.is_alive() or time.monotonic() - begin > STARTS:
                    raise DidNotStart(f"the {name} did not start; its own message stands above")
        self.look()

    def say(self, *words: Word) -> None:
        """Pass on words of the operator."""
        self._channels["words"].write(pack_words(words))

    def look(self) -> State | None:
        """Tell what was said, read the latest report, and return the state."""
        with contextlib.suppress(queue.Empty):
            while True:
                who, *sentences = self._said.get_nowait()
                for sentence in sentences:
                    self._tell(sentence if who == "event" else f"{who}: {sentence}")
        message = self._reports.read() if self._channels else None
        if message is not None:
            self.report = unpack_report(message)
        return None if self.report is None else self.report.state

    def alive(self, name: str) -> bool:
        """Return whether a process runs."""
        child = self._children.get(name)
        return child is not None and child.is_alive()

    def end(self) -> None:
        """Let the output return and park, then end the controller; give up after `ENDS`."""
        output, controller = self._children.get("output"), self._children.get("controller")
        if output is not None and output.is_alive():
            output.terminate()  # it parks first
            begin = time.monotonic()
            while output.is_alive() and time.monotonic() - begin < ENDS:
                output.join(0.05)
                self.look()
            if output.is_alive():
                self._tell("the platform did not park in time; packets end, and its own watchdog acts")
                output.kill()
        for child in (controller, output):
            if child is not None and child.is_alive():
                child.kill()
                child.join()
        self.look()
        self._children.clear()
        for channel in self._channels.values():
            channel.close()
        self._channels.clear()
