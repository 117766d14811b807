"""Any sequence of faults and of the operator's words, by hypothesis: what must hold in every world."""

import functools

import numpy as np
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from otolith.core.frames import SURGE_PITCH, SWAY_ROLL
from otolith.cueing.design import Design
from otolith.cueing.washout.tuning import load_tuning
from otolith.live.audit import audit
from otolith.live.faults import prepare
from otolith.live.messages import DeviceState, Flag, State, Word
from otolith.live.world import World
from otolith.platforms import load
from otolith.registry import make_cueing

MS = 1_000_000
MACHINE = load("davsi-4dof")


@functools.cache
def worlds() -> tuple[World, World]:
    design = Design(platform=load("davsi-4dof"), dofs=(SURGE_PITCH, SWAY_ROLL), washout=load_tuning("davsi"))
    return prepare(make_cueing("classical", design), design.platform, tick=5e-3)


class AnyFault(RuleBasedStateMachine):
    """A world that begins cued, and meets whatever comes."""

    def __init__(self) -> None:
        super().__init__()
        self.world = worlds()[1].again()
        self.world.trace.clear()
        self.world.output.session.events.clear()
        self.words_given: set[Word] = set()

    def go_on(self, seconds: float = 0.15) -> None:
        self.world.run(self.world.seconds + seconds)
        if self.world.latched:  # the supervisor has ended the session: it is started anew
            self.world.restart()
            self.world.run(self.world.seconds + 1.5)

    @rule(word=st.sampled_from(list(Word)))
    def word(self, word: Word) -> None:
        self.words_given.add(word)
        self.world.say(word)
        self.go_on(0.4)

    @rule(seconds=st.sampled_from([0.02, 0.06, 0.15, 1.2]))
    def silence(self, seconds: float) -> None:
        self.world.silence("telemetry", seconds)
        self.go_on(seconds)

    @rule(core=st.sampled_from(["controller", "output"]), seconds=st.sampled_from([0.01, 0.03, 0.2]))
    def hang(self, core: str, seconds: float) -> None:
        self.world.stop(core, seconds)
        self.go_on(seconds + 0.05)

    @rule(cost=st.integers(0, 60))
    def slow(self, cost: int) -> None:
        self.world.costs_ns = [cost * MS] * 4
        self.go_on()

    @rule(flags=st.sampled_from([Flag(0), Flag.RUNNING, Flag.PAUSED, Flag.RUNNING | Flag.REPLAY]))
    def flags(self, flags: Flag) -> None:
        self.world.source.flags = flags
        self.go_on()

    @rule(force=st.floats(-1e30, 1e30), axis=st.integers(0, 2))
    def force(self, force: float, axis: int) -> None:
        numbers = [0.0] * 3
        numbers[axis] = force
        self.world.source.change = lambda values: {**values, "specific force": tuple(numbers)}
        self.go_on()
        self.world.source.change = None

    @rule(state=st.sampled_from([None, *DeviceState]))
    def shown(self, state: DeviceState | None) -> None:
        self.world.device.shown = state
        self.go_on(0.05)
        self.world.device.shown = None

    @rule()
    def device_fails(self) -> None:
        self.world.device.fail(self.world.now_ns, "limit switch")
        self.go_on()

    @rule(sequence=st.integers(0, 10**6))
    def restart(self, sequence: int) -> None:
        self.world.source.sequence = sequence
        self.go_on()

    @rule()
    def nothing(self) -> None:
        self.go_on(2.5)

    @invariant()
    def limits_hold_and_nothing_moves_at_rest(self) -> None:
        trace = self.world.trace
        if len(trace) > 2:
            assert [str(violation) for violation in audit(trace, MACHINE)] == []
            del trace[:-2]

    @invariant()
    def only_words_engage(self) -> None:
        """Every engagement was asked for since the one before, and a fault is left by its word only."""
        events = self.world.output.session.events
        for event in events:
            if event.after is State.ENGAGED and event.before is State.READY:
                assert Word.ENGAGE in self.words_given
            if event.before is State.FAULT:
                assert event.after in {State.IDLE, State.FAULT}
                assert Word.REARM in self.words_given or event.after is State.FAULT
            if event.after is State.CHECKING:
                assert Word.ARM in self.words_given
        if any(event.after is State.RETURNING for event in events):
            self.words_given.discard(Word.ENGAGE)
        events.clear()

    @invariant()
    def set_points_are_numbers(self) -> None:
        assert np.isfinite(self.world.output.motion).all()


TestAnyFault = AnyFault.TestCase
TestAnyFault.settings = settings(
    max_examples=12,
    stateful_step_count=12,
    deadline=None,
    derandomize=True,
    suppress_health_check=list(HealthCheck),
)
