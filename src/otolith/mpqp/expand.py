"""Grow the set of regions: cross every facet of a region and enter the active set beyond it in the table.

The notation is that of `region`. Crossing a facet of constraint i removes i from the active set if it was
active, else adds it. If the enlarged set is dependent, an active row with a positive coefficient in M_i = Σ
x_a M_a must leave instead; if there is none, the far side is infeasible (Farkas). A test at a point STEP
beyond the facet's centre shows which candidate is the neighbour; if none is, the QP is solved there. All
candidates are entered, since one facet may have several neighbours.

What is found about a set depends on that set alone. So sets may be examined in any order and by several
threads: each enters the sets that it meets in a table of its own, and `merge` enters those in the common one.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.jit import jit_inner, jit_unlocked
from otolith.mpqp.dualqp import (
    FAILED,
    cholesky,
    optimality,
    right_hand_side,
    solve_qp,
    substitute,
    tie,
    untie,
)
from otolith.mpqp.region import (
    SEEN,
    Form,
    Work,
    facet_test,
    facet_threshold,
    halfspaces,
    inside_domain,
    keep_basis,
    multiplier_rows,
    position_of,
    start_ball,
    survey,
)
from otolith.mpqp.sets import SetTable, Words, insert, insert_key, unpack
from otolith.mpqp.simplex import solve

STEP = 1e-6  # distance of the test point beyond a facet, in the unit box
INSIDE = 1e-12  # largest violation at which a candidate set is optimal at that point
NOWHERE, UNKNOWN = -2, -3  # what lies beyond a facet: infeasible; not found


Ints32 = NDArray[np.int32]
Ints16 = NDArray[np.int16]
Rows32 = NDArray[np.float32]


class Found(NamedTuple):
    """Regions and their facets as they are found."""

    owner: Ints32  # (capacity,) int32 index of the active set
    centre: Mat  # (capacity, p)
    radius: Vec  # (capacity,)
    start: Ints32  # (capacity + 1,) first facet of each region
    constraint: Ints16  # (facet capacity,) int16
    beyond: Ints32  # (facet capacity,) int32 code of the set beyond, NOWHERE or UNKNOWN
    used: Ints  # (3,) regions, facets, sets examined


def found_memory(p: int, regions: int, facets: int) -> Found:
    """Allocate memory without entries."""
    return Found(
        np.zeros(regions, dtype=np.int32), np.zeros((regions, p)), np.zeros(regions),
        np.zeros(regions + 1, dtype=np.int32), np.zeros(facets, dtype=np.int16),
        np.zeros(facets, dtype=np.int32), np.zeros(3, dtype=np.int64),
    )  # fmt: skip


@jit_inner
def optimal_at(form: Form, work: Work, k: int) -> bool:
    """True when the rows near[:k] are the optimal active set at the point whose d(τ) is in dv."""
    if k > form.n or not cholesky(form.Q, work.near, 0, k, work.L):
        return False
    if optimality(form.Q, work.dv, work.near, k, work.L, work.lam, work.slack) > INSIDE:
        return False
    for a in range(k):
        work.slack[work.near[a]] = 1.0
    return tie(form.Q, form.delta, work.near, k, work.L, work.slack, work.x) < 0


@jit_inner
def copy_without(work: Work, k: int, left_out: int, added: int) -> int:
    """Set near to A[:k] without the position `left_out` and with the row `added` (-1 for none); return
    its size.
    """
    size = 0
    for a in range(k):
        if a != left_out:
            work.near[size] = work.A[a]
            size += 1
    if added >= 0:
        work.near[size] = added
        size += 1
    return size


@jit_inner
def choices(form: Form, work: Work, k: int, i: int) -> int:
    """Store in work.leave the positions of A that may leave when row i becomes active; 0 if infeasible
    beyond.

    The position -1 stands for none: row i is simply added. The result is the number of positions.
    """
    copy_without(work, k, -1, i)
    work.leave[0] = -1
    if k < form.n and cholesky(form.Q, work.near, 0, k + 1, work.L):
        return 1
    for a in range(k):
        work.x[a] = form.Q[work.A[a], i]
    cholesky(form.Q, work.A, 0, k, work.L)
    substitute(work.L, k, work.x)
    count = 0
    for a in range(k):
        if work.x[a] > 1e-9:
            work.leave[count] = a
            count += 1
    return count


@jit_inner
def untied(form: Form, work: Work, table: SetTable, k: int) -> bool:
    """True when A[:k], whose region is in work, is free of ties; otherwise the sets tied with it are
    entered.
    """
    i = tie(form.Q, form.delta, work.A, k, work.L, work.slack, work.x)
    if i < 0:
        return True
    for a in range(k):
        if work.x[a] > 1e-9:
            insert(table, work.near, copy_without(work, k, a, i))
    return False


@jit_inner
def solved(form: Form, work: Work, table: SetTable) -> int:
    """Solve the QP at work.tau; enter its active set and return the code, or NOWHERE, or UNKNOWN."""
    for c in range(work.tau.shape[0]):
        work.tau[c] = min(max(work.tau[c], -1.0), 1.0)
    if not inside_domain(form.fixed, work.tau):
        return NOWHERE
    right_hand_side(form.d, work.tau, work.dv)
    Q, A, L = form.Q, work.near, work.L
    k = solve_qp(Q, work.dv, form.n, A, work.lam, L, work.x, work.slack, form.grain)
    if k < 0:
        return UNKNOWN if k == FAILED else NOWHERE
    k = untie(Q, form.delta, work.dv, A, k, L, work.lam, work.slack, work.x)
    return insert(table, A, k)


@jit_inner
def cross(form: Form, work: Work, table: SetTable, k: int, j: int) -> int:
    """Return the code of the set beyond facet j, whose centre is in lp.y; all candidates are entered."""
    lp, i = work.lp, work.ids[j]
    for c in range(work.tau.shape[0]):
        work.tau[c] = lp.y[c] + STEP * lp.A[c, j]
    right_hand_side(form.d, work.tau, work.dv)
    position = position_of(work.A, k, i)
    added, count = -1, 1
    work.leave[0] = position
    if position < 0:
        added, count = i, choices(form, work, k, i)
        if count == 0:
            return NOWHERE
    beyond = UNKNOWN
    for t in range(count):
        size = copy_without(work, k, work.leave[t], added)
        code = insert(table, work.near, size)
        if beyond == UNKNOWN and optimal_at(form, work, size):
            beyond = code
    return solved(form, work, table) if beyond == UNKNOWN else beyond


@jit_inner
def record_facet(work: Work, found: Found, j: int, code: int) -> None:
    """Append facet j and what lies beyond it."""
    f = found.used[1]
    found.constraint[f] = work.ids[j]
    found.beyond[f] = code
    found.used[1] = f + 1


@jit_inner
def has_room(table: SetTable, found: Found, rows: int, n: int) -> bool:
    """True when there is room for one more region with all its facets and all sets beyond them."""
    sets = table.used[0] + rows * (n + 2) <= table.keys.shape[0]
    regions = found.used[0] + 1 < found.radius.shape[0]
    facets = found.used[1] + rows <= found.beyond.shape[0]
    return bool(sets and regions and facets)


@jit_unlocked
def expand_many(form: Form, work: Work, keys: Words, table: SetTable, found: Found, tolerance: float) -> None:
    """Examine the sets `keys` (N, words) while there is room; found.used[2] counts those that are done.

    A set that is a region is recorded, and all sets beyond its facets are entered in `table`.
    """
    lp = work.lp
    while found.used[2] < keys.shape[0] and has_room(table, found, work.ids.shape[0], form.n):
        index = found.used[2]
        found.used[2] += 1
        k = unpack(keys, index, work.A)
        M = halfspaces(form, work, k)
        if M < 0:
            continue
        start_ball(work, M)
        r = solve(lp, M, -1, tolerance)
        if r < tolerance or not untied(form, work, table, k):
            continue
        region = found.used[0]
        centre = found.centre[region]
        for c in range(centre.shape[0]):
            centre[c] = lp.y[c]
        found.owner[region], found.radius[region] = index, r
        keep_basis(work)
        survey(work, M, r)
        threshold = facet_threshold(r)
        for j in range(form.fixed.shape[1], M):
            place = facet_test(work, M, j, centre, r)
            if place == SEEN or (place >= 0 and solve(lp, M, place, threshold) >= threshold):
                record_facet(work, found, j, cross(form, work, table, k, j))
        found.used[0] = region + 1
        found.start[region + 1] = found.used[1]


@jit_unlocked
def seed_many(form: Form, work: Work, table: SetTable, points: Mat) -> None:
    """Solve the QP at τ (N, p) and enter the optimal sets."""
    for t in range(points.shape[0]):
        for c in range(points.shape[1]):
            work.tau[c] = points[t, c]
        solved(form, work, table)


@jit_unlocked
def merge(table: SetTable, keys: Words, place: Ints32, beyond: Ints32) -> None:
    """Enter a thread's sets `keys` (N, words) in the common table, and convert its codes in `beyond`.

    `place` (N,) is working memory. The caller provides room.
    """
    for i in range(keys.shape[0]):
        for w in range(keys.shape[1]):
            table.key[0, w] = keys[i, w]
        place[i] = insert_key(table)
    for f in range(beyond.shape[0]):
        if beyond[f] >= 0:
            beyond[f] = 2 * place[beyond[f] >> 1] + (beyond[f] & 1)


@jit_unlocked
def write_rows(form: Form, work: Work, keys: Words, start: Ints32, constraint: Ints16, rows: Rows32) -> None:
    """Compute the half-spaces a'τ ≤ b of the facets of regions `keys` (N, words): rows (facets, p + 1).

    Facets start[s] to start[s + 1] belong to region s.
    """
    Q, d, p, row = form.Q, form.d, form.d.shape[0] - 1, work.lp.step
    for s in range(keys.shape[0]):
        k = unpack(keys, s, work.A)
        multiplier_rows(form, work, k)
        for f in range(start[s], start[s + 1]):
            i = constraint[f]
            a = position_of(work.A, k, i)
            length = 0.0
            for c in range(p + 1):
                v = -work.T[a, c] if a >= 0 else d[c, i]
                for e in range(k if a < 0 else 0):
                    v -= Q[work.A[e], i] * work.T[e, c]
                row[c] = v
                length += v * v if c < p else 0.0
            length = np.sqrt(length)
            for c in range(p + 1):
                rows[f, c] = (row[c] if c == p else -row[c]) / length
