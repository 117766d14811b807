"""Usual sizes of the terms in each equation of the optimality conditions, and of each unknown.

The equations are H z + g + Rᵀ y = 0 and R z = b with R = (I_b; A): a symmetric system K (z, y) = (−g, b). An
equation with a number of its own (g_j ≠ 0, b_i ≠ 0) has a size at any point, the sum of its absolute terms.
From this size follow those of its unknowns, from these the sizes of equations without a number, and so on.
All sizes change with the units as their quantities do.
"""

from typing import NamedTuple

import numpy as np

from otolith.core.arrays import Ints, Vec
from otolith.qp.problem import Qp


class Entries(NamedTuple):
    """The non-zeros of a matrix with their positions; all fields have the same shape."""

    row: Ints
    column: Ints
    value: Vec  # absolute value


class Sizes(NamedTuple):
    """Sizes (n + b + m,) of all equations and of the unknowns (z, y); zero where none can be derived."""

    of_equations: Vec
    of_unknowns: Vec


def optimality_system(qp: Qp) -> Entries:
    """Return the non-zeros of K."""
    n, b = len(qp.g), qp.bounds
    (hi, hj), (ai, aj), bound = np.nonzero(qp.H), np.nonzero(qp.A), np.arange(b)
    rows, columns = np.concatenate([n + bound, n + b + ai]), np.concatenate([bound, aj])
    of_rows = np.concatenate([np.ones(b), np.abs(qp.A[ai, aj])])
    return Entries(
        np.concatenate([hi, rows, columns]),
        np.concatenate([hj, columns, rows]),
        np.concatenate([np.abs(qp.H[hi, hj]), of_rows, of_rows]),
    )


def natural_sizes(K: Entries, known: Vec, at_most: Vec) -> Sizes:
    """Derive the sizes of all equations and unknowns from the known ones.

    An unknown takes the median of the sizes that equations with a size give it, an equation the median of
    those that its unknowns give it, and so on until nothing new is reached. The median ignores outliers, such
    as a bound of 1e9 that means "no bound" or a 1e-14 left over from rounding.

    Parameters
    ----------
    known : sizes of the equations that have a number of their own, infinity for the others.
    at_most : sizes of unknowns that no equation reaches, infinity if there is none.
    """
    equations, unknowns = known.copy(), np.full(len(known), np.inf)
    for last in (unknowns, at_most):
        unknowns = np.where(np.isfinite(unknowns), unknowns, last)
        reached = -1
        while reached != (reached := int(np.isfinite(equations).sum() + np.isfinite(unknowns).sum())):
            with np.errstate(over="ignore"):
                given = _middle(K.column, equations[K.row] / K.value, len(known))
                unknowns = np.where(np.isfinite(unknowns), unknowns, given)
                given = _middle(K.row, unknowns[K.column] * K.value, len(known))
                equations = np.where(np.isfinite(equations), equations, given)
    return Sizes(*(np.where(np.isfinite(sizes), sizes, 0.0) for sizes in (equations, unknowns)))


def _middle(group: Ints, values: Vec, groups: int) -> Vec:
    """Lower median of the finite values of each group; infinity for a group without any."""
    finite = np.isfinite(values)
    group, values = group[finite], values[finite]
    order = np.lexsort((values, group))
    count = np.bincount(group, minlength=groups)
    first = np.cumsum(count) - count
    middles = np.full(groups, np.inf)
    some = count > 0
    middles[some] = values[order][(first + (count - 1) // 2)[some]]
    return middles
