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

Notation: H = L Lᵀ; V rows (L⁻¹ a)ᵀ of the working set; V Vᵀ = F Fᵀ, with the diagonal of F inverted. The
arithmetic may be fused: the certificate, elsewhere and strict, judges the answer.
"""

from typing import Final, NamedTuple, Self

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.jit import jit_fused, kernel

SOLVED, IMPOSSIBLE, GIVEN_UP = range(3)
DEPENDENT: Final = 1e-11  # squared length outside the span of the working set, relative, that counts as zero
TINY: Final = 1e-12  # smallest size of a row that counts
REFINEMENTS: Final = 2  # of the multipliers at the end
VIOLATED: Final = 1e-9  # excess over a bound, relative to its terms as in the certificate, that lets a row in


class Rows(NamedTuple):
    """The problem: m rows of n variables."""

    R: Mat  # (m, n)
    lower: Vec  # (m,)
    upper: Vec  # (m,)
    penalty: Vec  # (m,) w, infinite for a hard row


class Work(NamedTuple):
    """Memory of the method for n variables."""

    L: Mat  # (n, n)
    V: Mat  # (n + 1, n)
    F: Mat  # (n + 1, n + 1)
    held: Ints  # (n + 1,) rows of the working set, in the order of V
    pull: Vec  # (n + 1,) right-hand sides and their solutions
    step: Vec  # (n,)

    @classmethod
    def empty(cls, n: int) -> Self:
        """Allocate the memory."""
        return cls(
            L=np.zeros((n, n)),
            V=np.zeros((n + 1, n)),
            F=np.zeros((n + 1, n + 1)),
            held=np.zeros(n + 1, dtype=np.int64),
            pull=np.zeros(n + 1),
            step=np.zeros(n),
        )


@jit_fused
def _dot(a: Vec, b: Vec, n: int) -> float:
    total = 0.0
    for i in range(n):
        total += a[i] * b[i]
    return total


@jit_fused
def _factorise(H: Mat, L: Mat) -> bool:
    """Write L of H = L Lᵀ, its diagonal inverted; return False if H is not positive definite."""
    for i in range(len(H)):
        for j in range(i):
            L[i, j] = (H[i, j] - _dot(L[i], L[j], j)) * L[j, j]
        rest = H[i, i] - _dot(L[i], L[i], i)
        if not rest > 0.0:
            return False
        L[i, i] = 1.0 / np.sqrt(rest)
    return True


@jit_fused
def _forward(L: Mat, x: Vec, n: int) -> None:
    """Solve L x = x in place."""
    for i in range(n):
        x[i] = (x[i] - _dot(L[i], x, i)) * L[i, i]


@jit_fused
def _backward(L: Mat, x: Vec, n: int) -> None:
    """Solve Lᵀ x = x in place."""
    for i in range(n - 1, -1, -1):
        x[i] *= L[i, i]
        for j in range(i):
            x[j] -= L[i, j] * x[i]


@jit_fused
def _append(of: Rows, work: Work, k: int, row: int) -> bool:
    """Extend the factors of k rows by `row`; return False if it depends on the others."""
    n = len(work.L)
    for j in range(n):
        work.V[k, j] = of.R[row, j]
    _forward(work.L, work.V[k], n)
    work.held[k] = row
    return _extend(work, k)


@jit_fused
def _extend(work: Work, k: int) -> bool:
    """Write row k of F; return False if it depends on the others, with room for no more than `DEPENDENT`."""
    n, F = len(work.L), work.F
    for c in range(k):
        F[k, c] = (_dot(work.V[k], work.V[c], n) - _dot(F[k], F[c], c)) * F[c, c]
    whole = _dot(work.V[k], work.V[k], n)
    rest = whole - _dot(F[k], F[k], k)
    if k >= n or not rest > DEPENDENT * whole:
        return False
    F[k, k] = 1.0 / np.sqrt(rest)
    return True


@jit_fused
def _drop(work: Work, k: int, a: int) -> int:
    """Remove the a-th row of k from the working set; return how many are left."""
    for c in range(a, k - 1):
        work.held[c] = work.held[c + 1]
        for j in range(len(work.L)):
            work.V[c, j] = work.V[c + 1, j]
    for c in range(a, k - 1):
        _extend(work, c)
    return k - 1


@jit_fused
def _minimise(of: Rows, work: Work, g: Vec, y: Vec, z: Vec) -> None:
    """Write z = −H⁻¹ (g + Rᵀ y)."""
    n = len(g)
    for j in range(n):
        z[j] = -g[j]
    for i in range(len(y)):
        if y[i] != 0.0:
            for j in range(n):
                z[j] -= y[i] * of.R[i, j]
    _forward(work.L, z, n)
    _backward(work.L, z, n)


@kernel
def _room(of: Rows, state: Ints, y: Vec, i: int, change: float) -> float:
    """Return how many times `change` fits into the bounds of y_i; infinite if it leads to none."""
    w = of.penalty[i]
    low, high = (0.0, w) if state[i] > 0 else (-w, 0.0)
    if change == 0.0:
        return np.inf
    room: float = ((high if change > 0.0 else low) - y[i]) / change
    return max(0.0, room)


@kernel
def _leave(of: Rows, state: Ints, y: Vec, i: int, change: float) -> None:
    """Set y_i to the bound to which `change` leads, and its row free or saturated."""
    side = 1 if state[i] > 0 else -1
    outwards = change * side > 0.0
    state[i] = 2 * side if outwards else 0
    y[i] = side * of.penalty[i] if outwards else 0.0


@jit_fused
def _pulls(of: Rows, work: Work, state: Ints, z: Vec, k: int) -> None:
    """Write by how much the multipliers of the k rows of the working set must change to hold these rows."""
    for a in range(k):
        i = work.held[a]
        work.pull[a] = _dot(of.R[i], z, len(z)) - (of.upper[i] if state[i] > 0 else of.lower[i])
    _forward(work.F, work.pull, k)
    _backward(work.F, work.pull, k)


@jit_fused
def _refine(H: Mat, g: Vec, of: Rows, work: Work, state: Ints, y: Vec, z: Vec, k: int) -> None:
    """Correct z and the multipliers of the working set by what rounding left in the optimality conditions.

    With s = −(H z + g + Rᵀ y): z moves by H⁻¹ (s − Aᵀ δ), where S δ = A H⁻¹ s + (A z − b), and A z ≤ b are
    the rows that are held.
    """
    n, step = len(g), work.step
    for _ in range(REFINEMENTS):
        for j in range(n):
            step[j] = -g[j] - _dot(H[j], z, n)
        for i in range(len(y)):
            if y[i] != 0.0:
                for j in range(n):
                    step[j] -= y[i] * of.R[i, j]
        _forward(work.L, step, n)
        for a in range(k):
            i = work.held[a]
            gap = _dot(of.R[i], z, n) - (of.upper[i] if state[i] > 0 else of.lower[i])
            work.pull[a] = gap + _dot(work.V[a], step, n)
        _forward(work.F, work.pull, k)
        _backward(work.F, work.pull, k)
        for a in range(k):
            y[work.held[a]] += work.pull[a]
            for j in range(n):
                step[j] -= work.pull[a] * work.V[a, j]
        _backward(work.L, step, n)
        for j in range(n):
            z[j] += step[j]
    for a in range(k):  # rounding may have led beyond a bound
        i = work.held[a]
        low, high = (0.0, of.penalty[i]) if state[i] > 0 else (-of.penalty[i], 0.0)
        y[i] = min(high, max(low, y[i]))


@kernel
def _settle(of: Rows, work: Work, g: Vec, state: Ints, y: Vec, z: Vec, k: int) -> int:
    """Move the multipliers until all k rows of the working set are held; return how many are left."""
    while True:
        _minimise(of, work, g, y, z)
        _pulls(of, work, state, z, k)
        share, blocking = 1.0, -1
        for a in range(k):
            room = _room(of, state, y, work.held[a], work.pull[a])
            if room < share:
                share, blocking = room, a
        for a in range(k):
            y[work.held[a]] += share * work.pull[a]
        if blocking < 0:
            _minimise(of, work, g, y, z)
            return k
        _leave(of, state, y, work.held[blocking], work.pull[blocking])
        k = _drop(work, k, blocking)


@jit_fused
def _value(row: Vec, z: Vec) -> tuple[float, float]:
    """Return the product of a row with z, and the sum of its terms' sizes."""
    total, size = 0.0, 0.0
    for j in range(len(z)):
        term = row[j] * z[j]
        total += term
        size += abs(term)
    return total, size


@kernel
def _most_violated(of: Rows, state: Ints, z: Vec) -> tuple[int, int]:
    """Return the row that is furthest beyond its bound, or −1, and the direction (±1) of its multiplier."""
    worst, chosen, side = VIOLATED, -1, 0
    for i in range(len(state)):
        if abs(state[i]) == 1:
            continue
        r, size = _value(of.R[i], z)
        above = (r - of.upper[i]) / (size + abs(of.upper[i]) + TINY) if of.upper[i] < np.inf else -np.inf
        below = (of.lower[i] - r) / (size + abs(of.lower[i]) + TINY) if of.lower[i] > -np.inf else -np.inf
        if state[i] == 2:
            above, below = -np.inf, -above  # it returns when it is satisfied
        elif state[i] == -2:
            above, below = -below, -np.inf
        if max(above, below) > worst:
            worst, chosen, side = max(above, below), i, 1 if above > below else -1
    return chosen, side


@kernel
def _exchange(of: Rows, work: Work, state: Ints, y: Vec, k: int, side: int) -> int:
    """Move the multiplier of row k, which depends on the k others, at their cost; return how many are held.

    The row enters the working set where others leave until it depends on them no more. If none ever would,
    −1 is returned.
    """
    row, n = work.held[k], len(work.L)
    while True:
        for a in range(k):
            work.pull[a] = _dot(work.V[k], work.V[a], n)
        _forward(work.F, work.pull, k)
        _backward(work.F, work.pull, k)
        share, blocking = _room(of, state, y, row, float(side)), k
        for a in range(k):
            room = _room(of, state, y, work.held[a], -side * work.pull[a])
            if room < share:
                share, blocking = room, a
        if share == np.inf:
            return -1
        y[row] += share * side
        for a in range(k):
            y[work.held[a]] -= share * side * work.pull[a]
        if blocking == k:
            _leave(of, state, y, row, float(side))
            return k
        _leave(of, state, y, work.held[blocking], -side * work.pull[blocking])
        k = _drop(work, k + 1, blocking) - 1
        if _extend(work, k):
            return k + 1


@kernel
def _begin(of: Rows, work: Work, state: Ints, y: Vec) -> int:
    """Start from the rows that `state` names as far as they are independent; return how many are held."""
    k = 0
    for i in range(len(state)):
        y[i] = 0.0
        bound = of.upper[i] if state[i] > 0 else of.lower[i]
        if state[i] == 0 or not abs(bound) < np.inf or (abs(state[i]) == 2 and of.penalty[i] == np.inf):
            state[i] = 0
        elif abs(state[i]) == 2:
            y[i] = 0.5 * state[i] * of.penalty[i]
        elif _append(of, work, k, i):
            k += 1
        else:
            state[i] = 0
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
    if not _factorise(H, work.L):
        return GIVEN_UP, 0
    k = _begin(of, work, state, y)
    before = k
    k = _settle(of, work, g, state, y, z, k)
    changes = before - k
    for _ in range(limit):
        row, side = _most_violated(of, state, z)
        if row < 0:
            _refine(H, g, of, work, state, y, z, k)
            return SOLVED, changes
        state[row] = side if state[row] == 0 else state[row] // 2
        changes += 1
        before = k
        if _append(of, work, k, row):
            k = _settle(of, work, g, state, y, z, k + 1)
        else:
            k = _exchange(of, work, state, y, k, side)
            if k < 0:
                return IMPOSSIBLE, changes
            k = _settle(of, work, g, state, y, z, k)
        changes += max(0, before + 1 - k)
    return GIVEN_UP, changes
