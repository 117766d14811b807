from functools import partial

import numpy as np
import pytest
from numpy.testing import assert_allclose

from otolith.core.arrays import Vec
from otolith.core.frames import GRAVITY
from otolith.cueing.washout.classical import hold_response
from otolith.cueing.washout.optimal import optimal, optimal_nonlinear
from otolith.cueing.washout.riccati import lq_problem
from otolith.perception import Vestibular
from tests.cueing.washout.loop import Task, along, drive, fitted


@pytest.mark.parametrize("omega", [0.3, 1.0, 4.0, 10.0])
def test_small_signals_are_the_filter(omega: float) -> None:
    tuning = Task().tuning
    assert tuning.optimal is not None
    W = lq_problem(tuning.optimal, Vestibular(), rotates=True, translates=True).filter()
    response = W.frequency_response(np.array([omega]))[0]
    paper = response[1, 1] + GRAVITY * response[0, 1] / (1j * omega)
    paper *= tuning.scaling.force.slope * hold_response(np.array([omega]))[0]
    run = drive(
        optimal(Task()),
        2 * max(60.0, 8 * np.pi / omega),
        along(0, lambda t: 0.01 * np.sin(omega * t)),
        plant_period=2e-3 if omega > 3.0 else 1e-2,
    )
    ratio = fitted(run.time - 0.5 * run.plant_period, run.felt_force[:, 0], omega) / 0.01 / paper
    assert abs(abs(ratio) - 1.0) < 0.01
    assert abs(np.degrees(np.angle(ratio))) < 1.0


def pulse(size: float, t: Vec) -> Vec:
    return np.where((t > 0.5) & (t < 3.0), size, 0.0)


def test_the_nonlinear_variant_is_the_linear_one_for_small_signals_and_travels_less_for_large() -> None:
    travel = {}
    for size in (1e-4, 3.0):
        force = along(0, partial(pulse, size))
        runs = [drive(make(Task()), 8.0, force, plant_period=0.01) for make in (optimal, optimal_nonlinear)]
        travel[size] = [np.abs(run.pose[:, 0]).max() for run in runs]
    assert travel[1e-4][1] == pytest.approx(travel[1e-4][0], rel=1e-4)
    assert travel[3.0][1] < 0.8 * travel[3.0][0]


def test_force_and_rate_together_are_the_sum_of_each_alone() -> None:
    force, rate = along(0, lambda t: 0.1 * np.sin(t)), along(1, lambda t: 0.01 * np.cos(2 * t))
    both, one, other = (
        drive(optimal(Task()), 6.0, *signals, plant_period=0.01)
        for signals in ((force, rate), (force,), (along(0, np.zeros_like), rate))
    )
    assert_allclose(both.pose, one.pose + other.pose, atol=1e-4 * np.abs(both.pose).max())
