"""The structured engine on the problems of closed loops in 2 and 4 DOF, against daqp, step by step."""

import numpy as np
import pytest

from otolith.qp import DenseSolver, Status
from otolith.qp.stage import StageProblem, StageQp, condense, stage_residual
from otolith.qp.structured import StructuredSettings, StructuredSolver
from tests.qp.cueing_loop import STEP_2, closed_loop, linearise, multisine, stage_problem

EXACT = DenseSolver(primal_tolerance=1e-11)
CASES = [
    (2, 40, np.inf, 150),
    (2, 40, 100.0, 40),
    (4, 20, np.inf, 60),
    (4, 20, 100.0, 20),
]  # dofs, N, penalty, steps


def engine(problem: StageProblem, settings: StructuredSettings | None = None) -> StructuredSolver:
    return StructuredSolver(problem, settings, extension=STEP_2 if problem.inputs == 2 else "")


def assert_first_inputs_agree(
    qp: StageQp, solver: StructuredSolver, u0: np.ndarray, start: np.ndarray | None
) -> np.ndarray:
    expected = EXACT.solve(condense(qp), start).or_raise()
    np.testing.assert_allclose(u0, expected.z[: qp.problem.inputs], atol=1e-6)
    return expected.working_set


@pytest.mark.parametrize(("dofs", "horizon", "penalty", "steps"), CASES)
def test_every_step_is_certified_and_agrees_with_daqp(
    dofs: int, horizon: int, penalty: float, steps: int
) -> None:
    problem, limit = stage_problem(dofs, horizon, penalty)
    solver, start = engine(problem), None
    cold = engine(problem, StructuredSettings(exchange_limit=0))
    at_once = 0
    for k, (qp, found) in enumerate(
        closed_loop(problem, limit, multisine(steps, dofs // 2, seed=dofs), solver.solve)
    ):
        assert found.status is Status.OPTIMAL
        assert found.residual == pytest.approx(stage_residual(qp, found.U, found.y), rel=1e-6, abs=1e-12)
        start = assert_first_inputs_agree(qp, solver, found.U[0], start)
        if k % 5 == 0:
            np.testing.assert_allclose(cold.solve(qp).U, found.U, atol=1e-5)
        at_once += found.factorisations == 1
    assert at_once > 0.3 * steps


@pytest.mark.parametrize("penalty", [np.inf, 100.0])
def test_states_outside_soft_limits_are_solved(penalty: float) -> None:
    problem, limit = stage_problem(2, 40, penalty)
    solver, rng = engine(problem), np.random.default_rng(5)
    statuses = set()
    for _ in range(25):
        x0 = np.concatenate([rng.uniform(-1, 1, 4) * [0.1, 0.6, 1.0, 0.5], np.zeros(2)])
        qp = linearise(problem, limit, x0, np.zeros((40, 2)), rng.uniform(-5, 5, 1))
        solver.reset()
        found = solver.solve(qp)
        expected = EXACT.solve(condense(qp))
        statuses.add(found.status)
        assert found.status is expected.status
        if found.status is Status.OPTIMAL:
            np.testing.assert_allclose(found.U[0], expected.z[:2], atol=1e-6)
    assert statuses == ({Status.OPTIMAL} if np.isfinite(penalty) else {Status.OPTIMAL, Status.INFEASIBLE})


def test_a_whole_step_in_one_call_is_the_step_made_of_its_parts() -> None:
    problem, limit = stage_problem(2, 40)
    parts, whole = engine(problem), engine(problem)
    whole.load(linearise(problem, limit, np.zeros(6), np.zeros((40, 2)), np.zeros(1)))
    references = multisine(60, 1, seed=8)
    for wanted, (qp, found) in zip(
        references, closed_loop(problem, limit, references, parts.solve), strict=True
    ):
        whole.part("START")[:] = qp.x0
        assert whole.kernels.step(whole.vector, wanted[0]) == 0
        np.testing.assert_allclose(whole.part("PLAN"), found.U, atol=1e-7)


def test_a_reference_that_is_not_a_number_is_invalid_and_harmless() -> None:
    problem, limit = stage_problem(2, 40)
    solver = engine(problem)
    solver.load(linearise(problem, limit, np.zeros(6), np.zeros((40, 2)), np.zeros(1)))
    solver.kernels.step(solver.vector, 0.5)
    plan = solver.part("PLAN").copy()
    solver.kernels.step(solver.vector, np.nan)
    assert solver.solution().status is Status.INVALID
    np.testing.assert_array_equal(solver.part("PLAN"), plan)
    solver.kernels.step(solver.vector, 0.5)
    assert solver.solution().status is Status.OPTIMAL
