"""Other people's engines against ours; skipped where casadi is not installed."""

import sys

import numpy as np
import pytest

from otolith.core.errors import MissingExtra
from otolith.qp import DenseSolver, Status
from otolith.qp.casadi import Hpipm, QpOases
from otolith.qp.stage import condense
from otolith.qp.structured import StructuredSolver
from tests.qp.stage_problems import stage_problem, stage_qp


@pytest.mark.parametrize("seed", range(5))
def test_qpoases_agrees_with_daqp(seed: int) -> None:
    pytest.importorskip("casadi")
    qp = condense(stage_qp(np.random.default_rng(seed)))
    np.testing.assert_allclose(
        QpOases().solve(qp).or_raise().z, DenseSolver().solve(qp).or_raise().z, atol=1e-6
    )


@pytest.mark.parametrize("seed", range(5))
def test_hpipm_agrees_with_the_structured_engine(seed: int) -> None:
    pytest.importorskip("casadi")
    qp = stage_qp(np.random.default_rng(seed))
    theirs, ours = Hpipm(qp.problem).solve(qp), StructuredSolver(qp.problem).solve(qp)
    assert theirs.status is Status.OPTIMAL
    np.testing.assert_allclose(theirs.U, ours.U, atol=1e-5)
    np.testing.assert_allclose(theirs.y, ours.y, atol=1e-4)


def test_soft_rows_are_refused_not_hardened() -> None:
    rng = np.random.default_rng(1)
    with pytest.raises(ValueError, match="hard rows only"):
        Hpipm(stage_problem(rng, soft=1.0))
    with pytest.raises(ValueError, match="hard rows only"):
        QpOases().solve(condense(stage_qp(rng, soft=1.0)))


def test_bad_data_never_reach_casadi() -> None:
    qp = stage_qp(np.random.default_rng(1)).changed(x0=np.full(4, np.nan))
    assert Hpipm(qp.problem).solve(qp).status is Status.INVALID
    assert QpOases().solve(condense(qp)).status is Status.INVALID


def test_a_missing_casadi_is_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "casadi", None)
    with pytest.raises(MissingExtra, match=r"pip install 'otolith\[check\]'"):
        QpOases().solve(condense(stage_qp(np.random.default_rng(1))))
