"""How good a guess of the working set is, and the better of two.

With the guessed rows held at their sides, one linear system gives the point and the multipliers; what
contradicts the optimality conditions is counted. None: the guess is the answer.
"""

from collections.abc import Callable

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from otolith.core.arrays import Bools, Ints
from otolith.qp.problem import Qp

_VIOLATED = 1e-8  # a row beyond its bound, or a multiplier of the wrong sign, by more than this
_DEPENDENT = 1e-10  # relative regularisation of the rows' system: rows may depend on each other


def violations(qp: Qp, working_set: Ints) -> int:
    """How many optimality conditions fail, see `failing`."""
    return int(np.count_nonzero(failing(qp, working_set)))


def failing(qp: Qp, working_set: Ints) -> Bools:
    """Rows (b + m,) whose optimality conditions fail when the rows of a guess are held at their sides.

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
    """`start` when it is the answer or no worse than the hint, else that; and whether it was the hint.

    The hint is not asked for where `start` is the answer. It is heard on the groups in which `start` fails.

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
