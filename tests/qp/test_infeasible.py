"""Infeasibility is reported with a proof, and not without one."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from otolith.qp import DenseSolver, Qp, Status
from otolith.qp.infeasible import infeasible, is_proof
from tests.qp.qp_problems import KINDS, in_units, known_qp

INF = np.inf


def pair(second: float, penalty: float = INF) -> Qp:
    """z₁ + z₂ = 1 and 2 z₁ + 2 z₂ = second."""
    A = np.array([[1.0, 1.0], [2.0, 2.0]])
    sides = np.array([1.0, second])
    return Qp(np.eye(2), np.zeros(2), A, sides, sides, np.array([INF, penalty]))


@pytest.mark.parametrize("second", [2.001, 1.0, -3.0])
def test_contradicting_equalities_are_infeasible(second: float) -> None:
    assert DenseSolver().solve(pair(second)).status is Status.INFEASIBLE


def test_equalities_that_agree_are_not() -> None:
    np.testing.assert_allclose(DenseSolver().solve(pair(2.0)).or_raise().z, [0.5, 0.5])


def test_a_contradiction_within_rounding_proves_nothing() -> None:
    assert DenseSolver().solve(pair(2.0 + 1e-12)).status is not Status.INFEASIBLE


def test_a_soft_row_contradicts_nothing() -> None:
    assert not infeasible(pair(2.001, penalty=1.0))


def test_a_proof_is_judged_by_hand() -> None:
    qp = pair(2.001)
    assert is_proof(qp, np.array([2.0, -1.0]))
    assert not is_proof(qp, np.array([-2.0, 1.0]))  # turned round: 0 ≤ 0.001 contradicts nothing
    assert not is_proof(qp, np.array([2.0, -1.0 - 1e-6]))  # does not cancel
    assert not is_proof(qp, np.zeros(2))
    assert not is_proof(pair(2.001, penalty=1.0), np.array([2.0, -1.0]))


def test_a_side_that_does_not_exist_proves_nothing() -> None:
    A = np.array([[1.0], [1.0]])
    qp = Qp(np.eye(1), np.zeros(1), A, np.array([1.0, -INF]), np.array([INF, 0.0]))
    assert is_proof(qp, np.array([-1.0, 1.0]))
    assert not is_proof(qp, np.array([1.0, -1.0]))


def test_rows_that_meet_far_away_are_not_called_infeasible() -> None:
    # z₁ ≥ 1 + z₂ and z₁ (1 + 1e-9) ≤ z₂: only points with z₁ ≤ −1e9 satisfy both.
    A = np.array([[1.0, -1.0], [1.0 + 1e-9, -1.0]])
    qp = Qp(np.eye(2), np.zeros(2), A, np.array([1.0, -INF]), np.array([INF, 0.0]))
    assert not infeasible(qp)


@given(seed=st.integers(0, 100_000), kind=st.sampled_from(KINDS))
@settings(max_examples=30, deadline=None)
def test_in_all_units_what_is_feasible_is_not_proved_otherwise_and_what_is_not_is(
    seed: int, kind: str
) -> None:
    rng = np.random.default_rng(seed)
    known = known_qp(rng, kind)
    n, qp = len(known.z), known.qp
    d, e = 10.0 ** rng.uniform(-9, 9, n), 10.0 ** rng.uniform(-9, 9, len(qp.A) + 1)
    assert not infeasible(in_units(known, d, e[:-1], 1e9).qp)
    weights = rng.uniform(0.5, 2.0, len(qp.A)) * rng.choice([-1.0, 1.0], len(qp.A))
    side = np.where(weights > 0, qp.upper[qp.bounds :], qp.lower[qp.bounds :])
    if not np.isfinite(side).all():
        return
    beyond = float(weights @ side + 0.01 * np.abs(weights * side).sum() + 0.01)  # more than these rows allow
    A = np.vstack([qp.A, weights @ qp.A])
    contradicting = Qp(qp.H, qp.g, A, np.append(qp.lower, beyond), np.append(qp.upper, INF))
    scaled = in_units(type(known)(contradicting, known.z, np.append(known.y, 0.0)), d, e, 1e-9)
    assert infeasible(scaled.qp)
