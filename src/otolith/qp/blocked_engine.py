"""The engine for problems of few blocks and many rows: condensed in one compiled pass, solved with exact
penalties.

With M blocks of inputs a problem has n = M·nu variables, 54 for six axes in nine blocks, but states, outputs
and rows of every axis: a Riccati recursion over its states would cost many times as much as one factorisation
of n variables. So the states are eliminated (`otolith.qp.blocked_condense`). The QP is solved by
`otolith.qp.bounded_dual`, and judged by `otolith.qp.blocked_certificate`, which shares nothing with it and
knows no condensed form. What cannot be certified, or seems infeasible, goes to the exact dense engine, which
proves infeasibility or solves.
"""

from dataclasses import replace
from typing import Any, Final, NamedTuple

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.copying import copy_to
from otolith.core.jit import kernel
from otolith.core.methods import Bound
from otolith.qp.blocked import Lengths
from otolith.qp.blocked_certificate import Judged, blocked_residual
from otolith.qp.blocked_condense import Condensed, Dynamics, Layout, condense, empty_condensed, layout_of
from otolith.qp.bounded_dual import SOLVED, solve
from otolith.qp.condensed import CondensedSolver
from otolith.qp.dense import DenseSolver
from otolith.qp.engines import NO_ENTRANCE, SOLVE, Entrance, StageMemory, empty_memory, expand
from otolith.qp.problem import Status
from otolith.qp.stage import OnRequest, StageProblem, StageSolution
from otolith.qp.structured.generate import CODES, INFO
from otolith.qp.working_set import Work

FEW: Final = 400  # largest number of rows that enter from the working set before, mostly none …
LIMIT: Final = 3000  # … and from none: 2,000 do where nearly all are at their limits

_OPTIMAL, _LIMIT, _INVALID = (CODES.index(name) for name in ("OPTIMAL", "LIMIT", "INVALID"))
_CODE, _RESIDUAL, _COUNT = (INFO.index(name) for name in ("STATUS", "RESIDUAL", "CHANGES"))


class _Engine(NamedTuple):
    """Everything that the kernel reads and remembers."""

    memory: StageMemory
    dynamics: Dynamics
    layout: Layout
    condensed: Condensed
    judged: Judged
    work: Work
    tolerance: float
    held: Ints  # (M·rows,) working set of the last answer
    state: Ints  # (M·rows,) the one at work
    z: Vec  # (n,)
    U: Mat  # (M, nu)
    y: Mat  # (M, rows)


@kernel
def _well_posed(memory: StageMemory) -> bool:
    """Return whether all numbers are finite, and no lower bound is above its upper one; False for a NaN."""
    wrong = 0
    for i in range(len(memory.start)):
        wrong += not abs(memory.start[i]) < np.inf
    for numbers in (memory.output, memory.error, memory.varying, memory.input_linear):
        for k in range(numbers.shape[0]):
            for i in range(numbers.shape[1]):
                wrong += not abs(numbers[k, i]) < np.inf
    for k in range(memory.lower.shape[0]):
        for i in range(memory.lower.shape[1]):
            wrong += not memory.lower[k, i] <= memory.upper[k, i]
    return wrong == 0


@kernel
def _attempt(of: Any, info: Vec, limit: int) -> tuple[int, int]:
    """Solve the condensed problem from the working set at work and judge it; return code and changes."""
    c, m, nu, rows = of.condensed, of.U.shape[0], of.U.shape[1], of.y.shape[1]
    y = of.y.reshape(m * rows)
    outcome, changes = solve(c.H, c.g, c.rows, of.work, of.state, y, of.z, limit)
    for i in range(m * nu):
        of.U[i // nu, i % nu] = of.z[i]
    info[_RESIDUAL] = np.inf
    if outcome == SOLVED:
        info[_RESIDUAL] = blocked_residual(of.judged, of.memory, of.U, of.y)
    return _OPTIMAL if info[_RESIDUAL] < of.tolerance else _LIMIT, changes


@kernel
def _run(of: Any, info: Vec) -> int:
    """Solve the problem in memory and judge the answer; write and return what `SOLVE` says."""
    info[:] = 0.0
    info[_CODE], info[_RESIDUAL] = _INVALID, np.inf
    if not _well_posed(of.memory):
        return _INVALID
    condense(of.dynamics, of.layout, of.memory, of.condensed)
    copy_to(of.state, of.held)
    code, changes = _attempt(of, info, FEW)
    if code != _OPTIMAL:  # from another problem's working set the search may go round in circles
        of.state[:] = 0
        code, more = _attempt(of, info, LIMIT)
        changes += more
    if code == _OPTIMAL:
        copy_to(of.held, of.state)
    info[_CODE], info[_COUNT] = code, changes
    return code


class BlockedEngine:
    """Solves blocked problems of one structure, each from the working set of the previous one.

    A hint is not asked for: the working set of the answer before is nearly always right.

    Parameters are those of `otolith.qp.engines.CondensedEngine`.
    """

    def __init__(self, problem: StageProblem, *, tolerance: float, blocks: Lengths = ()) -> None:
        lengths = blocks or (1,) * problem.horizon
        self._problem, self._blocks = problem, blocks
        self.memory = empty_memory(problem, blocks)
        self._exact = CondensedSolver(problem, DenseSolver(tolerance=tolerance, patient=False), blocks=blocks)
        self.undecided = 0  # number of problems passed to the exact engine since the last reset
        M, nu, rows = len(lengths), problem.inputs, problem.rows
        dynamics = Dynamics.of(problem, lengths)
        condensed = empty_condensed(problem, lengths, dynamics)
        self._at = _Engine(
            memory=self.memory,
            dynamics=dynamics,
            layout=layout_of(problem, lengths, dynamics),
            condensed=condensed,
            judged=Judged.of(problem, lengths),
            work=Work.of(condensed.rows),
            tolerance=tolerance,
            held=np.zeros(M * rows, dtype=np.int64),
            state=np.zeros(M * rows, dtype=np.int64),
            z=np.zeros(M * nu),
            U=np.zeros((M, nu)),
            y=np.zeros((M, rows)),
        )
        self._info = np.zeros(len(INFO))
        self._method: Bound = SOLVE.bind(_run, self._at)

    @property
    def entrance(self) -> Entrance:
        """The way in for kernels, which ask for `exact` where they need it."""
        at = self._at
        return NO_ENTRANCE._replace(own=self._method.method, info=self._info, U=at.U, y=at.y)

    def reset(self) -> None:
        """Forget the working set."""
        self._at.held[:] = 0
        self._exact.reset()
        self.undecided = 0

    def run(self, start: Ints | None = None, hint: OnRequest | None = None) -> StageSolution:  # noqa: ARG002
        """Solve the problem in the memory; `start` (M, rows) replaces the remembered working set."""
        at, info = self._at, self._info
        if start is not None:
            at.held[:] = start.ravel()
        code = _run(self._method.held, info)
        if code == _LIMIT:
            return self.exact()
        changes, residual = int(info[_COUNT]), float(info[_RESIDUAL])
        if code == _INVALID:
            X, y = np.zeros((len(at.U), self._problem.states)), np.zeros_like(at.y)
            return StageSolution(Status.INVALID, np.zeros_like(at.U), X, y, 0, 0, 0, np.inf)
        return StageSolution(
            Status.OPTIMAL, at.U.copy(), self._ends(at.U), at.y.copy(), changes, 1, 0, residual
        )

    def exact(self) -> StageSolution:
        """Let the exact engine decide the problem that could not be certified."""
        self.undecided += 1
        at = self._at
        nothing = np.zeros(at.y.shape, dtype=np.int64)
        exact = self._exact.solve(expand(self._problem, self.memory, self._blocks), nothing)
        at.held[:] = exact.working_set.ravel()
        at.U[:], at.y[:] = exact.U, exact.y
        return replace(exact, changes=int(self._info[_COUNT]) + exact.changes)

    def _ends(self, U: Mat) -> Mat:
        """Return the states (M, nx) at the ends of the blocks."""
        of = self._at.condensed
        X: Mat = of.free[1:] + self._at.dynamics.dense(self._problem.states)[1:] @ U.ravel()
        return X
