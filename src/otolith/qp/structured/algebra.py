"""Sparse matrices of symbols, and the source text of sums of products of their entries.

A *symbol* is the text of one scalar factor. The empty text stands for the number one, so that it drops out of
a product. A matrix holds its non-zeros only: an absent entry is zero and drops out of a sum.
"""

from collections.abc import Iterable

import numpy as np

from otolith.core.arrays import Mat

Symbol = str
Matrix = dict[tuple[int, int], Symbol]

TINY = 1e-15  # a smaller entry of A or B counts as rounding error, not as structure


def named(values: Mat, letter: str) -> Matrix:
    """Name each non-zero, e.g. A0_2; entries that are exactly one need no name."""
    names: Matrix = {}
    for i, j in zip(*np.nonzero(np.abs(values) > TINY), strict=True):
        names[int(i), int(j)] = "" if values[i, j] == 1.0 else f"{letter}{i}_{j}"
    return names


def symmetric(size: int, letter: str) -> Matrix:
    """Make a full symmetric matrix of symbols; both triangles share the names of the upper one."""
    return {(i, j): f"{letter}{min(i, j)}_{max(i, j)}" for i in range(size) for j in range(size)}


def upper(size: int) -> list[tuple[int, int]]:
    """Index pairs of the upper triangle, row by row, in the order in which they are stored."""
    return [(i, j) for i in range(size) for j in range(i, size)]


def product(*factors: Symbol) -> str:
    """Return the source text of a product of symbols."""
    return "*".join(f for f in factors if f) or "1.0"


def total(terms: Iterable[str]) -> str:
    """Return the source text of a sum of products, "0.0" if there are none."""
    return " + ".join(terms) or "0.0"


def in_row(M: Matrix, i: int) -> list[tuple[int, Symbol]]:
    """Return the non-zeros (j, symbol) of row i."""
    return sorted((j, s) for (row, j), s in M.items() if row == i)


def in_column(M: Matrix, j: int) -> list[tuple[int, Symbol]]:
    """Return the non-zeros (i, symbol) of column j."""
    return sorted((i, s) for (i, column), s in M.items() if column == j)


def gram(M: Matrix, rows: Iterable[int], weight: str | None = None) -> dict[tuple[int, int], list[str]]:
    """Terms of the upper triangle of Σ_r w_r M_rᵀ M_r, where the weight of row r is named `weight` plus r."""
    terms: dict[tuple[int, int], list[str]] = {}
    for r in rows:
        entries, w = in_row(M, r), f"{weight}{r}" if weight else ""
        for n, (i, a) in enumerate(entries):
            for j, b in entries[n:]:
                terms.setdefault((i, j), []).append(product(w, a, b))
    return terms
