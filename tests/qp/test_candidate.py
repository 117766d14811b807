"""A guess of the working set is judged as the optimality conditions judge it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import block_diag

from otolith.core.arrays import Ints
from otolith.qp import DenseSolver, Qp
from otolith.qp.candidate import better, violations

seeds = st.integers(0, 10_000)
n, b, m = 5, 3, 8  # variables, simple bounds, rows of A


def random_qp(rng: np.random.Generator, penalty: float = np.inf) -> Qp:
    root = rng.standard_normal((n, n))
    lower, upper = -rng.uniform(0.1, 1.0, (2, b + m)) * [[1.0], [-1.0]]
    of_rows = np.full(b + m, np.inf)
    of_rows[b:] = penalty
    return Qp(
        root @ root.T + 0.1 * np.eye(n),
        3.0 * rng.standard_normal(n),
        rng.standard_normal((m, n)),
        lower,
        upper,
        of_rows,
    )


def by_hand(qp: Qp, guess: Ints) -> int:
    """The same count from the whole optimality system, solved in the least-squares sense."""
    R = np.vstack([np.eye(b, n), qp.A])
    held = np.flatnonzero(guess)
    side = np.where(guess > 0, qp.upper, qp.lower)[held]
    k = len(held)
    system = np.block([[qp.H, R[held].T], [R[held], np.zeros((k, k))]])
    z_y = np.linalg.lstsq(system, np.concatenate([-qp.g, side]))[0]
    z, y = z_y[:n], z_y[n:]
    rows, count = R @ z, 0
    assert qp.penalty is not None
    for i in range(b + m):
        if guess[i]:
            pull = guess[i] * y[held.tolist().index(i)]
            count += bool(pull < -1e-8 or pull > qp.penalty[i])
        else:
            count += bool(rows[i] > qp.upper[i] + 1e-8 or rows[i] < qp.lower[i] - 1e-8)
    return count


@given(seed=seeds, active=st.integers(0, n), penalty=st.sampled_from([np.inf, 1.0]))
@settings(max_examples=100, deadline=None, derandomize=True)
def test_what_is_counted_is_what_fails(seed: int, active: int, penalty: float) -> None:
    rng = np.random.default_rng(seed)
    qp, guess = random_qp(rng, penalty), np.zeros(b + m, dtype=np.int64)
    guess[rng.choice(b + m, active, replace=False)] = rng.choice([-1, 1], active)
    assert violations(qp, guess) == by_hand(qp, guess)


@given(seed=seeds)
@settings(max_examples=50, deadline=None, derandomize=True)
def test_nothing_fails_with_the_set_of_the_answer(seed: int) -> None:
    qp = random_qp(np.random.default_rng(seed))
    found = DenseSolver().solve(qp)
    if found.residual < 1e-6:
        assert violations(qp, found.working_set) == 0
        other = np.zeros(b + m, dtype=np.int64)
        chosen, hinted = better(qp, other, lambda: found.working_set, 0 * other)
        assert hinted == (violations(qp, other) > 0)
        assert violations(qp, chosen) == 0
        assert not better(qp, found.working_set, lambda: other, 0 * other)[1]


def test_a_hint_is_heard_only_on_the_groups_where_the_start_fails() -> None:
    rng = np.random.default_rng(3)
    one, two = random_qp(rng), random_qp(rng)
    answers = [DenseSolver().solve(qp).or_raise().working_set for qp in (one, two)]
    side_by_side = Qp(
        block_diag(one.H, two.H),
        np.concatenate([one.g, two.g]),
        np.vstack(
            [
                np.eye(b, 2 * n),
                np.hstack([one.A, 0 * one.A]),
                np.eye(b, 2 * n, n),
                np.hstack([0 * two.A, two.A]),
            ]
        ),
        np.concatenate([one.lower, two.lower]),
        np.concatenate([one.upper, two.upper]),
    )
    groups = np.repeat([0, 1], b + m)
    start, absurd = np.concatenate([answers[0], 0 * answers[1]]), np.ones(b + m, dtype=np.int64)
    made = np.concatenate([absurd, answers[1]])
    chosen, hinted = better(side_by_side, start, lambda: made, groups)
    assert hinted
    np.testing.assert_array_equal(chosen, np.concatenate(answers))
    assert not better(side_by_side, start, lambda: made, 0 * groups)[1]


@pytest.mark.parametrize("guess", ["all", "twice", "unbounded"])
def test_guesses_that_cannot_be_met_are_counted_and_harmless(guess: str) -> None:
    qp = random_qp(np.random.default_rng(1))
    sets = np.ones(b + m, dtype=np.int64)
    if guess == "twice":
        qp.A[1] = qp.A[0]
        sets[:] = 0
        sets[[b, b + 1]] = 1, -1
    if guess == "unbounded":
        qp.upper[:] = np.inf
        assert violations(qp, sets) == violations(qp, 0 * sets)
        return
    assert 0 < violations(qp, sets) <= b + m
