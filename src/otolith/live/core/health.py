"""Whether telemetry can be trusted: what is dropped, what is clipped, and what fades the reference.

Every sample is judged when it arrives, and silence whenever somebody asks. A sample is *dropped* (old, twice,
not finite, a spike) or *taken*. Besides, a *disturbance* makes the reference fade (R2), and telemetry must
then be good for one second before it is cued again: a restart of the sender, a jump of its clock, a teleport,
several spikes, a payload that stands still while the vehicle moves, a pause, a replay.

Silence climbs the ladder by itself: R1 up to 100 ms, R2 from there, R3 from one second; a source that falls
silent in its menus is declared `pauses_silently` and stays at R2.
"""

from collections import deque
from dataclasses import dataclass, field, fields
from enum import StrEnum
from typing import Final

import numpy as np

from otolith.core.arrays import Vec
from otolith.live.core.ladder import NO_REACTION, Reaction, strongest
from otolith.live.messages import Flag, Rung, Telemetry

MS: Final = 1_000_000  # [ns]
HOLD: Final = 30 * MS  # silence from which the reference decays
SILENT: Final = 100 * MS  # silence from which the reference fades
LOST: Final = 1000 * MS  # silence that ends cueing
GAP: Final = 1000 * MS  # between two looks at the clock: the machine was suspended
PROVEN: Final = 1000 * MS  # of good telemetry before it is cued
FROZEN: Final = 500 * MS  # of equal payloads while the vehicle moves
CLOCK_JUMP: Final = 1000 * MS  # of the sender's clock against ours
MOVING: Final = 1.0  # [m/s] from which a payload that stands still is suspicious
LARGEST: Final = 50.0  # [m/s²] no car does that; a larger force is a spike
STEEPEST: Final = 30.0  # [m/s²] between two samples; a crash of 20 m/s² passes
FASTEST: Final = 20.0  # [rad/s] an angular rate beyond this is a spike
SPIKES: Final = 3  # in a row that are only dropped
STRAY: Final = 5.0  # [m] that a position may be from where the velocity leads
DISAGREES: Final = 6.0  # [m/s] between the change of speed and the longitudinal force, over half a second
OVER: Final = 0.5  # [s] of that comparison
REORDERED: Final = 64  # a sequence that is less far back arrived late; further back is a restart
LATE_ROW: Final = 16  # packets in a row that seem late: it is a restart after all
SHARE: Final = 0.1  # of packets dropped by sequence in one second that is worth a warning


class Count(StrEnum):
    """What is counted about packets."""

    TAKEN = "taken"
    UNREADABLE = "unreadable"
    NOT_FINITE = "not finite"
    OLD = "out of order"
    TWICE = "twice"
    SPIKE = "spike"
    RESTART = "restart"
    TELEPORT = "teleport"


@dataclass(slots=True)
class _Moment:
    """What was last known of a source."""

    telemetry: Telemetry
    wanted: Vec  # (6,) as received
    time_ns: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Condition:
    """What telemetry is worth now."""

    reaction: Reaction
    healthy: bool  # good for as long as it takes to be cued
    warning: str = ""


@dataclass(slots=True)
class Health:
    """Judges the telemetry of one source.

    Parameters
    ----------
    pauses_silently : the source sends nothing in its menus, so silence alone never ends cueing.
    """

    pauses_silently: bool = False
    counts: dict[Count, int] = field(default_factory=lambda: dict.fromkeys(Count, 0))
    _last: _Moment | None = None  # the latest sample that was taken
    _received: Vec | None = None  # (6,) the latest sample, also if it was a spike
    _good_since: int | None = None
    _disturbed: str = ""  # why telemetry is not good; empty if it is
    _spikes: int = 0
    _late: int = 0
    _changed_ns: int = 0  # when the payload last changed
    _looked_ns: int | None = None
    _mismatch: float = 0.0  # [m/s]
    _proven: bool = False  # good for long enough, when last looked at
    _recent: deque[tuple[int, bool]] = field(default_factory=deque)  # arrivals of one second; dropped or not
    _dropped: int = 0  # of those

    @property
    def clock_ns(self) -> int | None:
        """Return our clock less the sender's when its newest sample came [ns]; None if it tells no time."""
        last = self._last
        if last is None or last.telemetry.sender_ns is None:
            return None
        return last.time_ns - last.telemetry.sender_ns

    def unreadable(self) -> None:
        """Take note of a packet that no parser understands; it counts as missing."""
        self.counts[Count.UNREADABLE] += 1

    def take(self, now_ns: int, telemetry: Telemetry, wanted: Vec) -> bool:
        """Judge one sample; `wanted` (6,) is what it says should be felt. Return whether it may be cued."""
        if not _finite(telemetry, wanted):
            self.counts[Count.NOT_FINITE] += 1
            return False
        if self._out_of_turn(now_ns, telemetry):
            return False
        if self._last is not None and (why := self._break(self._last, now_ns, telemetry)):
            self._disturb(why)
            self._last = _Moment(telemetry, wanted, now_ns)
            self._received = wanted
            self._changed_ns, self._mismatch = now_ns, 0.0
            return False
        if self._is_spike(wanted):
            return self._spike(wanted)
        self._accept(now_ns, telemetry, wanted)
        return self._proven

    def look(self, now_ns: int) -> Condition:
        """Return what telemetry is worth now; call this once per period."""
        gap = self._looked_ns is not None and now_ns - self._looked_ns > GAP
        self._looked_ns = now_ns
        if gap:
            self._disturb("the clock went on without us")
            self._good_since = None
            self._proven = False
            suspended = Reaction(Rung.RETURN, "suspended for more than a second")
            return Condition(reaction=suspended, healthy=False)
        disturbed = Reaction(Rung.FADE, self._disturbed) if self._disturbed else NO_REACTION
        reaction = strongest(self._silence(now_ns), disturbed)
        if reaction.rung >= Rung.FADE:
            self._good_since = None
        self._proven = self._good_since is not None and now_ns - self._good_since >= PROVEN
        return Condition(reaction=reaction, healthy=self._proven, warning=self._warning())

    # What a sample is checked for, in this order.

    def _out_of_turn(self, now_ns: int, telemetry: Telemetry) -> bool:
        """Return whether a sample is old or comes twice, and count it."""
        last = None if self._last is None else self._last.telemetry.sequence
        sequence = telemetry.sequence
        if last is None or sequence is None or sequence > last or self._began_anew(last, sequence):
            self._note(now_ns, dropped=False)
            self._late = 0
            return False
        self.counts[Count.TWICE if sequence == last else Count.OLD] += 1
        self._late += sequence < last
        self._note(now_ns, dropped=True)
        return True

    def _began_anew(self, last: int, sequence: int) -> bool:
        """Return whether a sequence that does not advance belongs to a restart and not to a late packet."""
        return sequence < last - REORDERED or (sequence < last and self._late >= LATE_ROW)

    def _break(self, last: _Moment, now_ns: int, telemetry: Telemetry) -> str:
        """Return why a sample does not continue the one before; empty if it does."""
        before, since = last.telemetry, now_ns - last.time_ns
        if (telemetry.sequence or 0) < (before.sequence or 0):
            self.counts[Count.RESTART] += 1
            return "the sender restarted"
        if before.sender_ns is not None and telemetry.sender_ns is not None:
            passed = telemetry.sender_ns - before.sender_ns
            if passed < 0 or abs(passed - since) > CLOCK_JUMP:
                self.counts[Count.RESTART] += 1
                return f"the sender's clock jumped by {1e-9 * (passed - since):+.1f} s"
        if _teleported(before, telemetry, 1e-9 * since):
            self.counts[Count.TELEPORT] += 1
            return "the vehicle was placed elsewhere"
        return ""

    def _is_spike(self, wanted: Vec) -> bool:
        if float(np.linalg.norm(wanted[:3])) > LARGEST or float(np.abs(wanted[3:]).max()) > FASTEST:
            return True
        if self._last is None or self._received is None:
            return False
        near = (self._received, self._last.wanted)
        return all(float(np.linalg.norm((wanted - known)[:3])) > STEEPEST for known in near)

    def _spike(self, wanted: Vec) -> bool:
        self.counts[Count.SPIKE] += 1
        self._spikes += 1
        self._received = wanted
        if self._spikes > SPIKES:
            self._disturb(f"{self._spikes} spikes in a row")
        return False

    def _accept(self, now_ns: int, telemetry: Telemetry, wanted: Vec) -> None:
        self.counts[Count.TAKEN] += 1
        self._spikes = 0
        if self._last is None or not _equal(self._last.telemetry, telemetry):
            self._changed_ns = now_ns
        self._compare_speed(now_ns, telemetry, wanted)
        self._disturbed = self._now_wrong(now_ns, telemetry)
        if self._disturbed:
            self._good_since = None
        elif self._good_since is None:
            self._good_since = now_ns
        self._last, self._received = _Moment(telemetry, wanted, now_ns), wanted

    def _now_wrong(self, now_ns: int, telemetry: Telemetry) -> str:
        """Return what is wrong with a sample that continues the one before; empty if nothing is."""
        flags = telemetry.flags
        if flags is not None:
            if flags & Flag.REPLAY:
                return "the source shows a replay"
            if flags & Flag.PAUSED or not flags & Flag.RUNNING:
                return "the source pauses"
        if now_ns - self._changed_ns >= FROZEN and _speed(telemetry) > MOVING:
            return "the payload stands still while the vehicle moves"
        if abs(self._mismatch) > DISAGREES:
            return "force and speed contradict each other"
        return ""

    def _compare_speed(self, now_ns: int, telemetry: Telemetry, wanted: Vec) -> None:
        """Compare the longitudinal force with the change of speed, over about half a second."""
        if self._last is None or not _knows_speed(telemetry):
            return
        dt = 1e-9 * (now_ns - self._last.time_ns)
        if not 0.0 < dt < OVER:
            self._mismatch = 0.0
            return
        gained = _speed(telemetry) - _speed(self._last.telemetry)
        self._mismatch += float(wanted[0]) * dt - gained - self._mismatch * dt / OVER

    def _disturb(self, why: str) -> None:
        self._disturbed, self._good_since = why, None

    # What time alone brings about.

    def _silence(self, now_ns: int) -> Reaction:
        if self._last is None:
            return Reaction(Rung.FADE, "no telemetry yet")
        age = now_ns - self._last.time_ns
        words = f"no good telemetry for {age // MS} ms"
        if age > LOST and not self.pauses_silently:
            return Reaction(Rung.RETURN, words)
        if age > SILENT:
            return Reaction(Rung.FADE, words)
        return Reaction(Rung.HOLD, words) if age > HOLD else NO_REACTION

    def _note(self, now_ns: int, *, dropped: bool) -> None:
        self._recent.append((now_ns, dropped))
        self._dropped += dropped
        while self._recent and now_ns - self._recent[0][0] > 1000 * MS:
            self._dropped -= self._recent.popleft()[1]

    def _warning(self) -> str:
        if self._dropped <= SHARE * len(self._recent):
            return ""
        return f"{self._dropped} of {len(self._recent)} packets in one second came twice or out of order"


def _finite(telemetry: Telemetry, wanted: Vec) -> bool:
    numbers = [telemetry.attitude, telemetry.velocity, telemetry.position, telemetry.speed, wanted]
    return all(bool(np.all(np.isfinite(number))) for number in numbers if number is not None)


# What a sample says beside its sequence and time; what changes most often stands first.
_PAYLOAD: Final = sorted(
    {entry.name for entry in fields(Telemetry)} - {"sequence", "sender_ns"},
    key=lambda name: (name not in {"acceleration", "angular_rate", "velocity"}, name),
)


def _equal(one: Telemetry, other: Telemetry) -> bool:
    """Return whether two samples differ in nothing but their sequence and time."""
    pairs = ((getattr(one, name), getattr(other, name)) for name in _PAYLOAD)
    return all(np.array_equal(a, b) if isinstance(a, np.ndarray) else a == b for a, b in pairs)


def _knows_speed(telemetry: Telemetry) -> bool:
    return telemetry.speed is not None or telemetry.velocity is not None


def _speed(telemetry: Telemetry) -> float:
    """Return the speed [m/s]; a source that tells none counts as moving."""
    if telemetry.speed is not None:
        return abs(telemetry.speed)
    return float("inf") if telemetry.velocity is None else float(np.linalg.norm(telemetry.velocity))


def _teleported(before: Telemetry, now: Telemetry, seconds: float) -> bool:
    if now.flags is not None and now.flags & Flag.TELEPORTED:
        return True
    if before.position is None or now.position is None:
        return False
    way = float(np.linalg.norm(now.position - before.position))
    speed = max(_speed(before), _speed(now)) if _knows_speed(now) else np.inf
    return way > STRAY + 2.0 * speed * max(seconds, 0.0)
