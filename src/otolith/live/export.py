"""A log as tables: what was wanted, the set-points, what was measured, decisions and events, with units.

Times are seconds since the first tick in the log; lengths are metres, angles radians.
"""

from collections.abc import Iterable, Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from otolith.core.arrays import Vec
from otolith.core.errors import OtolithError
from otolith.core.frames import AXES
from otolith.live.controller import Parse, Wanted
from otolith.live.core.health import Count, Health
from otolith.live.core.session import Event
from otolith.live.log import DECISIONS, DEVICE_STATES, SENDS, SET_POINTS, STATES, Kind, meaning
from otolith.live.messages import Feedback, Telemetry
from otolith.live.records import Record
from otolith.recordings.recorded import Signal

REFERENCE, SET_POINT, MEASURED, DECISION, EVENT = "reference", "set-points", "measured", "decisions", "events"
TABLES: Final = (REFERENCE, SET_POINT, MEASURED, DECISION, EVENT)
CODES: Final = {
    "state": " ".join(f"{place} {state}" for place, state in enumerate(STATES)),
    "device state": " ".join(f"{place} {state}" for place, state in enumerate(DEVICE_STATES)),
}
_FELT: Final = ("ax", "ay", "az"), ("roll_rate", "pitch_rate", "yaw_rate")


class Tables:
    """Collects a log's records as tables.

    Parameters
    ----------
    source : the log's name, for errors.
    parse, wanted, health : as of the session's controller, and new: what it took is the reference, what it
        dropped is left out.
    """

    def __init__(self, source: str, *, parse: Parse, wanted: Wanted, health: Health) -> None:
        self._source, self._parse, self._wanted, self._health = source, parse, wanted, health
        self._felt: list[tuple[int, Vec, float]] = []
        self._set_points: list[bytes] = []
        self._decisions: list[bytes] = []
        self._measured: list[tuple[int, Feedback]] = []
        self._events: list[Event] = []

    def take(self, records: Iterable[Record]) -> None:
        """Take in records.

        Raises
        ------
        CorruptFile : a record is damaged; what came before it was taken in.
        """
        for one in records:
            match one.kind:
                case Kind.SET_POINT:
                    self._set_points.append(one.payload)
                case Kind.DECISION:
                    self._decisions.append(one.payload)
                    self._health.look(int(meaning(one, self._source)["time"]))
                case Kind.TELEMETRY:
                    self._hear(*meaning(one, self._source))
                case Kind.MEASURED:
                    self._measured.append(meaning(one, self._source))
                case Kind.EVENT:
                    self._events.append(meaning(one, self._source))

    def _hear(self, arrival_ns: int, packet: bytes) -> None:
        """Keep what a packet wants to be felt, if the session took it."""
        try:
            sample = self._parse(packet)
            wanted = self._wanted(sample)
        except OtolithError:  # as the controller does: it counts them
            return
        before = self._health.counts[Count.TAKEN]
        self._health.take(arrival_ns, sample, wanted)
        if self._health.counts[Count.TAKEN] > before:
            self._felt.append((arrival_ns, wanted, _speed(sample)))

    def signals(self) -> dict[str, list[Signal]]:
        """Return every table that is not empty, by name."""
        set_points = np.frombuffer(b"".join(self._set_points), dtype=SET_POINTS)
        decisions = np.frombuffer(b"".join(self._decisions), dtype=DECISIONS)
        begun = min([int(ticks["time"][0]) for ticks in (set_points, decisions) if len(ticks)], default=0)
        columns = {
            REFERENCE: _reference(self._felt),
            SET_POINT: _set_points(set_points),
            MEASURED: _measured(self._measured),
            DECISION: _decisions(decisions),
            EVENT: _events(self._events),
        }
        made = {}
        for name, (time_ns, values) in columns.items():
            t = 1e-9 * (time_ns - begun).astype(np.float64)
            if len(t):
                made[name] = [Signal(what, unit, t, value) for (what, unit), value in values.items()]
        return made


Named = Mapping[tuple[str, str], NDArray[Any]]  # (name, unit) -> values


def _times(times: Iterable[int]) -> NDArray[np.int64]:
    return np.fromiter(times, dtype=np.int64)


def _reference(felt: list[tuple[int, Vec, float]]) -> tuple[NDArray[np.int64], Named]:
    wanted = np.array([one for _, one, _ in felt]).reshape(-1, 6)
    named: dict[tuple[str, str], NDArray[Any]] = {}
    for part, (names, unit) in enumerate(zip(_FELT, ("m/s^2", "rad/s"), strict=True)):
        named |= {(name, unit): wanted[:, 3 * part + n] for n, name in enumerate(names)}
    speed = np.array([one for *_, one in felt])
    if np.isfinite(speed).all():
        named["speed", "m/s"] = speed
    return _times(arrival for arrival, *_ in felt), named


def _speed(sample: Telemetry) -> float:
    if sample.speed is not None:
        return sample.speed
    return np.nan if sample.velocity is None else float(np.linalg.norm(sample.velocity))


def _set_points(ticks: NDArray[Any]) -> tuple[NDArray[np.int64], Named]:
    motion = ticks["motion"]
    named: dict[tuple[str, str], NDArray[Any]] = {}
    for row, (suffix, per) in enumerate((("", ""), (" velocity", "/s"), (" acceleration", "/s^2"))):
        for axis, name in enumerate(AXES):
            named[f"commanded {name}{suffix}", f"{'m' if axis < 3 else 'rad'}{per}"] = motion[:, row, axis]
    named["state", ""], named["follows", ""] = ticks["state"], ticks["follows"]
    named["sends", ""] = (ticks["flags"] & SENDS).astype(np.uint8)
    return ticks["time"], named


def _measured(heard: list[tuple[int, Feedback]]) -> tuple[NDArray[np.int64], Named]:
    unknown = np.full(6, np.nan)
    poses = np.array([unknown if one.pose is None else one.pose for _, one in heard]).reshape(-1, 6)
    named: dict[tuple[str, str], NDArray[Any]] = {
        (f"measured {name}", "m" if axis < 3 else "rad"): poses[:, axis] for axis, name in enumerate(AXES)
    }
    named["device state", ""] = np.array([DEVICE_STATES.index(one.state) for _, one in heard], dtype=np.uint8)
    named["faults", ""] = _texts(", ".join(one.faults) for _, one in heard)
    return _times(time_ns for time_ns, _ in heard), named


def _decisions(ticks: NDArray[Any]) -> tuple[NDArray[np.int64], Named]:
    return ticks["time"], {("plan", ""): ticks["sequence"], ("missed", ""): ticks["missed"]}


def _events(events: list[Event]) -> tuple[NDArray[np.int64], Named]:
    named = {
        ("before", ""): _texts(event.before for event in events),
        ("after", ""): _texts(event.after for event in events),
        ("reason", ""): _texts(event.reason for event in events),
    }
    return _times(event.time_ns for event in events), named


def _texts(texts: Iterable[str]) -> NDArray[Any]:
    """Return texts as UTF-8 of fixed length."""
    return np.array([text.encode() for text in texts], dtype=np.bytes_)
