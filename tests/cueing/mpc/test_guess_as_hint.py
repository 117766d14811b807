"""Rows along a guess of the controls, against the trajectory rolled out by hand."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from otolith.core.arrays import Mat, Vec
from otolith.core.frames import SURGE_PITCH, SWAY_ROLL
from otolith.cueing.mpc.guess import NoGuess
from otolith.cueing.mpc.guess_as_hint import CLOSE, GuessAsHint
from otolith.cueing.mpc.problem import Problem
from otolith.cueing.mpc.settings import BLOCKS, MpcSettings
from otolith.platforms import load
from otolith.qp.engines import CondensedEngine

FORMS = {"full": MpcSettings(), "blocked": MpcSettings(horizon=sum(BLOCKS), blocks=BLOCKS)}


class Fixed:
    active = True

    def __init__(self, controls: Mat) -> None:
        self._controls = controls

    def reset(self) -> None:
        pass

    def controls(self, x: Vec, wanted: Vec, plan: Mat) -> Mat:
        return self._controls


@pytest.mark.parametrize("form", FORMS)
def test_rows_at_their_bounds_along_the_guess_are_named(form: str) -> None:
    settings, pairs = FORMS[form], (SURGE_PITCH, SWAY_ROLL)
    problem = Problem(load("thesis"), pairs, settings)
    memory = CondensedEngine(problem.structure, tolerance=1e-6, blocks=settings.blocks).memory
    problem.begin(memory)
    assert problem.circle is not None
    weights = problem.circle.weights
    controls = np.tile([0.3, 5.0, -0.2, -0.5], (settings.horizon, 1))  # surge at its command bound
    x = np.array([0.0, 0.1, 0.2, 0.3, 0.0, 0.0, 0.0, -0.1, 0.0, -0.39, 0.0, 0.0])
    found = GuessAsHint(Fixed(controls), problem, memory).sets(x, np.zeros(2), controls)
    assert found is not None
    state, rows = x.copy(), []
    for u in controls:
        state = problem.structure.A @ state + problem.structure.B @ u
        longitudinal, lateral = (weights @ state[[p + 2, p + 3, p + 4]] for p in (0, 6))
        circle = [np.hypot(longitudinal, lateral)]
        rows.append(np.concatenate([problem.structure.C @ state, circle, u]))
    values = np.array(rows)[np.cumsum(settings.lengths) - 1]
    with np.errstate(invalid="ignore"):  # of infinite bounds: NaN, which compares false
        expected = np.where(values >= memory.upper - CLOSE * abs(memory.upper), 1, 0)
        expected -= np.where(values <= memory.lower + CLOSE * abs(memory.lower), 1, 0)
    assert_array_equal(found, expected[None])
    assert found[0, :, -3].all()  # the command
    assert found[0, :, -5].any()  # the circle, left by and by


def test_no_guess_is_no_hint() -> None:
    problem = Problem(load("thesis"), (SURGE_PITCH,), FORMS["full"])
    memory = CondensedEngine(problem.structure, tolerance=1e-6).memory
    assert GuessAsHint(NoGuess(), problem, memory).sets(np.zeros(6), np.zeros(1), np.zeros((50, 2))) is None
