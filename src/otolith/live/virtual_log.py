"""The log of a session in virtual time: rings, recorder and a disk that can be full, all in memory."""

import errno
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from otolith.live.log import ControllerLog, OutputLog, session_record
from otolith.live.recorder import CAPACITY, Recorder, lamp
from otolith.live.ring import Ring, room

NOWHERE: Final = {"settings": {"input": {"source": "generic"}}}  # a session that no file describes


@dataclass(slots=True)
class MemoryDisk:
    """A file in memory, on a disk that can be full."""

    data: bytearray = field(default_factory=bytearray)
    free: int | None = None  # [bytes]; None: without end

    def write(self, data: bytes) -> int:
        """Append bytes and return how many were."""
        if self.free == 0:
            raise OSError(errno.ENOSPC, "full")
        taken = len(data) if self.free is None else min(len(data), self.free)
        self.data += data[:taken]
        self.free = None if self.free is None else self.free - taken
        return taken


class VirtualLog:
    """What logs a virtual session.

    Parameters
    ----------
    session : what the first record says of it.
    capacity : of each of both rings [bytes].
    """

    def __init__(self, session: Mapping[str, Any] = NOWHERE, *, capacity: int = CAPACITY) -> None:
        self.disk = MemoryDisk(bytearray(session_record(session, {})))
        self.rings = [Ring(memoryview(bytearray(room(capacity))), capacity) for _ in range(2)]
        self.controller, self.output = ControllerLog(self.rings[0]), OutputLog(self.rings[1])
        self.recorder = Recorder(self.rings, self.disk)

    def lamp(self, now_ns: int) -> str:
        """Return what is wrong with it, in words; empty if nothing is."""
        return lamp(self.rings, now_ns)
