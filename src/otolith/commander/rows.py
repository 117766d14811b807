"""Rows of signals in shared memory: one process writes them, any number read, and nobody ever waits.

The ring holds the latest `CAPACITY` rows. A reader keeps a cursor of its own, the number of the next row that
it wants, so it needs no queue, and one that sleeps costs nobody anything: what was overwritten meanwhile is a
gap. The writer fills rows first and then raises their number; x86 keeps this order, and stores a word in one
go, as `otolith.live.shell.memory` explains; other machines are refused.
"""

import time
from multiprocessing import shared_memory
from typing import Final, Self

import numpy as np

from otolith.core.arrays import Singles
from otolith.live.shell.memory import WrongMemory, check_machine

CAPACITY: Final = 1 << 16  # rows: 65 s at 1 kHz
_SPARE: Final = 2_048  # rows that may be overwritten while a reader copies
_MAGIC: Final = 0x4F544C524F575331  # "OTLROWS1"
_FIRST: Final = 64  # [bytes] before the rows
# u64 words before the rows; the last is the time of the newest row [ns]
_IS, _COLUMNS, _GENERATION, _WRITTEN, _NEWEST = range(5)


class Rows:
    """The ring of rows.

    Parameters
    ----------
    name : of the segment. columns : of a row, for the process that makes the ring, and removes it in the end;
        None for its children.

    Raises
    ------
    WrongMemory : the machine reorders stores, or there is no ring under this name.
    """

    def __init__(self, name: str, columns: int | None = None) -> None:
        check_machine()
        self._creates = columns is not None
        size = 0 if columns is None else _FIRST + 4 * CAPACITY * columns
        self._memory = shared_memory.SharedMemory(name, create=self._creates, size=size)
        buffer = self._memory.buf
        if buffer is None:
            raise WrongMemory("shared memory is closed")
        self._words = buffer[:_FIRST].cast("Q")
        if columns is not None:
            self._words[_COLUMNS], self._words[_IS] = columns, _MAGIC
        if self._words[_IS] != _MAGIC:
            self._words.release()
            raise WrongMemory(f"shared memory {name} holds no rows")
        self.columns = self._words[_COLUMNS]
        count = CAPACITY * self.columns
        self._rows: Singles = np.frombuffer(buffer, dtype=np.float32, offset=_FIRST, count=count).reshape(
            CAPACITY, self.columns
        )

    @property
    def generation(self) -> int:
        """Return the number of the run whose rows these are."""
        return self._words[_GENERATION]

    @property
    def written(self) -> int:
        """Return how many rows of this run were written."""
        return self._words[_WRITTEN]

    @property
    def age(self) -> float:
        """Return the time since the newest row was written [s]; infinite before the first."""
        newest = self._words[_NEWEST]
        return 1e-9 * (time.monotonic_ns() - newest) if newest else float("inf")

    def begin(self, generation: int) -> None:
        """Begin another run, without rows."""
        self._words[_GENERATION] = 0  # of no run, while the rest is changed
        self._words[_WRITTEN] = 0
        self._words[_NEWEST] = 0
        self._words[_GENERATION] = generation

    def write(self, rows: Singles) -> None:
        """Append rows (n, columns), in pieces that no reader can mistake."""
        for first in range(0, len(rows), _SPARE // 2):
            piece = rows[first : first + _SPARE // 2]
            at = self.written % CAPACITY
            before = min(len(piece), CAPACITY - at)
            self._rows[at : at + before] = piece[:before]
            self._rows[: len(piece) - before] = piece[before:]
            self._words[_WRITTEN] = self.written + len(piece)
        self._words[_NEWEST] = time.monotonic_ns()

    def read(self, cursor: int, most: int) -> tuple[int, Singles]:
        """Return the number of the first row returned, and at most `most` rows from `cursor` on.

        The number is larger than `cursor` where rows have been overwritten.
        """
        while True:
            written = self.written
            first = max(cursor, written - CAPACITY + _SPARE)
            count = max(0, min(most, written - first))
            taken = self._rows[np.arange(first, first + count) % CAPACITY]
            if self.written - first <= CAPACITY - _SPARE // 2:
                return first, taken

    def close(self) -> None:
        """Let go of the segment; who made it removes it."""
        self._rows = np.empty((0, 0), dtype=np.float32)
        self._words.release()
        self._memory.close()
        if self._creates:
            self._memory.unlink()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
