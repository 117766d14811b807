"""Singular values of a small matrix, compiled: one-sided Jacobi rotations (Hestenes, 1958).

Rotations of two columns at a time make all columns orthogonal; their lengths are then the singular values,
each with a small relative error (Demmel & Veselic, SIAM J. Matrix Anal. Appl. 13, 1992). For six columns this
takes a tenth of the time of LAPACK's decomposition, which would compute vectors, too, and needs a library.
"""

import math
from typing import Final

from otolith.core.arrays import Mat
from otolith.core.jit import kernel

ORTHOGONAL: Final = 1e-14  # cosine of the angle between two columns that counts as zero
SWEEPS: Final = 30  # largest number; six columns take five to seven, since convergence is quadratic


@kernel
def _rotate(M: Mat, p: int, q: int) -> bool:
    """Make two columns orthogonal by a rotation; return False if they are so already."""
    a, b, c = 0.0, 0.0, 0.0
    for i in range(len(M)):
        a += M[i, p] * M[i, p]
        b += M[i, q] * M[i, q]
        c += M[i, p] * M[i, q]
    if not abs(c) > ORTHOGONAL * math.sqrt(a * b):  # a NaN fails every comparison
        return False
    zeta = (b - a) / (2.0 * c)
    tangent = math.copysign(1.0, zeta) / (abs(zeta) + math.sqrt(1.0 + zeta * zeta))
    cosine = 1.0 / math.sqrt(1.0 + tangent * tangent)
    sine = cosine * tangent
    for i in range(len(M)):
        x, y = M[i, p], M[i, q]
        M[i, p], M[i, q] = cosine * x - sine * y, sine * x + cosine * y
    return True


@kernel
def extreme_singular_values(M: Mat) -> tuple[float, float]:
    """Return the largest and the smallest singular value of a matrix (m, n), m >= n, which is overwritten.

    Both are NaN if a number of the matrix is none.
    """
    n = M.shape[1]
    for _ in range(SWEEPS):
        turned = 0
        for p in range(n - 1):
            for q in range(p + 1, n):
                turned += _rotate(M, p, q)
        if turned == 0:
            break
    largest, smallest = 0.0, math.inf
    for j in range(n):
        square = 0.0
        for i in range(len(M)):
            square += M[i, j] * M[i, j]
        if not square < math.inf:
            return math.nan, math.nan
        largest, smallest = max(largest, square), min(smallest, square)
    return math.sqrt(largest), math.sqrt(smallest)
