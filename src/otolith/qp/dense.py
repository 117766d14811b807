"""Dense engine: daqp, a dual active-set method (Arnström, Bemporad & Axehill, 2022).

Warm-started with a working set and counting its changes, it stands for the thesis's hot-started
qpOASES in all studies of iterations. Soft rows are solved through explicit slack variables.
"""

from dataclasses import dataclass

import daqp
import numpy as np

from otolith.core.arrays import Ints, Vec
from otolith.qp.problem import Qp, Solution, Status, kkt_residual
from otolith.qp.slack import Slacked

_ACTIVE_UPPER, _ACTIVE_LOWER = 1, 3  # bits of daqp's `sense`
_STATUS = {1: Status.OPTIMAL, -1: Status.INFEASIBLE}  # every other exit flag: no answer
_PROXIMAL_STEPS = 50  # at most, for soft rows


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
        shape = {"variables": len(qp.g), "rows": len(qp.upper)}
        if not qp.well_posed():
            return Solution.none(Status.INVALID, **shape)
        start = np.zeros(len(qp.upper), dtype=np.int64) if start is None else start
        if qp.penalty is None or not np.isfinite(qp.penalty).any():
            flag, z, y, changes = self._run(qp, start)
        else:
            flag, z, y, changes = self._run_soft(Slacked(qp, qp.penalty), start)
        status = _STATUS.get(flag, Status.LIMIT)
        if status is not Status.OPTIMAL:
            return Solution.none(status, **shape, changes=changes)
        residual = kkt_residual(qp, z, y)
        if not residual < self.tolerance:
            status = Status.UNCERTIFIED
        return Solution(status, z, y, changes, residual)

    def _run(self, qp: Qp, start: Ints) -> tuple[int, Vec, Vec, int]:
        """Exit flag, z, y and working-set changes of daqp on a problem whose rows are all hard."""
        sense = np.zeros(len(qp.upper), dtype=np.int32)
        sense[(start > 0) & np.isfinite(qp.upper)] = _ACTIVE_UPPER  # daqp would hold z at infinity
        sense[(start < 0) & np.isfinite(qp.lower)] = _ACTIVE_LOWER
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
        return flag, np.asarray(z), np.asarray(info["lam"]), changes

    def _run_soft(self, slacked: Slacked, start: Ints) -> tuple[int, Vec, Vec, int]:
        """The same for a problem with soft rows: proximal steps until the slacks stand still."""
        slack, working_set, changes = slacked.no_slack(), slacked.start(start), 0
        for _ in range(_PROXIMAL_STEPS):
            flag, z, y, more = self._run(slacked.about(slack), working_set)
            changes += more
            if flag not in _STATUS or _STATUS[flag] is not Status.OPTIMAL:
                break
            before, working_set = slack, np.sign(y).astype(np.int64)
            slack, _ = slacked.split(z)
            if np.allclose(slack, before, rtol=0.0, atol=self.primal_tolerance):
                break
        return flag, slacked.split(z)[1], slacked.multipliers(y), changes
