"""The recorder's core: what waits in rings goes to a file; what is wrong with it shows as a lamp.

It runs 20 times per second in a process of its own. Whether it is dead, late, or its disk is full, those who
write to the rings never wait for it: what has no room is left out and counted.
"""

import os
from collections.abc import Sequence
from typing import Final, Protocol

from otolith.live.ring import Ring

EVERY_NS: Final = 50_000_000  # [ns] between two looks at the rings
SILENT_NS: Final = 1_000_000_000  # [ns] after which a recorder counts as dead or hung
# [bytes] of a ring per stream: 15 s of set-points and of the longest plans without a look of the recorder
CAPACITY: Final = 1 << 24


class Disk(Protocol):
    """A file that grows."""

    def write(self, data: bytes) -> int:
        """Append bytes and return how many were; raises OSError."""


class Recorder:
    """Appends what waits in rings to a file, ring after ring; a record is never interleaved with another.

    Parameters
    ----------
    rings : one for each process that logs.
    """

    def __init__(self, rings: Sequence[Ring], disk: Disk) -> None:
        self._rings, self._disk = rings, disk
        self._left = b""  # what the disk has not taken yet

    def tick(self, now_ns: int) -> int:
        """Write what waits; return how many bytes were written."""
        written, error = 0, 0
        try:
            written += self._push()
            for ring in self._rings:
                if not self._left:
                    self._left = ring.take()
                    written += self._push()
        except OSError as problem:
            error = problem.errno or -1
        for ring in self._rings:
            ring.beat(now_ns, error)
        return written

    def _push(self) -> int:
        """Give the disk what is left, and return how much it took."""
        written = self._disk.write(self._left) if self._left else 0
        self._left = self._left[written:]
        return written


def lamp(rings: Sequence[Ring], now_ns: int) -> str:
    """Return what is wrong with the log, in words; empty if nothing is."""
    lost = sum(ring.lost for ring in rings)
    words = []
    error = next((ring.error for ring in rings if ring.error), 0)
    if error:
        words.append(f"cannot be written: {os.strerror(error)}")
    silent = now_ns - min(ring.heard_ns for ring in rings)
    if silent > SILENT_NS:
        words.append(f"its recorder has said nothing for {1e-9 * silent:.0f} s")
    if lost:
        words.append(f"{lost} ticks are missing")
    return f"the log: {', '.join(words)}; the platform goes on" if words else ""
