import pickle
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.signal import chirp as scipy_chirp

from otolith.core.arrays import Vec
from otolith.core.errors import InputError
from otolith.scenarios import signals
from otolith.scenarios.scenario import Scenario

T = np.linspace(0.0, 20.0, 4001)


def along(scenario: Scenario, t: Vec = T, index: int = 0) -> Vec:
    return scenario.specific_force(t)[:, index]


@given(amplitude=st.floats(-30, 30), frequency=st.floats(0.01, 50), start=st.floats(0, 9))
def test_a_sine_starts_at_zero_phase_after_its_rest(amplitude: float, frequency: float, start: float) -> None:
    made = along(signals.sine(amplitude, frequency, start=start))
    tau = T - start
    assert_allclose(made, np.where(tau >= 0, amplitude * np.sin(2 * np.pi * frequency * tau), 0.0), atol=1e-9)


def test_a_step_is_right_continuous() -> None:
    t = np.array([0.999999, 1.0, 4.999999, 5.0, 9.0])
    assert along(signals.step(2.0), t).tolist() == [0.0, 2.0, 2.0, 0.0, 0.0]


@given(rise=st.floats(0, 4), fall=st.floats(0, 4), amplitude=st.floats(-30, 30))
def test_a_step_may_grow_and_fade_along_straight_lines(rise: float, fall: float, amplitude: float) -> None:
    made = along(signals.step(amplitude, start=1.0, end=5.0, rise=rise, fall=fall))
    grown = np.clip((T - 1.0) / max(rise, 1e-12), 0.0, 1.0)
    left = np.clip((5.0 + fall - T) / max(fall, 1e-12), 0.0, 1.0)
    ramps = [np.abs(T - corner) > 1e-6 for corner in (1.0, 1.0 + rise, 5.0, 5.0 + fall)]
    sure = np.all(ramps, axis=0)  # at a jump itself rounding decides
    assert_allclose(made[sure], (amplitude * np.minimum(grown, left))[sure], atol=1e-6)


def test_a_step_can_grow_no_longer_than_it_lasts() -> None:
    with pytest.raises(InputError, match=r"rise is 5 s, must be from 0 s to .* from start to end, 2 s"):
        signals.step(1.0, start=1.0, end=3.0, rise=5.0)


def test_step_sine_is_a_step_and_later_a_sine() -> None:
    late = signals.sine(0.5, 0.1, start=10.0, duration=20.0)
    expected = along(signals.step(0.5)) + along(late)
    assert_allclose(along(signals.step_sine(0.5)), expected)


def test_combined_is_the_scaled_sum_of_its_sines() -> None:
    """Eq. 5.1 with Table 5.1's waves."""
    waves = [(1.0, 0.1), (0.8, 0.15), (0.1, 0.2), (0.6, 0.5)]
    expected = 0.3 * sum(a * np.sin(2 * np.pi * f * (T - 1.0)) for a, f in waves) * (T >= 1.0)
    assert_allclose(along(signals.combined()), expected, atol=1e-14)


def test_a_chirp_is_scipys() -> None:
    made = along(signals.chirp(2.0, low=0.1, high=1.5, duration=20.0))
    expected = 2.0 * scipy_chirp(T - 1.0, 0.1, 19.0, 1.5, phi=-90)
    assert_allclose(made, np.where(T >= 1.0, expected, 0.0), atol=1e-12)


@given(seed=st.integers(0, 2**63), amplitude=st.floats(0.1, 5))
def test_a_multisine_grows_from_rest_without_a_jump(seed: int, amplitude: float) -> None:
    """Below full height its slope is bounded by that of the sines plus that of the fade."""
    made = along(signals.multisine(seed, amplitude, high=1.0, count=8))
    assert not made[T <= 1.0].any()
    steepest = amplitude * np.sqrt(8) * (2 * np.pi * 1.0 + np.pi / 2)  # ‖a‖₁ ≤ √8 ‖a‖₂
    assert np.abs(np.diff(made)).max() <= steepest * (T[1] - T[0])


def test_a_multisine_has_the_mean_square_of_one_sine() -> None:
    t = np.linspace(2.0, 2002.0, 400_001)
    made = along(signals.multisine(3, 0.8, duration=3000.0), t)
    assert np.sqrt(np.mean(made**2)) == pytest.approx(0.8 / np.sqrt(2), rel=0.01)


def test_equal_seeds_give_equal_signals_and_others_do_not() -> None:
    one, again, other = (along(signals.multisine(seed)) for seed in (1, 1, 2))
    assert np.array_equal(one, again)
    assert np.abs(one - other).max() > 0.1


def test_a_lateral_signal_is_the_second_component() -> None:
    scenario = signals.sine(1.0, 0.2, axis="lateral")
    assert not along(scenario, index=0).any()
    assert not along(scenario, index=2).any()
    assert_allclose(along(scenario, index=1), along(signals.sine(1.0, 0.2)))
    assert not scenario.angular_rate(T).any()
    assert scenario.angular_rate(T).shape == (len(T), 3)


@pytest.mark.parametrize("make", [signals.sine, signals.step_sine, signals.multisine, signals.chirp])
def test_scenarios_travel_to_other_processes(make: Callable[[], Scenario]) -> None:
    scenario = make()
    assert_allclose(along(pickle.loads(pickle.dumps(scenario))), along(scenario))


@pytest.mark.parametrize(
    ("make", "options", "sentence"),
    [
        (signals.sine, {"amplitude": 31.0}, "amplitude is 31 m/s², must be between -30 and 30 m/s²"),
        (signals.sine, {"amplitude": np.nan}, "amplitude is nan m/s², must be between -30 and 30 m/s²"),
        (signals.sine, {"frequency": 0.0}, "frequency is 0 Hz, must be greater than 0 and at most 50 Hz"),
        (signals.sine, {"frequency": 51.0}, "frequency is 51 Hz, must be greater than 0 and at most 50 Hz"),
        (signals.sine, {"duration": np.inf}, "duration is inf s, must be between 0.1 and 3600 s"),
        (signals.sine, {"start": 10.0}, "start is 10 s, must be at least 0 s and before the duration, 10 s"),
        (signals.sine, {"axis": "up"}, "axis is 'up', must be one of longitudinal, lateral, vertical, yaw"),
        (signals.step, {"end": 1.0}, "end is 1 s, must be after the start, 1 s, and at most 3600 s"),
        (
            signals.step_sine,
            {"sine_start": -1.0},
            "sine_start is -1 s, must be at least 0 s and before the duration, 20 s",
        ),
        (signals.combined, {"scale": 11.0}, "scale is 11, must be between -10 and 10"),
        (signals.chirp, {"low": 2.0}, "low is 2 Hz, must be at most high, 1 Hz"),
        (signals.multisine, {"seed": -1}, "seed is -1, must be between 0 and 9.22337e+18"),
        (signals.multisine, {"count": 0}, "count is 0, must be between 1 and 100"),
    ],
)
def test_a_parameter_beyond_its_bound_is_named(make, options, sentence: str) -> None:
    with pytest.raises(InputError) as caught:
        make(**options)
    assert str(caught.value) == sentence


def test_along_yaw_a_signal_is_the_turn_of_a_car_at_ten_metres_per_second() -> None:
    """Lateral force = speed times yaw rate."""
    t = np.linspace(0.0, 10.0, 101)
    sideways = signals.sine(2.0, 0.2, axis="lateral").specific_force(t)[:, 1]
    turning = signals.sine(2.0, 0.2, axis="yaw").angular_rate(t)[:, 2]
    assert_allclose(10.0 * turning, sideways, atol=1e-15)
