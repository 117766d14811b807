"""Soft rows of the dense engine, against closed forms and against what an exact penalty must do."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from otolith.qp import DenseSolver, Qp, Status, kkt_residual
from otolith.qp.infeasible import infeasible


def scalar(penalty: float) -> Qp:
    """min ½ (z − 2)² with z ≤ 1 soft: z = 1 when the penalty reaches the multiplier 1, else 2 − w."""
    one = np.ones((1, 1))
    return Qp(one, np.array([-2.0]), one, np.array([-np.inf]), np.ones(1), np.array([penalty]))


@pytest.mark.parametrize(("penalty", "z"), [(3.0, 1.0), (1.5, 1.0), (0.4, 1.6), (np.inf, 1.0)])
def test_a_soft_row_holds_until_its_multiplier_reaches_the_penalty(penalty: float, z: float) -> None:
    found = DenseSolver().solve(scalar(penalty)).or_raise()
    assert found.z[0] == pytest.approx(z, abs=1e-9)
    assert found.y[0] == pytest.approx(min(penalty, 1.0), abs=1e-9)


@pytest.mark.parametrize("unit", [1e-3, 1e-4, 1e-5])
def test_a_penalty_that_is_not_reached_costs_no_digits_in_small_units(unit: float) -> None:
    """Where the multiplier stays below the penalty, the row is as good as hard; in real time as well."""
    qp = scalar(3.0)
    assert qp.penalty is not None
    small = Qp(qp.H, qp.g, unit * qp.A, qp.lower, unit * qp.upper, qp.penalty / unit)
    found = DenseSolver(patient=False).solve(small).or_raise()
    assert found.z[0] == pytest.approx(1.0, abs=1e-9)
    assert found.y[0] * unit == pytest.approx(1.0, abs=1e-9)


def test_no_answer_is_no_proof_where_every_row_is_soft() -> None:
    """Nothing can contradict soft rows, so a problem that is not solved is not infeasible either."""
    assert not infeasible(scalar(0.4))


@pytest.mark.parametrize(("z", "y"), [(1.6, 0.3), (1.7, 0.4), (1.6, 0.5), (1.6, -0.4), (0.9, 0.4)])
def test_a_damaged_soft_answer_is_not_certified(z: float, y: float) -> None:
    assert kkt_residual(scalar(0.4), np.array([1.6]), np.array([0.4])) < 1e-15
    assert kkt_residual(scalar(0.4), np.array([z]), np.array([y])) > 0.01


def test_soft_rows_make_contradicting_limits_solvable() -> None:
    rows = np.array([[1.0], [1.0]])
    hard = Qp(np.eye(1), np.zeros(1), rows, np.array([1.0, -9.0]), np.array([9.0, -1.0]))
    assert DenseSolver().solve(hard).status is Status.INFEASIBLE
    soft = Qp(hard.H, hard.g, rows, hard.lower, hard.upper, np.array([np.inf, 10.0]))
    assert DenseSolver().solve(soft).or_raise().z[0] == pytest.approx(1.0)


@given(seed=st.integers(0, 10_000))
@settings(max_examples=40, deadline=None)
def test_random_soft_problems_are_certified_from_any_start(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n, m, b = rng.integers(2, 8), rng.integers(1, 12), rng.integers(0, 3)
    root = rng.standard_normal((n, n))
    penalty = np.where(rng.uniform(size=b + m) < 0.6, rng.uniform(0.1, 20.0, b + m), np.inf)
    width = rng.uniform(0.01, 1.0, (2, b + m))
    qp = Qp(
        root @ root.T + 0.1 * np.eye(int(n)),
        5 * rng.standard_normal(n),
        rng.standard_normal((m, n)),
        -width[0],
        width[1],
        penalty,
    )
    cold = DenseSolver().solve(qp).or_raise()
    wild = DenseSolver().solve(qp, rng.integers(-1, 2, b + m)).or_raise()
    np.testing.assert_allclose(wild.z, cold.z, atol=1e-6)
