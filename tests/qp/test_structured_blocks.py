"""Blocked inputs: the structured engine against the dense form of the same blocked problem."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from otolith.qp import DenseSolver, Status, kkt_residual
from otolith.qp.blocked import block_ends, condense_blocked
from otolith.qp.stage import by_columns, condense, rollout
from otolith.qp.structured import StructuredSettings, StructuredSolver
from tests.qp.stage_problems import NU, NX, N, stage_problem, stage_qp

BLOCKS = (1, 2, 4)
EXACT = DenseSolver(primal_tolerance=1e-11)
COLD = StructuredSettings(exchange_limit=0)


@given(seed=st.integers(0, 10_000), cold=st.booleans(), soft=st.sampled_from([np.inf, 5.0]))
@settings(max_examples=60, deadline=None)
def test_random_blocked_problems_agree_with_daqp(seed: int, cold: bool, soft: float) -> None:
    rng = np.random.default_rng(seed)
    qp = stage_qp(rng, soft=soft).changed(x0=0.05 * rng.standard_normal(NX))
    dense = condense_blocked(qp, BLOCKS)
    expected = EXACT.solve(dense)
    found = StructuredSolver(qp.problem, COLD if cold else None, blocks=BLOCKS).solve(qp)
    assert found.status is expected.status
    if expected.status is Status.OPTIMAL:
        np.testing.assert_allclose(found.U, expected.z.reshape(len(BLOCKS), NU), atol=1e-6)
        fine = rollout(qp, np.repeat(found.U, BLOCKS, axis=0))
        np.testing.assert_allclose(found.X, fine[block_ends(BLOCKS)], atol=1e-9)
        nr = qp.problem.rows - NU
        y = np.concatenate([found.y[:, nr:].ravel(), found.y[:, :nr].ravel()])
        assert found.residual < 1e-6
        assert kkt_residual(dense, found.U.ravel(), y) < 1e-6


def test_blocks_of_one_step_are_no_blocks() -> None:
    qp = stage_qp(np.random.default_rng(3))
    blocked, plain = condense_blocked(qp, (1,) * N), condense(qp)
    for name in ("H", "g", "A", "lower", "upper"):
        np.testing.assert_allclose(getattr(blocked, name), getattr(plain, name), atol=1e-12)
    one = StructuredSolver(qp.problem).solve(qp)
    np.testing.assert_allclose(EXACT.solve(blocked).z, one.U.ravel(), atol=1e-6)
    assert kkt_residual(blocked, one.U.ravel(), by_columns(one.y, qp.problem)) < 1e-6


def test_the_plan_is_predicted_at_every_step() -> None:
    qp = stage_qp(np.random.default_rng(4))
    solver = StructuredSolver(qp.problem, blocks=BLOCKS)
    found = solver.solve(qp)
    solver.kernels.predict_plan(solver.vector)
    fine = rollout(qp, np.repeat(found.U, BLOCKS, axis=0))
    np.testing.assert_allclose(solver.part("STEP_STATE"), fine, atol=1e-9)


@pytest.mark.parametrize("blocks", [(1, 2), (8,), (0, 7)])
def test_blocks_must_fill_the_horizon(blocks: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match="do not fill a horizon of 7 steps"):
        StructuredSolver(stage_problem(np.random.default_rng(1)), blocks=blocks)
