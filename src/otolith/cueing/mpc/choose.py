"""Chooses from several hints the one with the fewest violated optimality conditions."""

from functools import cached_property

import numpy as np

from otolith.core.arrays import Ints
from otolith.qp.blocked import Lengths
from otolith.qp.candidate import violations
from otolith.qp.condensed import CondensedSolver
from otolith.qp.engines import StageMemory, expand
from otolith.qp.stage import StageProblem, by_columns


class Chooser:
    """Judges sets on the condensed problem, which is slow compared with a solve."""

    def __init__(self, problem: StageProblem, blocks: Lengths) -> None:
        self._problem, self._blocks = problem, blocks

    @cached_property
    def _solver(self) -> CondensedSolver:
        """Return what condenses; few controllers have several sets to choose from."""
        return CondensedSolver(self._problem, blocks=self._blocks)

    def best(self, memory: StageMemory, sets: Ints) -> Ints:
        """Return the set of `sets` (K, M, rows) that violates the fewest conditions; the first of equals."""
        if len(sets) == 1:
            only: Ints = sets[0]
            return only
        qp = self._solver.condense(expand(self._problem, memory, self._blocks))
        counts = [violations(qp, by_columns(one, self._problem)) for one in sets]
        chosen: Ints = sets[int(np.argmin(counts))]
        return chosen
