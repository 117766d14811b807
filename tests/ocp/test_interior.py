"""The optimal control solver against a general-purpose one, and its certificate against tampering."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import block_diag
from scipy.optimize import minimize

from otolith.core.arrays import Mat
from otolith.ocp import Answer, Breakdown, Disc, Dynamics, Expansion, certify, solve

A1, B1 = np.array([[1.0, 0.1], [0.0, 1.0]]), np.array([[0.005], [0.1]])  # a double integrator, 0.1 s


class Following:
    """½ Σ (place − wanted)² + ½ ε u² for every axis: a cost whose Gauss-Newton Hessian is exact."""

    def __init__(self, wanted: Mat, effort: float = 1e-3) -> None:
        self.wanted, self.effort = wanted, effort  # (N, axes)

    def costs(self, X, U):
        """The cost of every step, also of complex motions."""
        errors = np.sum((X[:, ::2] - self.wanted) ** 2, axis=1)
        return 0.5 * (errors + self.effort * np.sum(U**2, axis=1))

    def value(self, X: Mat, U: Mat) -> float:
        return float(self.costs(X[:-1], U).sum())

    def expand(self, X: Mat, U: Mat, *, exact: bool) -> Expansion:
        N, axes = self.wanted.shape
        gradient, hessian = np.zeros((N, 3 * axes)), np.zeros((N, 3 * axes, 3 * axes))
        gradient[:, 0 : 2 * axes : 2] = X[:-1, ::2] - self.wanted
        gradient[:, 2 * axes :] = self.effort * U
        for i in range(axes):
            hessian[:, 2 * i, 2 * i] = 1.0
            hessian[:, 2 * axes + i, 2 * axes + i] = self.effort
        return Expansion(self.value(X, U), gradient, hessian)


def problem(axes: int, N: int, *discs: Disc) -> tuple[Dynamics, Following]:
    rng = np.random.default_rng(axes + N)
    dynamics = Dynamics(
        A=block_diag(*[A1] * axes),
        B=block_diag(*[B1] * axes),
        lower=np.array([-0.3, -0.8] * axes + [-2.0] * axes),
        upper=np.array([0.4, np.inf] * axes + [3.0] * axes),
        discs=discs,
    )
    return dynamics, Following(np.cumsum(rng.normal(size=(N, axes)), axis=0) * 0.15)


def by_slsqp(dynamics: Dynamics, cost: Following) -> float:
    """The optimal cost by sequential quadratic programming over the inputs, from the definitions."""
    N, nu = cost.wanted.shape

    def motion(flat: Mat) -> tuple[Mat, Mat]:
        U, X = flat.reshape(N, nu), np.zeros((N + 1, dynamics.states))
        for k in range(N):
            X[k + 1] = dynamics.A @ X[k] + dynamics.B @ U[k]
        return X, U

    def room(flat: Mat) -> Mat:
        X, U = motion(flat)
        w = np.hstack([X[1:], U])
        finite = np.isfinite(dynamics.lower), np.isfinite(dynamics.upper)
        rooms = [(w - dynamics.lower)[:, finite[0]].ravel(), (dynamics.upper - w)[:, finite[1]].ravel()]
        rooms += [disc.radius**2 - np.sum(X[1:, list(disc.states)] ** 2, axis=1) for disc in dynamics.discs]
        return np.concatenate(rooms)

    found: Any = minimize(  # type: ignore[call-overload]  # its stubs know no constraint as a dictionary
        lambda flat: cost.value(*motion(flat)),
        np.zeros(N * nu),
        method="SLSQP",
        constraints={"type": "ineq", "fun": room},
        options={"maxiter": 500, "ftol": 1e-12},
    )
    assert found.success
    return float(found.fun)


@pytest.mark.parametrize(
    ("axes", "discs"), [(1, ()), (2, ()), (2, (Disc((0, 2), 0.25),))], ids=["one", "two", "disc"]
)
def test_the_optimum_is_that_of_another_solver_and_certified(axes: int, discs: tuple[Disc, ...]) -> None:
    dynamics, cost = problem(axes, 12, *discs)
    answer = solve(dynamics, cost, np.zeros(dynamics.states), 12)
    assert answer.converged
    assert cost.value(answer.X, answer.U) == pytest.approx(by_slsqp(dynamics, cost), rel=1e-6)
    assert certify(dynamics, cost.costs, answer).worst < 1e-7
    active = answer.of_sides.max(axis=0) > 1e-3
    assert active.any(), "no limit is met, so nothing was tried"
    if discs:
        assert answer.of_discs.max() > 1e-3


@pytest.mark.parametrize("what", ["input", "state", "multiplier", "sign"])
def test_a_certificate_sees_what_was_changed(what: str) -> None:
    dynamics, cost = problem(1, 40)
    answer = solve(dynamics, cost, np.zeros(2), 40)
    X, U, y = answer.X.copy(), answer.U.copy(), answer.of_sides.copy()
    if what == "input":
        U[20] += 0.01
        for k in range(40):
            X[k + 1] = dynamics.A @ X[k] + dynamics.B @ U[k]
    elif what == "state":
        X[20] += 1e-3
    elif what == "multiplier":
        y[y == y.max()] *= 1.1
    else:
        y[5, 0] = -0.01
    changed: Answer = replace(answer, X=X, U=U, of_sides=y)
    assert certify(dynamics, cost.costs, answer).worst < 1e-7
    assert certify(dynamics, cost.costs, changed).worst > 1e-4


def test_time_does_not_matter_to_the_answer() -> None:
    """A thousand steps, most of them at rest: the beginning is as in the short problem."""
    dynamics, cost = problem(1, 30)
    long = Following(np.vstack([cost.wanted, np.zeros((970, 1))]))
    short = Following(np.vstack([cost.wanted, np.zeros((170, 1))]))
    one, other = (solve(dynamics, of, np.zeros(2), len(of.wanted)) for of in (long, short))
    assert_allclose(one.X[:100], other.X[:100], atol=1e-5)


def test_a_start_outside_is_refused() -> None:
    dynamics, cost = problem(1, 10)
    with pytest.raises(ValueError, match="strictly inside"):
        solve(dynamics, cost, np.array([0.0, 1.0]), 10)
    with pytest.raises(ValueError, match="zero strictly inside"):
        Dynamics(A=A1, B=B1, lower=np.zeros(3), upper=np.ones(3))


@pytest.mark.parametrize("part", ["value", "gradient", "hessian"])
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_what_is_no_number_ends_the_iteration(part: str, bad: float) -> None:
    """It went on for ever once: no shift makes a Hessian positive that holds no number."""
    dynamics, cost = problem(1, 10)

    class Broken(Following):
        def expand(self, X: Mat, U: Mat, *, exact: bool) -> Expansion:
            found = super().expand(X, U, exact=exact)
            spoilt = np.array(getattr(found, part))
            spoilt.flat[-1] = bad
            return Expansion(**{**found._asdict(), part: spoilt})

    with pytest.raises(Breakdown, match="no number"):
        solve(dynamics, Broken(cost.wanted), np.zeros(2), 10)


def test_a_cost_without_a_lower_end_ends_the_iteration() -> None:
    dynamics, cost = problem(1, 10)

    class Downwards(Following):
        def expand(self, X: Mat, U: Mat, *, exact: bool) -> Expansion:
            found = super().expand(X, U, exact=exact)
            return found._replace(hessian=found.hessian - 1e30 * np.eye(3))

    with pytest.raises(Breakdown, match="makes the Hessian positive"):
        solve(dynamics, Downwards(cost.wanted), np.zeros(2), 10)


def test_without_limits_the_answer_is_that_of_least_squares() -> None:
    N, nothing = 12, np.full(3, np.inf)
    _, cost = problem(1, N)
    free = Dynamics(A=A1, B=B1, lower=-nothing, upper=nothing)
    answer = solve(free, cost, np.zeros(2), N)
    places = np.zeros((N, N))  # of x_k by u_j
    for k in range(N):
        for j in range(k):
            places[k, j] = (np.linalg.matrix_power(A1, k - 1 - j) @ B1)[0, 0]
    expected = np.linalg.solve(places.T @ places + cost.effort * np.eye(N), places.T @ cost.wanted)
    assert answer.converged
    assert_allclose(answer.U, expected, atol=1e-9)
    assert certify(free, cost.costs, answer).worst < 1e-9


def test_a_drive_that_wants_nothing_is_certified() -> None:
    """Its gradient is zero, and so is its cost: measured by what counts as nothing."""
    dynamics, cost = problem(1, 40)
    still = Following(np.zeros_like(cost.wanted))
    answer = solve(dynamics, still, np.zeros(2), 40)
    assert certify(dynamics, still.costs, answer, nothing=1e-8).worst < 1e-7
    moved = replace(answer, U=answer.U + 1e-3)
    assert certify(dynamics, still.costs, moved, nothing=1e-8).worst > 1e-2
