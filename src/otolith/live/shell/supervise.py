"""Starts a session, passes on the operator's words, tells what happens, and brings it to an end.

A lock that the system releases with its holder keeps a second session from the same device. The controller
may end at any time: the output then brakes and returns. When the output ends or hangs, a fault is latched
(`otolith.live.shell.watch`): nothing is sent any more, and the device's own watchdog acts.
"""

import contextlib
import fcntl
import multiprocessing
import os
import queue
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict
from multiprocessing import reduction
from pathlib import Path
from typing import Any, Final

from otolith.core.errors import OtolithError
from otolith.live.core.moves import planner
from otolith.live.core.parameters import SLEW, Parameters
from otolith.live.messages import Report, State, Word
from otolith.live.packed import pack_parameters, pack_words, unpack_report
from otolith.live.session import Session
from otolith.live.settings import changes_from
from otolith.live.shell.memory import Channel
from otolith.live.shell.processes import run_controller, run_output, run_recorder
from otolith.live.shell.recorder import SessionLog
from otolith.live.shell.timing import ControllerTiming, OutputTiming
from otolith.live.shell.watch import OutputWatch

LOOK: Final = 0.02  # [s] between two looks at what goes on while processes start
STARTS: Final = 300.0  # [s] that a start may take: a cold compiler
ENDS: Final = 60.0  # [s] that returning and parking may take
LEAVES: Final = 5.0  # [s] that a controller may take to end
NAMES: Final = ("plans", "reports", "words", "vitals", "changes")


class Handle:
    """A file descriptor that a process passes on to its child, which keeps it open."""

    def __init__(self, number: int) -> None:
        self.number = number

    def __reduce__(self) -> tuple[Any, ...]:
        """Let the child have it: this is called while a child is started."""
        return _handed_over, (reduction.DupFd(self.number),)


def _handed_over(handle: Any) -> Handle:
    return Handle(handle.detach())


class Occupied(OtolithError):
    """Another session drives this device."""


class DidNotStart(OtolithError):
    """A process of the session ended before it was ready."""


@contextlib.contextmanager
def only_session(device: tuple[str, int], tell: Callable[[str], None] = lambda _: None) -> Iterator[int]:
    """Hold the lock of a device; yield its file descriptor, which the output holds too.

    The lock is free when all who hold it have ended: also an output that still parks without its supervisor
    keeps others away. A session that ends in order leaves the file empty; a number that is found in a free
    one is of a process that died, which is told.

    Raises
    ------
    Occupied : another process holds it.
    """
    host, port = device
    with lock_of(device).open("a+") as file:
        file.seek(0)
        holder = file.read().strip()
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            what = f"process {holder} already" if _runs(holder) else f"what process {holder} left behind"
            raise Occupied(f"device {host}:{port} is driven by {what}") from None
        if holder:
            tell(f"the lock of {host}:{port} is taken over from process {holder}, which has died")
        file.truncate(0)
        file.write(str(os.getpid()))
        file.flush()
        yield file.fileno()
        file.truncate(0)


def lock_of(device: tuple[str, int]) -> Path:
    """Return the file whose lock says that a device, by host and port, is driven."""
    host, port = device
    return Path(tempfile.gettempdir()) / f"otolith-live-{host}-{port}.lock"


def _runs(holder: str) -> bool:
    return holder.isdigit() and Path(f"/proc/{holder}").exists()


class Latched(OtolithError):
    """The supervisor has ended a session, because its output died or hung."""


class Live:
    """A running session.

    Parameters
    ----------
    tell : is called with every sentence about it.
    lock : file descriptor of `only_session`.
    log : folder in which the session is logged; None for no log.
    controller : is the controller's process; it takes what `run_controller` takes.

    Raises
    ------
    MissingExtra : ruckig is not installed.
    NotWritten : the file of the log cannot be made.
    """

    def __init__(
        self,
        session: Session,
        tell: Callable[[str], None],
        *,
        lock: int,
        log: Path | None = None,
        controller: Callable[..., None] = run_controller,
    ) -> None:
        planner()  # without it no session gets beyond `idle`
        self.log = None if log is None else SessionLog(log, session)
        self._run_controller = controller
        self._context = multiprocessing.get_context("spawn")
        self._names = {name: f"otolith-{os.getpid()}-{name}" for name in NAMES}
        self._channels = {name: Channel(where, create=True) for name, where in self._names.items()}
        self._reports = self._channels["reports"]
        self._said: Any = self._context.Queue()
        self._tell, self._session, self._lock = tell, session, lock
        self._parameters = session.parameters  # that were asked for
        self._children: dict[str, Any] = {}
        self._watch: OutputWatch | None = None
        self.report: Report | None = None
        self.fault = ""  # why a fault is latched here; it is never taken back
        self._told: set[str] = set()
        self._ending = False
        self.output_timing, self.controller_timing = OutputTiming(), ControllerTiming()  # at their end

    def start(self, meanwhile: Callable[[], None] = lambda: None) -> None:
        """Start both processes and wait until they are ready.

        Parameters
        ----------
        meanwhile : is called every 20 ms while it waits; an exception ends the start.

        Raises
        ------
        DidNotStart : one of them is not.
        """
        begun = {}
        starts: dict[str, tuple[Any, int]] = {
            "controller": (self._run_controller, self._lock),
            "output": (run_output, self._lock),
        }
        names = self.names
        if self.log is not None:
            starts = {"recorder": (run_recorder, self.log.number), **starts}
            self._tell(f"the log is {self.log.path}")
        for name, (run, number) in starts.items():
            begun[name] = self._context.Event()
            arguments = (self._session, names, begun[name], self._said, Handle(number))
            self._children[name] = self._context.Process(
                target=run, args=arguments, name=f"otolith {name}", daemon=True
            )  # whatever ends this process, Python asks those to end first
            self._children[name].start()
        begin = time.monotonic()
        for name, child in self._children.items():
            while not begun[name].wait(LOOK):
                meanwhile()
                if not child.is_alive() or time.monotonic() - begin > STARTS:
                    raise DidNotStart(f"the {name} did not start; its own message stands above")
        self._watch = OutputWatch(
            self._children["output"],
            self._reports,
            others=(self._children["controller"],),
            latched=self._latch,
        )
        self._watch.start()
        self.look()

    def _latch(self, reason: str) -> None:
        """Keep why the session is over; called by the watch's thread, told by `look`."""
        self.fault = reason

    def say(self, *words: Word) -> None:
        """Pass on words of the operator; who arms is told which files have changed since they were read."""
        for sentence in self._session.changed() if Word.ARM in words else ():
            self._tell(f"{sentence}; the session goes on with what it read at its start")
        self._channels["words"].write(pack_words(words))

    def change(self, values: Mapping[str, Any]) -> str:
        """Ask the controller for other parameters from its next decision on; return it in words.

        Raises
        ------
        InputError : a value is out of its bounds, or no parameter of this session.
        OtolithError : the controller is dead.
        """
        asked = changes_from(values, self._session.offered)
        if self.fault or not self.alive("controller"):
            raise OtolithError(f"{', '.join(asked)}: not changed, since the controller has died")
        before = asdict(self._parameters)
        self._parameters = Parameters(**(before | asked))
        self._channels["changes"].write(pack_parameters(self._parameters))
        return ", ".join(
            f"{name}: {before[name]:g} → {value:g}, within {abs(value - before[name]) / SLEW:.1f} s"
            for name, value in asked.items()
        )

    @property
    def names(self) -> dict[str, str]:
        """Return the names of the shared memory, for a child that looks on."""
        return self._names | ({} if self.log is None else self.log.names)

    def sign(self) -> None:
        """Pass on a sign of life of whoever speaks the words."""
        self._channels["words"].beat()

    def look(self) -> State | None:
        """Tell what was said, read the latest report, and return the state."""
        with contextlib.suppress(queue.Empty):
            while True:
                who, *said = self._said.get_nowait()
                if who == "timing":
                    self._take(said[0])
                    continue
                for sentence in said:
                    self._tell(sentence if who == "event" else f"{who}: {sentence}")
        for news in self._deaths():
            if news not in self._told:
                self._told.add(news)
                self._tell(news)
        for news in () if self.log is None or self._ending else self.log.news(time.monotonic_ns()):
            self._tell(news)
        if self.fault:
            return State.FAULT
        message = self._reports.read() if self._channels else None
        if message is not None:
            self.report = unpack_report(message)
        return None if self.report is None else self.report.state

    def _take(self, timing: OutputTiming | ControllerTiming) -> None:
        """Keep and tell what a process that ends has noted about its time."""
        name = "output" if isinstance(timing, OutputTiming) else "controller"
        for sentence in timing.sentences():
            self._tell(f"{name}: {sentence}")
        if isinstance(timing, OutputTiming):
            self.output_timing = timing
        else:
            self.controller_timing = timing

    def _deaths(self) -> Iterator[str]:
        """Tell what cannot be undone by a word."""
        if self.fault:
            yield f"{State.FAULT}: {self.fault}"
        elif not self._ending and "controller" in self._children and not self.alive("controller"):
            yield "the controller has died: the platform can be parked, but not be engaged again"

    def alive(self, name: str) -> bool:
        """Return whether a process runs."""
        child = self._children.get(name)
        return child is not None and child.is_alive()

    def end(self) -> None:
        """Let the output return and park, then end the controller; give up after `ENDS`."""
        self._ending = True
        output, controller = self._children.get("output"), self._children.get("controller")
        if output is not None and output.is_alive() and not self.fault:
            output.terminate()  # it parks first
            begin = time.monotonic()
            while output.is_alive() and time.monotonic() - begin < ENDS:
                output.join(0.05)
                self.look()
        if self._watch is not None:
            self._watch.end()
        if output is not None and output.is_alive():
            self._tell("the platform did not park in time; packets end, and its own watchdog acts")
            output.kill()
        if controller is not None and controller.is_alive():
            controller.terminate()
            controller.join(LEAVES)
        recorder = self._children.get("recorder")
        for child in (controller, output, recorder):
            if child is recorder and child is not None:
                child.terminate()  # it writes what the others have said
                child.join(LEAVES)
            if child is not None and child.is_alive():
                child.kill()
                child.join()
        self.look()
        self._children.clear()
        for channel in self._channels.values():
            channel.close()
        self._channels.clear()
        if self.log is not None:
            self.log.close()
