"""Grow the set of regions: cross every facet of a region and enter the active set beyond it in the table.

The notation is that of `region`. Crossing a facet of constraint i removes i from the active set if it was
active, else adds it. If the enlarged set is dependent, an active row with a positive coefficient in M_i = Σ
x_a M_a must leave instead; if there is none, the far side is infeasible (Farkas). A test at a point STEP
beyond the facet's centre shows which candidate is the neighbour; if none is, the QP is solved there after the
batch. All candidates are entered, since one facet may have several neighbours.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.jit import jit_entry, jit_inner
from otolith.mpqp.dualqp import cholesky, optimality, right_hand_side, substitute, tie
from otolith.mpqp.region import (
    FLAT,
    SEEN,
    TIED,
    Form,
    Work,
    facet_test,
    facet_threshold,
    halfspaces,
    keep_basis,
    position_of,
    start_ball,
    survey,
)
from otolith.mpqp.sets import SetTable, insert, unpack
from otolith.mpqp.simplex import UNDECIDED, solve

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
    start: Ints  # (capacity + 1,) first facet of each region
    rows: Rows32  # (facet capacity, p + 1) float32, a'τ ≤ b
    constraint: Ints16  # (facet capacity,) int16
    beyond: Ints32  # (facet capacity,) int32 code of the set beyond, NOWHERE or UNKNOWN
    point: Mat  # (points capacity, p) τ beyond a facet where the QP is to be solved
    facet: Ints  # (points capacity,) that facet
    used: Ints  # (3,) regions, facets, points


def found_memory(p: int, regions: int, facets: int) -> Found:
    """Allocate memory without entries."""
    return Found(
        np.zeros(regions, dtype=np.int32), np.zeros((regions, p)), np.zeros(regions),
        np.zeros(regions + 1, dtype=np.int64), np.zeros((facets, p + 1), dtype=np.float32),
        np.zeros(facets, dtype=np.int16), np.zeros(facets, dtype=np.int32), np.zeros((facets, p)),
        np.zeros(facets, dtype=np.int64), np.zeros(3, dtype=np.int64),
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
def postpone(work: Work, found: Found) -> int:
    """Record that the QP at work.tau must be solved to find what lies beyond the next facet."""
    t = found.used[2]
    for c in range(work.tau.shape[0]):
        found.point[t, c] = work.tau[c]
    found.facet[t] = found.used[1]
    found.used[2] = t + 1
    return UNKNOWN


@jit_inner
def cross(form: Form, work: Work, table: SetTable, k: int, j: int, found: Found) -> int:
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
    return postpone(work, found) if beyond == UNKNOWN else beyond


@jit_inner
def record_facet(work: Work, found: Found, j: int, code: int) -> None:
    """Append facet j and what lies beyond it."""
    lp, f = work.lp, found.used[1]
    p = lp.A.shape[0]
    for c in range(p):
        found.rows[f, c] = lp.A[c, j]
    found.rows[f, p] = lp.b[j]
    found.constraint[f] = work.ids[j]
    found.beyond[f] = code
    found.used[1] = f + 1


@jit_inner
def has_room(table: SetTable, found: Found, rows: int, n: int) -> bool:
    """True when there is room for one more region with all its facets and all sets beyond them."""
    sets = table.used[0] + rows * (n + 2) <= table.keys.shape[0]
    regions = found.used[0] + 1 < found.radius.shape[0]
    facets = found.used[1] + rows <= found.beyond.shape[0]
    return bool(sets and regions and facets and found.used[2] + rows <= found.facet.shape[0])


@jit_entry
def expand_many(
    form: Form, work: Work, table: SetTable, found: Found, span: Ints, tolerance: float, refused: Ints
) -> None:
    """Examine sets from span[0] up to span[1] while there is room, and advance span[0].

    A set that is a region is recorded, and all sets beyond its facets are entered; `refused` (8,) counts the
    others by reason.
    """
    lp = work.lp
    while span[0] < min(span[1], table.used[0]) and has_room(table, found, work.ids.shape[0], form.n):
        index = span[0]
        span[0] += 1
        k = unpack(table.keys, index, work.A)
        M = halfspaces(form, work, k)
        if M < 0:
            refused[-M] += 1
            continue
        start_ball(work, M)
        r = solve(lp, M, -1, tolerance)
        if r < tolerance:
            refused[-FLAT if r > UNDECIDED else 5] += 1
            continue
        if not untied(form, work, table, k):
            refused[-TIED] += 1
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
                record_facet(work, found, j, cross(form, work, table, k, j, found))
        found.used[0] = region + 1
        found.start[region + 1] = found.used[1]


@jit_entry
def insert_many(table: SetTable, A: Ints, count: Ints, codes: Ints32) -> None:
    """Enter the sets A[t, :count[t]] and store their codes; where the count is negative the code is
    unchanged.
    """
    for t in range(count.shape[0]):
        if count[t] >= 0:
            codes[t] = insert(table, A[t], count[t])
