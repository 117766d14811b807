"""Counting beside a fast engine gives the counts of the slow one, and takes no part in a step's time."""

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from otolith.core.arrays import Ints
from otolith.core.frames import SURGE_PITCH
from otolith.cueing.hints.training.compare import Problems
from otolith.cueing.hints.training.manoeuvres import Manoeuvre, along
from otolith.cueing.hints.training.recording import Recording, record
from otolith.cueing.mpc.problem import Problem
from otolith.cueing.mpc.settings import MpcSettings
from otolith.platforms import load
from otolith.qp.engines import CondensedEngine, StageEngine
from otolith.scenarios.waves import Pulse
from otolith_thesis.counting_engine import COUNTED, CountedEngine, clock_of, engine_named
from otolith_thesis.emulator import Case
from otolith_thesis.loop import Loop

THESIS, PAIRS, SETTINGS = load("thesis"), (SURGE_PITCH,), MpcSettings()
SHORT = Loop(scenario="step:amplitude=1.5,duration=1.5,start=0.2,end=1", solver=COUNTED)


@pytest.mark.parametrize("cueing", ["implicit", "hybrid-all"])
def test_the_count_is_that_of_the_dense_engine(cueing: str) -> None:
    counted = replace(SHORT, cueing=cueing).run()
    dense = replace(SHORT, cueing=cueing, solver="dense").run()
    assert counted.changes.sum() > 50
    np.testing.assert_array_equal(counted.changes, dense.changes)
    assert counted.rmse == pytest.approx(dense.rmse, rel=1e-6)


def test_soft_rows_are_counted_alike() -> None:
    case = Case(scenario="step-0.1", where="offline", cueing="implicit", solver=COUNTED)
    counted, dense = case.run(), replace(case, solver="dense").run()
    assert counted.changes.sum() > 0
    np.testing.assert_array_equal(counted.changes, dense.changes)


def test_with_a_hint_the_count_begins_from_the_better_set() -> None:
    pulse = Manoeuvre("pulse", 3.0, Pulse(-0.8, 0.7, 1.9))
    recording = record(THESIS, PAIRS, SETTINGS, along((pulse,), PAIRS), plans=True)
    counted, dense = (_counts(recording, engine) for engine in (CountedEngine, CondensedEngine))
    np.testing.assert_array_equal(counted, dense)
    assert counted.sum() < 0.5 * recording.changed(np.ones(recording.sets[0].size, dtype=np.bool_)).sum()


def _counts(recording: Recording, make: Callable[..., StageEngine]) -> Ints:
    """Changes of every decision from the set before, with the right answer for a hint."""
    problems = Problems(Problem(THESIS, PAIRS, SETTINGS), recording)
    engine, changes = problems.engine(make), []
    for i in range(len(recording)):
        problems.write(engine, i)
        right = recording.sets[i].astype(np.int64)
        changes.append(engine.run(hint=partial(np.copy, right)).changes)
    return np.array(changes)


def test_the_clock_stands_still_while_counting() -> None:
    pulse = Manoeuvre("pulse", 3.0, Pulse(-0.8, 0.7, 1.9))
    recording = record(THESIS, PAIRS, SETTINGS, along((pulse,), PAIRS), plans=True)
    problems = Problems(Problem(THESIS, PAIRS, SETTINGS), recording)
    engine = problems.engine(CountedEngine)
    began, on_clock = time.thread_time(), engine.clock()
    for i in range(len(recording)):
        problems.write(engine, i)
        engine.run()
    assert 0.0 < engine.clock() - on_clock < time.thread_time() - began


def test_engines_have_names() -> None:
    assert engine_named(COUNTED) is CountedEngine
    assert engine_named("dense") is CondensedEngine
    assert clock_of(SHORT.controller()) != time.thread_time
    assert clock_of(replace(SHORT, solver="structured").controller()) is time.thread_time
