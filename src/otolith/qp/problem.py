"""A convex QP, its solution, and the one certificate that judges every engine.

    min_z ½ zᵀ H z + gᵀ z   subject to   l ≤ (z₁ … z_b, A z) ≤ u

The first b rows are simple bounds on the leading variables, the others the rows of A. One signed
multiplier y per row: y > 0 holds z at the upper side, y < 0 at the lower, 0 where neither is active:

    H z + g + (I_b; A)ᵀ y = 0,    y⁺ (u − r) = 0,    y⁻ (r − l) = 0    with r = (z₁ … z_b, A z).

A row with a finite penalty w is soft: it may be violated by σ ≥ 0 at the cost w σ (exact L1 penalty),
so that |y| ≤ w and (w − |y|) σ = 0 take the place of σ = 0.
"""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.errors import OtolithError


class Status(StrEnum):
    """What an engine found; only `OPTIMAL` carries a certificate below the engine's tolerance."""

    OPTIMAL = "optimal"
    INFEASIBLE = "infeasible"  # no z satisfies all rows
    LIMIT = "limit"  # iteration limit, cycling, or numerical trouble
    UNCERTIFIED = "uncertified"  # the engine claimed success, its answer does not hold
    INVALID = "invalid"  # data not finite, or l > u


class NotSolved(OtolithError):
    """`or_raise` was called on a solution that is not optimal."""


@dataclass(frozen=True, slots=True)
class Qp:
    """One quadratic program. Not copied: an engine reads it once per solve."""

    H: Mat  # (n, n) symmetric positive definite
    g: Vec  # (n,)
    A: Mat  # (m, n)
    lower: Vec  # (b + m,), −inf where there is none
    upper: Vec  # (b + m,), +inf where there is none
    penalty: Vec | None = None  # (b + m,) w, +inf where the row is hard; None: all are

    @property
    def bounds(self) -> int:
        """b, the number of leading variables that have simple bounds."""
        return len(self.upper) - len(self.A)

    def rows(self, z: Vec) -> Vec:
        """(b + m,) values that the bounds `lower` and `upper` apply to."""
        return np.concatenate([z[: self.bounds], self.A @ z])

    def well_posed(self) -> bool:
        """True when every number that must be finite is, no bound is NaN, and lower ≤ upper."""
        finite = np.isfinite(self.H).all() and np.isfinite(self.g).all() and np.isfinite(self.A).all()
        ordered = (self.lower <= self.upper).all()  # a NaN bound compares false
        return bool(finite and ordered and (self.penalty is None or (self.penalty > 0).all()))


@dataclass(frozen=True, slots=True)
class Solution:
    """What an engine returns: always arrays, and a status that says whether to trust them."""

    status: Status
    z: Vec  # (n,)
    y: Vec  # (b + m,) signed multipliers
    changes: int  # of the working set, from the start that was given
    residual: float  # kkt_residual of (z, y); inf when there is no answer

    @classmethod
    def none(cls, status: Status, *, variables: int, rows: int, changes: int = 0) -> "Solution":
        """The absence of an answer: zeros of the right shapes, no certificate."""
        return cls(status, np.zeros(variables), np.zeros(rows), changes, np.inf)

    @property
    def working_set(self) -> Ints:
        """(b + m,) +1 where the upper side is active, −1 where the lower is, 0 elsewhere."""
        return np.sign(self.y).astype(np.int64)

    def or_raise(self) -> "Solution":
        """Return self when optimal, else raise `NotSolved`."""
        if self.status is not Status.OPTIMAL:
            raise NotSolved(f"the QP was not solved: {self.status} (residual {self.residual:.1e})")
        return self


def kkt_residual(qp: Qp, z: Vec, y: Vec) -> float:
    """Largest violation of the optimality conditions; zero exactly at an optimum.

    Absolute, in the problem's own units. Anything not finite gives infinity, so that an answer is
    accepted only on `residual < tolerance`.

    Parameters
    ----------
    z : (n,) primal point.
    y : (b + m,) signed multipliers.
    """
    if not (np.isfinite(z).all() and np.isfinite(y).all()):
        return np.inf
    b = qp.bounds
    stationarity = qp.H @ z + qp.g + qp.A.T @ y[b:]  # (n,)
    stationarity[:b] += y[:b]
    penalty = np.full(len(y), np.inf) if qp.penalty is None else qp.penalty
    of_rows = row_residual(qp.rows(z), y, qp.lower, qp.upper, penalty)
    return worst_of(of_rows, np.abs(stationarity))


def worst_of(*violations: float | Vec) -> float:
    """The largest of all numbers given, infinity when any is not finite."""
    return max(float(np.max(v, initial=0.0)) if np.isfinite(v).all() else np.inf for v in violations)


def row_residual(rows: Vec, y: Vec, lower: Vec, upper: Vec, penalty: Vec) -> float:
    """The rows' part of a certificate: violation, complementarity, and |y| ≤ w where a row is soft.

    All arguments have the same shape; what is not finite gives infinity.
    """
    side = np.where(y > 0, upper - rows, rows - lower)  # distance to the side that y names
    held = y != 0.0
    complementarity = np.abs(y[held] * np.maximum(side[held], 0.0))  # inf: a multiplier on no bound at all
    violation = np.maximum(np.maximum(rows - upper, lower - rows), 0.0)
    soft = np.isfinite(penalty)
    outside = np.where(rows > upper, 1.0, -1.0) * y  # the multiplier towards the violated side
    unpaid = violation[soft] * np.abs(penalty[soft] - outside[soft])
    hard = violation[~soft] * np.maximum(np.abs(y[~soft]), 1.0)
    excess = np.abs(y[soft]) - penalty[soft]
    return worst_of(complementarity, hard, unpaid, excess)
