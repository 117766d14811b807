"""Solve problems that daqp cannot solve directly: little curvature, bad scaling, degenerate equalities.

The method is the proximal point method (Rockafellar, 1976) in equilibrated units: z_{k+1} minimises the cost
plus ½ ε ‖z − z_k‖². This term adds the curvature that daqp needs, and the limit minimises the cost itself.
When the working set no longer changes, one linear system for that set (the *polish* of Stellato et al., OSQP,
2020, §4) gives the limit directly. The best ε differs from problem to problem, so several are tried. The
certificate of the original problem decides, however an answer was found.
"""

from typing import Final, NamedTuple

import daqp
import numpy as np
from scipy.linalg import lu_factor, lu_solve

from otolith.core.arrays import Ints, Vec
from otolith.qp.certificate import first_order_residual
from otolith.qp.equilibrate import equilibrate
from otolith.qp.problem import Qp

# (ε, width by which equalities are opened into inequalities, so that daqp need not hold dependent ones from
# the start)
_ATTEMPTS: Final = ((1e-6, 0.0), (1e-4, 0.0), (1e-4, 1e-8), (1e-2, 0.0), (1e-3, 1e-7))
_STEPS = 40  # largest number of proximal points in one attempt
_ENOUGH = 1e-9  # certificate below which the search stops
_STILL = 1e-13  # a smaller movement counts as standing still
_REGULARISED = 1e-9  # regularisation of the polish's linear system; refinement removes its effect
_REFINEMENTS = 8


class Found(NamedTuple):
    """A point, its multipliers, its certificate, and the number of working-set changes that led to it."""

    z: Vec
    y: Vec
    residual: float
    changes: int

    @classmethod
    def nothing(cls, qp: Qp) -> "Found":
        """Make a result that stands for "no answer"."""
        return cls(np.zeros(len(qp.g)), np.zeros(len(qp.upper)), np.inf, 0)


def solve_with_care(qp: Qp, *, primal_tolerance: float, iteration_limit: int) -> Found:
    """Find the best answer to a convex problem with hard rows; its residual is infinite if there is none."""
    units = equilibrate(qp)
    best = Found.nothing(qp)
    changes = 0
    for epsilon, opening in _ATTEMPTS:
        walk = _Walk(units.qp, epsilon, opening, primal_tolerance, iteration_limit)
        found = walk.run()
        changes += found.changes
        if found.residual < best.residual:
            best = found
        if best.residual < _ENOUGH:
            break
    return Found(*units.back(best.z, best.y), best.residual, changes)


class _Walk:
    """The sequence of proximal points of one problem for one ε."""

    def __init__(
        self, qp: Qp, epsilon: float, opening: float, primal_tol: float, iteration_limit: int
    ) -> None:
        n, equal = len(qp.g), qp.lower == qp.upper
        self._qp, self._epsilon = qp, epsilon
        self._model = daqp.Model()
        self._model.settings = self._model.settings | {
            "primal_tol": primal_tol,
            "iter_limit": iteration_limit,
            "eps_prox": 0.0,
        }
        flag, _ = self._model.setup(
            qp.H + epsilon * np.eye(n),
            qp.g.copy(),
            np.ascontiguousarray(qp.A),
            np.where(equal, qp.upper + opening, qp.upper),
            np.where(equal, qp.lower - opening, qp.lower),
            np.zeros(len(qp.upper), dtype=np.int32),
        )
        self._ready = flag >= 0
        self._polished: Ints | None = None  # the working set that was polished last

    def run(self) -> Found:
        """Take proximal steps and return the best point found."""
        z, changes = np.zeros(len(self._qp.g)), 0
        best = Found.nothing(self._qp)
        for _ in range(_STEPS if self._ready else 0):
            self._model.update(f=self._qp.g - self._epsilon * z)
            point, _, flag, info = self._model.solve()
            if flag != 1:  # then the arrays hold no answer
                break
            before, z, y = z, np.array(point), np.array(info["lam"])
            changes += max(0, int(info["iterations"]) - 1)
            for candidate in self._judged(z, y):
                best = candidate if candidate.residual < best.residual else best
            if best.residual < _ENOUGH or np.max(np.abs(z - before), initial=0.0) < _STILL:
                break
        return best._replace(changes=changes)

    def _judged(self, z: Vec, y: Vec) -> list[Found]:
        """Judge the point and, if its working set is new, the polished point; each unchanged and clipped
        to its bounds.
        """
        points = [(z, y)]
        if self._polished is None or (np.sign(y) != self._polished).any():
            self._polished = np.sign(y).astype(np.int64)
            points.append(polish(self._qp, z, y))
        points += [(_within_bounds(self._qp, z), y) for z, y in points]
        return [Found(z, y, first_order_residual(self._qp, z, y), 0) for z, y in points]


def _within_bounds(qp: Qp, z: Vec) -> Vec:
    """Clip variables that rounding left outside their simple bounds to these bounds."""
    b = qp.bounds
    return np.concatenate([np.clip(z[:b], qp.lower[:b], qp.upper[:b]), z[b:]])


def polish(qp: Qp, z: Vec, y: Vec) -> tuple[Vec, Vec]:
    """Compute point and multipliers with the rows of the working set (the signs of y) held at their bounds.

    The matrix [H Aᵀ; A 0] of these rows may be singular. [H + δ I, Aᵀ; A, −δ I] is not; refining its solution
    with the first matrix converges to a solution of the singular system, if there is one.
    """
    n, b, held = len(qp.g), qp.bounds, y != 0.0
    rows = np.vstack([np.eye(b, n)[held[:b]], qp.A[held[b:]]])
    k = len(rows)
    system = np.block([[qp.H, rows.T], [rows, np.zeros((k, k))]])
    right = np.concatenate([-qp.g, np.where(y > 0.0, qp.upper, qp.lower)[held]])
    shift = np.concatenate([np.full(n, _REGULARISED), np.full(k, -_REGULARISED)])
    factors = lu_factor(system + np.diag(shift), check_finite=False)
    at = np.concatenate([z, y[held]])
    best, least = at, np.inf
    for _ in range(_REFINEMENTS):
        error = right - system @ at
        if not np.max(np.abs(error)) < least:
            break
        best, least = at, float(np.max(np.abs(error)))
        at = at + lu_solve(factors, error, check_finite=False)
    multipliers = np.zeros_like(y)
    multipliers[held] = best[n:]
    return best[:n], multipliers
