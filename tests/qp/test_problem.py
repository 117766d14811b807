"""The certificate, against closed forms and against deliberate damage."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from otolith.qp import DenseSolver, Qp, Status, kkt_residual
from otolith.qp.problem import NotSolved


def box_qp() -> Qp:
    """min ½‖z‖² − 2 z₁ + 0.3 z₂ with |z| ≤ 1 and z₁ + z₂ ≤ 0.5: z = (0.9, −0.4), y = (0, 0, 1.1) by hand."""
    return Qp(
        np.eye(2),
        np.array([-2.0, -0.7]),
        np.array([[1.0, 1.0]]),
        np.array([-1, -1, -9.0]),
        np.array([1, 1, 0.5]),
    )


def test_a_hand_solved_problem_is_certified_exactly() -> None:
    # Stationarity with the row active: z₁ = 2 − y, z₂ = 0.7 − y, sum 0.5: y = 1.1.
    assert kkt_residual(box_qp(), np.array([0.9, -0.4]), np.array([0.0, 0.0, 1.1])) < 1e-15


def test_the_engine_finds_the_hand_solved_answer() -> None:
    solution = DenseSolver().solve(box_qp()).or_raise()
    np.testing.assert_allclose(solution.z, [0.9, -0.4], atol=1e-12)
    np.testing.assert_array_equal(solution.working_set, [0, 0, 1])


@pytest.mark.parametrize(
    ("z", "y"),
    [
        ([0.9, -0.39], [0.0, 0.0, 1.1]),  # infeasible and not stationary
        ([0.9, -0.4], [0.0, 0.0, 1.0]),  # wrong multiplier
        ([0.9, -0.4], [0.0, 0.0, -1.1]),  # wrong side
        ([np.nan, 0.0], [0.0, 0.0, 0.0]),
        ([0.0, 0.0], [np.inf, 0.0, 0.0]),
    ],
)
def test_a_damaged_answer_is_not_certified(z: list[float], y: list[float]) -> None:
    assert not kkt_residual(box_qp(), np.array(z), np.array(y)) < 1e-3


def test_a_multiplier_on_an_absent_bound_is_not_certified() -> None:
    qp = Qp(np.eye(1), np.array([-1.0]), np.zeros((0, 1)), np.array([-np.inf]), np.array([np.inf]))
    assert kkt_residual(qp, np.array([0.0]), np.array([1.0])) == np.inf
    assert kkt_residual(qp, np.array([1.0]), np.array([0.0])) == 0.0


@pytest.mark.parametrize("damage", ["nan in H", "nan in g", "inf in A", "nan bound", "crossed bounds"])
def test_bad_data_never_count_as_solved(damage: str) -> None:
    qp = box_qp()
    match damage:
        case "nan in H":
            qp.H[0, 0] = np.nan
        case "nan in g":
            qp.g[1] = np.nan
        case "inf in A":
            qp.A[0, 0] = np.inf
        case "nan bound":
            qp.upper[2] = np.nan
        case _:
            qp.lower[0] = 2.0
    solution = DenseSolver().solve(qp)
    assert solution.status is Status.INVALID
    assert solution.residual == np.inf
    with pytest.raises(NotSolved, match="invalid"):
        solution.or_raise()


def test_contradicting_rows_are_reported_infeasible() -> None:
    qp = Qp(np.eye(1), np.zeros(1), np.array([[1.0], [1.0]]), np.array([1.0, -5.0]), np.array([5.0, -1.0]))
    assert DenseSolver().solve(qp).status is Status.INFEASIBLE


def test_an_iteration_limit_is_no_answer() -> None:
    rng = np.random.default_rng(3)
    A = rng.standard_normal((60, 20))
    qp = Qp(np.eye(20), 100 * rng.standard_normal(20), A, -np.ones(60), np.ones(60))
    assert DenseSolver(iteration_limit=2).solve(qp).status is Status.LIMIT


@given(seed=st.integers(0, 10_000))
@settings(max_examples=60, deadline=None)
def test_random_problems_are_certified_from_any_start_and_agree(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n, m, b = rng.integers(2, 9), rng.integers(1, 14), rng.integers(0, 3)
    root = rng.standard_normal((n, n))
    A = rng.standard_normal((m, n))
    inside = np.concatenate([np.zeros(b), A @ np.zeros(n)])
    qp = Qp(
        root @ root.T + 0.1 * np.eye(int(n)),
        5 * rng.standard_normal(n),
        A,
        inside - rng.uniform(0.01, 1.0, b + m),
        inside + rng.uniform(0.01, 1.0, b + m),
    )
    cold = DenseSolver().solve(qp).or_raise()
    again = DenseSolver().solve(qp, cold.working_set).or_raise()
    wild = DenseSolver().solve(qp, rng.integers(-1, 2, b + m)).or_raise()
    assert again.changes == 0
    np.testing.assert_allclose(again.z, cold.z, atol=1e-7)
    np.testing.assert_allclose(wild.z, cold.z, atol=1e-7)
