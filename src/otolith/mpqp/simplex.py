"""Find the largest ball in a polytope, or in one of its facets: dual simplex steps, each with a certificate.

Notation: max r subject to a_j·x + ν_j r ≤ b_j for j < M, one row optionally an equality (`fixed`). The dual
is min b'λ subject to Σ λ_j a_j = 0, Σ ν_j λ_j = 1, λ ≥ 0 except for the fixed row. A basis contains q = p + 1
rows; Binv inverts the matrix with columns (a_j, ν_j). The objective of every iterate bounds r from above, so
stopping below a threshold *proves* that the ball is smaller; an optimal end provides the ball. Columns of A
are the rows a_j, so pricing runs along contiguous memory.

Pitfall: a pivot of 1e-10 gives false emptiness. So the largest pivot among near ties is chosen (Harris), and
no bound is accepted before the residual of Σ λ_j a_j = 0, Σ ν_j λ_j = 1 is known to be small.
"""

from typing import NamedTuple

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.jit import jit_inner

RESIDUAL = 1e-11  # largest residual at which an iterate is accepted
PRICE, PRICE_LATE = (
    1e-12,
    1e-10,
)  # violation at which a row enters; the second value applies after many pivots
PIVOT = 1e-9  # smallest pivot
BLAND_AFTER = 60  # number of pivots after which the first violated row enters instead of the worst
PIVOT_LIMIT = 400
UNDECIDED = -5.0  # below any possible bound: every radius is at least -1


class Program(NamedTuple):
    """Rows and working memory of one linear program; q = p + 1."""

    A: Mat  # (p, cap)
    b: Vec  # (cap,)
    nu: Vec  # (cap,)
    price: Vec  # (cap,)
    Binv: Mat  # (q, q)
    basis: Ints  # (q,)
    lam: Vec  # (q,)
    y: Vec  # (q,) the point x and the radius r
    matrix: Mat  # (q, q) scratch
    step: Vec  # (q,) scratch


def program(p: int, capacity: int) -> Program:
    """Allocate memory for `capacity` rows in p dimensions."""
    q = p + 1
    return Program(
        np.zeros((p, capacity)), np.zeros(capacity), np.ones(capacity), np.zeros(capacity), np.zeros((q, q)),
        np.zeros(q, dtype=np.int64), np.zeros(q), np.zeros(q), np.zeros((q, q)), np.zeros(q),
    )  # fmt: skip


@jit_inner
def invert(B: Mat, X: Mat) -> None:
    """Write the inverse of B to X (Gauss-Jordan, partial pivoting); B is destroyed."""
    q = B.shape[0]
    for i in range(q):
        for k in range(q):
            X[i, k] = 1.0 if i == k else 0.0
    for c in range(q):
        best = c
        for i in range(c + 1, q):
            if abs(B[i, c]) > abs(B[best, c]):
                best = i
        if best != c:
            for k in range(q):
                B[c, k], B[best, k] = B[best, k], B[c, k]
                X[c, k], X[best, k] = X[best, k], X[c, k]
        pivot = B[c, c] if abs(B[c, c]) > 1e-14 else 1e-14
        for k in range(q):
            B[c, k] /= pivot
            X[c, k] /= pivot
        for i in range(q):
            f = B[i, c]
            if i != c and f != 0.0:
                for k in range(q):
                    B[i, k] -= f * B[c, k]
                    X[i, k] -= f * X[c, k]


@jit_inner
def factorise(lp: Program, place: int) -> None:
    """Compute Binv and λ from the basis; only the multiplier at `place` may be negative."""
    q = lp.lam.shape[0]
    p = q - 1
    for k in range(q):
        j = lp.basis[k]
        for i in range(p):
            lp.matrix[i, k] = lp.A[i, j]
        lp.matrix[p, k] = lp.nu[j]
    invert(lp.matrix, lp.Binv)
    for i in range(q):
        lp.lam[i] = lp.Binv[i, p] if i == place else max(lp.Binv[i, p], 0.0)


@jit_inner
def dual_residual(lp: Program) -> float:
    """Largest violation of Σ λ_j a_j = 0, Σ ν_j λ_j = 1."""
    q = lp.lam.shape[0]
    p = q - 1
    worst, total = 0.0, -1.0
    for i in range(q):
        total += lp.nu[lp.basis[i]] * lp.lam[i]
    for k in range(p):
        s = 0.0
        for i in range(q):
            s += lp.A[k, lp.basis[i]] * lp.lam[i]
        worst = max(worst, abs(s))
    return max(worst, abs(total))


@jit_inner
def point(lp: Program) -> float:
    """Compute y = (x, r) of the basis; return r."""
    q = lp.lam.shape[0]
    for k in range(q):
        s = 0.0
        for i in range(q):
            s += lp.b[lp.basis[i]] * lp.Binv[i, k]
        lp.y[k] = s
    return float(lp.y[q - 1])


@jit_inner
def slacks(lp: Program, M: int) -> None:
    """Compute price_j = b_j - a_j·x - ν_j r for j < M."""
    p = lp.A.shape[0]
    r = lp.y[p]
    for j in range(M):
        lp.price[j] = lp.b[j] - lp.nu[j] * r
    for k in range(p):
        x = lp.y[k]
        for j in range(M):
            lp.price[j] -= x * lp.A[k, j]


@jit_inner
def lowest(x: Vec, size: int) -> float:
    """Return the smallest of x[:size]; eight lanes, which the processor compares at once."""
    a = b = c = d = e = f = g = h = 1e300
    whole = size - size % 8
    for i in range(0, whole, 8):
        a, b, c, d = min(a, x[i]), min(b, x[i + 1]), min(c, x[i + 2]), min(d, x[i + 3])
        e, f, g, h = min(e, x[i + 4]), min(f, x[i + 5]), min(g, x[i + 6]), min(h, x[i + 7])
    for i in range(whole, size):
        a = min(a, x[i])
    return min(min(min(a, b), min(c, d)), min(min(e, f), min(g, h)))


@jit_inner
def entering(price: Vec, M: int, fixed: int, bland: bool) -> int:
    """Return the row that enters, or -1 when none is violated."""
    own = price[fixed]
    if fixed >= 0:
        price[fixed] = 0.0
    worst = lowest(price, M)
    chosen = -1
    if worst < (-PRICE_LATE if bland else -PRICE):
        chosen = 0
        while price[chosen] > (-PRICE_LATE if bland else worst):
            chosen += 1
    if fixed >= 0:
        price[fixed] = own
    return chosen


@jit_inner
def direction(lp: Program, j: int) -> None:
    """Compute step = Binv (a_j, ν_j)."""
    q = lp.lam.shape[0]
    p = q - 1
    for i in range(q):
        s = lp.Binv[i, p] * lp.nu[j]
        for k in range(p):
            s += lp.Binv[i, k] * lp.A[k, j]
        lp.step[i] = s


@jit_inner
def leaving(lp: Program, sign: float, place: int) -> int:
    """Return the position that leaves as the entering multiplier moves along `sign`; -1 when nothing
    blocks.
    """
    limit, chosen, largest = 1e300, -1, 0.0
    for i in range(lp.lam.shape[0]):
        s = sign * lp.step[i]
        if i != place and s > PIVOT:
            limit = min(limit, (lp.lam[i] + PRICE_LATE) / s)
    for i in range(lp.lam.shape[0]):
        s = sign * lp.step[i]
        if i != place and s > max(PIVOT, largest) and lp.lam[i] <= limit * s:
            chosen, largest = i, s
    return chosen


@jit_inner
def pivot(lp: Program, leave: int, enter: int, place: int) -> None:
    """Exchange the basic row at position `leave` for row `enter`."""
    q = lp.lam.shape[0]
    theta = lp.lam[leave] / lp.step[leave]
    for i in range(q):
        lp.lam[i] -= theta * lp.step[i]
        if i != place and lp.lam[i] < 0.0:
            lp.lam[i] = 0.0
    lp.lam[leave] = theta
    scale = 1.0 / lp.step[leave]
    for k in range(q):
        lp.Binv[leave, k] *= scale
    for i in range(q):
        f = lp.step[i]
        if i != leave and f != 0.0:
            for k in range(q):
                lp.Binv[i, k] -= f * lp.Binv[leave, k]
    lp.basis[leave] = enter


@jit_inner
def trusted(lp: Program, optimal: bool) -> bool:
    """True when the point (at an optimum) or the multipliers (below a threshold) are accurate."""
    if not optimal:
        return dual_residual(lp) <= RESIDUAL
    worst = 0.0
    for i in range(lp.lam.shape[0]):
        worst = max(worst, abs(lp.price[lp.basis[i]]))
    return worst <= RESIDUAL


@jit_inner
def solve(lp: Program, M: int, place: int, stop: float) -> float:
    """Run from the current feasible basis; return r, or any proven bound on r below `stop`.

    `place` is the basis position of the fixed row, -1 without one. At an optimum y contains the centre.
    Returns UNDECIDED when the limit on pivots is reached.
    """
    fixed = lp.basis[place] if place >= 0 else -1
    fresh = 0  # pivots since the last factorisation
    for turn in range(PIVOT_LIMIT):
        r = point(lp)
        enter = -1
        if r >= stop:
            slacks(lp, M)
            enter = entering(lp.price, M, fixed, turn > BLAND_AFTER)
        if enter < 0 or fresh >= 12:
            if fresh > 0 and not trusted(lp, r >= stop and enter < 0):
                factorise(lp, place)
                fresh = 0
                continue
            if enter < 0:
                return r
            fresh = 1
        direction(lp, enter)
        leave = leaving(lp, 1.0, place)
        if leave < 0:
            if fresh == 0:  # numerically optimal, or no further progress
                return r if lp.price[enter] > -10.0 * PRICE_LATE else UNDECIDED
            factorise(lp, place)
            fresh = 0
            continue
        pivot(lp, leave, enter, place)
        fresh += 1
    return UNDECIDED
