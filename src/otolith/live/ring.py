"""A ring of bytes between a process that must not wait and one that writes to a disk.

One process writes whole chunks, another takes them out; nobody ever waits, and nothing is locked. A chunk for
which there is no room is left out and counted, and the next one that has room begins with a record that says
how many were left out. The writer raises `head` after the bytes are there, the reader `tail` after it has
copied them; x86 keeps this order (`otolith.live.shell.memory` refuses other machines).
"""

import struct
from typing import Final

from otolith.live.records import record

LOST: Final = 12  # kind of the record that says how many chunks were left out: u64
_MAGIC: Final = 0x4F544C52494E4731  # "OTLRING1"
_HEAD: Final = 64  # [bytes] before the ring itself
# u64 words of the head
_IS, _CAPACITY, _WRITTEN, _TAKEN, _LOST, _BEAT, _ERROR = range(7)


def room(capacity: int) -> int:
    """Return how many bytes of memory a ring of `capacity` bytes needs."""
    return _HEAD + capacity


class Ring:
    """A ring in given memory.

    Parameters
    ----------
    memory : of `room(capacity)` bytes or more, writable.
    capacity : [bytes]; None for a ring that another process has made there.
    """

    def __init__(self, memory: memoryview, capacity: int | None = None) -> None:
        self._words = memory[:_HEAD].cast("Q")
        if capacity is not None:
            self._words[_CAPACITY], self._words[_IS] = capacity, _MAGIC
        if self._words[_IS] != _MAGIC:
            raise ValueError("there is no ring in this memory")
        self.capacity = self._words[_CAPACITY]
        self._bytes = memory[_HEAD : _HEAD + self.capacity]
        self._unsaid = 0  # chunks that were left out since the last one that had room

    @property
    def lost(self) -> int:
        """Return how many chunks had no room."""
        return self._words[_LOST]

    @property
    def filled(self) -> int:
        """Return how many bytes wait to be taken."""
        return self._words[_WRITTEN] - self._words[_TAKEN]

    def write(self, chunk: bytes) -> bool:
        """Write a chunk, if there is room; return whether there was."""
        if self._unsaid:
            chunk = record(LOST, struct.pack("<Q", self._unsaid)) + chunk
        if len(chunk) > self.capacity - self.filled:
            self._unsaid += 1
            self._words[_LOST] += 1
            return False
        at = self._words[_WRITTEN] % self.capacity
        first = min(len(chunk), self.capacity - at)
        self._bytes[at : at + first] = chunk[:first]
        self._bytes[: len(chunk) - first] = chunk[first:]
        self._words[_WRITTEN] += len(chunk)
        self._unsaid = 0
        return True

    def take(self) -> bytes:
        """Return all that waits; there is room again for as much."""
        filled = self.filled
        at = self._words[_TAKEN] % self.capacity
        first = min(filled, self.capacity - at)
        chunk = bytes(self._bytes[at : at + first]) + bytes(self._bytes[: filled - first])
        self._words[_TAKEN] += filled
        return chunk

    # What the reader says about itself.

    def beat(self, now_ns: int, error: int) -> None:
        """Let the reader say that it lives, and with which error of the system it failed; 0 for none."""
        self._words[_BEAT], self._words[_ERROR] = now_ns, error

    @property
    def heard_ns(self) -> int:
        """Return when the reader spoke last [ns]; 0 if it never did."""
        return self._words[_BEAT]

    @property
    def error(self) -> int:
        """Return the error of the system with which the reader failed last; 0 for none."""
        return self._words[_ERROR]

    def release(self) -> None:
        """Let go of the memory."""
        self._bytes.release()
        self._words.release()
