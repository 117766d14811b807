"""The log of a session: all that its two cores were told, and what they said, as records of one file.

Each core's records stand in the order in which it was told: first what reached it, then one record that ends
the tick (`DECISION`, `SET_POINT`) with the time that it was given. So a replay can tell other cores exactly
the same (`otolith.live.replay`), and nothing else of the processes matters: when packets were waited for,
which ticks were skipped, what the memory between them held.

Nothing here touches a disk: chunks of records go to a `otolith.live.ring`, one per tick and process.
"""

import json
import struct
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from enum import IntEnum
from itertools import islice
from mmap import mmap
from typing import Any, Final, Protocol

import numpy as np

from otolith.core.errors import CorruptFile, damage_reported
from otolith.live.controller import ControllerInbox
from otolith.live.core.ladder import Reaction
from otolith.live.core.session import Event
from otolith.live.devices.driver import Request
from otolith.live.messages import DeviceState, Feedback, Plan, Report, Rung, State
from otolith.live.output import OutputInbox, OutputOutbox
from otolith.live.packed import (
    pack_parameters,
    pack_plan,
    pack_report,
    pack_words,
    unpack_parameters,
    unpack_plan,
    unpack_report,
    unpack_words,
)
from otolith.live.records import HEAD, Record, Records, record
from otolith.live.ring import LOST
from otolith.live.wire import capture

VERSION: Final = 1
PIECES: Final = 10_000  # records that are taken at once where the progress is shown
SECOND_NS: Final = 1_000_000_000  # [ns] between two records of counters


class Kind(IntEnum):
    """Kinds of records."""

    SESSION = capture.SESSION  # JSON: the whole configuration, versions, hashes; the first record
    TELEMETRY = capture.TELEMETRY  # u64 time of arrival, packet as received
    PLAN = 3  # what the output was told by the controller
    SET_POINT = 4  # ends a tick of the output; see `SET_POINTS`
    MEASURED = 5  # what the output was told by the device
    EVENT = 6  # a change of state; follows from what the output was told
    COUNTERS = 7  # JSON: what a process counts, once a second
    WORDS = 8  # what the operator said to the output
    REACTION = 9  # what the shell of the output asks for
    REPORT = 10  # what the controller was told by the output, if it is another than before
    DECISION = 11  # ends a tick of the controller; see `DECISIONS`
    LOST = LOST  # u64: ticks of this core that are not in the log, because there was no room
    CHANGE = 13  # parameters that the controller was asked for


NAMES: Final = {kind.value: f"of kind {kind.name.lower()}" for kind in Kind}
MOST: Final = capture.MOST  # longest payload [bytes]
STATES, REQUESTS, DEVICE_STATES = (
    tuple(State),
    tuple(Request),
    tuple(DeviceState),
)  # only ever grow at the end
SENDS, DUE = 1, 2  # flags of a set-point: the device is sent set-points; this one was sent
SET_POINTS: Final = np.dtype(
    [
        ("time", "<i8"),  # [ns]
        ("generation", "<i8"),  # of the engagement
        ("follows", "<i8"),  # sequence of the plan that is followed; -1: none
        ("beats", "<i8"),  # decisions that the controller had begun
        ("page", "<i8"),  # signs of the page that alone commands; -1: others do, too
        ("state", "u1"),  # place in STATES
        ("request", "u1"),  # place in REQUESTS
        ("flags", "u1"),
        ("motion", "<f8", (3, 6)),  # pose, twist, acceleration [m, rad, s]
    ]
)
DECISIONS: Final = np.dtype(
    [
        ("time", "<i8"),  # [ns]
        ("missed", "<i8"),  # periods that the tick before took too long
        ("sequence", "<i8"),  # of the plan that was decided
        ("checksum", "<u4"),  # CRC-32 of that plan, packed
    ]
)
_TIME: Final = struct.Struct("<q")
_EVENT: Final = struct.Struct("<qBB")
_MEASURED: Final = struct.Struct("<qBB?qQ6d")  # time, state, parts, whether it failed, sequence, token, pose
_HAS_POSE, _HAS_SEQUENCE, _HAS_TOKEN = 1, 2, 4


class Sink(Protocol):
    """Where chunks of records go."""

    def write(self, chunk: bytes) -> bool:
        """Take a chunk, or leave it out and count it; never wait."""


def session_record(session: Mapping[str, Any], began: Mapping[str, Any]) -> bytes:
    """Return the first record of a log.

    Parameters
    ----------
    session : as of `otolith.live.session.Session.to_record`.
    began : when, by both clocks, and the versions of what decides.
    """
    source = session["settings"]["input"]["source"]
    said = {"format": capture.LOG, "version": VERSION, "source": source, **began, "session": session}
    return record(Kind.SESSION, json.dumps(said).encode())


Count = Callable[[], Mapping[str, int]]


class _Log:
    """What both logs have in common.

    Parameters
    ----------
    sink : where chunks go. count : what is logged once a second, if anything.
    """

    of = ""  # who counts

    def __init__(self, sink: Sink, count: Count | None = None) -> None:
        self._sink, self._count = sink, count
        self._counted_ns: int | None = None

    def _counters(self, now_ns: int) -> list[bytes]:
        if self._count is None or (self._counted_ns is not None and now_ns - self._counted_ns < SECOND_NS):
            return []
        self._counted_ns = now_ns
        said = {"time_ns": now_ns, "of": self.of, **self._count()}
        return [record(Kind.COUNTERS, json.dumps(said).encode())]


class ControllerLog(_Log):
    """Logs what the controller was told and decided."""

    of = "controller"
    _report: Report | None = None

    def note(self, now_ns: int, inbox: ControllerInbox, plan: Plan) -> None:
        """Log one tick."""
        parts = [record(Kind.TELEMETRY, _TIME.pack(arrival) + packet) for arrival, packet in inbox.packets]
        if inbox.report is not None and inbox.report is not self._report:
            parts.append(record(Kind.REPORT, pack_report(inbox.report)))
            self._report = inbox.report
        if inbox.change is not None:
            parts.append(record(Kind.CHANGE, pack_parameters(inbox.change)))
        ends = np.array((now_ns, inbox.missed, plan.sequence, zlib.crc32(pack_plan(plan))), dtype=DECISIONS)
        parts.append(record(Kind.DECISION, ends.tobytes()))
        self._sink.write(b"".join(parts + self._counters(now_ns)))


class OutputLog(_Log):
    """Logs what the output was told and said."""

    of = "output"
    _plan: Plan | None = None

    def note(self, now_ns: int, inbox: OutputInbox, out: OutputOutbox, events: Sequence[Event]) -> None:
        """Log one tick; `events` are the changes of state in it."""
        parts = []
        if inbox.plan is not None and inbox.plan is not self._plan:
            parts.append(record(Kind.PLAN, pack_plan(inbox.plan)))
            self._plan = inbox.plan
        if inbox.feedback is not None:
            parts.append(record(Kind.MEASURED, pack_measured(now_ns, inbox.feedback)))
        if inbox.words:
            parts.append(record(Kind.WORDS, pack_words(inbox.words)))
        if inbox.reaction.rung is not Rung.NONE:
            parts.append(record(Kind.REACTION, pack_reaction(inbox.reaction)))
        parts.append(record(Kind.SET_POINT, set_point(now_ns, inbox, out)))
        parts += [record(Kind.EVENT, pack_event(event)) for event in events]
        self._sink.write(b"".join(parts + self._counters(now_ns)))


def set_point(now_ns: int, inbox: OutputInbox, out: OutputOutbox) -> bytes:
    """Return what the output said in one tick, as one of `SET_POINTS`."""
    report = out.report
    flags = SENDS * out.sends | DUE * (out.set_point is not None)
    return np.array(
        (
            now_ns,
            report.generation,
            report.follows,
            inbox.beats,
            -1 if inbox.page is None else inbox.page,
            STATES.index(report.state),
            REQUESTS.index(out.request),
            flags,
            report.motion,
        ),
        dtype=SET_POINTS,
    ).tobytes()


def pack_reaction(reaction: Reaction) -> bytes:
    """Return a reaction as bytes."""
    return bytes([reaction.rung]) + reaction.reason.encode()


def unpack_reaction(payload: bytes) -> Reaction:
    """Return the reaction of `pack_reaction`."""
    return Reaction(Rung(payload[0]), payload[1:].decode())


def pack_event(event: Event) -> bytes:
    """Return a change of state as bytes."""
    before, after = STATES.index(event.before), STATES.index(event.after)
    return _EVENT.pack(event.time_ns, before, after) + event.reason.encode()


def unpack_event(payload: bytes) -> Event:
    """Return the change of state of `pack_event`."""
    time_ns, before, after = _EVENT.unpack_from(payload)
    return Event(time_ns, STATES[before], STATES[after], payload[_EVENT.size :].decode())


def pack_measured(now_ns: int, feedback: Feedback) -> bytes:
    """Return what a device reported as bytes, after the time at which the output was told."""
    parts = _HAS_POSE * (feedback.pose is not None)
    parts |= _HAS_SEQUENCE * (feedback.sequence is not None) | _HAS_TOKEN * (feedback.token is not None)
    pose = np.zeros(6) if feedback.pose is None else feedback.pose
    state = DEVICE_STATES.index(feedback.state)
    numbers = (feedback.sequence or 0, feedback.token or 0, *pose.tolist())
    head = _MEASURED.pack(now_ns, state, parts, bool(feedback.faults), *numbers)
    return head + "\n".join(feedback.faults).encode()


def unpack_measured(payload: bytes) -> tuple[int, Feedback]:
    """Return time and report of `pack_measured`."""
    now_ns, state, parts, failed, sequence, token, *pose = _MEASURED.unpack_from(payload)
    faults = payload[_MEASURED.size :].decode().split("\n")
    return now_ns, Feedback(
        pose=np.array(pose) if parts & _HAS_POSE else None,
        state=DEVICE_STATES[state],
        faults=tuple(faults) if failed else (),
        sequence=sequence if parts & _HAS_SEQUENCE else None,
        token=token if parts & _HAS_TOKEN else None,
    )


def _packet(payload: bytes) -> tuple[int, bytes]:
    return _TIME.unpack_from(payload)[0], payload[_TIME.size :]


_MEANINGS: Final[Mapping[int, Callable[[bytes], Any]]] = {
    Kind.SESSION: json.loads,
    Kind.TELEMETRY: _packet,
    Kind.PLAN: unpack_plan,
    Kind.SET_POINT: lambda payload: np.frombuffer(payload, dtype=SET_POINTS)[0],
    Kind.MEASURED: unpack_measured,
    Kind.EVENT: unpack_event,
    Kind.COUNTERS: json.loads,
    Kind.WORDS: unpack_words,
    Kind.REACTION: unpack_reaction,
    Kind.REPORT: unpack_report,
    Kind.DECISION: lambda payload: np.frombuffer(payload, dtype=DECISIONS)[0],
    Kind.LOST: lambda payload: int.from_bytes(payload, "little"),
    Kind.CHANGE: unpack_parameters,
}


def meaning(one: Record, source: str) -> Any:
    """Return what a record holds: values of `otolith.live.messages`, numbers by name, or plain JSON values.

    Raises
    ------
    CorruptFile : the record is sound by its checksum, and holds no such thing.
    """
    with damage_reported(f"{source} is damaged at byte {one.place:,}"):
        return _MEANINGS[one.kind](one.payload)


class Opened:
    """A log that is read.

    Parameters
    ----------
    source : the file's name, for errors.

    Raises
    ------
    CorruptFile : it does not begin as a log of this version.
    """

    def __init__(self, data: bytes | mmap, source: str) -> None:
        self.source, self.records = source, Records(data, source, NAMES, most=MOST)
        self._size, self._read = max(1, len(data)), 0
        first = next(iter(self.records), None)
        self.head: dict[str, Any] = {}
        if first is not None and first.kind == Kind.SESSION:
            with damage_reported(f"{source} is no log of a session"):
                self.head = dict(json.loads(first.payload))
        if (self.head.get("format"), self.head.get("version")) != (capture.LOG, VERSION):
            raise CorruptFile(f"{source} is no log of a session of version {VERSION}")

    @property
    def session(self) -> Mapping[str, Any]:
        """Return the session's plain values, see `otolith.live.session.session_from_record`."""
        with damage_reported(f"{self.source} is no log of a session"):
            return dict(self.head["session"])

    @property
    def share(self) -> float:
        """Return how much was read, 0 to 1."""
        return self._read / self._size

    def pieces(self, count: int) -> Iterator[list[Record]]:
        """Yield the records, `count` at a time; at a damaged one those before it, and then its error.

        Raises
        ------
        CorruptFile : a record is damaged.
        """
        found = iter(self.records)
        damage: CorruptFile | None = None
        while damage is None:
            piece: list[Record] = []
            try:
                piece.extend(islice(found, count))
            except CorruptFile as error:
                damage = error
            if not piece and damage is None:
                return
            if piece:
                self._read = piece[-1].place + HEAD.size + len(piece[-1].payload)
                yield piece
        raise damage
