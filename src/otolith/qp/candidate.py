"""How good a guess of the working set is, and the better of two.

With the guessed rows held at their sides, one linear system gives the point and the multipliers; what
contradicts the optimality conditions is counted. None: the guess is the answer.
"""

from collections.abc import Callable

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from otolith.core.arrays import Ints
from otolith.qp.problem import Qp

_VIOLATED = 1e-8  # a row beyond its bound, or a multiplier of the wrong sign, by more than this
_DEPENDENT = 1e-10  # relative regularisation of the rows' system: rows may depend on each other


def violations(qp: Qp, working_set: Ints) -> int:
    """Optimality conditions that fail when the rows of a guess are held at their sides.

    Counted are free rows out of bounds and held rows whose multiplier points the wrong way or, on a soft
    row, exceeds the penalty. Sides that are infinite are not held; a guess of more rows than variables
    cannot be met and counts as all rows.

    Parameters
    ----------
    working_set : (b + m,) as `Solution.working_set`.
    """
    side = np.where(working_set > 0, qp.upper, qp.lower)
    held = (working_set != 0) & np.isfinite(side)
    if np.count_nonzero(held) > len(qp.g):
        return len(held)
    b = qp.bounds
    A = np.vstack([np.eye(b, len(qp.g))[held[:b]], qp.A[held[b:]]])
    factor = cho_factor(qp.H)
    to_rows = cho_solve(factor, A.T)  # H⁻¹ Aᵀ
    free = -cho_solve(factor, qp.g)
    S = A @ to_rows
    S[np.diag_indices_from(S)] *= 1.0 + _DEPENDENT
    y = np.zeros(len(held))
    if held.any():
        y[held] = np.linalg.solve(S, A @ free - side[held])
    rows = qp.rows(free - to_rows @ y[held])
    out = ~held & ((rows > qp.upper + _VIOLATED) | (rows < qp.lower - _VIOLATED))
    pull = np.sign(working_set) * y
    most = np.inf if qp.penalty is None else qp.penalty
    wrong = held & ((pull < -_VIOLATED) | (pull > most)) & (qp.lower < qp.upper)
    return int(np.count_nonzero(out | wrong))


def better(qp: Qp, start: Ints, hint: Callable[[], Ints | None]) -> tuple[Ints, bool]:
    """`start` when it is the answer or no worse than the hint, else that; and whether it was the hint.

    The hint is not asked for where `start` is the answer.
    """
    of_start = violations(qp, start)
    made = hint() if of_start > 0 else None
    return (start, False) if made is None or violations(qp, made) >= of_start else (made, True)
