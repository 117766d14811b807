"""Perception models against closed forms and against scipy's simulation of the same transfer function."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy import signal

from otolith import registry
from otolith.core.arrays import Vec
from otolith.core.lti import StateSpace
from otolith.perception import TILT_THRESHOLDS, Vestibular, canals, otoliths, sense

OMEGA = np.logspace(-2, 2, 21)


@pytest.mark.parametrize("name", registry.PERCEPTION)
def test_every_model_is_stable_and_has_one_input_and_one_output(name: str) -> None:
    model: StateSpace = registry.PERCEPTION[name].load()()
    assert model.sizes[1:] == (1, 1)
    assert np.all(model.poles.real < 0.0)


def test_models_are_the_printed_transfer_functions() -> None:
    s = 1j * OMEGA
    printed = {
        otoliths.telban: 0.4 * (10 * s + 1) / ((5 * s + 1) * (0.016 * s + 1)),  # eq. 6.4
        otoliths.from_thresholds: 0.0225 * (1 + 22.05 * s) / ((1 + 0.62 * s) * (1 + 0.016 * s)),
        canals.telban: 5.73 * 80 * s**2 / ((1 + 80 * s) * (1 + 5.73 * s)),
        canals.from_thresholds: 2.2 * s * (1 + 0.014 * s) / ((1 + 2.16 * s) * (1 + 0.005 * s)),
    }
    for model, response in printed.items():
        assert_allclose(model().frequency_response(OMEGA)[:, 0, 0], response, rtol=1e-9)


def test_a_sensed_series_is_that_of_scipy() -> None:
    time = np.arange(2000) * 0.01
    force = np.random.default_rng(1).normal(size=(2000, 2)).cumsum(axis=0) * 0.05
    ours = sense(otoliths.telban(), force, 0.01, before=np.zeros(2))
    numerator, denominator = [4.0, 0.4], np.polymul([5.0, 1.0], [0.016, 1.0])
    for axis in range(2):  # lsim, too, takes the input straight between samples, but at 0 from t = 0 on
        from_zero = np.concatenate([[0.0], force[:, axis]])
        _, theirs, _ = signal.lsim((numerator, denominator), from_zero, np.append(time, 20.0))
        later = sense(otoliths.telban(), from_zero[:, None], 0.01, before=np.zeros(1))[:, 0]
        assert_allclose(later, theirs, atol=1e-9)
        assert_allclose(ours[0, axis], 0.0, atol=0.06)  # strictly proper: no jump passes at once


def test_the_initial_state_decides_how_a_change_after_a_long_force_is_felt() -> None:
    # After +3 m/s² for long, felt as 0.4 · 3 = 1.2, braking at −4.2 changes it by 0.8 · (−7.2) = −5.76 at
    # mid frequency; from a state of rest at zero the same braking would be felt as 0.8 · (−4.2) = −3.36.
    braking = np.full((100, 1), -4.2)
    after_3 = sense(otoliths.telban(), braking, 0.01, before=np.array([3.0]))[:, 0]
    after_0 = sense(otoliths.telban(), braking, 0.01, before=np.array([0.0]))[:, 0]
    assert after_3.min() == pytest.approx(1.2 - 5.76, abs=0.1)
    assert after_0.min() == pytest.approx(-3.36, abs=0.1)
    held = sense(otoliths.telban(), braking, 0.01, before=np.array([-4.2]))[:, 0]
    assert_allclose(held, -4.2 * 0.4, atol=1e-12)


def test_the_organs_of_a_driver_feel_three_axes_each_from_rest() -> None:
    n, organs, T = 3000, Vestibular(), 0.01
    turning = np.ones((n, 3)) * np.deg2rad([10.0, 0.0, -5.0])

    def ramp_response(t: Vec) -> Vec:  # ∫ of (T_a e^{−t/T_L} − T_L e^{−t/T_a}) / (T_a − T_L) over t … t + T
        grown = [np.exp(-u / 80.0) - np.exp(-u / 5.73) for u in (t, t + T)]
        return 80.0 * 5.73 / (80.0 - 5.73) * (grown[1] - grown[0]) / T

    expected = (
        turning[0] * ramp_response(np.arange(n, dtype=float) * T)[:, None]
    )  # the rate rises before the first sample
    assert_allclose(organs.rate(turning, T), expected, atol=1e-12)
    force = organs.force(np.ones((n, 3)), T, before=np.ones(3))
    assert_allclose(force, 0.4, atol=1e-12)


def test_thresholds_are_those_of_table_b5() -> None:
    pitch = [t.pitch_degps for t in TILT_THRESHOLDS if t.pitch_degps is not None]
    roll = [t.roll_degps for t in TILT_THRESHOLDS if t.roll_degps is not None]
    assert pitch == [3.0, 3.0, 3.6, 3.0, 2.0, 2.04, 6.0, 6.0]
    assert roll == [3.0, 2.3, 3.0, 4.0, 2.0, 2.04, 6.3]
