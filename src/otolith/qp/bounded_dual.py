"""A dense dual active-set method in which a soft row is a bound on its multiplier; compiled.

The problem is that of `otolith.qp.problem`, with all rows in R. An exact L1 penalty w on a row needs no slack
variable: its multiplier is bounded, |y| ≤ w, and at the bound the row is violated. So the dual is a QP in y
with simple bounds only,

    max_y −½ (g + Rᵀy)ᵀ H⁻¹ (g + Rᵀy) − Σ u y⁺ − l y⁻,    |y| ≤ w,    z = −H⁻¹ (g + Rᵀy),

and has no infeasible problems except through hard rows. Every row has a state σ: 0 free, ±1 held at its upper
or lower side, ±2 saturated (y = ±w). The method is that of Goldfarb and Idnani (1983), extended by the upper
bounds: multipliers move towards those that hold all rows of the working set, until one reaches 0 or ±w and
its row leaves; then the most violated row enters. The dual never falls, so any working set may start.

A row that depends on the working set moves no z. Its multiplier then grows at the cost of the others' until
one of them reaches a bound. If none ever does, no z satisfies the hard rows, up to rounding: the outcome
`IMPOSSIBLE` is a suspicion, not a proof.

Notation: H = Lᵀ L; V rows (L⁻ᵀ a)ᵀ of the working set; V Vᵀ = F Fᵀ, with the diagonals of L and F inverted;
t = −L⁻ᵀ (g + Rᵀy), so that z = L⁻¹ t and a·z = v·t. A multiplier moves t along its row of V. The arithmetic
may be fused: the certificate, elsewhere and strict, judges the answer.
"""

from typing import Final

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.jit import jit_inner, jit_inner_fused, kernel
from otolith.qp.working_set import (
    Rows,
    Work,
    append,
    backward,
    dot,
    drop,
    extend,
    factorise,
    forward,
    move,
    paid,
)

SOLVED, IMPOSSIBLE, GIVEN_UP = range(3)
TINY: Final = 1e-300  # added to sizes, so that none is zero; far below what any row means
REFINEMENTS: Final = 3  # at most, of z and the multipliers at the end …
REFINED: Final = 1e-8  # … until one moves z by less, relative: the next would by its square
VIOLATED: Final = 1e-9  # excess over a bound, relative to its terms as in the certificate, that lets a row in


@jit_inner_fused
def _bound(of: Rows, state: Ints, i: int) -> float:
    """Return the side of row i that is held."""
    side: float = of.upper[i] if state[i] > 0 else of.lower[i]
    return side


@jit_inner
def _room(of: Rows, state: Ints, y: Vec, i: int, change: float) -> float:
    """Return how many times `change` fits into the bounds of y_i; infinite if it leads to none."""
    w = of.penalty[i]
    low, high = (0.0, w) if state[i] > 0 else (-w, 0.0)
    if change == 0.0:
        return np.inf
    room: float = ((high if change > 0.0 else low) - y[i]) / change
    return max(0.0, room)


@jit_inner
def _leave(of: Rows, state: Ints, y: Vec, i: int, change: float) -> None:
    """Set y_i to the bound to which `change` leads, and its row free or saturated."""
    side = 1 if state[i] > 0 else -1
    outwards = change * side > 0.0
    state[i] = 2 * side if outwards else 0
    y[i] = side * of.penalty[i] if outwards else 0.0


@jit_inner_fused
def _pulls(of: Rows, work: Work, state: Ints, k: int) -> None:
    """Write by how much the multipliers of the k rows of the working set must change to hold these rows."""
    for a in range(k):
        work.pull[a] = dot(work.V[a], work.t, work.width[a]) - _bound(of, state, work.held[a])
    forward(work.F, work.pull, k)
    backward(work.F, work.pull, k)


@jit_inner_fused
def _refine(H: Mat, g: Vec, of: Rows, work: Work, state: Ints, y: Vec, z: Vec, k: int) -> float:
    """Correct z and the multipliers of the working set by what rounding left in the optimality conditions.

    With s = −(H z + g + Rᵀ y): z moves by H⁻¹ (s − Aᵀ δ), where S δ = A H⁻¹ s + (A z − b), and A z ≤ b are
    the rows that are held. Returned is the largest move, relative to the largest entry of z.
    """
    n, step = len(g), work.t
    for j in range(n):
        step[j] = -g[j]
    for i in range(n):
        step[i] -= dot(H[i], z, i + 1)
        for j in range(i):
            step[j] -= H[i, j] * z[i]
    paid(of, state, y, step)
    for a in range(k):
        for j in range(work.width[a]):
            step[j] -= y[work.held[a]] * work.A[a, j]
    backward(work.L, step, n)
    for a in range(k):
        gap = dot(work.A[a], z, work.width[a]) - _bound(of, state, work.held[a])
        work.pull[a] = gap + dot(work.V[a], step, work.width[a])
    forward(work.F, work.pull, k)
    backward(work.F, work.pull, k)
    for a in range(k):
        move(work, y, a, work.pull[a])
    forward(work.L, step, n)
    moved, size = 0.0, 0.0
    for j in range(n):
        z[j] += step[j]
        moved, size = max(moved, abs(step[j])), max(size, abs(z[j]))
    return moved / size if moved > 0.0 else 0.0


@jit_inner
def _polish(H: Mat, g: Vec, of: Rows, work: Work, state: Ints, y: Vec, z: Vec, k: int) -> None:
    """Refine z and y until no more is gained."""
    for _ in range(REFINEMENTS):
        if _refine(H, g, of, work, state, y, z, k) < REFINED:
            break
    for a in range(k):  # rounding may have led beyond a bound
        i = work.held[a]
        low, high = (0.0, of.penalty[i]) if state[i] > 0 else (-of.penalty[i], 0.0)
        y[i] = min(high, max(low, y[i]))


@jit_inner
def _settle(of: Rows, work: Work, state: Ints, y: Vec, z: Vec, k: int) -> int:
    """Move the multipliers until all k rows of the working set are held; return how many are left."""
    while True:
        _pulls(of, work, state, k)
        share, blocking = 1.0, -1
        for a in range(k):
            room = _room(of, state, y, work.held[a], work.pull[a])
            if room < share:
                share, blocking = room, a
        for a in range(k):
            move(work, y, a, share * work.pull[a])
        if blocking < 0:
            for j in range(len(z)):
                z[j] = work.t[j]
            forward(work.L, z, len(z))
            return k
        _leave(of, state, y, work.held[blocking], work.pull[blocking])
        k = drop(work, k, blocking)


@jit_inner_fused
def _evaluate(of: Rows, z: Vec, values: Mat) -> None:
    """Write the values (M, ≥ m) of all rows at z, four variables at a time."""
    for block in range(len(values)):
        R, n, into = of.R[block], of.width[block], values[block]
        for r in range(len(into)):
            into[r] = 0.0
        j = 0
        while j + 3 < n:
            a, b, c, d = z[j], z[j + 1], z[j + 2], z[j + 3]
            for r in range(len(into)):
                into[r] += a * R[j, r] + b * R[j + 1, r] + c * R[j + 2, r] + d * R[j + 3, r]
            j += 4
        while j < n:
            a = z[j]
            for r in range(len(into)):
                into[r] += a * R[j, r]
            j += 1


@jit_inner
def _size(of: Rows, block: int, r: int, z: Vec) -> float:
    """Return the sum of the sizes of a row's terms."""
    size = 0.0
    for j in range(of.width[block]):
        size += abs(of.R[block, j, r] * z[j])
    return size


@jit_inner
def _most_violated(of: Rows, work: Work, state: Ints, z: Vec) -> tuple[int, int]:
    """Return the row that is furthest beyond its bound, or −1, and the direction (±1) of its multiplier."""
    worst, chosen, side, rows = VIOLATED, -1, 0, len(of.lower) // len(of.R)
    _evaluate(of, z, work.values)
    for i in range(len(state)):
        if abs(state[i]) == 1:
            continue
        block, r = i // rows, i % rows
        value = work.values[block, r]
        above, below = value - of.upper[i], of.lower[i] - value
        if state[i] == 2:
            above, below = -np.inf, -above  # it returns when it is satisfied
        elif state[i] == -2:
            above, below = -below, -np.inf
        excess = max(above, below)
        if not excess > 0.0:
            continue
        bound = abs(of.upper[i] if (above > below) == (state[i] == 0) else of.lower[i]) + TINY
        if excess <= worst * (abs(value) + bound):  # the sizes of the terms are at least that of their sum
            continue
        excess /= _size(of, block, r, z) + bound
        if excess > worst:
            worst, chosen, side = excess, i, 1 if above > below else -1
    return chosen, side


@jit_inner
def _exchange(of: Rows, work: Work, state: Ints, y: Vec, k: int, side: int) -> int:
    """Move the multiplier of row k, which depends on the k others, at their cost; return how many are held.

    The row enters the working set where others leave until it depends on them no more. If none ever would,
    −1 is returned.
    """
    row = work.held[k]
    while True:
        for a in range(k):
            work.pull[a] = dot(work.V[k], work.V[a], min(work.width[k], work.width[a]))
        forward(work.F, work.pull, k)
        backward(work.F, work.pull, k)
        share, blocking = _room(of, state, y, row, float(side)), k
        for a in range(k):
            room = _room(of, state, y, work.held[a], -side * work.pull[a])
            if room < share:
                share, blocking = room, a
        if share == np.inf:
            return -1
        move(work, y, k, share * side)
        for a in range(k):
            move(work, y, a, -share * side * work.pull[a])
        if blocking == k:
            _leave(of, state, y, row, float(side))
            return k
        _leave(of, state, y, work.held[blocking], -side * work.pull[blocking])
        k = drop(work, k + 1, blocking) - 1
        if extend(work, k):
            return k + 1


@jit_inner
def _begin(g: Vec, of: Rows, work: Work, state: Ints, y: Vec) -> int:
    """Start from the rows that `state` names as far as they are independent; return how many are held."""
    k = 0
    for i in range(len(state)):
        y[i] = 0.0
        if state[i] == 0:
            continue
        hard = of.penalty[i] == np.inf
        if not abs(_bound(of, state, i)) < np.inf or (abs(state[i]) == 2 and hard):
            state[i] = 0
        elif abs(state[i]) == 2:
            y[i] = 0.5 * state[i] * of.penalty[i]
        elif append(of, work, k, i):
            k += 1
        else:
            state[i] = 0
    for j in range(len(g)):
        work.t[j] = -g[j]
    paid(of, state, y, work.t)
    backward(work.L, work.t, len(g))
    return k


@kernel
def solve(H: Mat, g: Vec, of: Rows, work: Work, state: Ints, y: Vec, z: Vec, limit: int) -> tuple[int, int]:
    """Minimise over z (n,), starting from the working set `state` (m,); return the outcome and the changes.

    Parameters
    ----------
    state : σ of every row; overwritten by those of the answer.
    y : (m,) signed multipliers, written.
    limit : largest number of rows that enter.
    """
    if not factorise(H, work.L):
        return GIVEN_UP, 0
    k = _begin(g, of, work, state, y)
    before = k
    k = _settle(of, work, state, y, z, k)
    changes = before - k
    for _ in range(limit):
        row, side = _most_violated(of, work, state, z)
        if row < 0:
            _polish(H, g, of, work, state, y, z, k)
            return SOLVED, changes
        state[row] = side if state[row] == 0 else state[row] // 2
        changes += 1
        before = k
        if append(of, work, k, row):
            k += 1
        else:
            k = _exchange(of, work, state, y, k, side)
            if k < 0:
                return IMPOSSIBLE, changes
        k = _settle(of, work, state, y, z, k)
        changes += max(0, before + 1 - k)
    return GIVEN_UP, changes
