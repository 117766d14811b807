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

import numpy as np

from otolith.core.errors import OtolithError
from otolith.live.messages import Plan, Report, Rung, State, Word

MAGIC: Final = 0x4F544C4D454D3031  # "OTLMEM01"
VERSION: Final = 2  # of the layout of header, slots and messages
SLOTS: Final = 4
SIZE: Final = 65_536  # [bytes] of a slot
_HEAD: Final = struct.Struct("<QQQ")  # magic, version, size of a slot
_COUNTER: Final = _HEAD.size
_BEATS: Final = _COUNTER + 8  # signs of life
_FINISHED: Final = _BEATS + 8  # whether the writer ended as it was asked to
_FIRST: Final = 64  # [bytes] before the first slot
_LENGTH: Final = struct.Struct("<Q")
_PLAN: Final = struct.Struct("<qqqqqqd?qq")
_REPORT: Final = struct.Struct("<qqq")
_ORDERED: Final = ("x86_64", "AMD64")  # machines whose stores stay in order


class WrongMemory(OtolithError):
    """Shared memory is not what this program expects."""


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
        if machine.machine() not in _ORDERED:
            raise WrongMemory(
                f"live operation is tested on {' and '.join(_ORDERED)}, not {machine.machine()}"
            )
        self._creates = create
        self._memory = shared_memory.SharedMemory(
            name, create=create, size=_FIRST + SLOTS * SIZE if create else 0
        )
        if create:
            _HEAD.pack_into(self._buffer, 0, MAGIC, VERSION, SIZE)
        found = _HEAD.unpack_from(self._buffer, 0)
        if found != (MAGIC, VERSION, SIZE):
            raise WrongMemory(f"shared memory {name} has layout {found}, must be {(MAGIC, VERSION, SIZE)}")
        self._seen = 0

    @property
    def _buffer(self) -> memoryview:
        buffer = self._memory.buf
        if buffer is None:
            raise WrongMemory("shared memory is closed")
        return buffer

    @property
    def published(self) -> int:
        """Return how many messages there were."""
        return int(_LENGTH.unpack_from(self._buffer, _COUNTER)[0])

    @property
    def beats(self) -> int:
        """Return how many signs of life the writer gave beside its messages."""
        return int(_LENGTH.unpack_from(self._buffer, _BEATS)[0])

    def beat(self) -> None:
        """Give a sign of life."""
        _LENGTH.pack_into(self._buffer, _BEATS, self.beats + 1)

    @property
    def finished(self) -> bool:
        """Return whether the writer has ended as it was asked to."""
        return bool(_LENGTH.unpack_from(self._buffer, _FINISHED)[0])

    def finish(self) -> None:
        """Say that no message follows, and that this is right."""
        _LENGTH.pack_into(self._buffer, _FINISHED, 1)

    def write(self, message: bytes) -> None:
        """Publish a message of at most `SIZE` - 8 bytes."""
        if len(message) > SIZE - _LENGTH.size:
            raise WrongMemory(f"a message has {len(message)} bytes, must be at most {SIZE - _LENGTH.size}")
        n = self.published + 1
        at = _FIRST + (n % SLOTS) * SIZE
        self._buffer[at : at + _LENGTH.size + len(message)] = _LENGTH.pack(len(message)) + message
        _LENGTH.pack_into(self._buffer, _COUNTER, n)

    def read(self) -> bytes | None:
        """Return the latest message if it is new and whole; None to go on with the one before."""
        n = self.published
        if n == self._seen:
            return None
        at = _FIRST + (n % SLOTS) * SIZE
        (length,) = _LENGTH.unpack_from(self._buffer, at)
        message = bytes(self._buffer[at + _LENGTH.size : at + _LENGTH.size + min(length, SIZE)])
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


def pack_plan(plan: Plan) -> bytes:
    """Return a plan as bytes; texts are cut at 200 bytes."""
    reason, outcome = (text.encode()[:200] for text in (plan.reason, plan.outcome))
    head = _PLAN.pack(
        plan.sequence,
        plan.generation,
        plan.time_ns,
        plan.period_ns,
        plan.rung,
        plan.telemetry_ns,
        plan.residual,
        plan.healthy,
        len(reason),
        len(outcome),
    )
    return head + reason + outcome + plan.stages.tobytes()


def unpack_plan(message: bytes) -> Plan:
    """Return the plan of `pack_plan`."""
    sequence, generation, time_ns, period_ns, rung, telemetry_ns, residual, healthy, m, n = _PLAN.unpack_from(
        message
    )
    at = _PLAN.size
    return Plan(
        sequence=sequence,
        generation=generation,
        time_ns=time_ns,
        period_ns=period_ns,
        rung=Rung(rung),
        telemetry_ns=telemetry_ns,
        residual=residual,
        healthy=healthy,
        reason=message[at : at + m].decode(errors="ignore"),
        outcome=message[at + m : at + m + n].decode(errors="ignore"),
        stages=np.frombuffer(message[at + m + n :]).reshape(-1, 6),
    )


def pack_report(report: Report) -> bytes:
    """Return a report as bytes."""
    head = _REPORT.pack(report.time_ns, report.generation, report.follows)
    return head + report.motion.tobytes() + str(report.state).encode()


def unpack_report(message: bytes) -> Report:
    """Return the report of `pack_report`."""
    time_ns, generation, follows = _REPORT.unpack_from(message)
    at = _REPORT.size
    return Report(
        time_ns=time_ns,
        generation=generation,
        follows=follows,
        motion=np.frombuffer(message[at : at + 144]).reshape(3, 6),
        state=State(message[at + 144 :].decode()),
    )


def pack_words(words: tuple[Word, ...]) -> bytes:
    """Return the operator's words as bytes."""
    return " ".join(words).encode()


def unpack_words(message: bytes) -> tuple[Word, ...]:
    """Return the words of `pack_words`."""
    return tuple(Word(word) for word in message.decode().split())
