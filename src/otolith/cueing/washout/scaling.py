"""Third-order scaling and limiting of a reference: small signals keep their slope, large ones saturate.

Notation: y = c₁ x + c₂ x² + c₃ x³ for 0 ≤ x ≤ x_m, odd, and y = y_m beyond, with y(x_m) = y_m, y'(0) = S and
y'(x_m) = 0. Derivation: the three conditions are linear in c; the tests check them by substitution. The form
is Reid & Nahon's (1985), with zero slope at the end, where it joins the constant part.
"""

from dataclasses import dataclass

import numpy as np

from otolith.core.arrays import Vec
from otolith.cueing.washout.kernels import scale


@dataclass(frozen=True, slots=True, kw_only=True)
class Cubic:
    """An odd cubic that is constant from `largest` on; it is increasing if 3 limit ≥ slope · largest."""

    slope: float  # S [-]
    largest: float  # x_m [SI]
    limit: float  # y_m [SI]

    @property
    def coefficients(self) -> Vec:
        """Return S, c₂, c₃ and x_m (4,), as `otolith.cueing.washout.kernels.scale` takes them."""
        S, x_m, y_m = self.slope, self.largest, self.limit
        return np.array([S, (3.0 * y_m - 2.0 * S * x_m) / x_m**2, (S * x_m - 2.0 * y_m) / x_m**3, x_m])

    def __call__(self, x: Vec) -> Vec:
        """Scale every entry."""
        return np.array([scale(self.coefficients, value) for value in x.tolist()])
