"""Engines for real time: a problem lies in memory, its owner changes what has changed, `run` solves it.

The memory holds matrices by their structural non-zeros, row by row, so that the structured engine
reads it in place; the condensed engine expands it first.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple, Protocol

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.qp.blocked import Lengths, block_ends
from otolith.qp.condensed import CondensedSolver, Dense
from otolith.qp.dense import DenseSolver
from otolith.qp.problem import Status
from otolith.qp.stage import OnRequest, StageProblem, StageQp, StageSolution
from otolith.qp.structured import StructuredSettings, StructuredSolver


class StageMemory(NamedTuple):
    """One stage QP as an engine holds it; symbols as in `otolith.qp.stage`, M blocks (M = N without)."""

    start: Vec  # (nx,) x_0
    output: Mat  # (N, non-zeros of D_k)
    error: Mat  # (N, ny)
    state_weight: Mat  # (N, weighted)
    state_linear: Mat  # (N, weighted)
    input_linear: Mat  # (M, nu), the sum over a block's steps
    varying: Mat  # (M, non-zeros of V_k) at the blocks' ends
    lower: Mat  # (M, rows)
    upper: Mat  # (M, rows)


class StageEngine(Protocol):
    """Solves what lies in its memory, from the working set of the answer before.

    Engines are built by calls (problem, *, tolerance, blocks), see `otolith.qp.blocked`; with blocks, the
    answers' stages are the blocks.
    """

    memory: StageMemory

    def run(self, start: Ints | None = None, hint: OnRequest | None = None) -> StageSolution:
        """Solve what lies in the memory; neither argument changes the minimiser.

        Parameters
        ----------
        start : (M, rows) as `StageSolution.working_set`; replaces the remembered working set.
        hint : makes a second guess (M, rows). It is called only when the first does not settle at once; then
            the one with which fewer optimality conditions fail is taken, `StageSolution.hinted` says which,
            and `changes` counts from there.
        """

    def reset(self) -> None:
        """Forget the last answer."""


def empty_memory(problem: StageProblem, blocks: Lengths = ()) -> StageMemory:
    """Memory of an engine that has no workspace of its own."""
    N, M, weighted = problem.horizon, len(blocks) or problem.horizon, len(problem.weighted)
    return StageMemory(
        start=np.zeros(problem.states),
        output=np.zeros((N, np.count_nonzero(problem.output))),
        error=np.zeros((N, len(problem.output))),
        state_weight=np.zeros((N, weighted)),
        state_linear=np.zeros((N, weighted)),
        input_linear=np.zeros((M, problem.inputs)),
        varying=np.zeros((M, np.count_nonzero(problem.varying))),
        lower=np.zeros((M, problem.rows)),
        upper=np.zeros((M, problem.rows)),
    )


def expand(problem: StageProblem, memory: StageMemory, blocks: Lengths = ()) -> StageQp:
    """The problem in memory as a value of its own; steps within a block have no bounds on states."""
    N, nr, lengths = problem.horizon, problem.rows - problem.inputs, blocks or (1,) * problem.horizon
    output, varying = np.zeros((N, *problem.output.shape)), np.zeros((N, *problem.varying.shape))
    output[:, problem.output] = memory.output
    varying[:, problem.varying] = np.repeat(memory.varying, lengths, axis=0)
    lower, upper = (np.repeat(side, lengths, axis=0) for side in (memory.lower, memory.upper))
    within = np.delete(np.arange(N), block_ends(lengths))
    lower[within, :nr], upper[within, :nr] = -np.inf, np.inf
    return StageQp(
        problem=problem,
        x0=memory.start.copy(),
        output=output,
        error=memory.error.copy(),
        state_weight=memory.state_weight.copy(),
        state_linear=memory.state_linear.copy(),
        input_linear=np.repeat(memory.input_linear / np.reshape(lengths, (-1, 1)), lengths, axis=0),
        varying=varying,
        lower=lower,
        upper=upper,
    )


class StructuredEngine:
    """The stage-structured engine: compiled for the structure, the fast path.

    The few problems that it gives up on, most of them at the edge of infeasibility, are decided by the
    condensed engine, which is exact: either solved and certified, or reported infeasible.
    """

    def __init__(
        self, problem: StageProblem, *, tolerance: float, blocks: Lengths = (), guesses: bool = True
    ) -> None:
        self._exact = CondensedSolver(problem, DenseSolver(tolerance=tolerance, patient=False), blocks=blocks)
        self.undecided = 0  # problems handed on since the last reset
        settings = StructuredSettings(tolerance=tolerance)
        if not guesses:  # every problem cold, by the interior point
            settings = replace(settings, exchange_limit=0)
        self._blocks = blocks
        self._solver = StructuredSolver(problem, settings, blocks=blocks)
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

    def run(self, start: Ints | None = None, hint: OnRequest | None = None) -> StageSolution:
        """Solve what lies in the memory with one compiled call, two where a hint is asked for."""
        solution = self._solver.run(start, hint)
        return self._decide(solution) if solution.status is Status.LIMIT else solution

    def reset(self) -> None:
        """Forget working set, multipliers and plan."""
        self._solver.reset()
        self.undecided = 0

    def _decide(self, given_up: StageSolution) -> StageSolution:
        self.undecided += 1
        nothing = np.zeros(self.memory.lower.shape, dtype=np.int64)
        exact = self._exact.solve(expand(self._solver.problem, self.memory, self._blocks), nothing)
        if exact.status is Status.OPTIMAL:  # the next problem starts from this answer
            self._solver.rows("SET")[:] = exact.working_set
            self._solver.rows("MULTIPLIER")[:] = exact.y
            self._solver.part("PLAN")[:] = exact.U
        return replace(exact, changes=given_up.changes + exact.changes)


class CondensedEngine:
    """The condensed engine: `daqp`, warm-started, counts its working-set changes.

    `dense` makes another engine for the condensed problems, from the tolerance.
    """

    def __init__(
        self,
        problem: StageProblem,
        *,
        tolerance: float,
        blocks: Lengths = (),
        dense: Callable[..., Dense] = DenseSolver,
    ) -> None:
        self._solver = CondensedSolver(problem, dense(tolerance=tolerance), blocks=blocks)
        self._blocks = blocks
        self.memory = empty_memory(problem, blocks)

    def run(self, start: Ints | None = None, hint: OnRequest | None = None) -> StageSolution:
        """Expand, condense and solve what lies in the memory."""
        return self._solver.solve(expand(self._solver.problem, self.memory, self._blocks), start, hint)

    def reset(self) -> None:
        """Forget the working set."""
        self._solver.reset()
