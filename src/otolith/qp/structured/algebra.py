"""Sparse matrices of names, and the source text of sums of products of their entries.

A *symbol* is the text of one scalar factor; the empty text is the number one, so that it drops out
of a product. A matrix holds its non-zeros only: what is absent is zero and drops out of a sum.
"""

from collections.abc import Iterable

import numpy as np

from otolith.core.arrays import Mat

Symbol = str
Matrix = dict[tuple[int, int], Symbol]

TINY = 1e-15  # below this an entry of A or B is rounding, not structure


def named(values: Mat, letter: str) -> Matrix:
    """One name per non-zero, e.g. A0_2; entries that are exactly one need none."""
    names: Matrix = {}
    for i, j in zip(*np.nonzero(np.abs(values) > TINY), strict=True):
        names[int(i), int(j)] = "" if values[i, j] == 1.0 else f"{letter}{i}_{j}"
    return names


def symmetric(size: int, letter: str) -> Matrix:
    """A full symmetric matrix; both triangles share the names of the upper one."""
    return {(i, j): f"{letter}{min(i, j)}_{max(i, j)}" for i in range(size) for j in range(size)}


def upper(size: int) -> list[tuple[int, int]]:
    """Index pairs of the upper triangle, row by row: the order in which it is stored."""
    return [(i, j) for i in range(size) for j in range(i, size)]


def product(*factors: Symbol) -> str:
    """Text of a product of symbols."""
    return "*".join(f for f in factors if f) or "1.0"


def total(terms: Iterable[str]) -> str:
    """Text of a sum of products, zero when there are none."""
    return " + ".join(terms) or "0.0"


def in_row(M: Matrix, i: int) -> list[tuple[int, Symbol]]:
    """Non-zeros (j, symbol) of row i."""
    return sorted((j, s) for (row, j), s in M.items() if row == i)


def in_column(M: Matrix, j: int) -> list[tuple[int, Symbol]]:
    """Non-zeros (i, symbol) of column j."""
    return sorted((i, s) for (i, column), s in M.items() if column == j)


def gram(M: Matrix, rows: Iterable[int], weight: str | None = None) -> dict[tuple[int, int], list[str]]:
    """Terms of the upper triangle of Σ_r w_r M_rᵀ M_r, where row r weighs `weight` + its number."""
    terms: dict[tuple[int, int], list[str]] = {}
    for r in rows:
        entries, w = in_row(M, r), f"{weight}{r}" if weight else ""
        for n, (i, a) in enumerate(entries):
            for j, b in entries[n:]:
                terms.setdefault((i, j), []).append(product(w, a, b))
    return terms
