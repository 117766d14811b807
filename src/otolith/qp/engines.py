"""Engines for real time: the problem lies in memory, its owner updates what has changed, and `run` solves it.

The memory stores matrices as their structural non-zeros, row by row. The structured engine reads it in place;
the condensed engine expands it first.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Final, NamedTuple, Protocol

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.methods import INTEGER, NO_METHOD, VECTOR, Method, Role, address_of
from otolith.qp.blocked import Lengths, block_ends
from otolith.qp.condensed import CondensedSolver, Dense
from otolith.qp.dense import DenseSolver
from otolith.qp.problem import Status
from otolith.qp.stage import OnRequest, StageProblem, StageQp, StageSolution
from otolith.qp.structured import StructuredSettings, StructuredSolver
from otolith.qp.structured.generate import INFO


class StageMemory(NamedTuple):
    """One stage QP as an engine stores it; symbols as in `otolith.qp.stage`, with M blocks (M = N without
    blocks).
    """

    start: Vec  # (nx,) x_0
    output: Mat  # (N, non-zeros of D_k)
    error: Mat  # (N, ny)
    state_weight: Mat  # (N, weighted)
    state_linear: Mat  # (N, weighted)
    input_linear: Mat  # (M, nu), summed over the steps of a block
    varying: Mat  # (M, non-zeros of V_k) at the ends of blocks
    lower: Mat  # (M, rows)
    upper: Mat  # (M, rows)


class Entrance(NamedTuple):
    """How kernels solve the problem in an engine's memory, and where they find the answer.

    Where neither `solve` nor `own` is given, only `StageEngine.run` can solve it.
    """

    solve: int  # address of the structured engine's kernel `solve(workspace)`, or 0
    own: Method  # kernel of another engine with data of its own, or zeros
    workspace: Vec
    offered: Vec  # (1,) what is known about a hint, an index of `otolith.qp.structured.generate.OFFERS`
    info: Vec  # as `otolith.qp.structured.generate.INFO`; its status is an index of `CODES`
    U: Mat  # (M, nu)
    y: Mat  # (M, rows) multipliers; empty if the engine offers none


NO_ENTRANCE: Final = Entrance(
    0, NO_METHOD, np.zeros(0), np.zeros(1), np.zeros(len(INFO)), np.zeros((0, 0)), np.zeros((0, 0))
)
# solve(data, info): an engine's kernel writes `INFO` and returns the status, an index of `CODES`
SOLVE: Final = Role(INTEGER, (VECTOR,))


class StageEngine(Protocol):
    """An engine that solves the problem in its memory, starting from the working set of its previous answer.

    Engines are built by calls (problem, *, tolerance, blocks), see `otolith.qp.blocked`. With blocks, the
    stages of an answer are the blocks.
    """

    memory: StageMemory

    def run(self, start: Ints | None = None, hint: OnRequest | None = None) -> StageSolution:
        """Solve the problem in the memory. The arguments affect the effort, never the minimiser.

        Parameters
        ----------
        start : (M, rows) as `StageSolution.working_set`; replaces the remembered working set.
        hint : makes a second guess (M, rows). It is called only when the first guess does not settle at once.
            Then the guess with which fewer optimality conditions fail is used, `StageSolution.hinted` says
            which one, and `changes` counts from there.
        """

    def reset(self) -> None:
        """Forget the last answer."""


def empty_memory(problem: StageProblem, blocks: Lengths = ()) -> StageMemory:
    """Allocate the memory of an engine that has no workspace of its own."""
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
    """Expand the problem in memory to a `StageQp`; steps inside a block get no bounds on states."""
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
    """The stage-structured engine: compiled for the problem's structure, and the fastest.

    It gives up on a few problems, most of them at the edge of infeasibility. The condensed engine, which is
    exact, then decides them: it solves and certifies them, or reports them infeasible.
    """

    def __init__(
        self, problem: StageProblem, *, tolerance: float, blocks: Lengths = (), guesses: bool = True
    ) -> None:
        self._exact = CondensedSolver(problem, DenseSolver(tolerance=tolerance, patient=False), blocks=blocks)
        self.undecided = 0  # number of problems passed to the condensed engine since the last reset
        settings = StructuredSettings(tolerance=tolerance)
        if not guesses:  # then every problem is solved without a warm start, by the interior point
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

    @property
    def entrance(self) -> Entrance:
        """The way in for kernels, which ask for `offer` and `exact` where they need them."""
        solver = self._solver
        code = address_of(solver.kernels.solve, VECTOR)
        offered, info, plan = (solver.part(name) for name in ("OFFERED", "INFO", "PLAN"))
        return Entrance(code, NO_METHOD, solver.vector, offered, info, plan, np.zeros((0, 0)))

    def run(self, start: Ints | None = None, hint: OnRequest | None = None) -> StageSolution:
        """Solve the problem in the memory with one compiled call, or two when a hint is requested."""
        solution = self._solver.run(start, hint)
        return self._decide(solution) if solution.status is Status.LIMIT else solution

    def offer(self, hint: Ints | None) -> None:
        """Give the hint (M, rows) that the kernel asked for, or none; it is then called again."""
        self._solver.offer(hint)

    def exact(self) -> StageSolution:
        """Decide the problem that the kernel has given up."""
        return self._decide(self._solver.solution())

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
    """The condensed engine: `daqp`, warm-started, which counts its working-set changes.

    `dense` makes the solver of the condensed problems from the tolerance.
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
        """Expand, condense and solve the problem in the memory."""
        return self._solver.solve(expand(self._solver.problem, self.memory, self._blocks), start, hint)

    def reset(self) -> None:
        """Forget the working set."""
        self._solver.reset()
