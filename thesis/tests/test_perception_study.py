"""Appendix B of the thesis, number by number, and its formulas against other ways to compute them."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy import signal
from scipy.optimize import minimize_scalar

from otolith.core.lti import StateSpace
from otolith.perception import otoliths
from otolith_thesis import perception_study as study
from otolith_thesis.perception_study import (
    CANALS,
    OTOLITHS,
    PERIOD,
    StepCharacteristics,
    figure_b1,
    figure_b2,
    figure_b3,
    in_thesis_reading,
    sensitivity,
    sensitivity_extrema,
    step_characteristics,
    step_response,
)

# Rise [samples], settling [s], minimum, maximum as printed; half a unit of the last digit.
TABLE_B2 = {  # columns exchanged as the module's docstring says
    "telban": (0.0022, 35.7432, -0.9551, 1.0),
    "reid": (0.0192, 32.7884, -1.0354, 1.0),
    "ormsby": (0.0393, 42.3197, -0.7601, 1.0),
}
YOUNG_WITH_LAG = (0.0399, 42.2508, -0.7771, 0.9781)
TABLE_B4 = {
    "telban": (9.7673e-4, 30.5390, -0.3629, 0.7918),
    "young": (0.0466, 33.6788, -0.3749, 0.8151),
    "ormsby": (0.1821, 32.2377, -0.0838, 0.5031),
}


def assert_printed(found: StepCharacteristics, printed: tuple[float, ...]) -> None:
    digits = 5e-9 if printed[0] < 1e-3 else 5.1e-5
    assert found.rise_time / PERIOD == pytest.approx(printed[0], abs=digits)
    rest = (found.settling_time, found.minimum, found.maximum)
    assert_allclose(rest, printed[1:], atol=5.1e-5)


@pytest.mark.parametrize("name", TABLE_B2)
def test_table_b2_comes_out_digit_for_digit(name: str) -> None:
    assert_printed(study.table_b2()[name], TABLE_B2[name])


def test_youngs_canals_of_table_b2_had_a_short_lag() -> None:
    assert_printed(in_thesis_reading(study.YOUNG_IN_TABLE_B2.system()), YOUNG_WITH_LAG)
    as_printed = study.table_b2()["young"]
    assert abs(as_printed.minimum - YOUNG_WITH_LAG[2]) > 0.01


@pytest.mark.parametrize("name", TABLE_B4)
def test_table_b4_comes_out_digit_for_digit(name: str) -> None:
    assert_printed(study.table_b4()[name], TABLE_B4[name])


@pytest.mark.parametrize("name", OTOLITHS)
def test_step_responses_are_those_of_scipy(name: str) -> None:
    m = OTOLITHS[name]
    system = ([m.k * m.T_a, m.k], np.polymul([m.T_L, 1.0], [m.T_S, 1.0]))
    time, output = step_response(m.system(), 0.01)
    _, unit = signal.step(system, T=time)
    delayed = {
        start: np.concatenate([np.zeros(k), unit[: len(time) - k]]) for start, k in ((2, 200), (15, 1500))
    }
    assert_allclose(output, delayed[2] - delayed[15], atol=1e-9)


def test_characteristics_of_a_first_order_lag_are_known() -> None:
    tau = 2.0
    time = np.linspace(0.0, 40.0, 40001)
    output = 1.0 - np.exp(-time / tau)
    found = step_characteristics(time, output, towards=1.0)
    assert found.rise_time == pytest.approx(tau * np.log(9.0), rel=1e-6)  # τ ln(0.9/0.1)
    assert found.settling_time == pytest.approx(-tau * np.log(0.02), rel=1e-4)
    assert found.minimum == 0.0
    assert found.maximum == pytest.approx(1.0)


def test_sensitivity_is_the_printed_polynomial() -> None:
    # eq. B.4
    omega = np.logspace(-2, 3, 31)
    printed = np.polyval([0.08, 5.016, 1.0], 1j * omega) / np.polyval([0.08, 9.016, 1.4], 1j * omega)
    assert_allclose(sensitivity(otoliths.telban()).frequency_response(omega)[:, 0, 0], printed, rtol=1e-10)


def test_sensitivity_holds_for_a_system_with_a_direct_path() -> None:
    T = StateSpace.from_polynomials([2.0, 1.0], [1.0, 4.0])
    omega = np.array([0.1, 1.0, 30.0])
    assert_allclose(
        sensitivity(T).frequency_response(omega), 1.0 / (1.0 + T.frequency_response(omega)), rtol=1e-12
    )


@pytest.mark.parametrize("factor", [0.5, 1.0, 1.5, 2.0])
def test_the_stationary_point_of_the_sensitivity_is_its_minimum(factor: float) -> None:
    model = replace(otoliths.TELBAN, k=factor * otoliths.TELBAN.k)
    S = sensitivity(model.system())

    def modulus(log_omega: float) -> float:
        return float(abs(S.frequency_response(np.array([10.0**log_omega]))[0, 0, 0]))

    found = minimize_scalar(modulus, bounds=(-1.0, 2.0), method="bounded", options={"xatol": 1e-10})
    ((omega, value),) = sensitivity_extrema(model)
    assert omega == pytest.approx(10.0**found.x, rel=1e-5)
    assert value == pytest.approx(found.fun, rel=1e-12)
    assert modulus(3.5) < 1.0  # its bound is 1, at infinite frequency: it has no maximum


def test_figures_hold_every_model_and_agree_with_numpy() -> None:
    assert set(figure_b1()) == set(CANALS)
    assert set(figure_b2()) == set(OTOLITHS)
    telban = figure_b2()["telban"]
    response = 0.4 * (10j * telban.omega + 1) / ((5j * telban.omega + 1) * (0.016j * telban.omega + 1))
    assert_allclose(telban.magnitude_db, 20 * np.log10(np.abs(response)), atol=1e-9)
    assert_allclose(telban.phase_deg, np.rad2deg(np.angle(response)), atol=1e-9)
    assert len(telban.time) == len(telban.output)


def test_half_the_gain_raises_the_least_sensitivity_and_halves_the_response() -> None:
    half, full = figure_b3(0.5), figure_b3(1.0)
    assert_allclose(half.otolith.output, 0.5 * full.otolith.output, atol=1e-12)
    assert_allclose(half.otolith.magnitude_db, full.otolith.magnitude_db - 20 * np.log10(2.0))
    assert half.sensitivity.magnitude_db.min() > full.sensitivity.magnitude_db.min()
