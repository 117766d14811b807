import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from otolith.metrics.harmonics import Fidelity, graded, harmonic


@settings(derandomize=True, deadline=None, max_examples=40)
@given(
    omega=st.floats(0.3, 20.0),
    modulus=st.floats(0.01, 10.0),
    phase=st.floats(-np.pi, np.pi),
    offset=st.floats(-3, 3),
    drift=st.floats(-0.1, 0.1),
)
def test_a_sine_is_found_beside_offset_and_drift(
    omega: float, modulus: float, phase: float, offset: float, drift: float
) -> None:
    time = np.arange(1, 45001, dtype=float) * 1e-3
    found = harmonic(time, modulus * np.cos(omega * time + phase) + offset + drift * time, omega)
    assert found.amplitude == pytest.approx(modulus * np.exp(1j * phase), abs=1e-8)
    assert found.spread < 1e-8
    assert found.distortion < 1e-6 / modulus


def test_what_has_not_settled_shows_as_spread() -> None:
    time = np.arange(1, 20001, dtype=float) * 1e-3
    found = harmonic(time, np.sin(2.0 * time) * (1.0 + 0.5 * np.exp(-time / 4.0)), 2.0)
    assert found.spread > 0.05
    assert abs(found.amplitude + 1j) < 2 * found.spread


def test_a_third_harmonic_shows_as_distortion() -> None:
    time = np.arange(1, 62832, dtype=float) * 1e-3
    found = harmonic(time, np.sin(time) + 0.2 * np.sin(3.0 * time), 1.0)
    assert found.amplitude == pytest.approx(-1j, abs=1e-6)
    assert found.distortion == pytest.approx(0.2, rel=1e-3)


def test_nothing_has_no_distortion_and_one_period_is_not_enough() -> None:
    time = np.arange(1, 10001, dtype=float) * 1e-3
    nothing = harmonic(time, np.zeros(10000), 2.0)
    assert nothing.amplitude == 0.0
    assert np.isnan(nothing.distortion)
    with pytest.raises(ValueError, match="less than two periods"):
        harmonic(time, np.sin(time), 1.0)


def test_a_grade_is_the_first_whose_bounds_hold() -> None:
    grades = [
        Fidelity(grade="high", least_gain=0.6, largest_phase_deg=30.0),
        Fidelity(grade="medium", least_gain=0.4, largest_phase_deg=60.0),
    ]
    assert graded(0.7, -29.0, grades) == "high"
    assert graded(0.7, 31.0, grades) == "medium"
    assert graded(0.3, 0.0, grades) == "none"
