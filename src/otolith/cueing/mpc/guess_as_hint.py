"""The working set that belongs to a guess of the controls: rows at a bound along its trajectory."""

from typing import Final

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.cueing.mpc.guess import Guess
from otolith.cueing.mpc.problem import Problem
from otolith.qp.blocked import block_ends, block_starts
from otolith.qp.engines import StageMemory

CLOSE: Final = 1e-3  # relative distance from a bound that counts as being at it


class GuessAsHint:
    """Turns a guess of controls into a hint."""

    def __init__(self, guess: Guess, problem: Problem, memory: StageMemory) -> None:
        self._guess, self._problem, self._memory = guess, problem, memory
        lengths = problem.settings.lengths
        self._starts, self._ends = block_starts(lengths), block_ends(lengths)

    def reset(self) -> None:
        """Discard what the guess remembers."""
        self._guess.reset()

    def sets(self, x: Vec, wanted: Vec, plan: Mat) -> Ints | None:
        """Return a hint (1, M, rows), or None if there is no guess."""
        controls = self._guess.controls(x, wanted, plan)
        if controls is None:
            return None
        values, low, high = self._values(x, controls), self._memory.lower, self._memory.upper
        upper, lower = values >= high - _margin(high), values <= low + _margin(low)
        return np.asarray(upper, dtype=np.int64)[None] - lower

    def _values(self, x: Vec, controls: Mat) -> Mat:
        """Return the values (M, rows) that are bounded; for the circle, the distance from the centre."""
        X = self._problem.predicted(x, controls)[self._ends]
        rows = [X @ self._problem.structure.C.T]
        if self._problem.circle is not None:
            rows.append(self._problem.circle.distance(X))
        return np.hstack([*rows, controls[self._starts]])


def _margin(bound: Mat) -> Mat:
    """Return the distance from a bound that counts as being at it; zero for an infinite bound."""
    margin: Mat = CLOSE * np.abs(np.where(np.isfinite(bound), bound, 0.0))
    return margin
