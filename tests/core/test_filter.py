import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy import signal

from otolith.core.filter import Filter
from otolith.core.lti import StateSpace, diagonal, series

RNG = np.random.default_rng(3)
LEAD_LAG = StateSpace.from_polynomials([4.0, 0.4], [0.08, 5.016, 1.0])
TWO = diagonal(LEAD_LAG, StateSpace.from_polynomials([1.0, 0.0], [1.0, 2.0])).discretise(0.01)


def test_a_series_comes_out_as_from_scipy() -> None:
    u = RNG.normal(size=(500, 2))
    _, theirs, _ = signal.dlsim((TWO.A, TWO.B, TWO.C, TWO.D, 0.01), u)
    assert_allclose(Filter(TWO).simulate(u), theirs, atol=1e-12)


def test_a_series_equals_its_steps_and_goes_on_where_it_stopped() -> None:
    u = RNG.normal(size=(60, 2))
    whole = Filter(TWO).simulate(u)
    stepping = Filter(TWO)
    stepped = np.array([stepping.step(sample) for sample in u])
    assert np.array_equal(stepped, whole)
    halves = Filter(TWO)
    assert np.array_equal(np.vstack([halves.simulate(u[:23]), halves.simulate(u[23:])]), whole)


def test_a_straight_input_is_filtered_exactly_under_a_first_order_hold() -> None:
    # 1/(τ s + 1) under u = t: y = t − τ (1 − e^{−t/τ})
    tau, t = 0.3, np.arange(200, dtype=float) * 0.05
    lag = StateSpace.from_polynomials([1.0], [tau, 1.0]).discretise(0.05, hold="first")
    y = Filter(lag).simulate(t[:, None])[:, 0]
    assert_allclose(y, t - tau * (1.0 - np.exp(-t / tau)), atol=1e-13)


def test_at_rest_a_constant_input_gives_a_constant_output() -> None:
    u = np.array([2.0, -1.0])
    y = Filter(TWO).at_rest(u).simulate(np.tile(u, (1000, 1)))
    assert_allclose(y, np.tile([0.8, 0.0], (1000, 1)), atol=1e-11)


def test_reset_forgets_and_a_state_can_be_given() -> None:
    filter_, u = Filter(TWO), RNG.normal(size=(5, 2))
    first = filter_.simulate(u)
    kept = filter_.state
    more = filter_.simulate(u)
    filter_.reset()
    assert np.array_equal(filter_.simulate(u), first)
    filter_.state = kept
    assert np.array_equal(filter_.simulate(u), more)


def test_a_system_without_a_state_only_multiplies() -> None:
    gain = series(LEAD_LAG.gain(np.array([[2.0]])), StateSpace.gain(np.array([[-1.5]])))
    static = StateSpace(A=gain.A, B=gain.B, C=gain.C, D=gain.D, period=0.01)
    assert_allclose(Filter(static).simulate(np.array([[1.0], [2.0]])), [[-3.0], [-6.0]])


def test_a_continuous_system_is_not_run() -> None:
    with pytest.raises(ValueError, match="discretise it first"):
        Filter(LEAD_LAG)
