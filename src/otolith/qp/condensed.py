"""Solve a stage problem through its condensed form with a dense engine, warm-started stage by stage.

This is the thesis's kind of online solver: condensing, then a hot-started dual active-set method that counts
its working-set changes.
"""

from functools import partial
from typing import Protocol

import numpy as np

from otolith.core.arrays import Ints
from otolith.core.lti import condense as predict
from otolith.qp.blocked import Lengths, block_bounds, block_ends, block_starts, hold
from otolith.qp.candidate import better
from otolith.qp.dense import DenseSolver
from otolith.qp.problem import Qp, Solution, Status
from otolith.qp.stage import OnRequest, StageProblem, StageQp, StageSolution, by_columns, by_rows, rollout


class Dense(Protocol):
    """A solver for dense problems that can start from a given working set."""

    def solve(self, qp: Qp, start: Ints | None = None) -> Solution:
        """Solve `qp`; `start` (b + m,) is a working set as in `Solution`."""


class CondensedSolver:
    """Solves problems of one structure, each starting from the working set of the previous one.

    Parameters
    ----------
    blocks : number of steps of each block of constant inputs, see `otolith.qp.blocked`; empty for one block
        per step. The M stages of working sets and answers are then the blocks.
    """

    def __init__(self, problem: StageProblem, dense: Dense | None = None, *, blocks: Lengths = ()) -> None:
        self.problem, self._dense = problem, dense or DenseSolver(patient=False)
        self._lengths = blocks or (1,) * problem.horizon
        self._ends, M = block_ends(self._lengths), len(self._lengths)
        self._Phi, Gamma = predict(problem.A, problem.B, problem.horizon)
        self._Gamma = Gamma @ hold(self._lengths, problem.inputs)  # (N, nx, n), n = M·nu
        self._at_ends = self._Gamma[self._ends]
        constant = problem.C @ self._at_ends  # (M, nc, n); constant, unlike the varying rows
        n = constant.shape[2]
        self._rows = np.concatenate([constant, np.zeros((M, len(problem.varying), n))], axis=1)
        self._weighted = np.ascontiguousarray(self._Gamma[:, list(problem.weighted)])
        self._control_weight = np.outer(self._lengths, problem.control_weight).ravel()
        self._penalty = by_columns(problem.penalty[self._ends], problem)
        self._groups: Ints = by_columns(np.tile(problem.groups, (M, 1)), problem)
        self._set: Ints = np.zeros((M, problem.rows), dtype=np.int64)

    def reset(self) -> None:
        """Forget the working set."""
        self._set = np.zeros_like(self._set)

    def solve(self, qp: StageQp, start: Ints | None = None, hint: OnRequest | None = None) -> StageSolution:
        """Solve `qp`, starting from the better of two working sets.

        Parameters
        ----------
        start : (M, rows) as `StageSolution.working_set`; None for that of the previous answer.
        hint : called when optimality conditions fail with `start`; its result (M, rows) replaces `start` when
            fewer conditions fail with it, see `otolith.qp.candidate`.
        """
        problem = self.problem
        if not qp.well_posed():
            return self._nothing(qp, Status.INVALID, 0)
        dense = self.condense(qp)
        chosen, hinted = by_columns(self._set if start is None else start, problem), False
        if hint is not None:
            chosen, hinted = better(dense, chosen, partial(_columns, hint, problem), self._groups)
        found = self._dense.solve(dense, chosen)
        if found.status is not Status.OPTIMAL:
            self.reset()
            return self._nothing(qp, found.status, found.changes)
        U, y = found.z.reshape(-1, problem.inputs), by_rows(found.y, problem)
        self._set = np.sign(y).astype(np.int64)
        X = self._Phi[self._ends] @ qp.x0 + self._at_ends @ found.z
        return StageSolution(found.status, U, X, y, found.changes, 0, 0, found.residual, hinted)

    def condense(self, qp: StageQp) -> Qp:
        """Return the problem in U alone, equal to `condense_blocked`, with the constant parts computed
        only once.
        """
        problem, M, n = self.problem, len(self._ends), self._Gamma.shape[2]
        nr, nc = problem.rows - problem.inputs, len(problem.C)
        free = self._Phi @ qp.x0  # (N, nx)
        D = (qp.output @ self._Gamma).reshape(-1, n)
        e = (np.einsum("kyi,ki->ky", qp.output, free) + qp.error).ravel()
        root = np.sqrt(qp.state_weight)[:, :, None] * self._weighted  # (N, w, n)
        stacked = np.concatenate([D, root.reshape(-1, n)])
        H = stacked.T @ stacked
        H[np.diag_indices(n)] += self._control_weight
        linear = qp.state_weight * free[:, list(problem.weighted)] + qp.state_linear
        g = D.T @ e + self._weighted.reshape(-1, n).T @ linear.ravel()
        g += np.add.reduceat(qp.input_linear, block_starts(self._lengths), axis=0).ravel()

        A, offset, varying = self._rows, np.zeros((M, problem.rows)), qp.varying[self._ends]
        A[:, nc:] = varying @ self._at_ends
        offset[:, :nc] = free[self._ends] @ problem.C.T
        offset[:, nc:nr] = np.einsum("kvi,ki->kv", varying, free[self._ends])
        lower, upper = (by_columns(side - offset, problem) for side in block_bounds(qp, self._lengths))
        return Qp(H, g, A.reshape(M * nr, n), lower, upper, self._penalty)

    def _nothing(self, qp: StageQp, status: Status, changes: int) -> StageSolution:
        U, y = np.zeros((len(self._ends), self.problem.inputs)), np.zeros(self._set.shape)
        X = rollout(qp, np.zeros_like(qp.input_linear))[self._ends]
        return StageSolution(status, U, X, y, changes, 0, 0, np.inf)


def _columns(hint: OnRequest, problem: StageProblem) -> Ints | None:
    made = hint()
    return None if made is None else by_columns(made, problem)
