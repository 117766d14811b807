"""The dual method with bounded multipliers against daqp with slack variables, and against brute force."""

from itertools import product

import numpy as np
import pytest
from numpy.testing import assert_allclose

from otolith.core.arrays import Ints, Vec
from otolith.qp import DenseSolver, Qp, Status, kkt_residual
from otolith.qp.bounded_dual import IMPOSSIBLE, SOLVED, solve
from otolith.qp.working_set import Work, empty_rows


def problem(rng: np.random.Generator, *, soft: float, twice: bool) -> Qp:
    """Random rows that may contradict each other, each soft with a probability; some rows occur twice."""
    n, m = int(rng.integers(2, 14)), int(rng.integers(4, 40))
    root, R = rng.standard_normal((n, n)), rng.standard_normal((m, n))
    if twice:
        R[m // 2 :] = R[: m - m // 2]
    lower = R @ rng.standard_normal(n) - rng.uniform(-0.3, 1.0, m)
    upper = lower + rng.uniform(0.0, 1.0, m) * (rng.random(m) < 0.9)
    lower[rng.random(m) < 0.2] = -np.inf
    penalty = np.where(rng.random(m) < soft, rng.choice([0.1, 1.0, 10.0, 1e3], m), np.inf)
    return Qp(root @ root.T + 0.01 * np.eye(n), 5.0 * rng.standard_normal(n), R, lower, upper, penalty)


def solved(qp: Qp, start: Ints | None = None, blocks: int = 1) -> tuple[int, Vec, Vec, Ints]:
    """Outcome, z, y and the final states, with the rows in as many blocks."""
    m, n = qp.A.shape
    state = np.zeros(m, dtype=np.int64) if start is None else start.copy()
    rows, y, z = empty_rows(n, qp.penalties.reshape(blocks, -1)), np.zeros(m), np.zeros(n)
    by_block = qp.A.reshape(blocks, -1, n)
    rows.R[:, :, : m // blocks], rows.lower[:], rows.upper[:] = (
        by_block.transpose(0, 2, 1),
        qp.lower,
        qp.upper,
    )
    rows.width[:] = [1 + np.flatnonzero(block.any(axis=0))[-1] for block in by_block]
    outcome, _ = solve(qp.H, qp.g, rows, Work.of(rows), state, y, z, 500)
    return outcome, z, y, state


@pytest.mark.parametrize("soft", [0.0, 0.6, 1.0])
@pytest.mark.parametrize("twice", [False, True])
def test_the_answer_is_certified_or_infeasibility_is_found(soft: float, twice: bool) -> None:
    rng, impossible = np.random.default_rng(7), 0
    for _ in range(60):
        qp = problem(rng, soft=soft, twice=twice)
        outcome, z, y, _ = solved(qp)
        expected = DenseSolver().solve(qp)
        if outcome == IMPOSSIBLE:
            assert expected.status is Status.INFEASIBLE
            impossible += 1
        else:
            assert outcome == SOLVED
            assert kkt_residual(qp, z, y) < 1e-10
            assert_allclose(z, expected.z, atol=1e-5)
    assert (impossible > 0) == (soft < 1.0)


def test_any_working_set_may_start_and_the_answer_is_the_same() -> None:
    rng = np.random.default_rng(8)
    for _ in range(40):
        qp = problem(rng, soft=1.0, twice=True)
        cold = solved(qp)
        warm = solved(qp, rng.integers(-2, 3, len(qp.lower)))
        again = solved(qp, cold[3])
        assert_allclose(warm[1], cold[1], atol=1e-9)
        assert_allclose(again[1], cold[1], atol=1e-9)


def test_soft_rows_cost_what_their_penalty_says() -> None:
    """By brute force: each of three rows free, held or violated at its price; the cheapest of all wins."""
    rng = np.random.default_rng(9)
    for _ in range(30):
        A, bound, w = rng.standard_normal((3, 2)), rng.standard_normal(3), rng.uniform(0.1, 2.0, 3)
        g = rng.standard_normal(2)
        qp = Qp(np.eye(2), g, A, np.full(3, -np.inf), bound, w)

        def cost(z: Vec, A: Vec = A, bound: Vec = bound, w: Vec = w, g: Vec = g) -> float:
            return float(0.5 * z @ z + g @ z + w @ np.maximum(A @ z - bound, 0.0))

        tried = []
        for kinds in product((0, 1, 2), repeat=3):
            held, paid = np.array(kinds) == 1, np.array(kinds) == 2
            pull = g + w[paid] @ A[paid]
            S = A[held] @ A[held].T
            y = np.linalg.lstsq(S, -bound[held] - A[held] @ pull, rcond=None)[0]
            tried.append(cost(-pull - y @ A[held]))
        assert cost(solved(qp)[1]) == pytest.approx(min(tried), abs=1e-9)


def test_rows_of_blocks_depend_on_the_first_variables() -> None:
    """Against daqp, which sees the zeros as numbers; from nothing and from any working set."""
    rng = np.random.default_rng(10)
    for _ in range(20):
        n, of_block = 9, 7
        A = rng.standard_normal((3, of_block, n))
        A[0, :, 3:] = A[1, :, 6:] = 0.0
        A, root = A.reshape(-1, n), rng.standard_normal((n, n))
        middle = A @ rng.standard_normal(n)
        penalty = rng.choice([0.3, 3.0, np.inf], len(A), p=[0.4, 0.4, 0.2])
        qp = Qp(
            root @ root.T + 0.01 * np.eye(n), 5.0 * rng.standard_normal(n), A, middle - 0.5, middle, penalty
        )
        expected = DenseSolver().solve(qp)
        for start in (None, rng.integers(-2, 3, len(A))):
            outcome, z, y, _ = solved(qp, start, blocks=3)
            assert outcome == SOLVED
            assert kkt_residual(qp, z, y) < 1e-10
            assert_allclose(z, expected.z, atol=1e-5)


def test_the_answer_scales_with_the_problem() -> None:
    """However small the numbers, rows that must be zero are; an absolute tolerance would let them drift."""
    rng = np.random.default_rng(11)
    for scale in (1.0, 1e-15, 1e-25, 1e-60):
        qp = problem(rng, soft=1.0, twice=False)
        at_zero = rng.random(len(qp.lower)) < 0.3
        lower, upper = (np.where(at_zero, 0.0, side) for side in (qp.lower, qp.upper))
        one = Qp(qp.H, qp.g, qp.A, lower, upper, qp.penalties)
        small = Qp(qp.H, scale * qp.g, qp.A, scale * lower, scale * upper, scale * qp.penalties)
        outcome, z, y, _ = solved(small)
        assert outcome == SOLVED
        assert kkt_residual(small, z, y) < 1e-10
        assert_allclose(z / scale, solved(one)[1], atol=1e-9)
