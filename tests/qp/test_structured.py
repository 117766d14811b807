"""The structured engine against daqp on the condensed problem; and on data that must not count as solved."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from otolith.qp import DenseSolver, Status
from otolith.qp.stage import StageQp, StageSolution, condense, rollout, stage_residual
from otolith.qp.structured import StructuredSettings, StructuredSolver
from tests.qp.stage_problems import NU, NX, N, stage_qp

seeds = st.integers(0, 10_000)
COLD = StructuredSettings(exchange_limit=0)
EXACT = DenseSolver(primal_tolerance=1e-11)


def solve(qp: StageQp, settings: StructuredSettings | None = None) -> StageSolution:
    return StructuredSolver(qp.problem, settings).solve(qp)


def assert_same(qp: StageQp, found: StageSolution, atol: float = 1e-6) -> None:
    expected = EXACT.solve(condense(qp)).or_raise()
    assert found.status is Status.OPTIMAL
    assert stage_residual(qp, found.U, found.y) < 1e-6
    np.testing.assert_allclose(found.U, expected.z.reshape(N, NU), atol=atol)
    np.testing.assert_allclose(found.X, rollout(qp, found.U), atol=1e-9)


@given(
    seed=seeds,
    cold=st.booleans(),
    soft=st.sampled_from([np.inf, 50.0, 0.5]),
    pull=st.sampled_from([0.1, 3.0, 100.0]),
)
@settings(max_examples=80, deadline=None)
def test_random_problems_agree_with_daqp(seed: int, cold: bool, soft: float, pull: float) -> None:
    qp = stage_qp(np.random.default_rng(seed), soft=soft, pull=pull)
    found = solve(qp, COLD if cold else None)
    assert (found.iterations > 0) or not cold
    assert_same(qp, found)


@pytest.mark.parametrize("row", range(6))
@pytest.mark.parametrize("side", ["lower", "upper"])
@pytest.mark.parametrize("soft", [np.inf, 1e-3])
def test_every_row_alone_can_bind_at_either_side(row: int, side: str, soft: float) -> None:
    qp = stage_qp(np.random.default_rng(7), soft=soft)
    loose = np.full_like(qp.upper, np.inf)
    qp = qp.changed(lower=-loose, upper=loose)
    free = solve(qp)
    values = StructuredSolver(qp.problem).rows("VALUE")  # only for its shape
    bound = np.full_like(values, np.inf)
    bound[:, row] = 0.01
    qp = qp.changed(upper=bound) if side == "upper" else qp.changed(lower=-bound)
    found = solve(qp)
    assert not free.working_set.any()
    assert np.any(found.working_set[:, row] == (1 if side == "upper" else -1))
    assert_same(qp, found)


def test_equal_bounds_are_equalities() -> None:
    qp = stage_qp(np.random.default_rng(9), tight=5.0)
    lower, upper = qp.lower.copy(), qp.upper.copy()
    lower[-1, :2] = upper[-1, :2] = 0.1, -0.05  # two terminal conditions
    qp = qp.changed(lower=lower, upper=upper)
    for way in (None, COLD):
        found = solve(qp, way)
        assert_same(qp, found)
        np.testing.assert_allclose(found.X[-1, 0], 0.1, atol=1e-8)


@given(seed=seeds)
@settings(max_examples=30, deadline=None)
def test_the_start_never_changes_the_answer(seed: int) -> None:
    rng = np.random.default_rng(seed)
    qp = stage_qp(rng)
    solver = StructuredSolver(qp.problem)
    first = solver.solve(qp)
    again = solver.solve(qp)
    wild = solver.solve(qp, rng.integers(-1, 2, first.y.shape))
    assert (again.changes, again.factorisations, again.iterations) == (0, 1, 0)
    np.testing.assert_allclose(again.U, first.U, atol=1e-8)
    np.testing.assert_allclose(wild.U, first.U, atol=1e-6)


def test_after_reset_equal_problems_give_equal_answers_bit_for_bit() -> None:
    rng = np.random.default_rng(11)
    first, second = stage_qp(rng), stage_qp(np.random.default_rng(12))
    second = second.changed(problem=first.problem)
    solver = StructuredSolver(first.problem)
    before = [solver.solve(qp) for qp in (first, second)]
    solver.reset()
    for one, other in zip(before, [solver.solve(qp) for qp in (first, second)], strict=True):
        np.testing.assert_array_equal(one.U, other.U)
        np.testing.assert_array_equal(one.y, other.y)


@given(seed=seeds, cold=st.booleans())
@settings(max_examples=60, deadline=None)
def test_what_is_infeasible_is_found_so_and_nothing_else(seed: int, cold: bool) -> None:
    rng = np.random.default_rng(seed)
    qp = stage_qp(rng, tight=0.5).changed(x0=rng.uniform(-0.6, 0.6, 4))
    expected = EXACT.solve(condense(qp)).status
    found = solve(qp, COLD if cold else None)
    assert found.status is expected
    if expected is Status.INFEASIBLE:
        assert found.residual == np.inf
        assert np.isfinite(found.U).all()


def least_violation(qp: StageQp) -> float:
    """The least amount by which all bounds must be widened for a feasible point, by HiGHS."""
    dense = condense(qp)
    n, R = len(dense.g), np.vstack([np.eye(dense.bounds, len(dense.g)), dense.A])
    above, below = np.isfinite(dense.upper), np.isfinite(dense.lower)
    A = np.vstack([R[above], -R[below]])
    found = linprog(
        np.eye(n + 1)[n],
        A_ub=np.hstack([A, -np.ones((len(A), 1))]),
        b_ub=np.concatenate([dense.upper[above], -dense.lower[below]]),
        bounds=[(None, None)] * n + [(-1.0, None)],
    )
    assert found.status == 0
    assert found.x is not None
    return float(found.x[n])


@given(seed=seeds, sides=st.sampled_from(["both", "upper", "none"]), edge=st.booleans())
@settings(max_examples=25, deadline=None, derandomize=True)
def test_infeasibility_is_proved_only_where_a_linear_program_finds_it(
    seed: int, sides: str, edge: bool
) -> None:
    rng = np.random.default_rng(seed)
    qp = stage_qp(rng, tight=0.3)
    if sides != "none":  # an input without bounds: its pivot row takes its part in the proof
        qp.upper[:, -1] = np.inf
    if sides == "both":
        qp.lower[:, -1] = -np.inf
    solver, feasible, x0 = StructuredSolver(qp.problem), 0.0, rng.uniform(-1.0, 1.0, NX)
    infeasible = 1.0
    for _ in range(12 if edge else 0):  # to the edge of the feasible starts along a ray
        middle = 0.5 * (feasible + infeasible)
        outside = least_violation(qp.changed(x0=middle * x0)) > 0.0
        feasible, infeasible = (feasible, middle) if outside else (middle, infeasible)
    for size in (feasible, infeasible):
        case = qp.changed(x0=size * x0)
        found = solver.solve(case)
        if found.status is Status.INFEASIBLE:
            assert least_violation(case) > 0.0
        else:
            assert (
                found.status is Status.OPTIMAL or abs(least_violation(case)) < 1e-4
            )  # left open at the edge


@given(seed=seeds, scale=st.sampled_from([1e-9, 1.0, 1e6]))
@settings(max_examples=60, deadline=None, derandomize=True)
def test_no_multipliers_prove_a_feasible_problem_infeasible(seed: int, scale: float) -> None:
    """Unbounded inputs cancel those on pivot rows; what rounding leaves of them proves nothing."""
    rng = np.random.default_rng(seed)
    qp = stage_qp(rng).changed(x0=rng.standard_normal(NX))  # at once outside, where inputs do nothing
    qp.lower[:, -NU:], qp.upper[:, -NU:] = -np.inf, np.inf
    solver = StructuredSolver(qp.problem)
    assume(solver.solve(qp).status is Status.OPTIMAL)
    rows = solver.rows("MULTIPLIER")
    rows[:] = 0.0
    of_pivots = list(solver.structure.pivots.values())
    rows[: rng.integers(1, 3), of_pivots] = scale * rng.standard_normal(len(of_pivots))
    assert not solver.kernels.impossible(solver.vector)


def test_most_infeasible_problems_are_proved_so_without_bounds_on_an_input() -> None:
    rng, proved, infeasible = np.random.default_rng(2), 0, 0
    for _ in range(40):
        qp = stage_qp(rng, tight=0.3).changed(x0=rng.uniform(-1.0, 1.0, NX))
        qp.lower[:, -1], qp.upper[:, -1] = -np.inf, np.inf
        if least_violation(qp) > 1e-6:
            infeasible += 1
            proved += solve(qp).status is Status.INFEASIBLE
    assert infeasible > 12
    assert proved > 0.9 * infeasible


def test_soft_rows_make_an_infeasible_start_solvable() -> None:
    rng = np.random.default_rng(3)
    hard = stage_qp(rng).changed(x0=np.array([50.0, 0.0, 0.0, 0.0]))  # beyond row 0 for good
    assert solve(hard).status is Status.INFEASIBLE
    soft = stage_qp(np.random.default_rng(3), soft=20.0).changed(x0=hard.x0)
    lower, upper = soft.lower.copy(), soft.upper.copy()
    lower[:, 2], upper[:, 2] = -np.inf, np.inf
    assert_same(soft.changed(lower=lower, upper=upper), solve(soft.changed(lower=lower, upper=upper)))


FINITE = ("x0", "output", "error", "state_weight", "state_linear", "input_linear", "varying")


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("field", FINITE)
def test_data_that_are_not_finite_are_refused(field: str, bad: float) -> None:
    qp = stage_qp(np.random.default_rng(1))
    damaged = getattr(qp, field).copy()
    damaged[
        np.unravel_index(np.flatnonzero(damaged if field != "x0" else damaged + 1)[-1], damaged.shape)
    ] = bad
    qp = qp.changed(**{field: damaged})
    assert not qp.well_posed()
    assert solve(qp).status is Status.INVALID


@pytest.mark.parametrize(("lower", "upper"), [(np.nan, 1.0), (-1.0, np.nan), (0.5, 0.4)])
def test_bounds_that_are_none_are_refused(lower: float, upper: float) -> None:
    qp = stage_qp(np.random.default_rng(1))
    qp.lower[2, 1], qp.upper[2, 1] = lower, upper
    assert solve(qp).status is Status.INVALID


@pytest.mark.parametrize("pull", [1e3, 1e6, 1e9, 1e12, 1e150, 1e299])
@pytest.mark.parametrize("soft", [np.inf, 10.0])
def test_huge_data_are_solved_or_honestly_not(pull: float, soft: float) -> None:
    for seed in range(5):
        qp = stage_qp(np.random.default_rng(seed), pull=pull, soft=soft)
        with np.errstate(over="ignore", invalid="ignore"):
            found = solve(qp)
            assert np.isfinite(found.U).all()
            assert found.status in {Status.OPTIMAL, Status.LIMIT}
            if found.status is Status.OPTIMAL:
                assert stage_residual(qp, found.U, found.y) < 1e-6
            elif pull <= 1e3:
                pytest.fail(f"not solved at {pull}")


def test_an_engine_recovers_from_bad_data() -> None:
    qp = stage_qp(np.random.default_rng(1))
    solver = StructuredSolver(qp.problem)
    good = solver.solve(qp)
    bad = solver.solve(qp.changed(x0=np.full(4, np.nan)))
    assert bad.status is Status.INVALID
    np.testing.assert_array_equal(bad.U, good.U)  # the last certified plan
    impossible = solver.solve(qp.changed(x0=np.array([50.0, 0.0, 0.0, 0.0])))
    assert impossible.status is Status.INFEASIBLE
    np.testing.assert_array_equal(impossible.U, good.U)
    np.testing.assert_allclose(
        impossible.X, rollout(qp.changed(x0=np.array([50.0, 0, 0, 0])), good.U), atol=1e-9
    )
    np.testing.assert_allclose(solver.solve(qp).U, good.U, atol=1e-8)


def test_an_iteration_limit_is_no_answer() -> None:
    qp = stage_qp(np.random.default_rng(4), pull=30.0)
    hurried = StructuredSettings(exchange_limit=1, polish_limit=1, iteration_limit=1)
    found = solve(qp, hurried)
    assert found.status is Status.LIMIT
    assert found.residual == np.inf
