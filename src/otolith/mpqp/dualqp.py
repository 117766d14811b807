"""Dense kernels on the least-distance form: factorisation, optimality at a point, a dual active-set QP.

The notation is that of `leastdistance`; A[:k] lists the active rows, L L' = Q_AA
(the diagonal of L is stored inverted), dv = d(τ) (m,), λ (k,),
slack = dv + Q_·A λ. The QP is solved by the dual method of Goldfarb and Idnani (1983), started from the
unconstrained minimiser u = 0.

Degeneracy: where a row outside A depends on A and has slack zero throughout, several active sets give the
same u and their regions overlap. Of these the set is chosen that remains optimal when every bound is relaxed
by an infinitesimal δ_i: the slack of such a row i is then δ_i - Q_iA Q_AA⁻¹ δ_A, and must not be negative.
`tie` finds a row that excludes a set; exchanging this row in is a step of the dual method.
"""

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.jit import jit_inner

DEPENDENT = 1e-10  # squared length of a row outside the span of the active ones that counts as zero
INFEASIBLE, FAILED = -1, -2
CHANGE_LIMIT = 500
SLACK_WEIGHT = 10.0  # a wrong slack changes z by its condition number, a wrong multiplier does not
TIED = 1e-12  # largest slack at which a dependent row counts as always binding
TIGHT, LOOSE = 1e-14, 1e-11  # the violations that the QP aims at first, and accepts last, with usual rounding
RETRIED = 4.0  # factor by which the last violation exceeds at least the first, which grows with rounding


@jit_inner
def append_row(Q: Mat, A: Ints, k: int, L: Mat) -> bool:
    """Extend the factor of rows A[:k] by row A[k]; return false when it depends on the others."""
    j = A[k]
    diagonal = Q[j, j]
    for c in range(k):
        s = Q[A[c], j]
        for e in range(c):
            s -= L[k, e] * L[c, e]
        s *= L[c, c]
        L[k, c] = s
        diagonal -= s * s
    if diagonal < DEPENDENT:
        return False
    L[k, k] = 1.0 / np.sqrt(diagonal)
    return True


@jit_inner
def cholesky(Q: Mat, A: Ints, start: int, k: int, L: Mat) -> bool:
    """Factorise rows A[:k], the first `start` of which are done; return false when they are dependent."""
    for a in range(start, k):  # noqa: SIM110 (compiled loop)
        if not append_row(Q, A, a, L):
            return False
    return True


@jit_inner
def back_substitute(L: Mat, k: int, x: Vec) -> None:
    """Solve L' x = x in place."""
    for a in range(k - 1, -1, -1):
        s = x[a]
        for e in range(a + 1, k):
            s -= L[e, a] * x[e]
        x[a] = s * L[a, a]


@jit_inner
def substitute(L: Mat, k: int, x: Vec) -> None:
    """Solve L L' x = x in place."""
    for a in range(k):
        s = x[a]
        for e in range(a):
            s -= L[a, e] * x[e]
        x[a] = s * L[a, a]
    back_substitute(L, k, x)


@jit_inner
def right_hand_side(d: Mat, tau: Vec, dv: Vec) -> None:
    """Compute dv = d(τ)."""
    p = tau.shape[0]
    for i in range(dv.shape[0]):
        dv[i] = d[p, i]
    for c in range(p):
        t = tau[c]
        for i in range(dv.shape[0]):
            dv[i] += t * d[c, i]


@jit_inner
def slack_of(Q: Mat, dv: Vec, A: Ints, k: int, lam: Vec, slack: Vec) -> None:
    """Compute slack = dv + Q_·A λ."""
    for i in range(dv.shape[0]):
        slack[i] = dv[i]
    for a in range(k):
        t, j = lam[a], A[a]
        if t != 0.0:
            for i in range(dv.shape[0]):
                slack[i] += t * Q[j, i]


@jit_inner
def least(x: Vec) -> float:
    """Return the smallest entry, using four independent chains of comparisons that the processor overlaps."""
    a, b, c, d = 1e300, 1e300, 1e300, 1e300
    n = x.shape[0]
    for i in range(0, n - 3, 4):
        a, b = min(a, x[i]), min(b, x[i + 1])
        c, d = min(c, x[i + 2]), min(d, x[i + 3])
    for i in range(n - n % 4, n):
        a = min(a, x[i])
    return min(min(a, b), min(c, d))


@jit_inner
def violated(Q: Mat, dv: Vec, A: Ints, k: int, lam: Vec, slack: Vec) -> float:
    """Return the largest violation of λ ≥ 0 and slack ≥ 0 with the rows A[:k] active and multipliers λ.

    The violation is relative to max(1, λ), with which rounding grows. A result of zero or less means that
    this set is optimal at this point.
    """
    slack_of(Q, dv, A, k, lam, slack)
    worst, size = -1e300, 1.0
    for a in range(k):
        worst = max(worst, -lam[a])
        size = max(size, lam[a])
        slack[A[a]] = 0.0
    return max(worst, -SLACK_WEIGHT * least(slack)) / size


@jit_inner
def optimality(Q: Mat, dv: Vec, A: Ints, k: int, L: Mat, lam: Vec, slack: Vec) -> float:
    """Solve for λ with the rows A active; return their violation. L must contain the factor of Q_AA."""
    for a in range(k):
        lam[a] = -dv[A[a]]
    substitute(L, k, lam)
    return violated(Q, dv, A, k, lam, slack)


@jit_inner
def tie(Q: Mat, delta: Vec, A: Ints, k: int, L: Mat, slack: Vec, x: Vec) -> int:
    """Find a row with slack zero, dependent on A, whose slack under δ is negative; -1 when there is none.

    L contains the factor of Q_AA; the slack of active rows must not be zero. x is set to the row's
    coefficients with respect to the active rows.
    """
    for i in range(slack.shape[0]):
        if abs(slack[i]) > TIED:
            continue
        for a in range(k):
            x[a] = Q[A[a], i]
        substitute(L, k, x)
        room, shift = Q[i, i], delta[i]
        for a in range(k):
            room -= x[a] * Q[A[a], i]
            shift -= x[a] * delta[A[a]]
        if room < DEPENDENT and shift < 0.0:
            return i
    return -1


@jit_inner
def untie(Q: Mat, delta: Vec, dv: Vec, A: Ints, k: int, L: Mat, lam: Vec, slack: Vec, x: Vec) -> int:
    """Exchange active rows until no tie is left; return k, which does not change."""
    for _ in range(4 * k):
        if not cholesky(Q, A, 0, k, L):
            return k
        optimality(Q, dv, A, k, L, lam, slack)
        for a in range(k):
            slack[A[a]] = 1.0
        i = tie(Q, delta, A, k, L, slack, x)
        if i < 0:
            return k
        leave, t = -1, 1e300
        for a in range(k):
            if x[a] > 1e-9 and lam[a] < t * x[a]:
                leave, t = a, lam[a] / x[a]
        if leave < 0:
            return k
        A[leave] = i
    return k


@jit_inner
def most_violated(slack: Vec, A: Ints, k: int, tolerance: float) -> int:
    """Return the inactive row with the least slack below -tolerance, or -1."""
    for a in range(k):
        slack[A[a]] = 0.0
    chosen, worst = -1, -tolerance
    for i in range(slack.shape[0]):
        if slack[i] < worst:
            chosen, worst = i, slack[i]
    return chosen


@jit_inner
def take_in(Q: Mat, A: Ints, k: int, n: int, j: int, gap: float, lam: Vec, L: Mat, x: Vec) -> int:
    """Make row j, violated by `gap`, active; drop rows whose multiplier would become negative.

    Returns the new number of active rows, or -1 when no z satisfies row j together with the others.
    """
    own = 0.0
    while True:
        room = Q[j, j]
        for a in range(k):
            s = Q[A[a], j]
            for e in range(a):
                s -= L[a, e] * x[e]
            x[a] = s * L[a, a]
            room -= x[a] * x[a]
            L[k, a] = x[a]
        back_substitute(L, k, x)
        blocking, t = -1, 1e300
        for a in range(k):
            if x[a] > 1e-11 and lam[a] < t * x[a]:
                blocking, t = a, lam[a] / x[a]
        full = gap / room if room > DEPENDENT and k < n else 1e300
        if blocking < 0 and full > 1e299:
            return -1
        t = min(t, full)
        for a in range(k):
            lam[a] -= t * x[a]
        own += t
        gap -= t * room
        if full <= t:
            A[k], lam[k], L[k, k] = j, own, 1.0 / np.sqrt(room)
            return k + 1
        for a in range(blocking, k - 1):
            A[a], lam[a] = A[a + 1], lam[a + 1]
        k -= 1
        cholesky(Q, A, blocking, k, L)


@jit_inner
def attempt_qp(
    Q: Mat, dv: Vec, n: int, A: Ints, lam: Vec, L: Mat, x: Vec, slack: Vec, tolerance: float, loosest: float
) -> int:
    """Run `solve_qp` at one tolerance; return FAILED if infeasible by so little that rounding may be the
    cause.
    """
    k = 0
    for _ in range(CHANGE_LIMIT):
        slack_of(Q, dv, A, k, lam, slack)
        j = most_violated(slack, A, k, tolerance)
        if j < 0:
            return k
        gap = -slack[j]
        k = take_in(Q, A, k, n, j, gap, lam, L, x)
        if k < 0:
            return INFEASIBLE if gap > loosest else FAILED
    return FAILED


@jit_inner
def solve_qp(Q: Mat, dv: Vec, n: int, A: Ints, lam: Vec, L: Mat, x: Vec, slack: Vec, grain: float) -> int:
    """Find the optimal active set of min ½|u|², M u ≤ dv, in A[:k] with λ; return k, INFEASIBLE or FAILED."""
    tolerance, loosest, k = TIGHT * grain, max(LOOSE, RETRIED * TIGHT * grain), FAILED
    while k == FAILED and tolerance <= loosest:
        k = attempt_qp(Q, dv, n, A, lam, L, x, slack, tolerance, loosest)
        tolerance *= 30.0
    return k
