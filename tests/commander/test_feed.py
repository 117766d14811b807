"""A live session as rows and state, and the words of its pages, without processes."""

from typing import Any

import numpy as np
import pytest

from otolith.commander.columns import columns
from otolith.commander.feed import WORDS, Feed
from otolith.commander.orders import Note
from otolith.commander.watched import EVENTS, Pages
from otolith.core.frames import GRAVITY
from otolith.live.core.parameters import Parameters
from otolith.live.messages import Plan, Report, State, Vitals, Word
from otolith.platforms import load

NAMES = [column.name for column in columns()]
MS = 1_000_000
DAVSI = load("davsi")


def report(ms: int, state: State = State.ENGAGED) -> Report:
    motion = np.zeros((3, 6))
    motion[0, 0], motion[0, 4], motion[1, 4], motion[2, 0] = 0.1, 0.05, 0.02, 0.7
    return Report(time_ns=ms * MS, motion=motion, state=state, generation=0)


def plan(ms: int, outcome: str = "decided", stages: int = 1) -> Plan:
    return Plan(
        sequence=0,
        generation=0,
        time_ns=ms * MS,
        period_ns=10 * MS,
        stages=np.zeros((stages, 6)),
        telemetry_ns=(ms - 3) * MS,
        outcome=outcome,
        residual=1e-9,
    )


def asks(ms: int, force: np.ndarray) -> Vitals:
    return Vitals(time_ns=ms * MS, asked=force, missed=0, clock_ns=None, parameters=Parameters(scale=0.25))


def value(row: np.ndarray, name: str) -> float:
    return float(row[NAMES.index(name)])


def test_a_row_is_what_the_output_reports_and_the_decision_asks_for() -> None:
    feed = Feed(DAVSI, 1000 * MS)
    feed.vitals(asks(1499, np.array([1.0, 2.0, 3.0])))
    feed.plan(plan(1499))
    feed.report(report(1500))
    (row,) = feed.rows()
    assert len(row) == len(NAMES)
    assert value(row, "time") == pytest.approx(0.5)
    assert [value(row, f"wanted_{axis}") for axis in "xyz"] == [1.0, 2.0, 3.0]
    assert value(row, "felt_x") == pytest.approx(0.7 - GRAVITY * np.sin(0.05), rel=1e-6)
    assert value(row, "pose_x") == pytest.approx(0.1)
    assert value(row, "pose_pitch") == pytest.approx(np.degrees(0.05))
    assert value(row, "tilt_rate_pitch") == pytest.approx(np.degrees(0.02))
    legs = DAVSI.six_legs().lengths(report(0).motion[0])
    assert [value(row, f"leg_{k}") for k in range(1, 7)] == pytest.approx(list(legs))
    assert np.isnan(value(row, "felt2_x"))
    assert len(feed.rows()) == 0


def test_missing_reports_are_a_gap_and_an_old_decision_asks_for_nothing() -> None:
    feed = Feed(DAVSI, 0)
    feed.vitals(asks(0, np.ones(3)))
    for ms in (1, 3, 200):
        feed.report(report(ms))
    rows = feed.rows()
    assert len(rows) == 4
    assert np.isnan(rows[2][1:]).all()
    assert np.isnan(value(rows[3], "wanted_x"))
    assert np.isfinite(value(rows[3], "felt_x"))


def test_the_state_says_which_words_are_possible_and_never_shows_an_old_one_as_running() -> None:
    feed = Feed(DAVSI, 0)
    starting = feed.state(MS)
    assert (starting["running"], starting["words"]) == (False, ["stop"])
    assert starting["text"].startswith("starting")
    feed.vitals(asks(1, np.zeros(3)))
    feed.plan(plan(1, "gate: leg 3"))
    feed.plan(plan(2, stages=0, outcome=""))
    feed.report(report(2, State.READY))
    told = feed.state(10 * MS)
    assert (told["state"], told["running"], told["words"]) == ("ready", True, ["stop", "engage", "park"])
    assert told["lamps"]["gate_refused"] == 1
    assert told["lamps"]["telemetry_age_s"] == pytest.approx(0.011)
    assert feed.state(600 * MS)["running"] is False


def test_the_state_says_what_was_asked_for_of_what_may_change() -> None:
    feed = Feed(DAVSI, 0, offered=("scale",))
    assert feed.state(MS)["parameters"] == {}
    feed.vitals(asks(1, np.zeros(3)))
    assert feed.state(MS)["parameters"] == {"scale": 0.25}


def test_the_words_are_those_that_the_states_of_a_session_accept() -> None:
    """Stop is possible in every state; rearm in a fault only; arm where docs/live.md says so."""
    arming = {state for state, words in WORDS.items() if Word.ARM in words}
    assert arming == {State.IDLE, State.PARKED}
    assert [state for state, words in WORDS.items() if Word.REARM in words] == [State.FAULT]
    assert [state for state, words in WORDS.items() if Word.ENGAGE in words] == [State.READY]


def test_sentences_are_numbered_and_the_oldest_go() -> None:
    stated: list[Any] = []

    class Said(Note):
        def __init__(self) -> None:
            pass

        def state(self, value: Any) -> None:
            stated.append(value)

    pages = Pages(Said(), None, lambda _: "")  # type: ignore[arg-type]
    for k in range(EVENTS + 5):
        pages.tell(f"sentence {k}")
    pages.tell("fault: the output died")
    events = Feed(DAVSI, 0, generation=3).state(MS, stated[-1]["events"])["events"]
    assert len(events) == EVENTS
    assert [one["number"] for one in events] == list(range(7, EVENTS + 7))
    assert (events[-1]["level"], events[0]["level"], events[0]["generation"]) == ("fault", "info", 3)
