"""A convex QP, its solution, and the one certificate that judges every engine.

    min_z ½ zᵀ H z + gᵀ z   subject to   l ≤ (z₁ … z_b, A z) ≤ u

The first b rows are simple bounds on the leading variables, the others the rows of A. One signed
multiplier y per row: y > 0 holds z at the upper side, y < 0 at the lower, 0 where neither is active:

    H z + g + (I_b; A)ᵀ y = 0,    y⁺ (u − r) = 0,    y⁻ (r − l) = 0    with r = (z₁ … z_b, A z).
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
        return bool(finite and (self.lower <= self.upper).all())  # a NaN bound compares false


@dataclass(frozen=True, slots=True)
class Solution:
    """What an engine returns: always arrays, and a status that says whether to trust them."""

    status: Status
    z: Vec  # (n,)
    y: Vec  # (b + m,) signed multipliers
    changes: int  # of the working set, from the start that was given
    residual: float  # kkt_residual of (z, y); inf when there is no answer

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
    rows = qp.rows(z)
    above, below = qp.upper - rows, rows - qp.lower  # (b + m,) slacks, +inf where there is no bound
    active_above, active_below = y > 0, y < 0
    violations = (
        np.abs(stationarity),
        -above,
        -below,
        np.abs(y[active_above] * above[active_above]),  # inf · y: a multiplier on no bound at all
        np.abs(y[active_below] * below[active_below]),
    )
    worst = max(float(np.max(v, initial=0.0)) for v in violations)
    return worst if np.isfinite(worst) else np.inf
