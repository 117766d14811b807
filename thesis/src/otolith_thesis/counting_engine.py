"""Answers of the structured engine, with the iterations of the thesis's kind counted beside.

A dual active-set method that starts from the answer's own working set changes nothing. So it need not run
where the structured engine finds that the set of the step before is right, which is two steps in three: the
others are solved once more, by the dense engine from that set, and its changes are the count. That is not
part of a step's time: `CountedEngine.clock` stands still meanwhile. Checked by
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

COUNTED: Final = "counted"  # solver of a loop


class CountedEngine:
    """The structured engine, whose `changes` are those of the dense one."""

    def __init__(self, problem: StageProblem, *, tolerance: float, blocks: Lengths = ()) -> None:
        self._problem, self._blocks = problem, blocks
        self._engine = StructuredEngine(problem, tolerance=tolerance, blocks=blocks)
        self._dense = CondensedSolver(problem, DenseSolver(tolerance=tolerance), blocks=blocks)
        self.memory = self._engine.memory
        self._counting = 0.0  # [s]
        self._set: Ints = np.zeros(self.memory.lower.shape, dtype=np.int64)

    def run(self, start: Ints | None = None, hint: OnRequest | None = None) -> StageSolution:
        """Solve what lies in the memory, then count."""
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
        """Forget the last answer."""
        self._engine.reset()
        self._set = np.zeros_like(self._set)

    def clock(self) -> float:
        """CPU time of this thread [s] without that of counting."""
        return time.thread_time() - self._counting


class _Once:
    """A hint that is made once and asked for by two engines."""

    def __init__(self, hint: OnRequest) -> None:
        self._hint, self._asked = hint, False
        self._made: Ints | None = None

    def __call__(self) -> Ints | None:
        if not self._asked:
            self._made, self._asked = self._hint(), True
        return self._made


def _settled_at_once(solution: StageSolution) -> bool:
    """Return whether the set of the step before was right."""
    return solution.changes == 0 and solution.iterations == 0 and not solution.hinted


def engine_named(solver: str) -> Callable[..., StageEngine]:
    """What makes the engine of a loop: `COUNTED`, or any of the registry."""
    made: Callable[..., StageEngine] = CountedEngine if solver == COUNTED else SOLVERS[solver].load()
    return made


def clock_of(cueing: Cueing) -> Callable[[], float]:
    """The clock that measures a controller's steps [s]."""
    if isinstance(cueing, Mpc) and isinstance(cueing.engine, CountedEngine):
        return cueing.engine.clock
    return time.thread_time
