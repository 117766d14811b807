"""Dense engine: daqp, a dual active-set method (Arnström, Bemporad & Axehill, 2022).

Warm-started with a working set and counting its changes, it stands for the thesis's hot-started
qpOASES in all studies of iterations.
"""

from dataclasses import dataclass

import daqp
import numpy as np

from otolith.core.arrays import Ints
from otolith.qp.problem import Qp, Solution, Status, kkt_residual

_ACTIVE_UPPER, _ACTIVE_LOWER = 1, 3  # bits of daqp's `sense`
_STATUS = {1: Status.OPTIMAL, -1: Status.INFEASIBLE}  # every other exit flag: no answer


@dataclass(frozen=True, slots=True, kw_only=True)
class DenseSolver:
    """Settings of the engine; `solve` is a pure function of problem and start.

    daqp's own feasibility tolerance is on rows of unit norm; 1e-9 there keeps a platform's limits
    within 1e-8 of their units, where its default of 1e-6 would not.
    """

    tolerance: float = 1e-6  # largest certificate that counts as solved
    primal_tolerance: float = 1e-9
    iteration_limit: int = 2000

    def solve(self, qp: Qp, start: Ints | None = None) -> Solution:
        """Solve `qp` from the working set `start`.

        Parameters
        ----------
        start : (b + m,) as `Solution.working_set`; None starts with no row active.
        """
        if not qp.well_posed():
            return self._no_answer(qp, Status.INVALID, 0)
        sense = np.zeros(len(qp.upper), dtype=np.int32)
        if start is not None:
            sense[start > 0] = _ACTIVE_UPPER
            sense[start < 0] = _ACTIVE_LOWER
        z, _, flag, info = daqp.solve(
            qp.H,
            qp.g,
            qp.A,
            qp.upper,
            qp.lower,
            sense,
            primal_tol=self.primal_tolerance,
            iter_limit=self.iteration_limit,
            eps_prox=0.0,  # H is positive definite: no hidden regularisation
        )
        changes = max(0, int(info["iterations"]) - 1)  # the last iteration only confirms
        status = _STATUS.get(flag, Status.LIMIT)
        if status is not Status.OPTIMAL:
            return self._no_answer(qp, status, changes)
        z, y = np.asarray(z), np.asarray(info["lam"])
        residual = kkt_residual(qp, z, y)
        if not residual < self.tolerance:
            status = Status.UNCERTIFIED
        return Solution(status, z, y, changes, residual)

    def _no_answer(self, qp: Qp, status: Status, changes: int) -> Solution:
        return Solution(status, np.zeros(len(qp.g)), np.zeros(len(qp.upper)), changes, np.inf)
