"""A convex QP and its solution; `otolith.qp.certificate` judges them.

    min_z ½ zᵀ H z + gᵀ z   subject to   l ≤ (z₁ … z_b, A z) ≤ u

The first b rows are simple bounds on the leading variables, the others are the rows of A. Each row has one
signed multiplier y: y > 0 holds z at the upper side, y < 0 at the lower side, and y = 0 where neither is
active:

    H z + g + (I_b; A)ᵀ y = 0,    y⁺ (u − r) = 0,    y⁻ (r − l) = 0    with r = (z₁ … z_b, A z).

A row with a finite penalty w is soft: it may be violated by σ ≥ 0 at the cost w σ (exact L1 penalty). The
conditions |y| ≤ w and (w − |y|) σ = 0 then replace σ = 0.
"""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.errors import OtolithError


class Status(StrEnum):
    """What an engine found. Only `OPTIMAL` guarantees a certificate below the engine's tolerance."""

    OPTIMAL = "optimal"
    INFEASIBLE = "infeasible"  # proved: no z satisfies all hard rows
    LIMIT = "limit"  # iteration limit, cycling, or numerical trouble
    UNCERTIFIED = "uncertified"  # the engine reported success, but its answer fails the certificate
    INVALID = "invalid"  # the data are not finite, l > u, or the cost is not convex


class NotSolved(OtolithError):
    """`or_raise` was called on a solution that is not optimal."""


@dataclass(frozen=True, slots=True)
class Qp:
    """One quadratic program. Its arrays are copied only if they are not float64."""

    H: Mat  # (n, n) symmetric positive semidefinite
    g: Vec  # (n,)
    A: Mat  # (m, n)
    lower: Vec  # (b + m,), −inf for a row without a lower bound
    upper: Vec  # (b + m,), +inf for a row without an upper bound
    penalty: Vec | None = None  # (b + m,) w, +inf for a hard row; None if all rows are hard

    def __post_init__(self) -> None:
        for name in ("H", "g", "A", "lower", "upper", "penalty"):
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, np.asarray(value, dtype=np.float64))

    @property
    def bounds(self) -> int:
        """b, the number of leading variables that have simple bounds."""
        return len(self.upper) - len(self.A)

    @property
    def penalties(self) -> Vec:
        """Penalties w (b + m,), +inf for hard rows."""
        return np.full(len(self.upper), np.inf) if self.penalty is None else self.penalty

    @property
    def has_soft_rows(self) -> bool:
        """True when at least one penalty is finite."""
        return self.penalty is not None and bool(np.isfinite(self.penalty).any())

    def rows(self, z: Vec) -> Vec:
        """Values (b + m,) of all rows at z (n,), to which the bounds `lower` and `upper` apply."""
        return np.concatenate([z[: self.bounds], self.A @ z])

    def fault(self) -> str:
        """Explain in one sentence why the numbers define no problem; empty when they do.

        All numbers must be finite except bounds and penalties, lower ≤ upper, and penalties must be positive.
        Whether H is positive semidefinite is tested separately, see `otolith.qp.convex`, since it needs a
        factorisation.
        """
        for name in ("H", "g", "A"):
            if not np.isfinite(getattr(self, name)).all():
                return f"{name} has an entry that is not finite"
        if not (self.lower <= self.upper).all():  # a NaN bound compares false
            i = int(np.argmin(self.lower <= self.upper))
            return f"lower[{i}] is {self.lower[i]:g}, must be at most upper[{i}], which is {self.upper[i]:g}"
        if self.penalty is not None and not (self.penalty > 0).all():
            i = int(np.argmin(self.penalty > 0))
            return f"penalty[{i}] is {self.penalty[i]:g}, must be positive"
        return ""

    def well_posed(self) -> bool:
        """True when there is no `fault`."""
        return not self.fault()


@dataclass(frozen=True, slots=True)
class Solution:
    """What an engine returns: always arrays, and a status that says whether to trust them."""

    status: Status
    z: Vec  # (n,)
    y: Vec  # (b + m,) signed multipliers
    changes: int  # of the working set, counted from the given start
    residual: float  # kkt_residual of (z, y); infinite when there is no answer
    why: str = ""  # reason in one sentence, where a problem was refused

    @classmethod
    def none(cls, status: Status, qp: Qp, *, changes: int = 0, why: str = "") -> "Solution":
        """Make a solution that carries no answer: zeros of the problem's shapes and an infinite residual."""
        return cls(status, np.zeros(len(qp.g)), np.zeros(len(qp.upper)), changes, np.inf, why)

    @property
    def working_set(self) -> Ints:
        """Active rows (b + m,): +1 where the upper side is active, −1 where the lower is, 0 elsewhere."""
        return np.sign(self.y).astype(np.int64)

    def or_raise(self) -> "Solution":
        """Return self when optimal; raise `NotSolved` otherwise."""
        if self.status is not Status.OPTIMAL:
            why = self.why or f"residual {self.residual:.1e}"
            raise NotSolved(f"the QP was not solved: {self.status} ({why})")
        return self
