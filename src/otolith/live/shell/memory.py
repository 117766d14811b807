"""Memory that processes share: one writer, any number of readers, nobody ever waits.

The latest message of a channel lies in one of four slots; a counter says how many were published, and
message n is in slot n mod 4. The writer fills the slot first and then raises the counter. A reader copies the
slot and believes the copy only if fewer than three messages came meanwhile, else it keeps what it had. There
is no lock, so a process that is killed at any instant leaves nothing locked. x86 keeps the order of the two
writes; other machines need a barrier between them and are refused.
"""

import platform as machine
import struct
from multiprocessing import shared_memory
from typing import Final, Self

from otolith.core.errors import OtolithError

MAGIC: Final = 0x4F544C4D454D3031  # "OTLMEM01"
VERSION: Final = 2  # of the layout of header, slots and messages
SLOTS: Final = 4
SIZE: Final = 65_536  # [bytes] of a slot
_HEAD: Final = struct.Struct("<QQQ")  # magic, version, size of a slot
VERSION_AT: Final = 8  # place of the version in the header
_COUNTER: Final = _HEAD.size
_BEATS: Final = _COUNTER + 8  # signs of life
_FINISHED: Final = _BEATS + 8  # whether the writer ended as it was asked to
_FIRST: Final = 64  # [bytes] before the first slot
_LENGTH: Final = struct.Struct("<Q")
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
        if create:
            _HEAD.pack_into(self.buffer, 0, MAGIC, VERSION, SIZE)
        found = _HEAD.unpack_from(self.buffer, 0)
        if found != (MAGIC, VERSION, SIZE):
            raise WrongMemory(f"shared memory {name} has layout {found}, must be {(MAGIC, VERSION, SIZE)}")
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
        return int(_LENGTH.unpack_from(self.buffer, _COUNTER)[0])

    @property
    def beats(self) -> int:
        """Return how many signs of life the writer gave beside its messages."""
        return int(_LENGTH.unpack_from(self.buffer, _BEATS)[0])

    def beat(self) -> None:
        """Give a sign of life."""
        _LENGTH.pack_into(self.buffer, _BEATS, self.beats + 1)

    @property
    def finished(self) -> bool:
        """Return whether the writer has ended as it was asked to."""
        return bool(_LENGTH.unpack_from(self.buffer, _FINISHED)[0])

    def finish(self) -> None:
        """Say that no message follows, and that this is right."""
        _LENGTH.pack_into(self.buffer, _FINISHED, 1)

    def write(self, message: bytes) -> None:
        """Publish a message of at most `SIZE` - 8 bytes."""
        if len(message) > SIZE - _LENGTH.size:
            raise WrongMemory(f"a message has {len(message)} bytes, must be at most {SIZE - _LENGTH.size}")
        n = self.published + 1
        at = _FIRST + (n % SLOTS) * SIZE
        self.buffer[at : at + _LENGTH.size + len(message)] = _LENGTH.pack(len(message)) + message
        _LENGTH.pack_into(self.buffer, _COUNTER, n)

    def read(self) -> bytes | None:
        """Return the latest message if it is new and whole; None to go on with the one before."""
        n = self.published
        if n == self._seen:
            return None
        at = _FIRST + (n % SLOTS) * SIZE
        (length,) = _LENGTH.unpack_from(self.buffer, at)
        message = bytes(self.buffer[at + _LENGTH.size : at + _LENGTH.size + min(length, SIZE)])
        if self.published - n >= SLOTS - 1:
            return None
        self._seen = n
        return message

    def close(self) -> None:
        """Let go of the segment; who made it removes it."""
        self._memory.close()
        if self._creates:
            self._memory.unlink()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
