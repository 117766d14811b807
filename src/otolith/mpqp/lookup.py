"""Find the region of a parameter and prove it, in compiled code.

The notation is that of `leastdistance`. Of a centrally symmetric law only one region of each mirror pair is
stored: h stored regions, the first `alone` of which are their own images. Region id r ≥ h is the image of the
stored region r - (h - alone), which is evaluated at -τ.

A walk starts at some region and crosses the facet that the point violates most. Its rows are rounded to 32
bits, so its end is a guess. The guess is accepted only if the optimality conditions of the QP hold in 64 bits
with that region's active set. Otherwise the QP itself is solved and its active set looked up. An answer is
therefore correct even where the table has a hole.
"""

from typing import NamedTuple

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.jit import jit_allocating, jit_entry, jit_inlined, jit_inner
from otolith.core.methods import array_at, pointer
from otolith.mpqp.dualqp import (
    INFEASIBLE,
    cholesky,
    right_hand_side,
    solve_qp,
    substitute,
    untie,
    violated,
)
from otolith.mpqp.expand import Rows32
from otolith.mpqp.packed import Tables, opened
from otolith.mpqp.region import inside_domain
from otolith.mpqp.sets import fold, seek, unpack

MISSED, OUTSIDE, UNSOLVED = -1, -2, -3
"""Region ids: feasible but not in the table; infeasible or outside the box; the QP did not converge."""

ROUNDED = 1e-6  # largest violation of a 32-bit row at which a walk stops
OPTIMAL = 2e-13  # largest violation of the optimality conditions at which a guess is accepted
NEARLY = 1e-12  # the same for the best region of a table without the QP as a fallback
WALK_LIMIT = 40


class Scratch(NamedTuple):
    """Working memory of one lookup."""

    tau: Vec  # (p,)
    image: Vec  # (p,)
    dv: Vec  # (m,)
    slack: Vec  # (m,)
    A: Ints  # (m + 1,)
    lam: Vec  # (n + 2,)
    x: Vec  # (n + 2,)
    L: Mat  # (n + 2, n + 2)


class Answers(NamedTuple):
    """Where a lookup writes its answers, one after the other, in two flat arrays."""

    reals: Vec  # (N · 2n,)
    ints: Ints  # (N · (n + 2),)
    n: int

    @property
    def z(self) -> Mat:
        """Minimisers (N, n), NaN where there is no answer."""
        return self.reals.reshape(-1, 2 * self.n)[:, : self.n]

    @property
    def lam(self) -> Mat:
        """Multipliers (N, n) of the active rows."""
        return self.reals.reshape(-1, 2 * self.n)[:, self.n :]

    @property
    def region(self) -> Ints:
        """Region ids (N,)."""
        return self.ints[:: self.n + 2]

    @property
    def size(self) -> Ints:
        """Number of active rows (N,); -1 where there is no answer."""
        return self.ints[1 :: self.n + 2]

    @property
    def A(self) -> Ints:
        """Active rows (N, n)."""
        return self.ints.reshape(-1, self.n + 2)[:, 2:]


def answers(count: int, n: int) -> Answers:
    """Allocate memory for `count` answers."""
    return Answers(np.empty(count * 2 * n), np.empty(count * (n + 2), dtype=np.int64), n)


@jit_allocating
def scratch(block: Ints, tables: Tables) -> Scratch:
    """Return the working memory behind a block."""
    m, n, p = tables.form.d.shape[1], tables.form.n + 2, tables.centre.shape[0]
    return Scratch(
        array_at(pointer(block, 18), p, np.float64), array_at(pointer(block, 19), p, np.float64),
        array_at(pointer(block, 20), m, np.float64), array_at(pointer(block, 21), m, np.float64),
        array_at(pointer(block, 26), m + 1, np.int64), array_at(pointer(block, 22), n, np.float64),
        array_at(pointer(block, 23), n, np.float64), array_at(pointer(block, 24), (n, n), np.float64),
    )  # fmt: skip


@jit_inlined
def twin(tables: Tables, r: int) -> int:
    """Return the id of a region's mirror image."""
    h = tables.start.shape[0] - 1
    if r < tables.alone:
        return r
    return int(r + h - tables.alone if r < h else r - (h - tables.alone))


@jit_inlined
def orient(tables: Tables, r: int, tau: Vec, image: Vec) -> int:
    """Return the stored region behind region r; `image` is set to τ, or to -τ for a mirror image."""
    h = tables.start.shape[0] - 1
    sign = 1.0 if r < h else -1.0
    for c in range(tau.shape[0]):
        image[c] = sign * tau[c]
    return r if r < h else r - (h - tables.alone)


@jit_inner
def worst_facet(rows: Rows32, first: int, last: int, tau: Vec) -> int:
    """Return the one of the facets first, ..., last - 1 that τ violates most, or -1 when it violates none.

    It is called at every step of a walk, so it takes no more than it needs: a kernel passes every array of a
    tuple with all its sizes.
    """
    p = tau.shape[0]
    chosen, worst = -1, ROUNDED
    for f in range(first, last):
        v = -float(rows[f, p])
        for c in range(p):
            v += rows[f, c] * tau[c]
        if v > worst:
            chosen, worst = f, v
    return chosen


@jit_inlined
def walk(tables: Tables, tau: Vec, image: Vec, r: int) -> int:
    """Walk from region r towards τ; return the final region, or MISSED. `image` is working memory."""
    h = tables.start.shape[0] - 1
    for _ in range(WALK_LIMIT):
        s = orient(tables, r, tau, image)
        f = worst_facet(tables.rows, tables.start[s], tables.start[s + 1], image)
        if f < 0:
            return r
        beyond = tables.beyond[f]
        if beyond < 0:
            return MISSED
        r = int(beyond) if r < h else twin(tables, beyond)
    return MISSED


@jit_inner
def learn(tables: Tables, s: int, place: int, k: int, w: Scratch) -> None:
    """Compute T = Q_AA⁻¹ d_A of stored region s, whose rows are w.A[:k], and keep it."""
    tables.owner[place] = ~s
    if cholesky(tables.form.Q, w.A, 0, k, w.L):
        tables.owner[place] = s
        for c in range(tables.T.shape[2]):
            for a in range(k):
                w.x[a] = tables.form.d[c, w.A[a]]
            substitute(w.L, k, w.x)
            for a in range(k):
                tables.T[place, a, c] = w.x[a]


@jit_inlined
def certify(tables: Tables, r: int, w: Scratch) -> tuple[int, float]:
    """Return the number of active rows of region r and the violation of optimality at w.tau; fill w.A and
    w.lam.

    T of the regions that were looked at last is kept. It is the same whenever it is computed.
    """
    s, p = orient(tables, r, w.tau, w.image), w.tau.shape[0]
    k, place = unpack(tables.sets.keys, s, w.A), s % tables.owner.shape[0]
    if tables.owner[place] != s and tables.owner[place] != ~s:
        learn(tables, s, place, k, w)
    if tables.owner[place] == ~s:
        return k, np.inf
    for a in range(k):
        t = tables.T[place, a, p]
        for c in range(p):
            t += tables.T[place, a, c] * w.image[c]
        w.lam[a] = -t
    right_hand_side(tables.form.d, w.image, w.dv)
    violation = violated(tables.form.Q, w.dv, w.A, k, w.lam, w.slack)
    if s != r:
        for a in range(k):
            w.A[a] = tables.sets.mirror[w.A[a]]
    return k, violation


@jit_inner
def by_qp(tables: Tables, w: Scratch) -> tuple[int, int]:
    """Solve the QP at w.tau; return the region (or MISSED, OUTSIDE, UNSOLVED) and the number of active
    rows.
    """
    form = tables.form
    right_hand_side(form.d, w.tau, w.dv)
    k = solve_qp(form.Q, w.dv, form.n, w.A, w.lam, w.L, w.x, w.slack, form.grain)
    if k < 0:
        return (OUTSIDE if k == INFEASIBLE else UNSOLVED), -1
    k = untie(form.Q, form.delta, w.dv, w.A, k, w.L, w.lam, w.slack, w.x)
    image = fold(tables.sets, w.A, k)
    s = tables.sets.slots[seek(tables.sets)]
    if s < 0:
        return MISSED, k
    return (twin(tables, s) if image else int(s)), k


@jit_inlined
def scale(tables: Tables, theta: Vec, tau: Vec) -> bool:
    """Convert θ to τ; return false when a number is not finite."""
    finite = True
    for c in range(tau.shape[0]):
        tau[c] = (theta[c] - tables.centre[c]) / tables.half[c]
        finite = finite and np.isfinite(tau[c])
    return bool(finite)


@jit_inlined
def minimiser(tables: Tables, w: Scratch, k: int, z: Vec) -> None:
    """Compute the first components of the minimiser at w.tau, as many as z has, with w.A[:k] active."""
    n, p = z.shape[0], w.tau.shape[0]
    for i in range(n):
        s = tables.Z[i, p]
        for c in range(p):
            s += tables.Z[i, c] * w.tau[c]
        z[i] = s
    for a in range(k):
        t, j = w.lam[a], w.A[a]
        for i in range(n):
            z[i] -= t * tables.V[j, i]


@jit_inlined
def write(tables: Tables, w: Scratch, r: int, k: int, reals: Vec, ints: Ints) -> None:
    """Write the answer at one parameter: the first components of z alone if `ints` has no room, else all."""
    n = tables.Z.shape[0] if ints.shape[0] else reals.shape[0]
    if k < 0:
        for i in range(n):
            reals[i] = np.nan
    else:
        minimiser(tables, w, k, reals[:n])
    if ints.shape[0]:
        ints[0], ints[1] = r, k
        for a in range(k):
            ints[2 + a], reals[n + a] = tables.names[w.A[a]], tables.weights[w.A[a]] * w.lam[a]


@jit_inlined
def answer(tables: Tables, theta: Vec, guess: int, w: Scratch) -> tuple[int, int]:
    """Return the region (or MISSED, OUTSIDE, UNSOLVED) at θ and the number of its active rows, in w.A."""
    if not scale(tables, theta, w.tau) or not inside_domain(tables.form.fixed, w.tau):
        return OUTSIDE, -1
    r = walk(tables, w.tau, w.image, guess) if guess >= 0 else MISSED
    if r >= 0:
        k, violation = certify(tables, r, w)
        if violation <= OPTIMAL:
            return r, k
    return by_qp(tables, w)


@jit_inner
def answer_each(tables: Tables, thetas: Vec, guess: int, reals: Vec, ints: Ints, w: Scratch) -> int:
    """The loop of `evaluate`, a separate function because numba does not count array references in it."""
    p = tables.centre.shape[0]
    count, r = thetas.shape[0] // p, MISSED
    for t in range(count):
        r, k = answer(tables, thetas[t * p : (t + 1) * p], guess, w)
        real, whole = reals.shape[0] // count, ints.shape[0] // count
        write(tables, w, r, k, reals[t * real : (t + 1) * real], ints[t * whole : (t + 1) * whole])
        guess = r if r >= 0 else guess
    return r


@jit_entry
def evaluate(block: Ints, thetas: Vec, guess: int, reals: Vec, ints: Ints) -> int:
    """Answer at parameters θ (N · p,); each walk starts at the previous region, the first one at `guess`.

    `reals` and `ints` are those of `Answers`. If `ints` is empty, only the first len(reals)/N components of
    the minimisers are computed. The region of the last parameter is returned.
    """
    tables = opened(block)
    return answer_each(tables, thetas, guess, reals, ints, scratch(block, tables))


@jit_inner
def contains(tables: Tables, r: int, tau: Vec, margin: float) -> bool:
    """True when τ satisfies the stored rows of region r, each tightened by `margin`."""
    p, h = tau.shape[0], tables.start.shape[0] - 1
    sign = 1.0 if r < h else -1.0
    s = r if r < h else r - (h - tables.alone)
    for f in range(tables.start[s], tables.start[s + 1]):
        v = margin - tables.rows[f, p]
        for c in range(p):
            v += tables.rows[f, c] * sign * tau[c]
        if v > 0.0:
            return False
    return True


@jit_inner
def scan(tables: Tables, tau: Vec, margin: float, hits: Ints) -> int:
    """Count the regions whose rows contain τ with `margin`; store the first of them in `hits`."""
    h = tables.start.shape[0] - 1
    count = 0
    for r in range(2 * h - tables.alone):
        if contains(tables, r, tau, margin):
            if count < hits.shape[0]:
                hits[count] = r
            count += 1
    return count


@jit_inner
def member(tables: Tables, guess: int, hits: Ints, w: Scratch) -> tuple[int, int]:
    """Find a region whose rows contain w.tau, and its number of active rows; MISSED when the table has none.

    A walk is tried first, then the region that the QP finds, if its rows contain the point. All regions are
    tested only where the QP finds none; where the QP is infeasible no region can be optimal.
    """
    if not inside_domain(tables.form.fixed, w.tau):
        return OUTSIDE, -1
    r = walk(tables, w.tau, w.image, guess)
    if r >= 0:
        k, violation = certify(tables, r, w)
        if violation <= OPTIMAL:
            return r, k
    r, k = by_qp(tables, w)
    if r == OUTSIDE or (r >= 0 and contains(tables, r, w.tau, -ROUNDED)):
        return r, k
    best, least = MISSED, NEARLY
    for c in range(min(scan(tables, w.tau, -ROUNDED, hits), hits.shape[0])):
        k, violation = certify(tables, hits[c], w)
        if violation < least:
            best, least = int(hits[c]), violation
    if best == MISSED:
        return MISSED, -1
    k, violation = certify(tables, best, w)
    return best, k


@jit_entry
def members(block: Ints, thetas: Mat, guess: int, regions: Ints, z: Mat) -> None:
    """Fill regions (N,) and z (N, n) from the table alone: by a walk, else by testing all regions."""
    tables = opened(block)
    w, hits = scratch(block, tables), np.empty(256, np.int64)
    for t in range(thetas.shape[0]):
        r, k = OUTSIDE, -1
        if scale(tables, thetas[t], w.tau):
            r, k = member(tables, guess, hits, w)
        if r >= 0:
            minimiser(tables, w, k, z[t])
            guess = r
        regions[t] = r


@jit_entry
def census(block: Ints, taus: Mat, margin: float, counts: Ints) -> None:
    """Count the regions that contain each τ (N, p) with a distance of at least `margin` from their facets."""
    tables = opened(block)
    none = np.empty(0, np.int64)
    for t in range(taus.shape[0]):
        counts[t] = scan(tables, taus[t], margin, none)
