"""Errors as parts of what they are errors in, and the rows' part of a certificate.

An equation Σ t_i = b holds *to a part ε* when its error is at most ε (Σ |t_i| + |b|): then a change of each
of its numbers by a part ε makes it exact. That is the componentwise backward error (Oettli & Prager, 1964;
Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., Theorem 7.3). It is the same number in any
units, since a change of units multiplies all terms of an equation alike.
"""

from typing import NamedTuple

import numpy as np

from otolith.core.arrays import Vec


class Rows(NamedTuple):
    """The rows of a problem at one point; all fields have the same shape."""

    value: Vec
    lower: Vec  # −inf where there is none
    upper: Vec  # +inf where there is none
    penalty: Vec  # w, +inf where the row is hard
    terms: Vec  # Σ |R_ij z_j|, the absolute terms that the value is the sum of


def part(error: Vec, size: Vec) -> Vec:
    """|error| / size, zero where there is no error, infinity where an error has no size."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        ratio = np.abs(error) / size
    return np.where(np.equal(error, 0.0), 0.0, ratio)


def worst_of(*violations: float | Vec) -> float:
    """The largest of all numbers given, infinity when any is not finite."""
    return max(float(np.max(v, initial=0.0)) if np.isfinite(v).all() else np.inf for v in violations)


def row_residual(rows: Rows, y: Vec, share: Vec) -> float:
    """The rows' part of a certificate, as parts; what is not finite gives infinity.

    A hard row lies within its bounds. A row whose multiplier is not zero lies at the side that the multiplier
    names, or the multiplier is too small to matter. A soft row has |y| ≤ w, and |y| = w where it is violated.

    Parameters
    ----------
    share : which part of the stationarity conditions each multiplier makes up, at most.
    """
    above = part(np.maximum(rows.value - rows.upper, 0.0), rows.terms + np.abs(rows.upper))
    below = part(np.maximum(rows.lower - rows.value, 0.0), rows.terms + np.abs(rows.lower))
    violation = np.maximum(above, below)
    soft = np.isfinite(rows.penalty)
    outward = np.where(above > 0.0, y, -y)  # the multiplier towards the violated side
    unpaid = np.minimum(violation, part(rows.penalty - outward, rows.penalty))[soft]
    excess = part(np.maximum(np.abs(y) - rows.penalty, 0.0), rows.penalty)[soft]

    held = y != 0.0
    side = np.where(y > 0.0, rows.upper, rows.lower)[held]
    toward = np.sign(y[held])
    gap = np.maximum(toward * (side - rows.value[held]), 0.0)
    idle = np.minimum(part(gap, rows.terms[held] + np.abs(side)), share[held])
    idle[np.isinf(side)] = np.inf  # a multiplier on no bound at all
    return worst_of(violation[~soft], unpaid, excess, idle)
