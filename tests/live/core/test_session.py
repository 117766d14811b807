"""The state machine: what every word does in every state."""

import pytest

from otolith.live.core.ladder import InARow, Ladder, Lasting, Reaction, strongest
from otolith.live.core.session import Seen, Session
from otolith.live.messages import Rung, State, Word

R1, R2, R3, R4 = (Reaction(rung, f"cause of R{int(rung)}") for rung in list(Rung)[1:])


def brought_to(state: State) -> Session:
    """A session in a state, by the shortest way."""
    session, tick = Session(), iter(range(1, 100))
    ways: dict[State, list[Seen]] = {State.IDLE: []}
    ways[State.CHECKING] = [Seen(words=(Word.ARM,))]
    ways[State.ENGAGING] = [*ways[State.CHECKING], Seen(passed_checks=True)]
    ways[State.READY] = [*ways[State.ENGAGING], Seen(done=True, brought=True)]
    ways[State.ENGAGED] = [*ways[State.READY], Seen(words=(Word.ENGAGE,), healthy=True)]
    ways[State.HOLDING] = [*ways[State.ENGAGED], Seen(cueing=R2)]
    ways[State.RETURNING] = [*ways[State.ENGAGED], Seen(words=(Word.RETURN,))]
    ways[State.PARKING] = [*ways[State.READY], Seen(words=(Word.PARK,))]
    ways[State.PARKED] = [*ways[State.PARKING], Seen(done=True)]
    ways[State.FAULT] = [*ways[State.READY], Seen(reaction=R4)]
    for seen in ways[state]:
        session.step(next(tick), seen)
    assert session.state is state
    return session


# state -> word -> state; words that are not listed change nothing
EFFECTS = {
    State.IDLE: {Word.ARM: State.CHECKING},
    State.CHECKING: {},
    State.ENGAGING: {Word.STOP: State.RETURNING, Word.PARK: State.RETURNING},
    State.READY: {Word.PARK: State.PARKING, Word.ENGAGE: State.ENGAGED},
    State.ENGAGED: {
        Word.RETURN: State.RETURNING,
        Word.STOP: State.RETURNING,
        Word.PARK: State.RETURNING,
    },
    State.HOLDING: {
        Word.RETURN: State.RETURNING,
        Word.STOP: State.RETURNING,
        Word.PARK: State.RETURNING,
    },
    State.RETURNING: {},
    State.PARKING: {},
    State.PARKED: {Word.ARM: State.CHECKING},
    State.FAULT: {Word.REARM: State.IDLE},
}


@pytest.mark.parametrize("state", list(State))
@pytest.mark.parametrize("word", list(Word))
def test_a_word_has_its_effect_where_the_state_accepts_it_and_none_elsewhere(
    state: State, word: Word
) -> None:
    session = brought_to(state)
    cueing = R2 if state is State.HOLDING else Reaction()
    after = session.step(
        100, Seen(words=(word,), brought=True, healthy=state is not State.HOLDING, cueing=cueing)
    )
    assert after is EFFECTS[state].get(word, state)


@pytest.mark.parametrize("state", list(State))
def test_r4_of_the_device_is_a_fault_in_every_state_and_only_rearm_leaves_it(state: State) -> None:
    session = brought_to(state)
    assert session.step(100, Seen(reaction=R4)) is State.FAULT
    for k, word in enumerate(word for word in Word if word is not Word.REARM):
        assert session.step(101 + k, Seen(words=(word,), healthy=True, done=True)) is State.FAULT
    assert session.step(200, Seen(words=(Word.REARM,))) is State.IDLE
    assert session.step(201, Seen(healthy=True, done=True, passed_checks=True)) is State.IDLE


def test_r3_returns_and_engages_again_only_after_rearm() -> None:
    session = brought_to(State.ENGAGED)
    assert session.step(100, Seen(cueing=R3, brought=True)) is State.RETURNING
    assert session.step(101, Seen(done=True, brought=True)) is State.READY
    assert session.step(102, Seen(words=(Word.ENGAGE,), healthy=True)) is State.READY
    assert session.ladder.kept == R3
    assert session.step(103, Seen(words=(Word.REARM, Word.ENGAGE), healthy=True)) is State.ENGAGED


def test_telemetry_that_is_missing_before_anything_is_cued_leaves_no_trace() -> None:
    session = brought_to(State.READY)
    assert session.step(100, Seen(cueing=R3)) is State.READY
    assert session.ladder.kept.rung is Rung.NONE
    assert session.step(101, Seen(words=(Word.ENGAGE,), cueing=R3, healthy=True)) is State.READY
    assert session.step(102, Seen(healthy=True)) is State.ENGAGED  # what was said is still wanted


def test_every_engagement_has_a_generation_of_its_own() -> None:
    session = brought_to(State.ENGAGED)
    first = session.generation
    session.step(100, Seen(words=(Word.RETURN,)))
    session.step(101, Seen(done=True))
    session.step(102, Seen(words=(Word.ENGAGE,), healthy=True))
    assert session.generation == first + 1


def test_stop_before_the_device_follows_parks_it_instead_of_moving_it() -> None:
    session = brought_to(State.ENGAGING)
    assert session.step(100, Seen(words=(Word.STOP,), brought=False)) is State.PARKING


def test_park_from_engaged_returns_first() -> None:
    session = brought_to(State.ENGAGED)
    states = [session.step(100, Seen(words=(Word.PARK,)))]
    states += [session.step(101 + k, Seen(done=True)) for k in range(2)]
    assert states == [State.RETURNING, State.PARKING, State.PARKED]


def test_the_ladder_keeps_what_only_a_person_ends() -> None:
    ladder = Ladder()
    assert ladder.react(R2) == R2
    assert ladder.react() == Reaction()
    assert ladder.react(R3, R1) == R3
    assert ladder.react(R2) == R3
    assert ladder.react(R4) == R4
    assert ladder.react(R3) == R4
    ladder.rearm()
    assert ladder.react(R1) == R1
    assert strongest() == Reaction()


def test_counts_in_a_row_and_conditions_that_last() -> None:
    row = InARow(3, Rung.RETURN, "misses")
    assert [row.note(x).rung for x in (True, True, False, True, True, True)][-1] is Rung.RETURN
    assert row.note(False).rung is Rung.NONE
    lasting = Lasting(100, Rung.RETURN, "off")
    rungs = [
        lasting.note(present, t).rung for t, present in ((0, True), (99, True), (100, True), (101, False))
    ]
    assert rungs == [Rung.NONE, Rung.NONE, Rung.RETURN, Rung.NONE]
    assert lasting.note(True, 150).rung is Rung.NONE
