"""Engines of other authors, through casadi: HPIPM on the stages, qpOASES on the condensed problem.

They serve to check Otolith's own engines. They start cold and are built anew for every problem, so their
times here say nothing about their speed. Nothing else depends on them (extra `check`). Both accept hard rows
only: a problem with soft rows is refused, not changed. The multipliers of casadi have the sign used here.
"""

from contextlib import redirect_stdout
from functools import partial
from io import StringIO
from typing import Any, Final

import casadi
import numpy as np
from scipy.linalg import block_diag

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.errors import InputError
from otolith.qp.blocked import Lengths
from otolith.qp.certificate import first_order_residual
from otolith.qp.convex import convexity_fault
from otolith.qp.engines import CondensedEngine, empty_memory, expand
from otolith.qp.infeasible import infeasible
from otolith.qp.problem import Qp, Solution, Status
from otolith.qp.proximal import polish
from otolith.qp.stage import (
    OnRequest,
    StageProblem,
    StageQp,
    StageSolution,
    condense,
    rollout,
    stage_residual,
)


class QpOases:
    """qpOASES (Ferreau et al., 2014), a dense online active-set method."""

    def __init__(self, tolerance: float = 1e-6) -> None:
        self.tolerance = tolerance

    def solve(self, qp: Qp, start: Ints | None = None) -> Solution:
        """Solve a problem without soft rows; `start` is ignored, since casadi's interface takes no working
        set.

        Raises
        ------
        InputError : the problem has soft rows.
        """
        del start
        if qp.penalty is not None:
            _refuse_soft(qp.penalty)
        fault = qp.fault() or convexity_fault(qp.H)
        if fault:
            return Solution.none(Status.INVALID, qp, why=fault)
        b = qp.bounds
        none = np.full(len(qp.g) - b, np.inf)
        found = _solve(
            "qpoases",
            {"printLevel": "none"},
            h=qp.H,
            g=qp.g,
            a=qp.A,
            lba=qp.lower[b:],
            uba=qp.upper[b:],
            lbx=np.concatenate([qp.lower[:b], -none]),
            ubx=np.concatenate([qp.upper[:b], none]),
        )
        if found is None:
            return Solution.none(_unsolved(qp), qp)
        z, of_rows, of_bounds = found
        y = np.concatenate([of_bounds[:b], of_rows])
        residual = first_order_residual(qp, z, y)
        if (
            not residual < self.tolerance and not qp.has_soft_rows
        ):  # the engine's own tolerance is on absolute errors
            z, y = polish(qp, z, y)
            residual = first_order_residual(qp, z, y)
        return Solution(_judged(residual, self.tolerance), z, y, 0, residual)


class Hpipm:
    """HPIPM (Frison & Diehl, 2020), a structured interior point, on z = (x_0, u_0, x_1, …, u_{N−1}, x_N).

    Its rows are, stage by stage, the dynamics A x_k + B u_k − x_{k+1} = 0 and the rows on x_k.
    """

    def __init__(self, problem: StageProblem, tolerance: float = 1e-6) -> None:
        _refuse_soft(problem.penalty)
        self.problem, self.tolerance = problem, tolerance

    def solve(self, qp: StageQp) -> StageSolution:
        """Solve one problem without soft rows; raises `InputError` if it has soft rows."""
        p = self.problem
        if not qp.well_posed():
            return self._answer(qp, Status.INVALID, np.zeros((p.horizon, p.inputs)))
        H, g = self._cost(qp)
        A, lower, upper = self._rows(qp)
        below, above = self._bounds(qp)
        stages = {
            "nx": [p.states] * (p.horizon + 1),
            "nu": [p.inputs] * p.horizon + [0],
            "ng": [0] + [p.rows - p.inputs] * p.horizon,
        }
        options = {"N": p.horizon, **stages, "hpipm": _PATIENT}
        found = _solve("hpipm", options, h=H, g=g, a=A, lba=lower, uba=upper, lbx=below, ubx=above)
        if found is None:
            return self._answer(qp, _unsolved(condense(qp)), np.zeros((p.horizon, p.inputs)))
        z, of_rows, of_bounds = found
        U, of_inputs = self._inputs(z), self._inputs(of_bounds)
        by_stage = np.empty(len(of_rows))
        by_stage[self._order()] = of_rows
        y = np.hstack([by_stage.reshape(p.horizon, -1)[:, p.states :], of_inputs])
        return self._answer(qp, Status.OPTIMAL, U, y)

    def _answer(self, qp: StageQp, status: Status, U: Mat, y: Mat | None = None) -> StageSolution:
        if y is None:
            empty = np.zeros((self.problem.horizon, self.problem.rows))
            return StageSolution(status, U, rollout(qp, U), empty, 0, 0, 0, np.inf)
        residual = stage_residual(qp, U, y)
        return StageSolution(_judged(residual, self.tolerance), U, rollout(qp, U), y, 0, 0, 0, residual)

    def _inputs(self, z: Vec) -> Mat:
        """Places (N, nu) of the inputs in z."""
        p = self.problem
        width = p.states + p.inputs
        return z[: p.horizon * width].reshape(p.horizon, width)[:, p.states :]

    def _order(self) -> Ints:
        """Places of (dynamics to x_{k+1}, rows on x_{k+1}), stage by stage, in HPIPM's order of rows.

        In that order the rows on x_{k+1} follow the dynamics that leave x_{k+1}; the last rows stand alone.
        """
        p = self.problem
        nx, N = p.states, p.horizon
        places_of_stage = np.arange(N * (nx + p.rows - p.inputs)).reshape(N, -1)
        dynamics, rows = places_of_stage[:, :nx], places_of_stage[:, nx:]
        places = [dynamics[0]]
        for k in range(1, N):
            places += [dynamics[k], rows[k - 1]]
        return np.concatenate([*places, rows[N - 1]])

    def _cost(self, qp: StageQp) -> tuple[Mat, Vec]:
        p, weighted = self.problem, list(self.problem.weighted)
        blocks, gradient = [np.zeros((p.states, p.states))], [np.zeros(p.states)]
        for k in range(p.horizon):
            Q, q = qp.output[k].T @ qp.output[k], qp.output[k].T @ qp.error[k]
            Q[weighted, weighted] += qp.state_weight[k]
            q[weighted] += qp.state_linear[k]
            blocks += [np.diag(p.control_weight), Q]
            gradient += [qp.input_linear[k], q]
        return block_diag(*blocks), np.concatenate(gradient)

    def _rows(self, qp: StageQp) -> tuple[Mat, Vec, Vec]:
        p = self.problem
        nx, nr, width = p.states, p.rows - p.inputs, p.states + p.inputs
        A = np.zeros((p.horizon, nx + nr, p.horizon * width + nx))
        for k in range(p.horizon):
            here, there = k * width, (k + 1) * width
            A[k, :nx, here:there] = np.hstack([p.A, p.B])
            A[k, :nx, there : there + nx] = -np.eye(nx)
            A[k, nx:, there : there + nx] = np.vstack([p.C, qp.varying[k]])
        still = np.zeros((p.horizon, nx))
        lower, upper = (np.hstack([still, side[:, :nr]]) for side in (qp.lower, qp.upper))
        order = self._order()
        return A.reshape(len(order), -1)[order], lower.ravel()[order], upper.ravel()[order]

    def _bounds(self, qp: StageQp) -> tuple[Vec, Vec]:
        p = self.problem
        free = np.full((p.horizon, p.states), np.inf)
        sides = []
        for sign, side in ((-1.0, qp.lower), (1.0, qp.upper)):
            stages = np.hstack([sign * free, side[:, p.rows - p.inputs :]])  # (N, nx + nu)
            stages[0, : p.states] = qp.x0
            sides.append(np.concatenate([stages.ravel(), sign * free[0]]))
        return sides[0], sides[1]


class HpipmEngine:
    """HPIPM behind the protocol of `otolith.qp.engines`; it does not support blocks."""

    def __init__(self, problem: StageProblem, *, tolerance: float, blocks: Lengths = ()) -> None:
        if blocks:
            raise InputError("blocks", ",".join(map(str, blocks)), "none with casadi-hpipm")
        self._solver = Hpipm(problem, tolerance)
        self.memory = empty_memory(problem)

    def run(self, start: Ints | None = None, hint: OnRequest | None = None) -> StageSolution:
        """Expand and solve the problem in the memory, without a warm start."""
        del start, hint
        return self._solver.solve(expand(self._solver.problem, self.memory))

    def reset(self) -> None:
        """Do nothing: this engine keeps no state between problems."""


QpOasesEngine: Final = partial(CondensedEngine, dense=QpOases)


_PATIENT = {"iter_max": 100}  # its default tolerances, near 1e-8, are tight enough for the certificate


def _solve(plugin: str, options: dict[str, Any], **data: Any) -> tuple[Vec, Vec, Vec] | None:
    """Return the primal point and the multipliers of rows and bounds; None when the engine reports
    failure.
    """
    h, a = (casadi.sparsify(casadi.DM(data[name])) for name in ("h", "a"))
    sparsity = {"h": h.sparsity(), "a": a.sparsity()}
    with redirect_stdout(
        StringIO()
    ):  # qpOASES always prints its notice, and standard output may be reserved for results
        solver = casadi.conic("engine", plugin, sparsity, {"error_on_fail": False, **options})
        found = solver(**data | {"h": h, "a": a})
    if not solver.stats()["success"]:
        return None
    z, of_rows, of_bounds = (np.asarray(found[name].full()).ravel() for name in ("x", "lam_a", "lam_x"))
    return z, of_rows, of_bounds


def _unsolved(qp: Qp) -> Status:
    """Status of a problem that an engine gave up. casadi has no status for infeasible, so a proof is
    sought.
    """
    return Status.INFEASIBLE if infeasible(qp) else Status.LIMIT


def _judged(residual: float, tolerance: float) -> Status:
    return Status.OPTIMAL if residual < tolerance else Status.UNCERTIFIED


def _refuse_soft(penalty: Vec) -> None:
    if np.isfinite(penalty).any():
        raise InputError(
            "a soft row's penalty", f"{np.min(penalty):g}", "infinite: casadi's engines know hard rows only"
        )
