"""Condensing block by block against eliminating the states step by step."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from otolith.qp.blocked import Lengths, condense_blocked
from otolith.qp.blocked_condense import Dynamics, condense, empty_condensed, layout_of
from otolith.qp.engines import empty_memory
from otolith.qp.stage import by_columns
from tests.qp.stage_problems import NX, N, stage_qp
from tests.qp.test_engines import write


@pytest.mark.parametrize("lengths", [(1,) * N, (1, 2, 4), (N,)], ids=str)
def test_the_problem_is_the_one_that_eliminating_every_step_gives(lengths: Lengths) -> None:
    """Twice in the same memory, so that weights which change, and rows of before, are seen."""
    rng = np.random.default_rng(4)
    problem = stage_qp(rng).problem
    memory, dynamics = empty_memory(problem, lengths), Dynamics.of(problem, lengths)
    layout, found = layout_of(problem, lengths, dynamics), empty_condensed(problem, lengths, dynamics)
    for _ in range(2):
        qp = stage_qp(rng).changed(problem=problem, x0=rng.standard_normal(NX))
        qp = qp.changed(
            varying=qp.varying * problem.varying,
            output=qp.output * problem.output,
            state_linear=rng.standard_normal(qp.state_linear.shape),
        )
        write(memory, qp, lengths)
        condense(dynamics, layout, memory, found)
        expected = condense_blocked(qp, lengths)
        assert_allclose(found.H, np.tril(expected.H), atol=1e-12)
        assert_allclose(found.g, expected.g, atol=1e-12)
        M, nu, nr = len(lengths), problem.inputs, problem.rows - problem.inputs
        by_block = found.rows.R[:, :, : problem.rows].transpose(0, 2, 1)
        assert_allclose(by_block[:, :nr].reshape(M * nr, -1), expected.A, atol=1e-12)
        assert_allclose(by_block[:, nr:].reshape(M * nu, -1), np.eye(M * nu), atol=0.0)
        for side, bound in ((found.rows.lower, expected.lower), (found.rows.upper, expected.upper)):
            assert_allclose(by_columns(side.reshape(M, -1), problem), bound, atol=1e-12)
