import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from otolith.core.arrays import Vec
from otolith.core.errors import InputError
from otolith.recordings import Log, log_scenario, sampled_log
from otolith.scenarios.scenario import Scenario


def log_of(t: Vec, ax: Vec) -> Log:
    force = np.stack([ax, -ax, 0.5 * ax], axis=1)
    rate = np.stack([0.1 * ax, 0.2 * ax, 0.3 * ax], axis=1)
    return sampled_log("drives/tour.csv", t, force, rate)


def sampled(scenario: Scenario, dt: float = 0.01) -> tuple[Vec, Vec]:
    t = np.arange(round(scenario.duration / dt), dtype=float) * dt
    return t, scenario.specific_force(t)[:, 0]


def gain(scenario: Scenario, frequency: float, dt: float = 0.01) -> complex:
    """Amplitude and phase of a sine of that frequency in the middle of the drive."""
    t, f = sampled(scenario, dt)
    middle = (t > 19.995) & (t < 39.995)  # whole periods
    return complex(2 * np.mean(f[middle] * np.exp(-2j * np.pi * frequency * t[middle])) * 1j)


EVEN = np.arange(6001, dtype=float) * 0.01


def sine_log(frequency: float, t: Vec = EVEN) -> Log:
    return log_of(t, np.sin(2 * np.pi * frequency * t))


def test_an_even_log_at_the_controllers_rate_passes_unchanged() -> None:
    log = sine_log(1.0)
    scenario = log_scenario(log)
    assert scenario.name == "tour"
    assert scenario.duration == 60.0
    assert_allclose(scenario.specific_force(EVEN), log.force, atol=1e-12)
    assert_allclose(scenario.angular_rate(EVEN), log.rate, atol=1e-12)


def test_first_and_last_value_hold_beyond_the_drive() -> None:
    log = log_of(EVEN, 1.0 + EVEN)
    assert_allclose(log_scenario(log).specific_force(np.array([-5.0, 99.0]))[:, 0], [1.0, 61.0])


@given(scale=st.floats(0.01, 10), rate_scale=st.floats(0.01, 10))
def test_scales_act_on_force_and_rate_apart(scale: float, rate_scale: float) -> None:
    log = sine_log(1.0, EVEN[:501])
    scenario = log_scenario(log, scale=scale, rate_scale=rate_scale)
    assert_allclose(scenario.specific_force(log.t), scale * log.force, atol=1e-12)
    assert_allclose(scenario.angular_rate(log.t), rate_scale * log.rate, atol=1e-12)


def warped(frequency: float) -> float:
    """What the bilinear transform makes of a frequency at 100 Hz."""
    return math.tan(math.pi * frequency * 0.01)


@pytest.mark.parametrize("frequency", [0.5, 2.0, 3.0, 5.0, 10.0])
def test_the_zero_phase_filter_has_butterworths_response_twice(frequency: float) -> None:
    """|H|² = 1/(1 + Ω⁴) at second order, without delay."""
    response = gain(log_scenario(sine_log(frequency), lowpass_hz=3.0), frequency)
    assert response == pytest.approx(1 / (1 + (warped(frequency) / warped(3.0)) ** 4), abs=1e-6)


@pytest.mark.parametrize("frequency", [0.5, 2.0, 3.0, 5.0, 10.0])
def test_the_causal_filter_has_butterworths_response(frequency: float) -> None:
    """H = 1/(1 + √2 jΩ − Ω²)."""
    response = gain(log_scenario(sine_log(frequency), lowpass_hz=3.0, causal=True), frequency)
    Omega = warped(frequency) / warped(3.0)
    assert response == pytest.approx(1 / (1 + math.sqrt(2) * 1j * Omega - Omega**2), abs=1e-6)


@pytest.mark.parametrize("causal", [False, True])
@given(value=st.floats(-40, 40))
def test_a_constant_passes_every_filter_from_the_first_sample_on(causal: bool, value: float) -> None:
    log = log_of(np.arange(500, dtype=float) * 0.001, np.full(500, value))
    _, f = sampled(log_scenario(log, lowpass_hz=2.0, causal=causal))
    assert_allclose(f, value, atol=1e-9)


def test_the_causal_filter_does_not_look_ahead() -> None:
    jump = log_of(EVEN, (EVEN >= 30.0).astype(np.float64))
    t, causal = sampled(log_scenario(jump, lowpass_hz=1.0, causal=True))
    _, both = sampled(log_scenario(jump, lowpass_hz=1.0))
    assert np.abs(causal[t < 29.995]).max() < 1e-12
    assert np.abs(both[(t > 29.8) & (t < 29.995)]).max() > 0.05


@pytest.mark.parametrize(("frequency", "passes"), [(5.0, True), (61.0, False), (97.0, False)])
def test_a_faster_log_is_not_aliased(frequency: float, passes: bool) -> None:
    fast = np.arange(60_001, dtype=float) * 0.001
    _, f = sampled(log_scenario(sine_log(frequency, fast)))
    amplitude = math.sqrt(2) * np.std(f[1000:5000])
    assert amplitude == pytest.approx(1.0 if passes else 0.0, abs=2e-3)


def test_resampling_converges_with_the_square_of_the_sampling_time() -> None:
    """Straight lines between samples: the error is at most h²/8 max|f″|."""
    errors = []
    for n in (250, 500, 1000):  # all slower than the controller
        t = np.linspace(0.0, 20.0, n + 1)
        time, f = sampled(log_scenario(sine_log(0.5, t)))
        errors.append(np.abs(f - np.sin(np.pi * time)).max())
        assert errors[-1] <= (20.0 / n) ** 2 / 8 * np.pi**2 * 1.01
    assert_allclose(np.log2(np.array(errors[:-1]) / errors[1:]), 2.0, atol=0.1)


@given(seed=st.integers(0, 99))
def test_uneven_samples_are_put_where_they_belong(seed: int) -> None:
    """Straight lines are exact for a straight line, however it was sampled."""
    rng = np.random.default_rng(seed)
    t = np.cumsum(np.r_[0.0, rng.uniform(0.01, 0.3, 200)])
    time, f = sampled(log_scenario(log_of(t, 0.3 * t - 2.0)))
    assert_allclose(f, 0.3 * time - 2.0, atol=1e-9)


@given(start=st.floats(0, 50), duration=st.floats(0.05, 9))
def test_a_window_is_the_drive_from_there_on(start: float, duration: float) -> None:
    scenario = log_scenario(log_of(EVEN, EVEN), start=start, duration=duration)
    assert duration - 0.01 < scenario.duration + 1e-9 < duration + 2e-9 + 0.01
    t, f = sampled(scenario)
    assert_allclose(f, start + t, atol=1e-9)


def test_a_window_has_no_transient_of_its_own() -> None:
    log = sine_log(1.0)
    whole = log_scenario(log, lowpass_hz=2.0).specific_force(np.array([20.0, 21.5]))
    window = log_scenario(log, lowpass_hz=2.0, start=20.0, duration=3.0).specific_force(np.array([0.0, 1.5]))
    assert_allclose(window, whole, atol=1e-12)


def test_the_origin_tells_what_was_done() -> None:
    scenario = log_scenario(sine_log(1.0), lowpass_hz=3.0, causal=True, scale=0.5, start=2.0)
    assert scenario.origin == "drives/tour.csv, from 2 s, causal low-pass 3 Hz, scaled by 0.5"


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"period": 2.0}, "period is 2 s, must be between 0.001 and 1 s"),
        ({"period": math.nan}, "period is nan s, must be between 0.001 and 1 s"),
        ({"scale": 0.0}, "scale is 0, must be between 0.001 and 10"),
        ({"rate_scale": -1.0}, "rate_scale is -1, must be between 0.001 and 10"),
        ({"lowpass_hz": 60.0}, "lowpass_hz is 60 Hz, must be between 0.01 and 45 Hz"),
        (
            {"start": 60.0},
            "start is 60 s, must be at least 0 s and less than 60 s, the length of drives/tour.csv",
        ),
        (
            {"start": 55.0, "duration": 6.0},
            "duration is 6 s, must be greater than 0 s and at most 5 s, "
            "what drives/tour.csv has from 55 s on",
        ),
        ({"duration": 0.015}, "length of drives/tour.csv is 0.015 s, must be at least two periods, 0.02 s"),
    ],
)
def test_an_option_beyond_its_bound_is_named(options: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InputError) as caught:
        log_scenario(sine_log(1.0), **options)
    assert str(caught.value) == sentence


def test_a_log_shorter_than_two_periods_is_refused() -> None:
    with pytest.raises(InputError, match="at least two periods"):
        log_scenario(log_of(np.array([0.0, 0.015]), np.zeros(2)))
