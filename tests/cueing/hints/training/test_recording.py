"""A recording's answers are the answers of its questions, by an engine that shares nothing with the first."""

import pickle
from dataclasses import fields, replace

import numpy as np
import pytest

from otolith.core.frames import SURGE_PITCH, SWAY_ROLL
from otolith.cueing.hints.training.compare import Problems
from otolith.cueing.hints.training.manoeuvres import along, unseen
from otolith.cueing.hints.training.recording import record
from otolith.cueing.mpc.problem import Problem
from otolith.cueing.prediction import parse_prediction
from otolith.qp.engines import CondensedEngine
from tests.cueing.hints.training.tiny import PAIRS, SETTINGS, THESIS, recording_of, unseen_recording


@pytest.mark.parametrize("prediction", [None, "decay:time=0.7"])
def test_every_recorded_question_has_its_own_answer(prediction: str | None) -> None:
    settings = SETTINGS if prediction is None else replace(SETTINGS, prediction=parse_prediction(prediction))
    recording = unseen_recording() if prediction is None else recording_of(settings)
    assert len(recording) == 300
    assert recording.solved.all()
    assert recording.begins.sum() == 1
    problems = Problems(Problem(THESIS, PAIRS, settings), recording)
    engine = problems.engine(CondensedEngine)
    for i in range(0, len(recording), 7):
        problems.write(engine, i)
        solution = engine.run()
        np.testing.assert_allclose(solution.U[0], recording.first[i], atol=1e-6)
        clear = np.abs(solution.y) > 1e-6
        np.testing.assert_array_equal(solution.working_set[clear], recording.sets[i][clear])


def test_processes_that_share_the_manoeuvres_record_the_same() -> None:
    made = [record(THESIS, PAIRS, SETTINGS, along(unseen()[:3], PAIRS), jobs=jobs) for jobs in (1, 2)]
    for one in fields(made[0]):
        np.testing.assert_array_equal(getattr(made[1], one.name), getattr(made[0], one.name), one.name)
    assert made[1].begins.sum() == 3


def test_degrees_of_freedom_that_came_from_another_process_make_the_same_problem() -> None:
    pairs = (SURGE_PITCH, SWAY_ROLL)
    copies = pickle.loads(pickle.dumps(pairs))
    made = [record(THESIS, of, SETTINGS, along(unseen()[:1], pairs, seed=1)) for of in (pairs, copies)]
    np.testing.assert_array_equal(made[0].first, made[1].first)
