"""An independent answer to the question that a law answers: the ordinary QP at one parameter, solved by DAQP.

Notation: z = size · y, the Hessian in y is R'R with ones on its diagonal, v = R y. Sizes are such that the
median row lies at the distance 1 from v = 0. DAQP solves the problem in v, where its Hessian is the identity
and the rows have length one. So what counts as feasible or equal does not depend on the units of z, of the
rows and of the cost, nor on how weak the curvature is in some direction. DAQP's own regularisation, which
would hide weak curvature, is off. No code is shared with the engine.
"""

import daqp
import numpy as np
from scipy.linalg import cholesky, solve_triangular

from otolith.core.arrays import Bools, Mat, Vec
from otolith.mpqp.problem import ParametricQp, unit_curvature
from otolith.mpqp.prune import inscribed

_EXACT = 1e-11  # violation of a row at which DAQP stops
_GRAIN = 1e-14  # the same, relative to the distance of the unconstrained minimiser
_LOOSER = (1.0, 1e2, 1e4)  # factors on both, tried in turn while DAQP reaches no verdict
_OPTIMAL, _INFEASIBLE = 1, -1  # DAQP's exit flags


class Oracle:
    """Computes minimisers of a parametric QP, and how far it is from being infeasible, at any parameter.

    Attributes
    ----------
    size : (n,) units of z.
    problem : the problem in y; a row that involves z has length one in v.
    """

    def __init__(self, problem: ParametricQp) -> None:
        unit = unit_curvature(problem.H)
        self._R: Mat = cholesky(problem.H * np.outer(unit, unit))
        M = _solve_transposed(self._R, (problem.G * unit).T).T
        length, level = np.linalg.norm(M, axis=1), _level(problem)
        self._bare: Bools = length == 0.0  # rows that involve the parameter alone
        span = _median(level[~self._bare] / length[~self._bare])
        self.size: Vec = unit * span
        rows = 1.0 / np.where(self._bare, np.maximum(level, 1e-300), length * span)
        self._M = np.ascontiguousarray(M * (rows * span)[:, None])
        self.problem = ParametricQp(
            H=problem.H * np.outer(unit, unit), F=problem.F * unit[:, None] / span, f=problem.f * unit / span,
            G=problem.G * np.outer(rows, self.size), w=problem.w * rows, S=problem.S * rows[:, None],
            lower=problem.lower, upper=problem.upper,
        )  # fmt: skip

    def solve(self, theta: Vec) -> Vec:
        """Return the minimiser z (n,) at θ (p,); NaN when there is none, or when DAQP does not find it."""
        g, b = self.problem.at(theta)
        none = np.full(len(g), np.nan)
        if (b[self._bare] < -_EXACT).any():
            return none
        linear = _solve_transposed(self._R, g)
        tolerance = max(_EXACT, _GRAIN * float(np.linalg.norm(linear)))
        for factor in _LOOSER:
            v, flag = self._run(linear, b, factor * tolerance)
            if flag == _OPTIMAL and np.isfinite(v).all():
                return np.asarray(self.size * solve_triangular(self._R, v))
            if flag == _INFEASIBLE:
                break
        return none

    def _run(self, linear: Vec, b: Vec, tolerance: float) -> tuple[Vec, int]:
        """Run DAQP on min ½|v|² + linear·v, M v ≤ b; return the point and the exit flag."""
        above = b[~self._bare]
        free, kinds = np.full(len(above), -1e30), np.zeros(len(above), dtype=np.int32)
        identity, rows = np.eye(len(linear)), self._M[~self._bare]
        v, _, flag, _ = daqp.solve(
            identity, linear, rows, above, free, kinds, primal_tol=tolerance, eps_prox=0.0
        )
        return np.asarray(v), int(flag)

    def margin(self, theta: Vec) -> float:
        """Return by how much all rows can be tightened, at most 1; negative when the QP is infeasible."""
        return inscribed(self._M, self.problem.at(theta)[1])


def solve(problem: ParametricQp, theta: Vec) -> Vec:
    """Return the minimiser (n,) of the ordinary QP at `theta` (p,) by the oracle; NaN when it has none."""
    return Oracle(problem).solve(theta)


def _solve_transposed(R: Mat, right: Mat) -> Mat:
    """Solve R' x = right."""
    return np.asarray(solve_triangular(R, right, trans="T"), dtype=np.float64)


def _level(problem: ParametricQp) -> Vec:
    """Largest right-hand side (m,) of each row over the box."""
    centre, half = (problem.lower + problem.upper) / 2, (problem.upper - problem.lower) / 2
    level: Vec = np.abs(problem.w + problem.S @ centre) + np.abs(problem.S) @ half
    return level


def _median(distance: Vec) -> float:
    """Median distance of the rows that do not go through zero; 1 when there are none."""
    away = distance[distance > 0.0]
    return float(np.median(away)) if len(away) else 1.0
