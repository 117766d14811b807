"""The stage problem against its dense form, finite differences and hand-solved cases."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import block_diag

from otolith.qp import DenseSolver, kkt_residual
from otolith.qp.stage import (
    StageProblem,
    StageQp,
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
def test_both_certificates_accept_the_optimum_and_refuse_what_is_beside_it(seed: int, soft: float) -> None:
    rng = np.random.default_rng(seed)
    qp = stage_qp(rng, soft=soft)
    dense = condense(qp)
    found = DenseSolver().solve(dense).or_raise()
    U, y = found.z.reshape(N, NU), by_rows(found.y, qp.problem)
    assert stage_residual(qp, U, y) < 1e-8
    assert kkt_residual(dense, found.z, found.y) < 1e-8
    beside = U + 1e-3 * np.abs(U).max() * rng.standard_normal(U.shape)
    assert stage_residual(qp, beside, y) > 1e-6
    assert kkt_residual(dense, beside.ravel(), found.y) > 1e-6


def in_other_units(qp: StageQp, of: np.random.Generator) -> tuple[StageQp, np.ndarray, np.ndarray]:
    """The problem in units of states, inputs, rows and cost that differ by 1e±9; factors of U and y."""
    problem = qp.problem
    dx, du = 10.0 ** of.uniform(-9, 9, problem.states), 10.0 ** of.uniform(-9, 9, problem.inputs)
    er = np.concatenate([10.0 ** of.uniform(-9, 9, problem.rows - problem.inputs), 1.0 / du])
    c = 10.0 ** of.uniform(-9, 9)
    nc, weighted = len(problem.C), list(problem.weighted)
    scaled = replace(
        problem,
        A=problem.A * dx / dx[:, None],
        B=problem.B * du / dx[:, None],
        C=er[:nc, None] * problem.C * dx,
        control_weight=c * problem.control_weight * du**2,
        penalty=c * problem.penalty / er,
    )
    other = StageQp(
        problem=scaled,
        x0=qp.x0 / dx,
        output=np.sqrt(c) * qp.output * dx,
        error=np.sqrt(c) * qp.error,
        state_weight=c * qp.state_weight * dx[weighted] ** 2,
        state_linear=c * qp.state_linear * dx[weighted],
        input_linear=c * qp.input_linear * du,
        varying=er[nc : nc + len(problem.varying), None] * qp.varying * dx,
        lower=qp.lower * er,
        upper=qp.upper * er,
    )
    return other, 1.0 / du, c / er


@given(seed=seeds, soft=st.sampled_from([np.inf, 0.5]), damage=st.sampled_from([0.0, 1e-4, 1.0]))
@settings(max_examples=40, deadline=None)
def test_the_certificate_does_not_depend_on_units(seed: int, soft: float, damage: float) -> None:
    rng = np.random.default_rng(seed)
    qp = stage_qp(rng, soft=soft)
    found = DenseSolver().solve(condense(qp)).or_raise()
    y = by_rows(found.y, qp.problem)
    U = found.z.reshape(N, NU) + damage * rng.standard_normal((N, NU))
    other, of_U, of_y = in_other_units(qp, rng)
    here, there = stage_residual(qp, U, y), stage_residual(other, U * of_U, y * of_y)
    assert there == pytest.approx(here, rel=1e-6, abs=1e-12)


def test_a_negative_state_weight_is_no_problem() -> None:
    qp = stage_qp(np.random.default_rng(2))
    weight = qp.state_weight.copy()
    weight[3, 1] = -1e-9
    assert qp.well_posed()
    assert not qp.changed(state_weight=weight).well_posed()


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
