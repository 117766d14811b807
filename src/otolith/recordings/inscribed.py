"""Units in the cells of a table, written behind each number: "12.3 km/h", "0.02g"."""

import csv
import re
from collections.abc import Sequence
from typing import Final

from otolith.recordings.units import UNITS, canonical, factor, is_unit

LOOKED_AT: Final = 100  # number of first rows in which columns with units are looked for
_MEASURED: Final = re.compile(r"([+-]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][+-]?\d+)?)\s*([^\s\d.,].*)")


def measured(cell: str) -> tuple[str, str] | None:
    """Return the number and the unit of a cell that holds both; None of any other cell."""
    found = _MEASURED.fullmatch(cell)
    return (found[1], found[2].strip()) if found and is_unit(found[2].strip()) else None


def without_units(
    body: Sequence[str], delimiter: str | None, stated: Sequence[str]
) -> tuple[list[str], list[str]]:
    """Return the rows (n,) without the units in their cells, and the units of all columns (c,).

    A column whose unit changes, or differs from the one that the file states for it, is left unchanged as
    text.

    Parameters
    ----------
    body : the rows (n,), each of one line.
    stated : the units (c,) that the file states elsewhere, empty where it states none.
    """
    units = list(stated)
    if delimiter is None or not _columns(
        body[:LOOKED_AT], delimiter, len(units)
    ):  # with blanks as delimiters, number and unit are two cells
        return list(body), units
    rows = list(csv.reader(body, delimiter=delimiter, skipinitialspace=True))
    for i in _columns(body[:LOOKED_AT], delimiter, len(units)):
        found = {
            at: both for at, row in enumerate(rows) if i < len(row) and (both := measured(row[i].strip()))
        }
        by_meaning = {_meaning(unit): unit for _, unit in found.values()}
        if len(by_meaning) > 1 or (units[i] and _meaning(units[i]) not in by_meaning):
            continue
        units[i] = units[i] or next(iter(by_meaning.values()))
        for at, (number, _) in found.items():
            rows[at][i] = number
    return [delimiter.join(row) for row in rows], units


def _meaning(unit: str) -> object:
    """Return what all spellings of one unit share: its factors to SI, or its canonical spelling."""
    sizes = [(kind, size) for kind in UNITS if (size := factor(kind, unit)) is not None]
    return tuple(sizes) or canonical(unit)


def _columns(first: Sequence[str], delimiter: str, width: int) -> list[int]:
    """Return the columns that hold units in at least one of these rows."""
    rows = list(csv.reader(first, delimiter=delimiter, skipinitialspace=True))
    return [i for i in range(width) if any(i < len(row) and measured(row[i].strip()) for row in rows)]
