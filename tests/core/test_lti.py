import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose

from otolith.core.arrays import Vec
from otolith.core.lti import condense, zero_order_hold

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
