"""The structured engine, which also counts iterations as the thesis does.

A dual active-set method that starts from the answer's own working set changes nothing. So it need not run if
the structured engine finds that the previous step's set is still right, which holds for two steps in three.
The other steps are solved again by the dense engine, from the previous step's set, and its changes are
counted. This does not count as step time: `CountedEngine.clock` stands still meanwhile. Checked by
test_the_count_is_that_of_the_dense_engine.
"""

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np

from otolith.core.arrays import Ints
from otolith.cueing.mpc.controller import Mpc
from otolith.interfaces import Cueing
from otolith.qp import Status
from otolith.qp.blocked import Lengths
from otolith.qp.condensed import CondensedSolver
from otolith.qp.dense import DenseSolver
from otolith.qp.engines import StageEngine, StructuredEngine, expand
from otolith.qp.stage import OnRequest, StageProblem, StageSolution
from otolith.registry import SOLVERS

COUNTED: Final = "counted"  # name of this engine as the solver of a loop


class CountedEngine:
    """The structured engine, whose `changes` are those of the dense engine."""

    def __init__(self, problem: StageProblem, *, tolerance: float, blocks: Lengths = ()) -> None:
        self._problem, self._blocks = problem, blocks
        self._engine = StructuredEngine(problem, tolerance=tolerance, blocks=blocks)
        self._dense = CondensedSolver(problem, DenseSolver(tolerance=tolerance), blocks=blocks)
        self.memory = self._engine.memory
        self._counting = 0.0  # [s]
        self._set: Ints = np.zeros(self.memory.lower.shape, dtype=np.int64)

    def run(self, start: Ints | None = None, hint: OnRequest | None = None) -> StageSolution:
        """Solve the problem in the memory, then count."""
        before = self._set if start is None else start
        asked = None if hint is None else _Once(hint)
        solution = self._engine.run(start, asked)
        self._set = solution.working_set
        if solution.status is not Status.OPTIMAL or _settled_at_once(solution):
            return solution
        began = time.thread_time()
        counted = self._dense.solve(expand(self._problem, self.memory, self._blocks), before, asked)
        self._counting += time.thread_time() - began
        return replace(solution, changes=counted.changes, hinted=counted.hinted)

    def reset(self) -> None:
        """Discard the last answer."""
        self._engine.reset()
        self._set = np.zeros_like(self._set)

    def clock(self) -> float:
        """Return the CPU time of this thread [s] without the time for counting."""
        return time.thread_time() - self._counting


class _Once:
    """A hint that is computed once for two engines."""

    def __init__(self, hint: OnRequest) -> None:
        self._hint, self._asked = hint, False
        self._made: Ints | None = None

    def __call__(self) -> Ints | None:
        if not self._asked:
            self._made, self._asked = self._hint(), True
        return self._made


def _settled_at_once(solution: StageSolution) -> bool:
    """Return whether the working set of the previous step was right."""
    return solution.changes == 0 and solution.iterations == 0 and not solution.hinted


def engine_named(solver: str) -> Callable[..., StageEngine]:
    """Return the factory of a loop's engine: `COUNTED`, or an engine of the registry."""
    made: Callable[..., StageEngine] = CountedEngine if solver == COUNTED else SOLVERS[solver].load()
    return made


def clock_of(cueing: Cueing) -> Callable[[], float]:
    """Return the clock [s] that measures a controller's steps."""
    if isinstance(cueing, Mpc) and isinstance(cueing.engine, CountedEngine):
        return cueing.engine.clock
    return time.thread_time
