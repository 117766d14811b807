"""The log of a running session: a file, two rings in shared memory, and the process between them.

The process has normal priority and looks 20 times per second. When it is asked to end, or its parent dies, it
goes on until nobody has written for half a second: an output that still parks is logged to its end.
"""

import contextlib
import os
import time
from collections.abc import Iterator, Mapping
from datetime import UTC, datetime
from multiprocessing import shared_memory
from multiprocessing.synchronize import Event
from pathlib import Path
from typing import Final

from otolith.core.disk import NotWritten
from otolith.live.log import session_record
from otolith.live.recorder import CAPACITY, EVERY_NS, SILENT_NS, Recorder, lamp
from otolith.live.ring import Ring, room
from otolith.live.session import Session, versions
from otolith.live.shell.memory import check_machine

STREAMS: Final = ("controller", "output")  # who logs
QUIET_NS: Final = 500_000_000  # [ns] without a new record after which a recorder that is asked to end does
LEAVES: Final = 5.0  # [s] that it may take then
ENDING: Final = ".otl"


class SharedRing(Ring):
    """A ring in shared memory.

    Parameters
    ----------
    name : of the segment. create : whether this process makes it, and removes it in the end.
    """

    def __init__(self, name: str, *, create: bool = False) -> None:
        check_machine()
        self._creates = create
        self._memory = shared_memory.SharedMemory(name, create=create, size=room(CAPACITY) if create else 0)
        self._view = memoryview(self._memory.buf or b"")
        super().__init__(self._view, CAPACITY if create else None)

    def close(self) -> None:
        """Let go of the segment; who made it removes it."""
        self.release()
        self._view.release()
        self._memory.close()
        if self._creates:
            self._memory.unlink()


@contextlib.contextmanager
def ring_of(names: Mapping[str, str], stream: str) -> Iterator[SharedRing | None]:
    """Yield the ring to which a process logs; None where nothing is logged."""
    name = names.get(f"log-{stream}")
    ring = None if name is None else SharedRing(name)
    try:
        yield ring
    finally:
        if ring is not None:
            ring.close()


class File:
    """A file that grows, without a buffer: what was written is there, also if this process is killed."""

    def __init__(self, number: int) -> None:
        self._number = number

    def write(self, data: bytes) -> int:
        """Append bytes and return how many were; raises OSError."""
        return os.write(self._number, data)


def record_until(asked: list[int], names: Mapping[str, str], ready: Event, number: int) -> None:
    """Move what is logged to the open file `number`; `asked` gets longer when this should end."""
    with contextlib.ExitStack() as stack:
        rings = [stack.enter_context(ring_of(names, stream)) for stream in STREAMS]
        recorder = Recorder([ring for ring in rings if ring is not None], File(number))
        recorder.tick(time.monotonic_ns())
        ready.set()
        last = time.monotonic_ns()
        while not asked or time.monotonic_ns() - last <= QUIET_NS:
            time.sleep(1e-9 * EVERY_NS)
            now = time.monotonic_ns()
            if recorder.tick(now):
                last = now


class SessionLog:
    """The log of a running session, as its supervisor has it.

    Parameters
    ----------
    folder : where the file is made, named after the time.

    Raises
    ------
    NotWritten : the file cannot be made.
    """

    def __init__(self, folder: Path, session: Session) -> None:
        now = datetime.now(UTC)
        self.path = folder / f"{now:%Y-%m-%dT%H-%M-%S}-{session.token:08x}{ENDING}"
        began = {
            "began": {"utc": now.isoformat(), "monotonic_ns": time.monotonic_ns()},
            "versions": versions(),
        }
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self.number = os.open(self.path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_APPEND, 0o644)
            os.write(self.number, session_record(session.to_record(), began))
        except OSError as error:
            raise NotWritten(self.path, error.strerror or str(error)) from error
        self.names = {f"log-{stream}": f"otolith-{os.getpid()}-log-{stream}" for stream in STREAMS}
        self._rings = [SharedRing(name, create=True) for name in self.names.values()]
        self._shown: tuple[bool, ...] = (False, False, False)

    def news(self, now_ns: int) -> Iterator[str]:
        """Tell what is wrong with the log when it begins, and when it is over."""
        words = lamp(self._rings, now_ns)
        silent = any(now_ns - ring.heard_ns > SILENT_NS for ring in self._rings)
        shown = (any(ring.error for ring in self._rings), silent, any(ring.lost for ring in self._rings))
        if shown != self._shown:
            self._shown = shown
            yield words or "the log: is written again"

    def close(self) -> None:
        """Let go of file and memory; the recorder has ended."""
        os.close(self.number)
        for ring in self._rings:
            ring.close()
