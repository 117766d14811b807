"""What size is usual in each equation of the optimality conditions, and for each unknown.

The equations are H z + g + Rᵀ y = 0 and R z = b with R = (I_b; A): a symmetric system K (z, y) = (−g, b). An
equation with a number of its own (g_j ≠ 0, b_i ≠ 0) has a size at any point, the sum of its absolute terms.
It tells the size of its unknowns, these that of equations without a number, and so on. All follow a change
of units.
"""

from typing import NamedTuple

import numpy as np

from otolith.core.arrays import Ints, Vec
from otolith.qp.problem import Qp


class Entries(NamedTuple):
    """The non-zeros of a matrix, by their places; all fields have the same shape."""

    row: Ints
    column: Ints
    value: Vec  # absolute


class Sizes(NamedTuple):
    """Sizes (n + b + m,) of all equations and of the unknowns (z, y); zero where nothing tells them."""

    of_equations: Vec
    of_unknowns: Vec


def optimality_system(qp: Qp) -> Entries:
    """Non-zeros of K."""
    n, b = len(qp.g), qp.bounds
    (hi, hj), (ai, aj), bound = np.nonzero(qp.H), np.nonzero(qp.A), np.arange(b)
    rows, columns = np.concatenate([n + bound, n + b + ai]), np.concatenate([bound, aj])
    of_rows = np.concatenate([np.ones(b), np.abs(qp.A[ai, aj])])
    return Entries(
        np.concatenate([hi, rows, columns]),
        np.concatenate([hj, columns, rows]),
        np.concatenate([np.abs(qp.H[hi, hj]), of_rows, of_rows]),
    )


def natural_sizes(K: Entries, told: Vec, at_most: Vec) -> Sizes:
    """Sizes of all equations and unknowns, from those that are told.

    An unknown takes the middle one of the sizes that equations with a size give it, an equation the middle
    one of those that its unknowns give it, and so on outwards until nothing new is reached. The middle,
    since a bound of 1e9 that stands for none, or a 1e-14 left over from rounding, tells nothing.

    Parameters
    ----------
    told : sizes of the equations that have a number of their own, infinity for the others.
    at_most : sizes of unknowns that no equation reaches, infinity where there is none either.
    """
    equations, unknowns = told.copy(), np.full(len(told), np.inf)
    for last in (unknowns, at_most):
        unknowns = np.where(np.isfinite(unknowns), unknowns, last)
        known = -1
        while known != (known := int(np.isfinite(equations).sum() + np.isfinite(unknowns).sum())):
            with np.errstate(over="ignore"):
                given = _middle(K.column, equations[K.row] / K.value, len(told))
                unknowns = np.where(np.isfinite(unknowns), unknowns, given)
                given = _middle(K.row, unknowns[K.column] * K.value, len(told))
                equations = np.where(np.isfinite(equations), equations, given)
    return Sizes(*(np.where(np.isfinite(sizes), sizes, 0.0) for sizes in (equations, unknowns)))


def _middle(group: Ints, values: Vec, groups: int) -> Vec:
    """The lower median of the finite values of each group, infinity where a group has none."""
    finite = np.isfinite(values)
    group, values = group[finite], values[finite]
    order = np.lexsort((values, group))
    count = np.bincount(group, minlength=groups)
    first = np.cumsum(count) - count
    middles = np.full(groups, np.inf)
    some = count > 0
    middles[some] = values[order][(first + (count - 1) // 2)[some]]
    return middles
