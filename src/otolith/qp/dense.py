"""The dense engine: daqp, a dual active-set method (Arnström, Bemporad & Axehill, 2022).

It starts from a working set and counts its changes, and so represents the thesis's hot-started qpOASES in all
studies of iterations. Soft rows are solved through explicit slack variables. A problem that daqp does not
solve directly is tried again more carefully (`otolith.qp.proximal`). Its status "infeasible" is not trusted:
infeasibility is reported only with a proof (`otolith.qp.infeasible`).
"""

from dataclasses import dataclass, replace
from functools import partial

import daqp
import numpy as np

from otolith.core.arrays import Ints, Vec
from otolith.qp.certificate import first_order_residual
from otolith.qp.convex import convexity_fault
from otolith.qp.infeasible import infeasible
from otolith.qp.problem import Qp, Solution, Status
from otolith.qp.proximal import Found, polish, solve_with_care
from otolith.qp.slack import Slacked

_ACTIVE_UPPER, _ACTIVE_LOWER = 1, 3  # bits of daqp's `sense`
_SOLVED, _INFEASIBLE, _ITERATION_LIMIT, _NOT_CONVEX = 1, -1, -4, -5  # daqp's exit flags
_CLOSER = 1e-3  # factor on daqp's tolerance when its answer is not close enough
_PROXIMAL_STEPS = 50  # largest number of proximal steps for soft rows


@dataclass(frozen=True, slots=True, kw_only=True)
class DenseSolver:
    """Settings of the dense engine; `solve` is a pure function of the problem and the start.

    daqp's own feasibility tolerance applies to rows of unit norm. Its value of 1e-9 here keeps a platform's
    limits within 1e-8 of their units; daqp's default of 1e-6 would not.
    """

    tolerance: float = 1e-6  # largest certificate that counts as solved
    primal_tolerance: float = 1e-9
    iteration_limit: int = 2000
    patient: bool = True  # whether to go on, for seconds, where daqp gives up; not for real time

    def solve(self, qp: Qp, start: Ints | None = None) -> Solution:
        """Solve `qp` from the working set `start`.

        Parameters
        ----------
        start : (b + m,) as `Solution.working_set`; None starts with no active row.
        """
        fault = qp.fault()
        if fault:
            return Solution.none(Status.INVALID, qp, why=fault)
        cold = np.zeros(len(qp.upper), dtype=np.int64)
        flag, found = self._direct(qp, cold if start is None else start)
        if flag == _SOLVED and not found.residual < self.tolerance:
            found = self._closer(qp, found)
        if found.residual < self.tolerance:
            return Solution(Status.OPTIMAL, found.z, found.y, found.changes, found.residual)
        return self._doubted(qp, flag, found)

    def _closer(self, qp: Qp, found: Found) -> Found:
        """Improve an answer when rows are so small that daqp's tolerance is coarse in their own units."""
        closer = replace(self, primal_tolerance=_CLOSER * self.primal_tolerance)
        flag, again = closer._direct(qp, np.sign(found.y).astype(np.int64))
        better = again if flag == _SOLVED and again.residual < found.residual else found
        return better._replace(changes=found.changes)  # counts the search only, not the later refinement

    def _direct(self, qp: Qp, start: Ints) -> tuple[int, Found]:
        """Run daqp on the problem unchanged; return its exit flag and answer. If it solved it, the cost
        is convex.
        """
        flag, z, y, changes = self._soft_or_hard(qp, start)
        if flag != _SOLVED:
            return flag, Found.nothing(qp)._replace(changes=changes)
        return flag, Found(z, y, first_order_residual(qp, z, y), changes)

    def _doubted(self, qp: Qp, flag: int, found: Found) -> Solution:
        """Answer a problem that daqp has not solved unchanged."""
        fault = convexity_fault(qp.H)
        if fault:
            return Solution.none(Status.INVALID, qp, why=fault)
        if flag == _ITERATION_LIMIT:
            return Solution.none(Status.LIMIT, qp, changes=found.changes)
        if flag == _INFEASIBLE and infeasible(qp):
            return Solution.none(Status.INFEASIBLE, qp, changes=found.changes)
        changes = found.changes
        if flag == _SOLVED or qp.has_soft_rows:
            z, y = self._as_hard(qp, found) if qp.has_soft_rows else polish(qp, found.z, found.y)
            found = min(found, Found(z, y, first_order_residual(qp, z, y), 0), key=lambda one: one.residual)
        if self.patient and not found.residual < self.tolerance:
            careful = self._with_care(qp)
            changes += (
                0 if flag == _SOLVED else careful.changes
            )  # after a successful search the careful method only adds digits
            found = min(found, careful, key=lambda one: one.residual)
        if found.residual < self.tolerance:
            return Solution(Status.OPTIMAL, found.z, found.y, changes, found.residual)
        if flag != _INFEASIBLE and infeasible(qp):
            return Solution.none(Status.INFEASIBLE, qp, changes=changes)
        if flag == _SOLVED:
            return Solution(Status.UNCERTIFIED, found.z, found.y, changes, found.residual)
        return Solution.none(Status.LIMIT, qp, changes=changes)

    def _as_hard(self, qp: Qp, found: Found) -> tuple[Vec, Vec]:
        """Solve the problem with hard rows, from the working set that was found.

        Where no multiplier reaches its penalty, this is the answer of the problem with soft rows as well,
        with more digits than proximal steps leave.
        """
        hard = replace(qp, penalty=None)
        flag, z, y, _ = self._run(hard, np.sign(found.y).astype(np.int64))
        return (z, y) if flag == _SOLVED else (found.z, found.y)

    def _with_care(self, qp: Qp) -> Found:
        attempt = partial(
            solve_with_care, primal_tolerance=self.primal_tolerance, iteration_limit=self.iteration_limit
        )
        if not qp.has_soft_rows:
            return attempt(qp)
        slacked = Slacked(qp)
        found = attempt(slacked.exact())
        z, y = slacked.split(found.z)[1], slacked.multipliers(found.y)
        return Found(z, y, first_order_residual(qp, z, y), found.changes)

    def _soft_or_hard(self, qp: Qp, start: Ints) -> tuple[int, Vec, Vec, int]:
        return self._run_soft(Slacked(qp), start) if qp.has_soft_rows else self._run(qp, start)

    def _run(self, qp: Qp, start: Ints) -> tuple[int, Vec, Vec, int]:
        """Run daqp on a problem whose rows are all hard; return exit flag, z, y and working-set changes."""
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
            eps_prox=0.0,  # no hidden regularisation
        )
        changes = max(0, int(info["iterations"]) - 1)  # the last iteration only confirms the working set
        return flag, np.asarray(z), np.asarray(info["lam"]), changes

    def _run_soft(self, slacked: Slacked, start: Ints) -> tuple[int, Vec, Vec, int]:
        """Solve a problem with soft rows by proximal steps, until the slacks no longer change."""
        slack, working_set, changes = slacked.no_slack(), slacked.start(start), 0
        for _ in range(_PROXIMAL_STEPS):
            flag, z, y, more = self._run(slacked.about(slack), working_set)
            changes += more
            if flag != _SOLVED:
                break
            before, working_set = slack, np.sign(y).astype(np.int64)
            slack, _ = slacked.split(z)
            if np.allclose(slack, before, rtol=0.0, atol=self.primal_tolerance):
                break
        return flag, slacked.split(z)[1], slacked.multipliers(y), changes
