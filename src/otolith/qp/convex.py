"""Test whether a quadratic cost is convex: only then do the first-order conditions imply a minimum.

The Hessian is scaled to a unit diagonal first, so the result is independent of units.
"""

import numpy as np

from otolith.core.arrays import Mat

ROUNDING = 1e-10  # negative curvature and asymmetry up to this part of the diagonal count as rounding errors


def convexity_fault(H: Mat) -> str:
    """Explain in one sentence why H (n, n) is not symmetric positive semidefinite; empty when it is."""
    diagonal = np.diag(H)
    if (diagonal < 0.0).any():
        i = int(np.argmin(diagonal))
        return f"H[{i}, {i}] is {diagonal[i]:.3g}, must be at least 0: the cost is not convex"
    flat = diagonal == 0.0
    scale = 1.0 / np.sqrt(np.where(flat, 1.0, diagonal))
    scaled = scale[:, None] * H * scale
    if np.abs(scaled - scaled.T).max(initial=0.0) > ROUNDING:
        return "H is not symmetric"
    if scaled[flat].any():
        i = int(np.flatnonzero(flat)[np.argmax(np.abs(scaled[flat]).max(axis=1))])
        return f"H[{i}, {i}] is 0 and its row is not: the cost is not convex"
    if not _positive(scaled + ROUNDING * np.eye(len(H))):
        least = float(np.linalg.eigvalsh(scaled)[0])
        bound = "must be at least 0: the cost is not convex"
        return f"H has the eigenvalue {least:.3g} in units of its diagonal, {bound}"
    return ""


def _positive(S: Mat) -> bool:
    """True when S is positive definite."""
    try:
        np.linalg.cholesky(S)
    except np.linalg.LinAlgError:
        return False
    return True
