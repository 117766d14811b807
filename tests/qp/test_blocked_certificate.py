"""The compiled certificate of blocked problems against the readable one, and against wrong answers."""

import numpy as np
import pytest

from otolith.qp import DenseSolver, Status
from otolith.qp.blocked import condense_blocked
from otolith.qp.blocked_certificate import Judged, blocked_residual
from otolith.qp.engines import empty_memory, expand
from otolith.qp.stage import by_rows, stage_residual
from tests.qp.stage_problems import NU, NX, N, stage_qp
from tests.qp.test_engines import firm_at_first, write

ONES = (1,) * N


@pytest.mark.parametrize("soft", [np.inf, 0.3])
def test_without_blocks_it_is_the_residual_of_the_stages(soft: float) -> None:
    """For answers that are right, nearly right and wrong."""
    rng = np.random.default_rng(1)
    for share in (0.0, 1e-6, 1.0):
        qp = firm_at_first(stage_qp(rng).changed(x0=0.05 * rng.standard_normal(NX)), soft)
        memory = empty_memory(qp.problem, ())
        write(memory, qp, ())
        found = DenseSolver().solve(condense_blocked(qp, ONES))
        U = found.z.reshape(N, NU) + share * rng.standard_normal((N, NU))
        y = by_rows(found.y, qp.problem) * (1.0 + share)
        expected = stage_residual(expand(qp.problem, memory), U, y)
        assert blocked_residual(Judged.of(qp.problem, ONES), memory, U, y) == pytest.approx(
            expected, rel=1e-6, abs=1e-14
        )


def test_an_answer_for_blocks_is_accepted_and_a_wrong_one_is_not() -> None:
    rng, lengths = np.random.default_rng(2), (1, 2, 4)
    for _ in range(20):
        qp = firm_at_first(stage_qp(rng).changed(x0=0.05 * rng.standard_normal(NX)), 5.0)
        memory = empty_memory(qp.problem, lengths)
        write(memory, qp, lengths)
        found = DenseSolver().solve(condense_blocked(qp, lengths))
        assert found.status is Status.OPTIMAL
        judged, U = Judged.of(qp.problem, lengths), found.z.reshape(3, NU)
        y = by_rows(found.y, qp.problem)
        assert blocked_residual(judged, memory, U, y) < 1e-7
        assert blocked_residual(judged, memory, U + 1e-3, y) > 1e-6
        assert blocked_residual(judged, memory, U, y + 1e-2) > 1e-6
        assert blocked_residual(judged, memory, U * np.nan, y) == np.inf
        wrong = y.copy()
        wrong[1, 0] = np.nan
        assert blocked_residual(judged, memory, U, wrong) == np.inf
