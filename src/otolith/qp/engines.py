"""Engines for real time: a problem lies in memory, its owner changes what has changed, `run` solves it.

The memory holds matrices by their structural non-zeros, row by row, so that the structured engine
reads it in place; the condensed engine expands it first.
"""

from dataclasses import replace
from typing import NamedTuple, Protocol

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.qp.condensed import CondensedSolver
from otolith.qp.dense import DenseSolver
from otolith.qp.problem import Status
from otolith.qp.stage import StageProblem, StageQp, StageSolution
from otolith.qp.structured import StructuredSettings, StructuredSolver


class StageMemory(NamedTuple):
    """One stage QP as an engine holds it; symbols as in `otolith.qp.stage`."""

    start: Vec  # (nx,) x_0
    output: Mat  # (N, non-zeros of D_k)
    error: Mat  # (N, ny)
    state_weight: Mat  # (N, weighted)
    state_linear: Mat  # (N, weighted)
    input_linear: Mat  # (N, nu)
    varying: Mat  # (N, non-zeros of V_k)
    lower: Mat  # (N, rows)
    upper: Mat  # (N, rows)


class StageEngine(Protocol):
    """Solves what lies in its memory, from the working set of the answer before."""

    memory: StageMemory

    def run(self, start: Ints | None = None) -> StageSolution:
        """Solve; `start` (N, rows) replaces the remembered working set."""

    def reset(self) -> None:
        """Forget the last answer."""


def expand(problem: StageProblem, memory: StageMemory) -> StageQp:
    """The problem in memory as a value of its own."""
    N = problem.horizon
    output, varying = np.zeros((N, *problem.output.shape)), np.zeros((N, *problem.varying.shape))
    output[:, problem.output], varying[:, problem.varying] = memory.output, memory.varying
    same = {name: getattr(memory, name).copy() for name in _SAME}
    return StageQp(problem=problem, x0=memory.start.copy(), output=output, varying=varying, **same)


_SAME = ("error", "state_weight", "state_linear", "input_linear", "lower", "upper")


class StructuredEngine:
    """The stage-structured engine: compiled for the structure, the fast path.

    The few problems that it gives up on, most of them at the edge of infeasibility, are decided by the
    condensed engine, which is exact: either solved and certified, or reported infeasible.
    """

    def __init__(self, problem: StageProblem, *, tolerance: float, guesses: bool = True) -> None:
        self._exact = CondensedSolver(problem, DenseSolver(tolerance=tolerance))
        self.undecided = 0  # problems handed on since the last reset
        settings = StructuredSettings(tolerance=tolerance)
        if not guesses:  # every problem cold, by the interior point
            settings = replace(settings, exchange_limit=0)
        self._solver = StructuredSolver(problem, settings)
        part, rows = self._solver.part, self._solver.rows
        self.memory = StageMemory(
            start=part("START"),
            output=part("OUTPUT"),
            error=part("ERROR"),
            state_weight=part("STATE_WEIGHT"),
            state_linear=part("STATE_LINEAR"),
            input_linear=part("INPUT_LINEAR"),
            varying=part("VARYING"),
            lower=rows("LOWER"),
            upper=rows("UPPER"),
        )

    def run(self, start: Ints | None = None) -> StageSolution:
        """Solve what lies in the memory with one compiled call."""
        if start is not None:
            self._solver.rows("SET")[:] = start
        self._solver.kernels.solve(self._solver.vector)
        solution = self._solver.solution()
        return self._decide(solution) if solution.status is Status.LIMIT else solution

    def reset(self) -> None:
        """Forget working set, multipliers and plan."""
        self._solver.reset()
        self.undecided = 0

    def _decide(self, given_up: StageSolution) -> StageSolution:
        self.undecided += 1
        nothing = np.zeros((self._solver.problem.horizon, self._solver.problem.rows), dtype=np.int64)
        exact = self._exact.solve(expand(self._solver.problem, self.memory), nothing)
        if exact.status is Status.OPTIMAL:  # the next problem starts from this answer
            self._solver.rows("SET")[:] = exact.working_set
            self._solver.rows("MULTIPLIER")[:] = exact.y
            self._solver.part("PLAN")[:] = exact.U
        return replace(exact, changes=given_up.changes + exact.changes)


class CondensedEngine:
    """The condensed engine: `daqp`, warm-started, counts its working-set changes."""

    def __init__(self, problem: StageProblem, *, tolerance: float) -> None:
        self._solver = CondensedSolver(problem, DenseSolver(tolerance=tolerance))
        N, weighted = problem.horizon, len(problem.weighted)
        self.memory = StageMemory(
            start=np.zeros(problem.states),
            output=np.zeros((N, np.count_nonzero(problem.output))),
            error=np.zeros((N, len(problem.output))),
            state_weight=np.zeros((N, weighted)),
            state_linear=np.zeros((N, weighted)),
            input_linear=np.zeros((N, problem.inputs)),
            varying=np.zeros((N, np.count_nonzero(problem.varying))),
            lower=np.zeros((N, problem.rows)),
            upper=np.zeros((N, problem.rows)),
        )

    def run(self, start: Ints | None = None) -> StageSolution:
        """Expand, condense and solve what lies in the memory."""
        return self._solver.solve(expand(self._solver.problem, self.memory), start)

    def reset(self) -> None:
        """Forget the working set."""
        self._solver.reset()
