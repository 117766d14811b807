"""Problems that daqp does not solve as they are, against closed forms and scipy's linear programs."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from otolith.qp import DenseSolver, Qp, Status
from otolith.qp.proximal import polish, solve_with_care

INF = np.inf


def test_a_singular_hessian_is_solved() -> None:
    qp = Qp(np.ones((2, 2)), -np.ones(2), np.eye(2)[:0], np.zeros(2), np.ones(2))  # any z₁ + z₂ = 1
    assert DenseSolver().solve(qp).or_raise().z.sum() == pytest.approx(1.0)


@given(seed=st.integers(0, 100_000))
@settings(max_examples=25, deadline=None)
def test_linear_programs_are_solved_as_scipy_solves_them(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n, m = rng.integers(2, 7), rng.integers(1, 8)
    g, A = rng.standard_normal(n), rng.standard_normal((m, n))
    upper = A @ rng.uniform(-1, 1, n) + rng.uniform(0, 1, m)
    box = 2.0 * np.ones(n)
    qp = Qp(np.zeros((n, n)), g, A, np.concatenate([-box, np.full(m, -INF)]), np.concatenate([box, upper]))
    expected = linprog(g, A_ub=A, b_ub=upper, bounds=[(-2, 2)] * n)
    assert g @ DenseSolver().solve(qp).or_raise().z == pytest.approx(expected.fun, abs=1e-7)


def test_a_cost_without_a_minimum_is_no_answer() -> None:
    qp = Qp(np.zeros((1, 1)), -np.ones(1), np.zeros((0, 1)), np.zeros(1), np.array([INF]))
    assert DenseSolver().solve(qp).status is Status.LIMIT


def test_an_impatient_engine_gives_a_singular_problem_up() -> None:
    qp = Qp(np.ones((2, 2)), -np.ones(2), np.eye(2)[:0], np.zeros(2), np.ones(2))
    assert DenseSolver(patient=False).solve(qp).status is Status.LIMIT


def test_polish_solves_the_working_set_though_its_rows_depend_on_each_other() -> None:
    # min ½‖z‖² − z₁ − 2 z₂ with z₁ + z₂ ≤ 1 twice: z = (0, 1), multipliers that add up to 1.
    A = np.array([[1.0, 1.0], [1.0, 1.0]])
    qp = Qp(np.eye(2), np.array([-1.0, -2.0]), A, np.full(2, -INF), np.ones(2))
    z, y = polish(qp, np.array([0.3, 0.9]), np.array([0.2, 0.5]))
    np.testing.assert_allclose(z, [0.0, 1.0], atol=1e-12)
    assert y.sum() == pytest.approx(1.0)


def test_the_changes_on_the_way_are_counted() -> None:
    """A linear cost ends at a corner: its rows enter one by one."""
    qp = Qp(np.zeros((2, 2)), np.array([-1.0, 1.0]), np.eye(2), np.full(2, -1.0), np.full(2, 0.5))
    found = solve_with_care(qp, primal_tolerance=1e-9, iteration_limit=100)
    np.testing.assert_allclose(found.z, [0.5, -1.0], atol=1e-9)
    assert found.changes >= 2
