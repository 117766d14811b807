from typing import Any, Literal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose
from scipy import signal

from otolith.core.arrays import Vec
from otolith.core.errors import InputError
from otolith.core.lti import (
    NoSteadyState,
    StateSpace,
    condense,
    diagonal,
    parallel,
    series,
    zero_order_hold,
)

MODEST = st.floats(-10, 10)
A, B = zero_order_hold(np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[0.0], [1.0]]), 0.1)


def test_a_double_integrator_is_discretised_in_closed_form() -> None:
    assert_allclose(A, [[1.0, 0.1], [0.0, 1.0]], atol=1e-15)
    assert_allclose(B, [[0.005], [0.1]], atol=1e-15)


def test_two_half_periods_make_one() -> None:
    model = np.array([[0.0, 1.0], [-3.0, -0.7]]), np.array([[0.2], [1.0]])
    whole, half = zero_order_hold(*model, 0.2), zero_order_hold(*model, 0.1)
    assert_allclose(half[0] @ half[0], whole[0], atol=1e-14)
    assert_allclose(half[0] @ half[1] + half[1], whole[1], atol=1e-14)


@given(x0=arrays(float, 2, elements=MODEST), U=arrays(float, 5, elements=MODEST))
def test_condensing_equals_rollout(x0: Vec, U: Vec) -> None:
    Phi, Gamma = condense(A, B, horizon=5)
    x = x0
    for k, u in enumerate(U):
        x = A @ x + B[:, 0] * u
        assert_allclose(Phi[k] @ x0 + Gamma[k] @ U, x, atol=1e-10)


# Low-pass, washout of third order, lag-lead with time constants three decades apart, plain gain.
TRANSFERS: list[tuple[list[float], list[float]]] = [
    ([4.0], [1.0, 2.4, 4.0]),
    ([1.0, 0.0, 0.0, 0.0], [1.0, 4.25, 5.5, 0.625]),
    ([4.0, 0.4], [0.08, 5.016, 1.0]),
    ([0.0, -3.0], [0.0, 2.0]),
]
OMEGA = np.logspace(-2, 2, 41)
FIRST = StateSpace.from_polynomials([1.0, 0.3], [1.0, 2.0, 5.0])
SECOND = StateSpace.from_polynomials([2.0, 0.0], [0.7, 1.0])


def at(numerator: list[float], denominator: list[float]) -> np.ndarray:
    """The polynomials' ratio at jω, evaluated by numpy: knows nothing of state space."""
    return np.polyval(numerator, 1j * OMEGA) / np.polyval(denominator, 1j * OMEGA)


def response(system: StateSpace) -> np.ndarray:
    return system.frequency_response(OMEGA)[:, 0, 0]


@pytest.mark.parametrize(("numerator", "denominator"), TRANSFERS)
def test_a_system_responds_as_its_polynomials(numerator: list[float], denominator: list[float]) -> None:
    system = StateSpace.from_polynomials(numerator, denominator)
    assert_allclose(response(system), at(numerator, denominator), rtol=1e-10)
    assert_allclose(np.sort_complex(system.poles), np.sort_complex(np.roots(denominator)), rtol=1e-9)


@pytest.mark.parametrize("hold", ["zero", "first"])
@pytest.mark.parametrize(("numerator", "denominator"), TRANSFERS)
def test_discrete_systems_are_those_of_scipy(
    numerator: list[float], denominator: list[float], hold: Literal["zero", "first"]
) -> None:
    system = StateSpace.from_polynomials(numerator, denominator)
    ours = system.discretise(0.05, hold=hold)
    method = {"zero": "zoh", "first": "foh"}[hold]
    theirs: Any = signal.cont2discrete(  # type: ignore[call-overload]  # its stubs name each method apart
        (system.A, system.B, system.C, system.D), 0.05, method=method
    )
    for name, mine, other in zip("ABCD", (ours.A, ours.B, ours.C, ours.D), theirs, strict=False):
        assert_allclose(mine, other, rtol=1e-9, atol=1e-12, err_msg=name)


def test_a_discrete_response_is_the_sum_of_the_impulse_response() -> None:
    discrete = FIRST.discretise(0.05)
    impulse = signal.unit_impulse(800)[:, None]
    _, h, _ = signal.dlsim((discrete.A, discrete.B, discrete.C, discrete.D, 0.05), impulse)
    turning = np.exp(-1j * OMEGA[:, None] * 0.05 * np.arange(800))  # e^{−jωkT}
    assert_allclose(response(discrete), turning @ h[:, 0], rtol=1e-10)


def test_systems_compose_as_transfer_functions_do() -> None:
    G, H = response(FIRST), response(SECOND)
    assert_allclose(response(series(FIRST, SECOND, FIRST)), G * H * G, rtol=1e-12)
    assert_allclose(response(parallel(FIRST, SECOND)), G + H, rtol=1e-12)
    assert_allclose(response(series(StateSpace.gain(np.array([[3.0]])), FIRST)), 3.0 * G, rtol=1e-12)
    both = diagonal(FIRST, StateSpace.gain(np.array([[0.5]])), SECOND).frequency_response(OMEGA)
    expected = np.zeros((len(OMEGA), 3, 3), dtype=complex)
    expected[:, 0, 0], expected[:, 1, 1], expected[:, 2, 2] = G, 0.5, H
    assert_allclose(both, expected, atol=1e-12)
    assert diagonal(FIRST, SECOND).sizes == (3, 2, 2)


@pytest.mark.parametrize("hold", ["zero", "first"])
@pytest.mark.parametrize(("numerator", "denominator"), TRANSFERS)
def test_at_rest_nothing_moves_and_the_output_is_that_of_zero_frequency(
    numerator: list[float], denominator: list[float], hold: Literal["zero", "first"]
) -> None:
    system, u = StateSpace.from_polynomials(numerator, denominator), np.array([-1.7])
    for one in (system, system.discretise(0.01, hold=hold)):
        x = one.steady_state(u)
        moved = one.A @ x + one.B @ u - (0.0 if one.period is None else x)
        assert_allclose(moved, 0.0, atol=1e-12)
        assert_allclose(one.C @ x + one.D @ u, one.frequency_response(np.zeros(1))[0].real @ u, atol=1e-9)


def test_an_integrator_rests_without_input_only() -> None:
    integrator = StateSpace.from_polynomials([1.0], [1.0, 0.0])
    for system in (integrator, integrator.discretise(0.1)):
        assert_allclose(system.steady_state(np.zeros(1)), 0.0)
        with pytest.raises(NoSteadyState, match=r"integrates the input \[1.0\]"):
            system.steady_state(np.ones(1))


@pytest.mark.parametrize(
    ("numerator", "denominator", "sentence"),
    [
        ([1.0, 0.0, 0.0], [1.0, 1.0], "the numerator's degree is 2, must be at most the denominator's, 1"),
        ([1.0], [0.0, 0.0], "denominator is zero"),
        ([np.nan], [1.0], "numerator is .* must be finite"),
        ([1.0], [], "denominator is .* must be finite"),
    ],
)
def test_what_is_no_proper_transfer_function_is_refused(
    numerator: list[float], denominator: list[float], sentence: str
) -> None:
    with pytest.raises(InputError, match=sentence):
        StateSpace.from_polynomials(numerator, denominator)


def test_a_period_is_positive_and_the_same_for_all() -> None:
    with pytest.raises(InputError, match=r"the period is 0\.0 s"):
        FIRST.discretise(0.0)
    discrete = FIRST.discretise(0.1)
    with pytest.raises(ValueError, match="cannot discretise"):
        discrete.discretise(0.1)
    for join in (series, parallel, diagonal):
        with pytest.raises(ValueError, match="different periods"):
            join(discrete, SECOND)
