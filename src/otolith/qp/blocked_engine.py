"""The engine for problems of few blocks and many rows: condensed in one compiled pass, solved with exact
penalties.

With M blocks of inputs a problem has n = M·nu variables, 54 for six axes in nine blocks, but states, outputs
and rows of every axis: a Riccati recursion over its states would cost many times as much as one factorisation
of n variables. So the states are eliminated. What inputs do to states is constant, and each input moves only
the few states of its own axis, so that one step of the horizon costs as many products as its outputs have
non-zeros. The QP is solved by `otolith.qp.bounded_dual`, and judged by `otolith.qp.blocked_certificate`,
which shares nothing with it and knows no condensed form. What cannot be certified, or seems infeasible, goes
to the exact dense engine, which proves infeasibility or solves.
"""

from dataclasses import replace
from typing import Final, NamedTuple

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.jit import jit_fused
from otolith.core.lti import condense as predict
from otolith.qp.blocked import Lengths, block_ends, hold
from otolith.qp.blocked_certificate import Judged, blocked_residual
from otolith.qp.bounded_dual import SOLVED, Rows, Work, solve
from otolith.qp.condensed import CondensedSolver
from otolith.qp.dense import DenseSolver
from otolith.qp.engines import StageMemory, empty_memory, expand
from otolith.qp.problem import Qp, Status
from otolith.qp.stage import OnRequest, StageProblem, StageSolution

LIMIT: Final = 400  # largest number of rows that enter


class Response(NamedTuple):
    """What inputs do to states: constant and sparse, since an input moves the states of its own axis only."""

    of: Ints  # (N,) block of every step
    moved: Ints  # (nu,) number of states that an input moves
    states: Ints  # (nu, s) and which
    gain: Mat  # (N, M, nu, s) change of these states at step k by the input of block m

    @classmethod
    def made(cls, Gamma: Mat, lengths: Lengths, inputs: int) -> "Response":
        """Return the response from Γ (N, nx, M·nu)."""
        N, nx, n = Gamma.shape
        full = Gamma.reshape(N, nx, n // inputs, inputs)
        moved = [np.flatnonzero(np.abs(full[:, :, :, j]).max(axis=(0, 2)) > 0.0) for j in range(inputs)]
        number = np.array([len(of) for of in moved])
        states = np.zeros((inputs, number.max()), dtype=np.int64)
        gain = np.zeros((N, n // inputs, inputs, number.max()))
        for j, of in enumerate(moved):
            states[j, : len(of)] = of
            gain[:, :, j, : len(of)] = full[:, of][..., j].transpose(0, 2, 1)
        return cls(np.repeat(np.arange(len(lengths)), lengths), number, states, gain)


@jit_fused
def by_inputs(of: Response, step: int, row: Vec, out: Vec) -> None:
    """Write how a row (nx,) of the states after `step` changes with the inputs of all blocks (n,)."""
    nu = len(of.moved)
    for m in range(of.gain.shape[1]):
        for j in range(nu):
            total = 0.0
            if m <= of.of[step]:
                for t in range(of.moved[j]):
                    total += row[of.states[j, t]] * of.gain[step, m, j, t]
            out[m * nu + j] = total


@jit_fused
def outputs_by_inputs(of: Response, where: Ints, memory: StageMemory, free: Mat, J: Mat, e: Mat) -> None:
    """Write J (N, ny, n) and errors e (N, ny) of all outputs, with the inputs zero.

    Parameters
    ----------
    where : (non-zeros, 2) output and state of the numbers in `memory.output`.
    free : (N, nx) states without inputs.
    """
    N, ny = memory.error.shape
    row = np.zeros((ny, free.shape[1]))
    for k in range(N):
        for s in range(len(where)):
            row[where[s, 0], where[s, 1]] = memory.output[k, s]
        for c in range(ny):
            total = memory.error[k, c]
            for i in range(free.shape[1]):
                total += row[c, i] * free[k, i]
            e[k, c] = total
            by_inputs(of, k, row[c], J[k, c])


@jit_fused
def varying_by_inputs(of: Response, where: Ints, ends: Ints, varying: Mat, free: Mat, R: Mat, r: Mat) -> None:
    """Write the rows R (M, nv, n) of all varying rows and their values r (M, nv) with the inputs zero."""
    row = np.zeros((R.shape[1], free.shape[1]))
    for k in range(len(ends)):
        for s in range(len(where)):
            row[where[s, 0], where[s, 1]] = varying[k, s]
        for c in range(R.shape[1]):
            total = 0.0
            for i in range(free.shape[1]):
                total += row[c, i] * free[ends[k], i]
            r[k, c] = total
            by_inputs(of, ends[k], row[c], R[k, c])


class BlockedEngine:
    """Solves blocked problems of one structure, each from the working set of the previous one.

    A hint is not asked for: the working set of the answer before is nearly always right.

    Parameters are those of `otolith.qp.engines.CondensedEngine`.
    """

    def __init__(self, problem: StageProblem, *, tolerance: float, blocks: Lengths = ()) -> None:
        lengths = blocks or (1,) * problem.horizon
        self._problem, self._blocks, self._tolerance = problem, blocks, tolerance
        self._ends = block_ends(lengths)
        self.memory = empty_memory(problem, blocks)
        self._exact = CondensedSolver(problem, DenseSolver(tolerance=tolerance, patient=False), blocks=blocks)
        self.undecided = 0  # number of problems passed to the exact engine since the last reset
        M, nu, N = len(lengths), problem.inputs, problem.horizon
        self._Phi, Gamma = predict(problem.A, problem.B, N)
        self._Gamma = Gamma @ hold(lengths, nu)
        self._response = Response.made(self._Gamma, lengths, nu)
        self._outputs, self._varying = np.argwhere(problem.output), np.argwhere(problem.varying)
        n, nc = M * nu, len(problem.C)
        self._J, self._e = np.zeros((N, len(problem.output), n)), np.zeros((N, len(problem.output)))
        self._R, self._r = np.zeros((M, problem.rows, n)), np.zeros((M, problem.rows))
        self._R[:, :nc] = problem.C @ self._Gamma[self._ends]
        self._R[:, nc + len(problem.varying) :] = np.eye(n).reshape(M, nu, n)
        self._V, self._v = np.zeros((M, len(problem.varying), n)), np.zeros((M, len(problem.varying)))
        self._control = np.outer(lengths, problem.control_weight).ravel()
        self._weight, self._H0 = np.full(self.memory.state_weight.shape, np.nan), np.zeros((n, n))
        self._work, self._judged = Work.empty(n), Judged.of(problem, lengths)
        self._set = np.zeros((M, problem.rows), dtype=np.int64)

    def reset(self) -> None:
        """Forget the working set."""
        self._set[:] = 0
        self._exact.reset()
        self.undecided = 0

    def run(self, start: Ints | None = None, hint: OnRequest | None = None) -> StageSolution:  # noqa: ARG002
        """Solve the problem in the memory; `start` (M, rows) replaces the remembered working set."""
        memory = self.memory
        numbers = (memory.start, memory.output, memory.error, memory.varying, memory.input_linear)
        if not (all(np.isfinite(part).all() for part in numbers) and (memory.lower <= memory.upper).all()):
            return self._nothing(Status.INVALID, 0)
        self._weigh()
        qp, used = self._condense()
        state = (self._set if start is None else start).ravel()[used]
        y, z = np.zeros(len(used)), np.zeros(len(qp.g))
        rows = Rows(qp.A, qp.lower, qp.upper, qp.penalties)
        outcome, changes = solve(qp.H, qp.g, rows, self._work, state, y, z, LIMIT)
        every = np.zeros(self._set.size)
        every[used] = y
        U, multipliers = z.reshape(len(self._ends), -1), every.reshape(self._set.shape)
        residual = blocked_residual(self._judged, memory, U, multipliers) if outcome == SOLVED else np.inf
        if not residual < self._tolerance:
            return self._decide(changes)
        self._set[:] = 0
        self._set.ravel()[used] = state
        X = self._Phi[self._ends] @ memory.start + self._Gamma[self._ends] @ z
        return StageSolution(Status.OPTIMAL, U, X, multipliers, changes, 1, 0, residual)

    def _weigh(self) -> None:
        """Update the part of the Hessian that is due to weights on states, where these have changed."""
        weight = self.memory.state_weight
        if np.array_equal(weight, self._weight):
            return
        self._weight[:] = weight
        weighted = self._Gamma[:, list(self._problem.weighted)]
        root = (np.sqrt(weight)[:, :, None] * weighted).reshape(-1, len(self._H0))
        self._H0[:] = root.T @ root
        self._H0[np.diag_indices(len(self._H0))] += self._control
        of_states = np.einsum("kw,kwn,kwi->ni", weight, weighted, self._Phi[:, list(self._problem.weighted)])
        self._pull = np.ascontiguousarray(of_states)  # (n, nx): gradient by the inputs of states without any

    def _condense(self) -> tuple[Qp, Ints]:
        """Return the problem in the inputs alone, and which of all rows (M·rows,) have a bound."""
        memory, problem, n = self.memory, self._problem, len(self._H0)
        nc, nv = len(problem.C), len(problem.varying)
        free = (self._Phi.reshape(-1, problem.states) @ memory.start).reshape(-1, problem.states)
        outputs_by_inputs(self._response, self._outputs, memory, free, self._J, self._e)
        varying_by_inputs(self._response, self._varying, self._ends, memory.varying, free, self._V, self._v)
        self._R[:, nc : nc + nv], self._r[:, nc : nc + nv] = self._V, self._v
        self._r[:, :nc] = free[self._ends] @ problem.C.T
        J = self._J.reshape(-1, n)
        H = J.T @ J + self._H0
        g = J.T @ self._e.ravel() + self._pull @ memory.start + memory.input_linear.ravel()
        if memory.state_linear.any():
            weighted = self._Gamma[:, list(problem.weighted)]
            g += memory.state_linear.ravel() @ weighted.reshape(-1, n)
        lower, upper = (memory.lower - self._r).ravel(), (memory.upper - self._r).ravel()
        used = np.flatnonzero((lower > -np.inf) | (upper < np.inf))
        penalty = problem.penalty[self._ends].ravel()[used]
        return Qp(H, g, self._R.reshape(-1, n)[used], lower[used], upper[used], penalty), used

    def _decide(self, changes: int) -> StageSolution:
        """Let the exact engine decide a problem that could not be certified."""
        self.undecided += 1
        nothing = np.zeros(self._set.shape, dtype=np.int64)
        exact = self._exact.solve(expand(self._problem, self.memory, self._blocks), nothing)
        self._set[:] = exact.working_set
        return replace(exact, changes=changes + exact.changes)

    def _nothing(self, status: Status, changes: int) -> StageSolution:
        M, nu = len(self._ends), self._problem.inputs
        X, y = np.zeros((M, self._problem.states)), np.zeros(self._set.shape)
        return StageSolution(status, np.zeros((M, nu)), X, y, changes, 0, 0, np.inf)
