"""Other people's engines against ours; skipped where casadi is not installed."""

from collections.abc import Callable

import numpy as np
import pytest

from otolith.core.errors import InputError
from otolith.qp import DenseSolver, Qp, Status
from otolith.qp.engines import CondensedEngine, StageEngine
from otolith.qp.stage import condense
from otolith.qp.structured import StructuredSolver
from tests.qp.stage_problems import stage_problem, stage_qp
from tests.qp.test_engines import write

pytest.importorskip("casadi")
from otolith.qp.casadi import Hpipm, HpipmEngine, QpOases, QpOasesEngine


@pytest.mark.parametrize("seed", range(5))
def test_qpoases_agrees_with_daqp(seed: int) -> None:
    qp = condense(stage_qp(np.random.default_rng(seed)))
    np.testing.assert_allclose(
        QpOases().solve(qp).or_raise().z, DenseSolver().solve(qp).or_raise().z, atol=1e-6
    )


@pytest.mark.parametrize("seed", range(5))
def test_hpipm_agrees_with_the_structured_engine(seed: int) -> None:
    qp = stage_qp(np.random.default_rng(seed))
    theirs, ours = Hpipm(qp.problem).solve(qp), StructuredSolver(qp.problem).solve(qp)
    assert theirs.status is Status.OPTIMAL
    np.testing.assert_allclose(theirs.U, ours.U, atol=1e-5)
    np.testing.assert_allclose(theirs.y, ours.y, atol=1e-4)


def test_soft_rows_are_refused_not_hardened() -> None:
    rng = np.random.default_rng(1)
    with pytest.raises(InputError, match="hard rows only"):
        Hpipm(stage_problem(rng, soft=1.0))
    with pytest.raises(InputError, match="hard rows only"):
        QpOases().solve(condense(stage_qp(rng, soft=1.0)))


def test_bad_data_never_reach_casadi() -> None:
    qp = stage_qp(np.random.default_rng(1)).changed(x0=np.full(4, np.nan))
    assert Hpipm(qp.problem).solve(qp).status is Status.INVALID
    assert QpOases().solve(condense(qp)).status is Status.INVALID


@pytest.mark.parametrize("make", [HpipmEngine, QpOasesEngine])
def test_behind_the_protocol_they_answer_what_lies_in_memory(make: Callable[..., StageEngine]) -> None:
    qp = stage_qp(np.random.default_rng(2))
    theirs, ours = (made(qp.problem, tolerance=1e-6) for made in (make, CondensedEngine))
    for engine in (theirs, ours):
        write(engine.memory, qp, ())
    np.testing.assert_allclose(theirs.run().U, ours.run().U, atol=1e-5)


@pytest.mark.parametrize("make", [HpipmEngine, QpOasesEngine])
def test_nothing_is_printed_where_a_command_prints_its_result(
    make: Callable[..., StageEngine], capfd: pytest.CaptureFixture[str]
) -> None:
    qp = stage_qp(np.random.default_rng(2))
    engine = make(qp.problem, tolerance=1e-6)
    write(engine.memory, qp, ())
    engine.run()
    assert capfd.readouterr().out == ""


def test_hpipm_refuses_blocks() -> None:
    with pytest.raises(InputError, match="blocks is 1,2, must be none with casadi-hpipm"):
        HpipmEngine(stage_problem(np.random.default_rng(2)), tolerance=1e-6, blocks=(1, 2))


def test_infeasible_problems_are_told_from_those_that_were_given_up() -> None:
    qp = stage_qp(np.random.default_rng(1))
    impossible = qp.changed(
        lower=np.where(np.arange(qp.lower.shape[1]) == 0, 50.0, qp.lower), upper=qp.upper + 60.0
    )
    assert DenseSolver().solve(condense(impossible)).status is Status.INFEASIBLE
    assert Hpipm(qp.problem).solve(impossible).status is Status.INFEASIBLE
    assert QpOases().solve(condense(impossible)).status is Status.INFEASIBLE


def test_a_maximum_is_not_asked_of_qpoases() -> None:
    refused = QpOases().solve(Qp(-np.eye(2), np.zeros(2), np.zeros((0, 2)), -np.ones(2), np.ones(2)))
    assert refused.status is Status.INVALID
    assert "not convex" in refused.why
