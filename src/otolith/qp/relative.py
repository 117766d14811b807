"""Relative errors of equations, and the rows' part of a certificate.

An equation Σ t_i = b holds *to a part ε* when its error is at most ε (Σ |t_i| + |b|): then changing each of
its numbers by a part ε makes it exact. This is the componentwise backward error (Oettli & Prager, 1964;
Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., Theorem 7.3). It is the same in any units,
since a change of units multiplies all terms of an equation alike.
"""

from typing import NamedTuple

import numpy as np

from otolith.core.arrays import Vec


class Rows(NamedTuple):
    """The rows of a problem at one point; all fields have the same shape."""

    value: Vec
    lower: Vec  # −inf for a row without a lower bound
    upper: Vec  # +inf for a row without an upper bound
    penalty: Vec  # w, +inf for a hard row
    terms: Vec  # Σ |R_ij z_j|, the sum of the absolute terms of the row's value


def part(error: Vec, size: Vec) -> Vec:
    """Return |error| / size; zero where there is no error, infinite where an error has no size."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        ratio = np.abs(error) / size
    return np.where(np.equal(error, 0.0), 0.0, ratio)


def worst_of(*violations: float | Vec) -> float:
    """Return the largest of all numbers given, or infinity when any is not finite."""
    return max(float(np.max(v, initial=0.0)) if np.isfinite(v).all() else np.inf for v in violations)


def row_residual(rows: Rows, y: Vec, share: Vec) -> float:
    """Compute the rows' part of a certificate, as relative errors; infinite when a number is not finite.

    A hard row must lie within its bounds. A row with a non-zero multiplier must lie at the side given by the
    multiplier's sign, unless the multiplier is negligible. A soft row needs |y| ≤ w, and |y| = w where it is
    violated.

    Parameters
    ----------
    share : largest part that each multiplier contributes to any of the stationarity conditions.
    """
    above = part(np.maximum(rows.value - rows.upper, 0.0), rows.terms + np.abs(rows.upper))
    below = part(np.maximum(rows.lower - rows.value, 0.0), rows.terms + np.abs(rows.lower))
    violation = np.maximum(above, below)
    soft = np.isfinite(rows.penalty)
    outward = np.where(above > 0.0, y, -y)  # the multiplier's component towards the violated side
    unpaid = np.minimum(violation, part(rows.penalty - outward, rows.penalty))[soft]
    excess = part(np.maximum(np.abs(y) - rows.penalty, 0.0), rows.penalty)[soft]

    held = y != 0.0
    side = np.where(y > 0.0, rows.upper, rows.lower)[held]
    toward = np.sign(y[held])
    gap = np.maximum(toward * (side - rows.value[held]), 0.0)
    idle = np.minimum(part(gap, rows.terms[held] + np.abs(side)), share[held])
    idle[np.isinf(side)] = np.inf  # a multiplier on a side without a bound
    return worst_of(violation[~soft], unpaid, excess, idle)
