"""The stage problem against its dense form, finite differences and hand-solved cases."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import block_diag

from otolith.qp import DenseSolver, kkt_residual
from otolith.qp.stage import (
    StageProblem,
    by_columns,
    by_rows,
    condense,
    cost,
    rollout,
    row_values,
    stage_residual,
    stationarity,
)
from tests.qp.stage_problems import NU, N, stage_problem, stage_qp

seeds = st.integers(0, 10_000)


@given(seed=seeds)
@settings(max_examples=20, deadline=None)
def test_the_condensed_problem_is_the_rolled_out_one(seed: int) -> None:
    rng = np.random.default_rng(seed)
    qp = stage_qp(rng).changed(x0=rng.standard_normal(4))
    dense, U, zero = condense(qp), rng.standard_normal((N, NU)), np.zeros((N, NU))
    X = rollout(qp, U)
    quadratic = 0.5 * U.ravel() @ dense.H @ U.ravel() + dense.g @ U.ravel()
    assert quadratic == pytest.approx(cost(qp, U, X) - cost(qp, zero, rollout(qp, zero)), rel=1e-9, abs=1e-9)
    slack = by_rows(dense.upper - dense.rows(U.ravel()), qp.problem)
    np.testing.assert_allclose(slack, qp.upper - row_values(qp, U, X), atol=1e-10)


def test_inputs_of_one_group_move_no_constant_row_of_another() -> None:
    one = stage_problem(np.random.default_rng(4))
    double = StageProblem(
        horizon=N,
        A=block_diag(one.A, one.A),
        B=block_diag(one.B, one.B),
        C=block_diag(one.C, one.C),
        output=np.ones((1, 8), dtype=np.bool_),
        varying=np.ones((1, 8), dtype=np.bool_),
        weighted=(0, 7),
        control_weight=np.ones(2 * NU),
        penalty=np.full(6 + 1 + 2 * NU, np.inf),
    )
    np.testing.assert_array_equal(double.groups, [0, 0, 0, 1, 1, 1, 2, 0, 0, 1, 1])
    rng = np.random.default_rng(5)
    moved = np.zeros((2, double.rows), dtype=np.bool_)
    for g in range(2):
        U = rng.standard_normal((N, 2 * NU)) * (double.groups[-2 * NU :] == g)
        X, x = [], np.zeros(8)
        for u in U:
            x = double.A @ x + double.B @ u
            X.append(x)
        moved[g, :6] = (np.abs(np.array(X) @ double.C.T) > 1e-12).any(axis=0)
    np.testing.assert_array_equal(moved[0, :6], double.groups[:6] == 0)
    np.testing.assert_array_equal(moved[1, :6], double.groups[:6] == 1)


@given(seed=seeds, soft=st.sampled_from([np.inf, 0.5]))
@settings(max_examples=30, deadline=None)
def test_both_certificates_agree_on_any_point(seed: int, soft: float) -> None:
    rng = np.random.default_rng(seed)
    qp = stage_qp(rng, soft=soft).changed(x0=rng.standard_normal(4))
    U, y = rng.standard_normal((N, NU)), rng.standard_normal((N, qp.problem.rows))
    y[rng.uniform(size=y.shape) < 0.3] = 0.0
    dense = kkt_residual(condense(qp), U.ravel(), by_columns(y, qp.problem))
    assert stage_residual(qp, U, y) == pytest.approx(dense, rel=1e-9)


def test_stationarity_is_the_slope_of_the_lagrangian() -> None:
    rng = np.random.default_rng(5)
    qp = stage_qp(rng)
    U, y = rng.standard_normal((N, NU)), rng.standard_normal((N, qp.problem.rows))

    def lagrangian(U: np.ndarray) -> float:
        X = rollout(qp, U)
        return cost(qp, U, X) + float(np.sum(y * row_values(qp, U, X)))

    step = 1e-5
    slope = np.empty_like(U)
    for position in np.ndindex(*U.shape):
        there = np.zeros_like(U)
        there[position] = step
        slope[position] = (lagrangian(U + there) - lagrangian(U - there)) / (2 * step)
    np.testing.assert_allclose(stationarity(qp, U, rollout(qp, U), y), slope, atol=1e-8)


def test_multipliers_by_rows_and_by_columns_are_the_same_numbers() -> None:
    problem = stage_problem(np.random.default_rng(1))
    y = np.arange(float(N * problem.rows)).reshape(N, -1)
    np.testing.assert_array_equal(by_rows(by_columns(y, problem), problem), y)


def test_the_dense_engine_certifies_a_stage_problem() -> None:
    qp = stage_qp(np.random.default_rng(2))
    found = DenseSolver().solve(condense(qp)).or_raise()
    assert stage_residual(qp, found.z.reshape(N, NU), by_rows(found.y, qp.problem)) < 1e-8


@pytest.mark.parametrize("damage", [np.nan, np.inf])
def test_a_point_that_is_not_finite_has_no_certificate(damage: float) -> None:
    qp = stage_qp(np.random.default_rng(2))
    U, y = np.zeros((N, NU)), np.zeros((N, qp.problem.rows))
    U[3, 1] = damage
    assert stage_residual(qp, U, y) == np.inf


def test_a_wrong_shape_is_refused_by_name() -> None:
    good = stage_problem(np.random.default_rng(0))
    fields = {name: getattr(good, name) for name in StageProblem.__slots__}
    with pytest.raises(ValueError, match="penalty has shape"):
        StageProblem(**fields | {"penalty": np.ones(3)})


@pytest.mark.parametrize(
    ("field", "bad"), [("A", np.nan), ("control_weight", 0.0), ("penalty", -1.0), ("penalty", np.nan)]
)
def test_values_that_no_problem_can_have_are_refused(field: str, bad: float) -> None:
    good = stage_problem(np.random.default_rng(0))
    fields = {name: getattr(good, name) for name in StageProblem.__slots__}
    damaged = fields[field].copy()
    damaged.flat[0] = bad
    with pytest.raises(ValueError, match="positive control weights"):
        StageProblem(**fields | {field: damaged})
