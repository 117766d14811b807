"""Convert a problem with soft rows to problems with hard rows only, for engines without penalties.

With r the values of all rows (bounds first, see `otolith.qp.problem`) and one slack σ per soft row, the
problem in the variables (σ, z) is

    min ½ zᵀ H z + gᵀ z + wᵀ σ + ½ ε ‖σ − σ°‖²   s.t.   σ ≥ 0,  r_soft − σ ≤ u,  r_soft + σ ≥ l,  hard rows.

The proximal term keeps the Hessian positive definite. With σ° the slacks of the previous solution, repeated
solves converge to the exact minimiser without this term (proximal point method, Rockafellar, 1976), mostly
after one solve.
"""

import numpy as np

from otolith.core.arrays import Ints, Vec
from otolith.qp.problem import Qp

_CURVATURE = 1e-4  # ε


class Slacked:
    """The hard form of a soft problem. Its rows are σ ≥ 0, hard rows, soft rows with −σ, soft rows with
    +σ.
    """

    def __init__(self, qp: Qp) -> None:
        n, b, penalty = len(qp.g), qp.bounds, qp.penalties
        rows = np.vstack([np.eye(b, n), qp.A])  # (b + m, n)
        soft = np.isfinite(penalty)
        self._soft, self._hard = np.flatnonzero(soft), np.flatnonzero(~soft)
        self._linear = np.concatenate([penalty[soft], qp.g])
        s, h = len(self._soft), len(self._hard)
        unit, nothing = np.eye(s), np.full(s, np.inf)
        self._H = np.block([[_CURVATURE * unit, np.zeros((s, n))], [np.zeros((n, s)), qp.H]])
        self._A = np.block([[np.zeros((h, s)), rows[~soft]], [-unit, rows[soft]], [unit, rows[soft]]])
        self._lower = np.concatenate([np.zeros(s), qp.lower[~soft], -nothing, qp.lower[soft]])
        self._upper = np.concatenate([nothing, qp.upper[~soft], qp.upper[soft], nothing])

    def about(self, slack: Vec) -> Qp:
        """Return the hard problem with the proximal term centred at the given slacks (s,)."""
        linear = self._linear.copy()
        linear[: len(slack)] -= _CURVATURE * slack
        return Qp(self._H, linear, self._A, self._lower, self._upper)

    def exact(self) -> Qp:
        """Return the hard problem without the proximal term; its Hessian is singular."""
        s, H = len(self._soft), self._H.copy()
        H[:s, :s] = 0.0
        return Qp(H, self._linear, self._A, self._lower, self._upper)

    def no_slack(self) -> Vec:
        """Slacks (s,) of a point that satisfies all rows: zeros."""
        return np.zeros(len(self._soft))

    def split(self, z: Vec) -> tuple[Vec, Vec]:
        """Split a solution into slacks and variables."""
        return z[: len(self._soft)], z[len(self._soft) :]

    def start(self, start: Ints) -> Ints:
        """Convert a working set of the soft problem to one of the hard problem; every slack starts at
        zero.
        """
        soft = start[self._soft]
        return np.concatenate(
            [-np.ones_like(soft), start[self._hard], np.maximum(soft, 0), np.minimum(soft, 0)]
        )

    def multipliers(self, y: Vec) -> Vec:
        """Convert multipliers of the hard problem to those of the soft problem (b + m,)."""
        s, h = len(self._soft), len(self._hard)
        original = np.zeros(s + h)
        original[self._hard] = y[s : s + h]
        original[self._soft] = y[s + h : s + h + s] + y[s + h + s :]
        return original
