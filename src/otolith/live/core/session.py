"""The states of a session, and what leads from one to the next.

```
 idle ─arm─► checking ─► engaging ─► ready ─engage─► engaged ◄──► holding
  ▲              │                   ▲   │              │            │
  │ rearm        └──► idle           │   │              ▼    R3      ▼
 fault ◄── R4 in any state           └───┼────────── returning ◄─────┘
                                         └─park─► parking ─► parked ─arm─► checking
```

Only `idle` and `parked` accept *arm*. *stop* is R3 by hand: brake, return to neutral, and wait to be
re-armed. *return* does the same and needs no re-arming; *park* returns first where the platform is cued. Only
*rearm* leaves `fault`, to `idle`; it also ends an R3, in `ready`. Nothing is engaged again by the end of a
fault's cause.
"""

from dataclasses import dataclass
from typing import Final

from otolith.live.core.ladder import NO_REACTION, Ladder, Reaction, strongest
from otolith.live.messages import Rung, State, Word

# States in which the set-points move, or hold the platform under power.
POWERED: Final = frozenset(
    {State.ENGAGING, State.READY, State.ENGAGED, State.HOLDING, State.RETURNING, State.PARKING}
)
CUED: Final = frozenset({State.ENGAGED, State.HOLDING})
STILL: Final = frozenset({State.IDLE, State.CHECKING, State.PARKED, State.FAULT})


@dataclass(frozen=True, slots=True, kw_only=True)
class Seen:
    """What a state machine has to know of one tick."""

    words: tuple[Word, ...] = ()
    reaction: Reaction = NO_REACTION  # to what the device and the output do
    cueing: Reaction = NO_REACTION  # to telemetry and to what the controller decides; only where it is cued
    brought: bool = False  # the device is engaged, and has to follow
    passed_checks: bool = False  # in `checking`: the device answers, and can be engaged
    done: bool = False  # the motion that the state is there for has come to its end
    healthy: bool = False  # telemetry may be cued
    parked: str = "parked"  # what may be claimed of a device that has parked


@dataclass(frozen=True, slots=True)
class Event:
    """A change of state, for the log."""

    time_ns: int
    before: State
    after: State
    reason: str


class Session:
    """The state machine. It knows no clock and no device: it is told what is seen, and says what is next."""

    def __init__(self) -> None:
        self.state = State.IDLE
        self.since_ns = 0  # [ns] of the last change
        self.generation = 0  # counts engagements; plans of another one are refused
        self.ladder = Ladder()
        self.events: list[Event] = []
        self._wants_engaged = False  # the operator's word, until telemetry is healthy
        self._wants_parked = False

    def step(self, now_ns: int, seen: Seen) -> State:
        """Take in one tick and return the state that holds now."""
        for word in seen.words:
            self._say(now_ns, word, seen)
        reaction = self._reaction(seen)
        if reaction.rung >= Rung.FAULT and self.state is not State.FAULT:
            self._go(now_ns, State.FAULT, reaction.reason)
        elif reaction.rung >= Rung.RETURN:
            self._end(now_ns, reaction.reason, seen)
        self._advance(now_ns, seen, reaction)
        return self.state

    def _reaction(self, seen: Seen) -> Reaction:
        """Return what is to be done; a reaction is kept only where there is something to end."""
        cueing = seen.cueing if self.state in CUED else NO_REACTION
        if self.state in POWERED:
            return self.ladder.react(seen.reaction, cueing)
        return strongest(self.ladder.kept, seen.reaction)

    def _say(self, now_ns: int, word: Word, seen: Seen) -> None:
        """Obey a word of the operator where the state accepts it; elsewhere it has no effect."""
        state = self.state
        match word:
            case Word.ARM if state in {State.IDLE, State.PARKED} and self.ladder.kept.rung is Rung.NONE:
                self._go(now_ns, State.CHECKING, "arm")
            case Word.ENGAGE if state is State.READY and self.ladder.kept.rung is Rung.NONE:
                self._wants_engaged = True
            case Word.RETURN if state in CUED:
                self._go(now_ns, State.RETURNING, "return")
            case Word.STOP if state in POWERED:
                self._end(now_ns, self.ladder.react(Reaction(Rung.RETURN, "stop")).reason, seen)
            case Word.PARK if state in POWERED - {State.PARKING}:
                self._park(now_ns, seen)
            case Word.REARM:
                self._rearm(now_ns)

    def _rearm(self, now_ns: int) -> None:
        if self.state is State.FAULT:
            self.ladder.rearm()
            self._go(now_ns, State.IDLE, "rearm")
        elif self.state in {State.READY, State.IDLE, State.PARKED}:
            self.ladder.rearm()

    def _park(self, now_ns: int, seen: Seen) -> None:
        self._wants_engaged = False
        if self.state is State.READY or not self._moving(seen):
            self._go(now_ns, State.PARKING, "park")
            return
        self._wants_parked = True
        if self.state is not State.RETURNING:
            self._go(now_ns, State.RETURNING, "park")

    def _end(self, now_ns: int, reason: str, seen: Seen) -> None:
        """Bring the platform to neutral where it moves; withdraw what was wanted."""
        self._wants_engaged = False
        if self.state in CUED or (self.state is State.ENGAGING and self._moving(seen)):
            self._go(now_ns, State.RETURNING, reason)
        elif self.state is State.ENGAGING:
            self._go(now_ns, State.PARKING, reason)
        elif self.state is State.CHECKING:
            self._go(now_ns, State.IDLE, reason)

    def _moving(self, seen: Seen) -> bool:
        """Return whether the device follows; while it engages by itself, it does not yet."""
        return self.state is not State.ENGAGING or seen.brought

    def _advance(self, now_ns: int, seen: Seen, reaction: Reaction) -> None:
        """Go on where the state has reached its end."""
        match self.state:
            case State.CHECKING if seen.passed_checks:
                self._go(now_ns, State.ENGAGING, "checked")
            case State.ENGAGING if seen.done:
                self._go(now_ns, State.READY, "at neutral")
            case State.READY if self._wants_engaged and seen.healthy and seen.cueing.rung < Rung.FADE:
                self.generation += 1
                self._go(now_ns, State.ENGAGED, "engage")
            case State.ENGAGED if reaction.rung >= Rung.FADE:
                self._go(now_ns, State.HOLDING, reaction.reason)
            case State.HOLDING if reaction.rung < Rung.FADE and seen.healthy:
                self._go(now_ns, State.ENGAGED, "telemetry is good again")
            case State.RETURNING if seen.done:
                self._go(now_ns, State.PARKING if self._wants_parked else State.READY, "at neutral")
            case State.PARKING if seen.done:
                self._go(now_ns, State.PARKED, seen.parked)

    def give_up(self, now_ns: int, reason: str) -> None:
        """Give up checking or engaging: the platform stays where it is."""
        if self.state in {State.CHECKING, State.ENGAGING}:
            self._go(now_ns, State.IDLE, reason)

    def _go(self, now_ns: int, state: State, reason: str) -> None:
        if state is not State.READY:
            self._wants_engaged = False
        if state in {State.PARKING, State.FAULT, State.IDLE}:
            self._wants_parked = False
        self.events.append(Event(now_ns, self.state, state, reason))
        self.state, self.since_ns = state, now_ns
