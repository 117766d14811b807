"""Scale a problem to units in which its numbers are about one.

With z = D z' t, rows times E and cost times c / t², the largest entry of each row and column of the
optimality system becomes about one (Ruiz, 2001). The choice of t does the same for the median bound, that of
c for the largest curvature. All factors are powers of two, so nothing is rounded. The certificate is the same
before and after.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from otolith.core.arrays import Vec
from otolith.qp.problem import Qp

_ROUNDS = 10
_NO_NUMBER = 1e-9  # bounds smaller than this part of the largest one are treated as rounding errors


@dataclass(frozen=True, slots=True)
class Equilibrated:
    """A scaled problem, and the factors that undo the scaling."""

    qp: Qp
    of_variables: Vec  # (n,) factor from z' to z
    of_multipliers: Vec  # (b + m,) factor from y' to y

    def back(self, z: Vec, y: Vec) -> tuple[Vec, Vec]:
        """Convert variables and multipliers back to the original units."""
        return z * self.of_variables, y * self.of_multipliers


def equilibrate(qp: Qp) -> Equilibrated:
    """Scale a problem whose rows are all hard."""
    b = qp.bounds
    D, E = _ruiz(np.abs(qp.H), np.abs(qp.A))
    E = np.concatenate([1.0 / D[:b], E])
    lower, upper = qp.lower * E, qp.upper * E
    t = _amplitude(np.abs(np.concatenate([lower, upper])))
    H, g = D[:, None] * qp.H * D, qp.g * D / t
    most = np.max(np.abs(H), initial=0.0) or np.max(np.abs(g), initial=0.0) or 1.0
    c = _power_of_two(1.0 / most)
    scaled = Qp(c * H, c * g, E[b:, None] * qp.A * D, lower / t, upper / t)
    return Equilibrated(scaled, D * t, E * t / c)


def _ruiz(H: Vec, A: Vec) -> tuple[Vec, Vec]:
    D, E = np.ones(len(H)), np.ones(len(A))
    for _ in range(_ROUNDS):
        of_rows = E[:, None] * A * D
        columns = np.maximum((D[:, None] * H * D).max(axis=0), of_rows.max(axis=0, initial=0.0))
        rows = of_rows.max(axis=1, initial=0.0)
        D /= np.sqrt(np.where(columns == 0.0, 1.0, columns))
        E /= np.sqrt(np.where(rows == 0.0, 1.0, rows))
    return _power_of_two(D), _power_of_two(E)


def _amplitude(bounds: Vec) -> float:
    """Median of the bounds that are finite and not negligible; one if there are none."""
    bounds = bounds[np.isfinite(bounds)]
    bounds = bounds[bounds > _NO_NUMBER * np.max(bounds, initial=0.0)]
    return float(_power_of_two(np.median(bounds))) if len(bounds) else 1.0


def _power_of_two(x: Any) -> Any:
    return 2.0 ** np.round(np.log2(x))
