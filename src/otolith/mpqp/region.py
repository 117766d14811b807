"""One critical region: its half-spaces, its largest ball, its facets.

The notation is that of `leastdistance` and `simplex`. With the rows A[:k] active, T = Q_AA⁻¹ d_A (k, p + 1);
the region is {τ: T τ ≤ 0 in homogeneous form (multipliers), d_i - Q_iA T ≥ 0 (slacks)} within the box and E.
The columns of the linear program are: lower box, one redundant row that closes the start basis, upper box, E,
then constraints (`ids` lists which).

A facet is full-dimensional when it contains a ball of FACET times the region's radius. There are three tests,
in order of cost: a simplex around the region (the optimal basis of the largest ball) that does not reach the
row; a ray from the centre that meets the row well before the others; else a linear program.
"""

from typing import NamedTuple

import numpy as np

from otolith.core.arrays import Bools, Ints, Mat, Vec
from otolith.core.jit import jit_inner
from otolith.mpqp.dualqp import cholesky
from otolith.mpqp.leastdistance import LeastDistance
from otolith.mpqp.simplex import (
    Program,
    direction,
    factorise,
    leaving,
    pivot,
    program,
)

DEPENDENT, WEAK, EMPTY = -1, -2, -3  # why a set is not a region, known before its largest ball is
NULL_ROW = 1e-9  # largest gradient at which a half-space counts as constant
NO_FACET, SEEN = -1, -2
RELAXED = 10.0  # right-hand side that makes a row without effect, once another makes it superfluous
FACET, FACET_LEAST, FACET_MOST = 1e-5, 1e-12, 1e-8
RAY = 0.05  # ball on a facet, relative to the region's, that a ray must leave free
PARALLEL, SAME = (
    1e-9,
    2e-8,
)  # 1 - cosine at which two rows are compared; difference at which they are the same
DOMAIN = 1e-8  # how far outside the box, scaled to [-1, 1]^p, a point may lie
CLEAR = 5e-8  # distance to the simplex that proves a row superfluous; above SAME because of equal rows


class Form(NamedTuple):
    """The least-distance problem in the form that kernels need."""

    Q: Mat  # (m, m)
    d: Mat  # (p + 1, m)
    fixed: Mat  # (p + 1, 2p + 1 + ne) rows of box and E, the right-hand side last
    n: int
    delta: Vec  # (m,) infinitesimal relaxation that decides between tied active sets
    grain: float  # factor by which rounding is coarser than in a well-scaled problem, see `LeastDistance`


class Work(NamedTuple):
    """Working memory for one region; cap is the number of rows of the linear program."""

    lp: Program
    ids: Ints  # (cap,) constraint of each row, -1 for box and E
    L: Mat  # (n + 2, n + 2)
    T: Mat  # (n + 2, p + 1)
    A: Ints  # (m + 1,) active rows
    near: Ints  # (m + 1,) active rows of a neighbour
    leave: Ints  # (n + 2,) positions of A that may leave
    lam: Vec  # (n + 2,)
    x: Vec  # (n + 2,)
    dv: Vec  # (m,)
    slack: Vec  # (m,)
    tau: Vec  # (p,)
    basis: Ints  # (p + 1,) basis of the largest ball
    Binv: Mat  # (p + 1, p + 1) inverse basis of the largest ball
    cosine: Vec  # (cap,)
    gap: Vec  # (cap,) slack of every row at the centre
    reach: Vec  # (cap,) how far a row reaches into the simplex around the region
    dead: Bools  # (cap,)


def kernel_form(form: LeastDistance) -> Form:
    """Convert a least-distance problem to the arrays of the kernels."""
    p = len(form.half)
    box = np.vstack([-np.eye(p), np.full((1, p), p**-0.5), np.eye(p), form.E.T])
    level = np.concatenate([np.ones(p), [p**0.5 + 1.0], np.ones(p), form.e])
    fixed = np.ascontiguousarray(np.column_stack([box, level]).T)
    return Form(np.array(form.Q), np.array(form.d), fixed, form.V.shape[1], _relaxation(form), form.grain)


def _relaxation(form: LeastDistance) -> Vec:
    """Generic numbers in [1, 2], equal for a row and its mirror image."""
    index = np.arange(len(form.rows))
    if len(form.mirror):
        index = np.minimum(index, form.mirror)
    delta: Vec = 1.0 + np.mod((index + 1) * 0.6180339887498949, 1.0)
    return delta


def work_memory(form: Form) -> Work:
    """Allocate memory for regions of this problem and fill in its fixed rows."""
    q, m = form.d.shape
    off, n = form.fixed.shape[1], form.n
    cap = off + m
    lp = program(q - 1, cap)
    lp.A[:, :off] = form.fixed[:-1]
    floats = np.zeros

    def ints(size: int) -> Ints:
        return np.full(size, -1, dtype=np.int64)

    return Work(
        lp, ints(cap), floats((n + 2, n + 2)), floats((n + 2, q)), ints(m + 1), ints(m + 1), ints(n + 2),
        floats(n + 2), floats(n + 2), floats(m), floats(m), floats(q - 1), ints(q), floats((q, q)),
        floats(cap), floats(cap), floats(cap), np.zeros(cap, dtype=np.bool_),
    )  # fmt: skip


@jit_inner
def inside_domain(fixed: Mat, tau: Vec) -> bool:
    """True when τ lies in the box and in E, each widened by DOMAIN."""
    p = tau.shape[0]
    for c in range(p):
        if abs(tau[c]) > 1.0 + DOMAIN:
            return False
    for j in range(2 * p + 1, fixed.shape[1]):
        s = -fixed[p, j] - DOMAIN
        for c in range(p):
            s += fixed[c, j] * tau[c]
        if s > 0.0:
            return False
    return True


@jit_inner
def multiplier_rows(form: Form, work: Work, k: int) -> bool:
    """Compute T = Q_AA⁻¹ d_A; return false when the active rows are dependent."""
    L, T = work.L, work.T
    if not cholesky(form.Q, work.A, 0, k, L):
        return False
    q = form.d.shape[0]
    for a in range(k):
        for c in range(q):
            s = form.d[c, work.A[a]]
            for e in range(a):
                s -= L[a, e] * T[e, c]
            T[a, c] = s * L[a, a]
    for a in range(k - 1, -1, -1):
        for c in range(q):
            s = T[a, c]
            for e in range(a + 1, k):
                s -= L[e, a] * T[e, c]
            T[a, c] = s * L[a, a]
    return True


@jit_inner
def raw_rows(form: Form, work: Work, k: int) -> None:
    """Write the half-spaces a'τ ≤ b of all constraints, not normalised, to columns off + i."""
    m, p = form.d.shape[1], form.d.shape[0] - 1
    off = form.fixed.shape[1]
    for c in range(p + 1):
        sign = 1.0 if c == p else -1.0
        target = work.lp.b if c == p else work.lp.A[c]
        for i in range(m):
            target[off + i] = sign * form.d[c, i]
        for a in range(k):
            t, j = -sign * work.T[a, c], work.A[a]
            for i in range(m):
                target[off + i] += t * form.Q[j, i]
        for a in range(k):
            target[off + work.A[a]] = -sign * work.T[a, c]


@jit_inner
def position_of(A: Ints, k: int, i: int) -> int:
    """Return the position of row i in A[:k], or -1."""
    for a in range(k):
        if A[a] == i:
            return a
    return -1


@jit_inner
def halfspaces(form: Form, work: Work, k: int) -> int:
    """Write the unit half-spaces of the region of rows A[:k] to the linear program.

    work.slack is set to zero for rows that bind throughout without being active, else to one. Returns the
    number of half-spaces with box and E, or DEPENDENT, WEAK (a multiplier is zero throughout: the set without
    it represents the region) or EMPTY (a constant row is violated).
    """
    if not multiplier_rows(form, work, k):
        return DEPENDENT
    raw_rows(form, work, k)
    lp, p, off = work.lp, form.d.shape[0] - 1, form.fixed.shape[1]
    for j in range(off):
        lp.b[j] = form.fixed[p, j]
    M = off
    for j in range(off, off + form.d.shape[1]):
        s = 0.0
        for c in range(p):
            s += lp.A[c, j] * lp.A[c, j]
        s = np.sqrt(s)
        work.slack[j - off] = 1.0
        if s < NULL_ROW:
            if abs(lp.b[j]) < NULL_ROW:
                work.slack[j - off] = 0.0
            if lp.b[j] < -NULL_ROW:
                return EMPTY
            if lp.b[j] < NULL_ROW and position_of(work.A, k, j - off) >= 0:
                return WEAK
            continue
        for c in range(p):
            lp.A[c, M] = lp.A[c, j] / s
        lp.b[M] = lp.b[j] / s
        work.ids[M] = j - off
        M += 1
    return int(M)


@jit_inner
def start_ball(work: Work, M: int) -> None:
    """Set up the linear program of the largest ball in the region; its start basis is the first rows of
    the box.
    """
    lp = work.lp
    for j in range(M):
        lp.nu[j] = 1.0
        work.dead[j] = False
    for i in range(lp.lam.shape[0]):
        lp.basis[i] = i
    factorise(lp, -1)


@jit_inner
def keep_basis(work: Work) -> None:
    """Save the optimal basis of the largest ball, from which all facets start."""
    lp = work.lp
    q = lp.lam.shape[0]
    factorise(lp, -1)
    for i in range(q):
        work.basis[i] = lp.basis[i]
        for k in range(q):
            work.Binv[i, k] = lp.Binv[i, k]


@jit_inner
def survey(work: Work, M: int, r: float) -> None:
    """Compute the slack of every row at the centre, and how far it reaches into the simplex around the
    region.

    The vertex opposite basic row i is x - (r/λ_i) Binv_i; without a positive λ_i it lies at infinity.
    """
    lp = work.lp
    p = lp.A.shape[0]
    lp.y[p] = 0.0
    for j in range(M):
        lp.nu[j] = 1.0
    for j in range(M):
        work.gap[j] = lp.b[j]
        work.reach[j] = -1e300
    for k in range(p):
        for j in range(M):
            work.gap[j] -= lp.y[k] * lp.A[k, j]
    for i in range(p + 1):
        scale = -r / max(work.Binv[i, p], 1e-12)
        for j in range(M):
            work.cosine[j] = 0.0
        for k in range(p):
            t = scale * work.Binv[i, k]
            for j in range(M):
                work.cosine[j] += t * lp.A[k, j]
        for j in range(M):
            work.reach[j] = max(work.reach[j], work.cosine[j])
    for j in range(M):
        work.reach[j] -= work.gap[j]


@jit_inner
def facet_norms(work: Work, M: int, j: int) -> None:
    """Compute ν_i, the length of row i within the hyperplane of row j; row j itself becomes an equality."""
    lp = work.lp
    for i in range(M):
        work.cosine[i] = 0.0
    for k in range(lp.A.shape[0]):
        t = lp.A[k, j]
        for i in range(M):
            work.cosine[i] += t * lp.A[k, i]
    for i in range(M):
        s = work.cosine[i]
        lp.nu[i] = np.sqrt(max(1.0 - s * s, 1e-12 if s > 0.0 else 1e-6))
    lp.nu[j] = 0.0


@jit_inner
def drop_parallel(work: Work, M: int, j: int) -> bool:
    """Relax rows parallel to j that are looser, or equal and later; return true if j itself is such a row.

    Where many rows bind together, rounding separates them by up to 1e-8. Treated as different rows they would
    cut each other off, and none would be a facet.
    """
    lp = work.lp
    for i in range(M):
        if work.cosine[i] < 1.0 - PARALLEL or i == j or work.dead[i]:
            continue
        apart = 0.0
        for k in range(lp.A.shape[0]):
            apart = max(apart, abs(lp.A[k, i] - lp.A[k, j]))
        if apart > SAME:
            continue
        looser = lp.b[i] - lp.b[j]
        loser = i if looser > SAME or (looser > -SAME and i > j) else j
        work.dead[loser] = True
        lp.b[loser] = RELAXED
        work.gap[loser] = RELAXED
        if loser == j:
            return True
    return False


@jit_inner
def ray_ball(work: Work, M: int, j: int) -> float:
    """Radius of the ball on facet j around the centre's projection; negative when the projection is
    outside.
    """
    lp = work.lp
    h = work.gap[j]
    least = 1e300
    for i in range(M):
        if i != j:
            least = min(least, (work.gap[i] - h * work.cosine[i]) / lp.nu[i])
    return least


@jit_inner
def facet_start(work: Work, j: int) -> int:
    """Derive a basis for facet j from that of the largest ball; return the position of row j in it.

    Changing the last row of the basis matrix to the new ν is a rank-one update of its inverse.
    """
    lp = work.lp
    q = lp.lam.shape[0]
    p = q - 1
    for k in range(q):
        s = 0.0
        for i in range(q):
            s += (lp.nu[work.basis[i]] - 1.0) * work.Binv[i, k]
        lp.step[k] = s
    total = 1.0 + lp.step[p]
    place = -1
    for i in range(q):
        f = work.Binv[i, p] / total
        for k in range(q):
            lp.Binv[i, k] = work.Binv[i, k] - f * lp.step[k]
        lp.lam[i] = max(lp.Binv[i, p], 0.0)
        lp.basis[i] = work.basis[i]
        if work.basis[i] == j:
            place = i
    if place < 0:
        direction(lp, j)
        place = leaving(lp, -1.0, -1)
        if place < 0:
            place = leaving(lp, 1.0, -1)
        pivot(lp, place, j, place)
    return place


@jit_inner
def facet_test(work: Work, M: int, j: int, centre: Vec, r: float) -> int:
    """Test facet j: NO_FACET, SEEN with its centre in lp.y, or the start of its linear program (≥ 0)."""
    if work.dead[j] or work.reach[j] < -CLEAR:
        return NO_FACET
    facet_norms(work, M, j)
    if drop_parallel(work, M, j):
        return NO_FACET
    if ray_ball(work, M, j) <= RAY * r:
        return facet_start(work, j)
    for k in range(centre.shape[0]):
        work.lp.y[k] = centre[k] + work.gap[j] * work.lp.A[k, j]
    return SEEN


@jit_inner
def facet_threshold(r: float) -> float:
    """Smallest ball that makes a facet of a region with radius r."""
    return max(FACET_LEAST, min(FACET * r, FACET_MOST))
