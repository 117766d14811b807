from functools import partial

import numpy as np
import pytest
from numpy.testing import assert_allclose

from otolith.core.arrays import Vec
from otolith.core.frames import SURGE_PITCH
from otolith.core.methods import hold
from otolith.cueing.washout.adaptive import Memory, adaptive, memory, step
from otolith.cueing.washout.tuning import Tuning
from tests.cueing.washout.loop import Task, along, drive

T = 0.01


def tuned(**values: float) -> Tuning:
    tuning = Task().tuning
    assert tuning.adaptive is not None
    return tuning.model_copy(update={"adaptive": tuning.adaptive.model_copy(update=values)})


class Channels:
    """The adaptive channels without a washout around them."""

    def __init__(self, task: Task) -> None:
        self.memory: Memory = memory(task, T)
        self.gains, self.rate_gains = self.memory.gains, self.memory.rate_gains
        self._held, _ = hold(self.memory)

    def step(self, a: float, q: float = 0.0) -> Vec:
        """The motion (12,) for an acceleration along x and a rate about y."""
        motion, demand = np.zeros(12), np.zeros(9)
        demand[[0, 3, 7]] = a, a, q
        step(self._held, 0, demand, motion)
        return motion


def test_gains_follow_the_gradient_of_the_cost() -> None:
    """ΔP = −K T ∂J/∂P, the derivative by finite differences of two washouts with gains held at P ± h."""
    of = Task().tuning.adaptive
    assert of is not None
    h, signal = 1e-4, [0.8 * np.sin(0.05 * k) for k in range(120)]

    def cost(P: float) -> float:
        channels = Channels(Task(tuning=tuned(speed=1e-6)))
        for a in signal:
            channels.gains[:] = P
            s, v, acc = channels.memory.travel.step(np.array([P * a]))
        return 0.5 * (
            of.force_weight * (signal[-1] - acc) ** 2
            + of.velocity_weight * v**2
            + of.position_weight * s**2
            + of.gain_weight * (P - 1.0) ** 2
        )

    channels = Channels(Task())
    P = 0.9
    for a in signal[:-1]:
        channels.gains[:] = P
        channels.step(a)
    channels.gains[:] = P
    channels.step(signal[-1])
    expected = P - T * of.speed * (cost(P + h) - cost(P - h)) / (2 * h)
    assert channels.gains[0] == pytest.approx(expected, rel=1e-6)
    assert abs(channels.gains[0] - P) > 1e-6


def test_gains_stay_within_their_bounds_and_motion_finite_under_anything() -> None:
    of = Task().tuning.adaptive
    assert of is not None
    channels = Channels(Task(dofs=(SURGE_PITCH,)))
    rng = np.random.default_rng(3)
    seen = []
    for _ in range(3000):
        motion = channels.step(*(1e3 * rng.standard_t(1.5, size=2)))
        seen.append([channels.gains[0], channels.rate_gains[0]])
        assert np.isfinite(motion).all()
    assert np.min(seen) >= of.least_gain
    assert np.max(seen) <= of.largest_gain
    assert np.min(seen) == of.least_gain  # they were reached


def test_gains_return_to_neutral_when_nothing_happens() -> None:
    channels = Channels(Task())
    channels.gains[:], channels.rate_gains[:] = 0.3, 0.5
    for _ in range(6000):
        channels.step(0.0)
    assert_allclose([channels.gains[0], channels.rate_gains[0]], 1.0, atol=1e-4)


def swing(size: float, t: Vec) -> Vec:
    return size * np.sin(0.6 * t)


def test_adapting_spares_travel_on_hard_manoeuvres_and_keeps_gentle_ones() -> None:
    """What adaptation is for: the same washout, with and without it."""
    travel = {}
    for size in (0.2, 4.0):
        force = along(0, partial(swing, size))
        frozen = adaptive(Task(tuning=tuned(speed=1e-6, rate_speed=1e-6)))
        runs = [drive(washout, 20.0, force, plant_period=T) for washout in (adaptive(Task()), frozen)]
        travel[size] = np.abs(runs[0].pose[:, 0]).max() / np.abs(runs[1].pose[:, 0]).max()
    assert travel[0.2] > 0.9
    assert travel[4.0] < 0.7
