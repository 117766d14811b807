"""Memory that processes share: one writer, any number of readers, nobody ever waits.

The latest message of a channel lies in one of four slots; a counter says how many were published, and
message n is in slot n mod 4. The writer fills the slot first and then raises the counter. A reader copies the
slot and believes the copy only if fewer than three messages came meanwhile, else it keeps what it had. There
is no lock, so a process that is killed at any instant leaves nothing locked. x86 keeps the order of the two
writes; other machines need a barrier between them and are refused.

What another process may read meanwhile is a word of 8 bytes that the machine stores in one go. Such a word is
assigned through a view of words: `struct.pack_into` sets its bytes to zero first, and a reader may see that.
"""

import platform as machine
from multiprocessing import shared_memory
from typing import Final, Self

from otolith.core.errors import OtolithError

MAGIC: Final = 0x4F544C4D454D3031  # "OTLMEM01"
VERSION: Final = 2  # of the layout of header, slots and messages
SLOTS: Final = 4
SIZE: Final = 65_536  # [bytes] of a slot
_WORD: Final = 8  # [bytes]
_FIRST: Final = 64  # [bytes] before the first slot
# u64 words before the first slot: signs of life at 4, and at 5 whether the writer ended as it was asked to
_IS, _VERSION, _SIZE, _COUNTER, _BEATS, _FINISHED = range(6)
VERSION_AT: Final = _WORD * _VERSION  # [bytes]
_ORDERED: Final = ("x86_64", "AMD64")  # machines whose stores stay in order


class WrongMemory(OtolithError):
    """Shared memory is not what this program expects."""


def check_machine() -> None:
    """Refuse a machine that may reorder stores."""
    if machine.machine() not in _ORDERED:
        raise WrongMemory(f"live operation is tested on {' and '.join(_ORDERED)}, not {machine.machine()}")


class Channel:
    """One kind of message in shared memory.

    Parameters
    ----------
    name : of the segment. create : whether this process makes it, and removes it in the end. Others have to
        be its children: they share its tracker of resources, and an outsider's would remove the segment.

    Raises
    ------
    WrongMemory : the machine reorders stores, or the segment has another layout.
    """

    def __init__(self, name: str, *, create: bool = False) -> None:
        check_machine()
        self._creates = create
        self._memory = shared_memory.SharedMemory(
            name, create=create, size=_FIRST + SLOTS * SIZE if create else 0
        )
        self._words = self.buffer[: _FIRST + SLOTS * SIZE].cast("Q")
        layout = (MAGIC, VERSION, SIZE)
        if create:
            self._words[_IS], self._words[_VERSION], self._words[_SIZE] = layout
        found = (self._words[_IS], self._words[_VERSION], self._words[_SIZE])
        if found != layout:
            self._words.release()
            raise WrongMemory(f"shared memory {name} has layout {found}, must be {layout}")
        self._seen = 0

    @property
    def buffer(self) -> memoryview:
        """Return all bytes of the segment."""
        buffer = self._memory.buf
        if buffer is None:
            raise WrongMemory("shared memory is closed")
        return buffer

    @property
    def published(self) -> int:
        """Return how many messages there were."""
        return self._words[_COUNTER]

    @property
    def beats(self) -> int:
        """Return how many signs of life the writer gave beside its messages."""
        return self._words[_BEATS]

    def beat(self) -> None:
        """Give a sign of life."""
        self._words[_BEATS] += 1

    @property
    def finished(self) -> bool:
        """Return whether the writer has ended as it was asked to."""
        return bool(self._words[_FINISHED])

    def finish(self) -> None:
        """Say that no message follows, and that this is right."""
        self._words[_FINISHED] = 1

    def write(self, message: bytes) -> None:
        """Publish a message of at most `SIZE` - 8 bytes."""
        if len(message) > SIZE - _WORD:
            raise WrongMemory(f"a message has {len(message)} bytes, must be at most {SIZE - _WORD}")
        n = self.published + 1
        at = _FIRST + (n % SLOTS) * SIZE
        self._words[at // _WORD] = len(message)
        self.buffer[at + _WORD : at + _WORD + len(message)] = message
        self._words[_COUNTER] = n

    def read(self) -> bytes | None:
        """Return the latest message if it is new and whole; None to go on with the one before."""
        n = self.published
        if n == self._seen:
            return None
        at = _FIRST + (n % SLOTS) * SIZE
        length = self._words[at // _WORD]
        message = bytes(self.buffer[at + _WORD : at + _WORD + min(length, SIZE)])
        if self.published - n >= SLOTS - 1:
            return None
        self._seen = n
        return message

    def close(self) -> None:
        """Let go of the segment; who made it removes it."""
        self._words.release()
        self._memory.close()
        if self._creates:
            self._memory.unlink()

    def __del__(self) -> None:
        """Let go of the words, without which Python cannot let go of the segment."""
        if hasattr(self, "_words"):
            self._words.release()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
