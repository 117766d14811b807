"""Move blocking: a stage problem whose inputs are held for several steps, with rows only at the ends of
blocks.

A long horizon with few blocks costs less to solve than a short horizon without blocks; the cost still counts
every step. `lengths` holds the number of steps of each block; their sum is the horizon. A block has the rows
of its last step, and its inputs obey the tightest of its steps' bounds.
"""

import numpy as np

from otolith.core.arrays import Ints, Mat
from otolith.qp.problem import Qp
from otolith.qp.stage import StageQp, by_columns, condense

Lengths = tuple[int, ...]


def block_ends(lengths: Lengths) -> Ints:
    """Index of the last step of every block."""
    return np.asarray(np.cumsum(lengths) - 1, dtype=np.int64)


def block_starts(lengths: Lengths) -> Ints:
    """Index of the first step of every block."""
    return np.asarray(block_ends(lengths) - np.asarray(lengths) + 1, dtype=np.int64)


def hold(lengths: Lengths, inputs: int) -> Mat:
    """Matrix (N·nu, blocks·nu) that gives the inputs of all steps from those of the blocks."""
    of_blocks = np.repeat(np.eye(len(lengths)), lengths, axis=0)
    return np.asarray(np.kron(of_blocks, np.eye(inputs)), dtype=np.float64)


def block_bounds(qp: StageQp, lengths: Lengths) -> tuple[Mat, Mat]:
    """Bounds (blocks, rows) of the blocked problem."""
    nr, starts, ends = qp.problem.rows - qp.problem.inputs, block_starts(lengths), block_ends(lengths)
    lower, upper = qp.lower[ends].copy(), qp.upper[ends].copy()
    lower[:, nr:] = np.maximum.reduceat(qp.lower[:, nr:], starts, axis=0)
    upper[:, nr:] = np.minimum.reduceat(qp.upper[:, nr:], starts, axis=0)
    return lower, upper


def condense_blocked(qp: StageQp, lengths: Lengths) -> Qp:
    """Return the blocked problem in its inputs alone (n = blocks·nu), with rows in the order of
    `condense`.
    """
    problem, ends = qp.problem, block_ends(lengths)
    nu, nr, N, M = problem.inputs, problem.rows - problem.inputs, problem.horizon, len(lengths)
    fine = condense(qp)
    T = hold(lengths, nu)
    A = fine.A.reshape(N, nr, N * nu)[ends].reshape(M * nr, N * nu) @ T
    lower, upper = block_bounds(qp, lengths)
    of_states = [side[N * nu :].reshape(N, nr)[ends].ravel() for side in (fine.lower, fine.upper)]
    return Qp(
        T.T @ fine.H @ T,
        T.T @ fine.g,
        A,
        np.concatenate([lower[:, nr:].ravel(), of_states[0]]),
        np.concatenate([upper[:, nr:].ravel(), of_states[1]]),
        by_columns(problem.penalty[ends], problem),
    )
