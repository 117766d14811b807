"""The working set of a dual active-set method: its rows, and the factors by which they act on each other.

The rows of the problem lie in blocks, of which each depends on the first variables only, as rows along a
horizon do. The Hessian is factorised from the last variable on, so that the zeros of these rows stay zeros.
Notation is that of `otolith.qp.bounded_dual`. The arithmetic may be fused; a certificate judges the answer.
"""

from typing import Final, NamedTuple, Self

import numpy as np

from otolith.core.arrays import Cube, Ints, Mat, Vec
from otolith.core.jit import jit_fused, jit_inner_fused

DEPENDENT: Final = 1e-11  # squared length outside the span of the working set, relative, that counts as zero
TURN: Final = 16  # numbers that a loop over memory takes in one turn; what is left over costs as much each


class Rows(NamedTuple):
    """The rows of the problem: M blocks of m rows, of n variables."""

    R: Cube  # (M, n, ≥ m) by block, variable and row, so that all rows of a block are evaluated together
    width: Ints  # (M,) number of variables, the first, on which the rows of a block depend
    lower: Vec  # (M·m,)
    upper: Vec  # (M·m,)
    penalty: Vec  # (M·m,) w, infinite for a hard row


@jit_fused
def whole_turns(n: int) -> int:
    """Return the least number of whole turns, in numbers, that is not below n."""
    return (n + TURN - 1) // TURN * TURN


def empty_rows(n: int, penalty: Mat) -> Rows:
    """Allocate rows of n variables with these penalties (M, m); all are zero and without bounds."""
    M, m = penalty.shape
    endless = np.full(M * m, np.inf)
    return Rows(np.zeros((M, n, whole_turns(m))), np.full(M, n), -endless, endless, np.array(penalty).ravel())


class Work(NamedTuple):
    """Memory of the method."""

    L: Mat  # (n, n)
    A: Mat  # (n + 1, n) rows of the working set …
    V: Mat  # (n + 1, n)
    F: Mat  # (n + 1, n + 1)
    held: Ints  # (n + 1,) … their indices …
    width: Ints  # (n + 1,) … and the number of variables on which each depends
    pull: Vec  # (n + 1,) right-hand sides and their solutions
    t: Vec  # (n,)
    values: Mat  # (M, ≥ m) of all rows

    @classmethod
    def of(cls, rows: Rows) -> Self:
        """Allocate the memory."""
        M, n, m = rows.R.shape
        return cls(
            L=np.zeros((n, n)),
            A=np.zeros((n + 1, n)),
            V=np.zeros((n + 1, n)),
            F=np.zeros((n + 1, n + 1)),
            held=np.zeros(n + 1, dtype=np.int64),
            width=np.zeros(n + 1, dtype=np.int64),
            pull=np.zeros(n + 1),
            t=np.zeros(n),
            values=np.zeros((M, m)),
        )


@jit_inner_fused
def dot(a: Vec, b: Vec, n: int) -> float:
    """Return the product of the first n entries."""
    total = 0.0
    for i in range(n):
        total += a[i] * b[i]
    return total


@jit_inner_fused
def factorise(H: Mat, L: Mat) -> bool:
    """Write L of H = Lᵀ L, its diagonal inverted; return False if H is not positive definite.

    Only the lower triangle of H is read. Later rows are taken off four at a time, which spares memory.
    """
    n = len(H)
    for k in range(n - 1, -1, -1):
        for j in range(k + 1):
            L[k, j] = H[k, j]
        p = k + 1
        while p + 3 < n:
            a, b, c, d = L[p, k], L[p + 1, k], L[p + 2, k], L[p + 3, k]
            for j in range(k + 1):
                L[k, j] -= a * L[p, j] + b * L[p + 1, j] + c * L[p + 2, j] + d * L[p + 3, j]
            p += 4
        while p < n:
            a = L[p, k]
            for j in range(k + 1):
                L[k, j] -= a * L[p, j]
            p += 1
        if not L[k, k] > 0.0:
            return False
        L[k, k] = 1.0 / np.sqrt(L[k, k])
        for j in range(k):
            L[k, j] *= L[k, k]
    return True


@jit_inner_fused
def forward(L: Mat, x: Vec, n: int) -> None:
    """Solve L x = x in place."""
    for i in range(n):
        x[i] = (x[i] - dot(L[i], x, i)) * L[i, i]


@jit_inner_fused
def backward(L: Mat, x: Vec, n: int) -> None:
    """Solve Lᵀ x = x in place, where all entries behind the first n are zero.

    Four entries at a time are taken off those before them, in less than half the time of one by one.
    """
    i = n - 1
    while i >= 3:
        a = x[i] * L[i, i]
        b = (x[i - 1] - L[i, i - 1] * a) * L[i - 1, i - 1]
        c = (x[i - 2] - L[i, i - 2] * a - L[i - 1, i - 2] * b) * L[i - 2, i - 2]
        d = (x[i - 3] - L[i, i - 3] * a - L[i - 1, i - 3] * b - L[i - 2, i - 3] * c) * L[i - 3, i - 3]
        x[i], x[i - 1], x[i - 2], x[i - 3] = a, b, c, d
        for j in range(i - 3):
            x[j] -= a * L[i, j] + b * L[i - 1, j] + c * L[i - 2, j] + d * L[i - 3, j]
        i -= 4
    while i >= 0:
        x[i] *= L[i, i]
        for j in range(i):
            x[j] -= L[i, j] * x[i]
        i -= 1


@jit_inner_fused
def append(of: Rows, work: Work, k: int, row: int) -> bool:
    """Extend the factors of k rows by `row`; return False if it depends on the others."""
    rows = len(of.lower) // len(of.R)
    block, r = row // rows, row % rows
    n = of.width[block]
    for j in range(n):
        work.A[k, j] = work.V[k, j] = of.R[block, j, r]
    backward(work.L, work.V[k], n)
    work.held[k], work.width[k] = row, n
    return extend(work, k)


@jit_inner_fused
def extend(work: Work, k: int) -> bool:
    """Write row k of F; return False if it depends on the others, with room for no more than `DEPENDENT`."""
    V, F, n = work.V, work.F, work.width[k]
    for c in range(k):
        F[k, c] = (dot(V[k], V[c], min(n, work.width[c])) - dot(F[k], F[c], c)) * F[c, c]
    whole = dot(V[k], V[k], n)
    rest = whole - dot(F[k], F[k], k)
    if k >= len(work.L) or not rest > DEPENDENT * whole:
        return False
    F[k, k] = 1.0 / np.sqrt(rest)
    return True


@jit_inner_fused
def drop(work: Work, k: int, a: int) -> int:
    """Remove the a-th row of k from the working set; return how many are left."""
    for c in range(a, k - 1):
        work.held[c], work.width[c] = work.held[c + 1], work.width[c + 1]
        for j in range(work.width[c]):
            work.A[c, j], work.V[c, j] = work.A[c + 1, j], work.V[c + 1, j]
    for c in range(a, k - 1):
        extend(work, c)
    return k - 1


@jit_inner_fused
def move(work: Work, y: Vec, a: int, change: float) -> None:
    """Change the multiplier of the a-th row of the working set."""
    y[work.held[a]] += change
    for j in range(work.width[a]):
        work.t[j] -= change * work.V[a, j]


@jit_inner_fused
def paid(of: Rows, state: Ints, y: Vec, out: Vec) -> None:
    """Take what violated rows pull, y_i a_i, off from `out` (n,)."""
    rows = len(of.lower) // len(of.R)
    for i in range(len(state)):
        if abs(state[i]) == 2:
            block, r = i // rows, i % rows
            for j in range(of.width[block]):
                out[j] -= y[i] * of.R[block, j, r]
