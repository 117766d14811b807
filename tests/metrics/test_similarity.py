import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from otolith.metrics import correlation, delay, mean_absolute_difference, scale_ratio

DT = 0.01
TIME = np.arange(3000) * DT
RNG = np.random.default_rng(5)


def hump(t: np.ndarray, centre: float) -> np.ndarray:
    return np.exp(-(((t - centre) / 0.8) ** 2))


def test_correlation_is_that_of_scipy() -> None:
    a = RNG.normal(size=500)
    b = 0.6 * a + RNG.normal(size=500) + 4.0
    assert correlation(a, b) == pytest.approx(stats.pearsonr(a, b).statistic, abs=1e-12)


@settings(derandomize=True, deadline=None, max_examples=40)
@given(gain=st.floats(0.01, 50), offset=st.floats(-5, 5))
def test_correlation_does_not_see_size_nor_offset(gain: float, offset: float) -> None:
    wanted = hump(TIME, 10.0)
    assert correlation(wanted, gain * wanted + offset) == pytest.approx(1.0, abs=1e-9)
    assert correlation(wanted, -gain * wanted + offset) == pytest.approx(-1.0, abs=1e-9)


@settings(derandomize=True, deadline=None, max_examples=60)
@given(lag=st.floats(-1.9, 1.9), gain=st.floats(0.1, 3.0))
def test_a_delay_is_found_to_a_fraction_of_a_sample(lag: float, gain: float) -> None:
    wanted = hump(TIME, 10.0) - 0.7 * hump(TIME, 17.0)
    felt = gain * (hump(TIME - lag, 10.0) - 0.7 * hump(TIME - lag, 17.0))
    assert delay(wanted, felt, DT) == pytest.approx(lag, abs=0.02 * DT)


def test_a_sine_is_late_by_its_phase() -> None:
    omega, phase = 2 * np.pi * 0.4, 0.5
    wanted, felt = np.sin(omega * TIME), 0.3 * np.sin(omega * TIME - phase)
    assert delay(wanted, felt, DT, largest=1.0) == pytest.approx(phase / omega, abs=0.002)


@pytest.mark.parametrize("n", [40, 41, 67])
@pytest.mark.parametrize("lag", [-9, -1, 0, 4, 12])
def test_the_delay_of_noise_is_that_of_every_lag_tried(n: int, lag: int) -> None:
    """Noise that is as large at the ends as in the middle: what meets across the ends would be seen."""
    wanted = RNG.normal(size=n)
    felt = np.roll(wanted, lag) + 0.3 * RNG.normal(size=n)
    w, f = wanted - wanted.mean(), felt - felt.mean()
    reach = n // 2

    def alike(k: int) -> float:
        a, b = (w[: n - k], f[k:]) if k >= 0 else (w[-k:], f[: n + k])
        return float(a @ b / np.sqrt((a @ a) * (b @ b)))

    best = max(range(-reach, reach + 1), key=alike)
    found = delay(wanted, felt, 1.0, largest=reach)
    if abs(best) == reach:
        assert np.isnan(found)
    else:
        before, peak, after = (alike(best + k) for k in (-1, 0, 1))
        fraction = 0.5 * (before - after) / (before - 2.0 * peak + after)
        assert found == pytest.approx(best + fraction, abs=1e-9)


def test_what_is_not_defined_is_not_a_number() -> None:
    wanted, still = hump(TIME, 10.0), np.full(len(TIME), 0.3)
    for measure in (correlation, lambda a, b: delay(a, b, DT)):
        assert np.isnan(measure(wanted, still))
        assert np.isnan(measure(still, wanted))
    assert np.isnan(scale_ratio(np.zeros(5), np.ones(5)))
    late_beyond_the_range = hump(TIME - 5.0, 10.0)
    assert np.isnan(delay(wanted, late_beyond_the_range, DT))


def test_size_and_difference_of_scaled_signals_are_known() -> None:
    wanted = np.sin(2 * np.pi * np.arange(1000) / 1000)  # mean |sin| over a period is 2/π
    assert scale_ratio(wanted, -0.4 * wanted) == pytest.approx(0.4)
    assert mean_absolute_difference(wanted, 0.4 * wanted) == pytest.approx(0.6 * 2 / np.pi, rel=1e-5)
