"""A stage problem solved through its condensed form by a dense engine, warm-started by stage.

It gives the thesis's online solver in kind: condensing, then a hot-started dual active-set method
that counts its working-set changes.
"""

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.lti import condense as predict
from otolith.qp.dense import DenseSolver
from otolith.qp.problem import Qp, Status
from otolith.qp.stage import StageProblem, StageQp, StageSolution, by_columns, by_rows, rollout


class CondensedSolver:
    """Solve problems of one structure, each from the working set of the one before."""

    def __init__(self, problem: StageProblem, dense: DenseSolver | None = None) -> None:
        self.problem, self._dense = problem, dense or DenseSolver()
        N, nu = problem.horizon, problem.inputs
        self._Phi, self._Gamma = predict(problem.A, problem.B, N)
        constant = problem.C @ self._Gamma  # (N, nc, N·nu): only the varying rows change
        self._rows = np.concatenate([constant, np.zeros((N, len(problem.varying), N * nu))], axis=1)
        self._weighted = np.ascontiguousarray(self._Gamma[:, list(problem.weighted)])
        nr = problem.rows - nu
        self._penalty = np.concatenate([np.tile(problem.penalty[nr:], N), np.tile(problem.penalty[:nr], N)])
        self._set: Ints = np.zeros((N, problem.rows), dtype=np.int64)

    def reset(self) -> None:
        """Forget the working set."""
        self._set = np.zeros_like(self._set)

    def solve(self, qp: StageQp, start: Ints | None = None) -> StageSolution:
        """Solve `qp` from the working set `start` (N, rows), by default the previous answer's."""
        problem = self.problem
        N, nu, nx = problem.horizon, problem.inputs, problem.states
        if not qp.well_posed():
            return _nothing(qp, Status.INVALID, 0)
        dense = self.condense(qp)
        start = self._set if start is None else start
        found = self._dense.solve(dense, by_columns(start, problem))
        if found.status is not Status.OPTIMAL:
            self.reset()
            return _nothing(qp, found.status, found.changes)
        U, y = found.z.reshape(N, nu), by_rows(found.y, problem)
        self._set = np.sign(y).astype(np.int64)
        X = (self._Phi @ qp.x0 + self._Gamma @ found.z).reshape(N, nx)
        return StageSolution(found.status, U, X, y, found.changes, 0, 0, found.residual)

    def condense(self, qp: StageQp) -> Qp:
        """The problem in U alone, as `otolith.qp.stage.condense`, with what is constant computed once."""
        problem = self.problem
        N, n = problem.horizon, problem.horizon * problem.inputs
        nr, nc = problem.rows - problem.inputs, len(problem.C)
        free = self._Phi @ qp.x0  # (N, nx)
        D = (qp.output @ self._Gamma).reshape(-1, n)
        e = (np.einsum("kyi,ki->ky", qp.output, free) + qp.error).ravel()
        root = np.sqrt(qp.state_weight)[:, :, None] * self._weighted  # (N, w, n)
        stacked = np.concatenate([D, root.reshape(-1, n)])
        H = stacked.T @ stacked
        H[np.diag_indices(n)] += np.tile(problem.control_weight, N)
        linear = qp.state_weight * free[:, list(problem.weighted)] + qp.state_linear
        g = D.T @ e + self._weighted.reshape(-1, n).T @ linear.ravel() + qp.input_linear.ravel()

        A, offset = self._rows, np.empty((N, nr))
        A[:, nc:] = qp.varying @ self._Gamma
        offset[:, :nc] = free @ problem.C.T
        offset[:, nc:] = np.einsum("kvi,ki->kv", qp.varying, free)
        lower, upper = _by_columns(qp.lower, offset), _by_columns(qp.upper, offset)
        return Qp(H, g, A.reshape(N * nr, n), lower, upper, self._penalty)


def _by_columns(bound: Mat, offset: Mat) -> Vec:
    nr = offset.shape[1]
    return np.concatenate([bound[:, nr:].ravel(), (bound[:, :nr] - offset).ravel()])


def _nothing(qp: StageQp, status: Status, changes: int) -> StageSolution:
    problem = qp.problem
    U, y = np.zeros((problem.horizon, problem.inputs)), np.zeros((problem.horizon, problem.rows))
    return StageSolution(status, U, rollout(qp, U), y, changes, 0, 0, np.inf)
