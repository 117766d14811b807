"""Judge a guess of the working set, and choose the better of two.

With the guessed rows held at their bounds, one linear system gives the point and the multipliers. The
optimality conditions that this point violates are counted; if there are none, the guess is the answer.
"""

from collections.abc import Callable

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from otolith.core.arrays import Bools, Ints
from otolith.qp.problem import Qp

_VIOLATED = 1e-8  # a row further outside its bound, or a multiplier further on the wrong side of zero, fails
_DEPENDENT = 1e-10  # relative regularisation of the rows' linear system, since rows may depend on each other


def violations(qp: Qp, working_set: Ints) -> int:
    """Count the optimality conditions that fail with a guess, see `failing`."""
    return int(np.count_nonzero(failing(qp, working_set)))


def failing(qp: Qp, working_set: Ints) -> Bools:
    """Rows (b + m,) whose optimality conditions fail when the rows of a guess are held at their bounds.

    These are free rows outside their bounds, and held rows whose multiplier has the wrong sign or, on a soft
    row, exceeds the penalty. Infinite bounds are not held. A guess with more rows than variables cannot be
    satisfied; then all rows count as failing.

    Parameters
    ----------
    working_set : (b + m,) as `Solution.working_set`.
    """
    side = np.where(working_set > 0, qp.upper, qp.lower)
    held = (working_set != 0) & np.isfinite(side)
    if np.count_nonzero(held) > len(qp.g):
        return np.ones(len(held), dtype=np.bool_)
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
    failed: Bools = out | wrong
    return failed


def better(qp: Qp, start: Ints, hint: Callable[[], Ints | None], groups: Ints) -> tuple[Ints, bool]:
    """Choose between `start` and a hint; return the working set to use, and whether it contains the hint.

    The hint is requested only if `start` is not the answer. It is used only in those groups of rows in which
    `start` fails, and only if fewer conditions fail with it.

    Parameters
    ----------
    groups : (b + m,) number of the group of each row, see `otolith.qp.stage.StageProblem.groups`.
    """
    failed = failing(qp, start)
    made = hint() if failed.any() else None
    if made is None:
        return start, False
    mixed = np.where(np.isin(groups, groups[failed]), made, start)
    return (mixed, True) if violations(qp, mixed) < np.count_nonzero(failed) else (start, False)
