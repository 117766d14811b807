"""From cells to samples: numbers are parsed, repeated rows dropped, and coarse time stamps refined."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from otolith.core.arrays import Bools, Ints, Vec
from otolith.core.errors import InputError
from otolith.recordings import clocks
from otolith.recordings.columns import Column
from otolith.recordings.recorded import Cells, Recorded

BLANK: Final = frozenset(  # cells without a value; Windows prints "1.#QNAN" and the like for NaN
    {"", "nan", "na", "n/a", "null", "none", "-", "--", "nil", "#n/a", "#na", "#null!", "#value!", "?", "*"}
    | {"-nan", "+nan", "nan(ind)", "-nan(ind)", "nan(snan)", "1.#qnan", "-1.#qnan", "1.#ind", "-1.#ind"}
    | {"1.#qnb", "-1.#inb", "missing", "undefined", "nodata", "no data", "---", "<na>", "nat"}
)


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """The valid samples of one column, with the values that stand in the file."""

    column: Column
    t: Vec  # (n,) [s], strictly increasing
    values: Vec  # (n,) not yet multiplied by the column's factor
    rows: Ints  # (n,) row in the file of each sample
    notes: tuple[str, ...] = ()
    fault: InputError | None = None  # why the column cannot be used; None if it can


def numbers(cells: Cells) -> tuple[Vec, int | None]:
    """Parse cells as numbers, and find the first cell that is neither blank nor a finite number.

    Returns
    -------
    Values (n,), NaN where a cell is blank or wrong; and the index of the first wrong cell, None if there is
    none.
    """
    if isinstance(cells, np.ndarray):
        values = np.asarray(cells, dtype=np.float64)
        wrong = np.isinf(values)
    else:
        values, wrong = _parsed(cells)
    if not wrong.any():
        return values, None
    return np.where(wrong, np.nan, values), int(np.argmax(wrong))


def _parsed(cells: Sequence[str]) -> tuple[Vec, Bools]:
    values = np.full(len(cells), np.nan)
    wrong = np.zeros(len(cells), dtype=np.bool_)
    for i, cell in enumerate(cells):
        if cell.lower() in BLANK:
            continue
        try:
            values[i] = float(cell)
        except ValueError:
            wrong[i] = True
        else:
            wrong[i] = not np.isfinite(values[i]) or "_" in cell
    return values, np.asarray(wrong, dtype=np.bool_)


def read_stamps(recorded: Recorded, column: Column) -> clocks.Stamps:
    """Read the time stamps of all rows from the column that holds them.

    Raises
    ------
    InputError : a cell is not a time, or the unit would make the steps impossibly small.
    """
    cells, place = recorded.cells([column.index])[0], _Place(recorded, column)
    if not isinstance(cells, np.ndarray):
        first = next((cell for cell in cells if cell.lower() not in BLANK), "")
        if ":" in first or "T" in first:
            return clocks.clock_times(cells, column, place.row)
    values, wrong = numbers(cells)
    if wrong is not None:
        raise place.fault(wrong, cells)
    return clocks.numeric_stamps(values, column)


def samples(recorded: Recorded, columns: Sequence[Column], stamps: Vec | None) -> list[Samples]:
    """Return the valid samples of these columns, on a common clock or each on its own.

    Rows that repeat the time stamp of the row before are dropped as duplicates; where values differ between
    equal stamps, the stamps are coarser than the rows and are spread evenly. A column that cannot be used is
    returned with a `fault`, the sentence that says why.

    Parameters
    ----------
    stamps : (n,) [s] the clock of all rows; None if each column has its own.
    """
    raw = []
    for column, cells in zip(columns, recorded.cells([column.index for column in columns]), strict=True):
        values, wrong = numbers(cells)
        fault = None if wrong is None else _Place(recorded, column).fault(wrong, cells)
        t = recorded.clock(column.index) if stamps is None else stamps
        assert t is not None  # noqa: S101 - a file whose columns have no clocks is read with stamps
        raw.append(Samples(column, t, values, recorded.rows(column.index), (), fault))
    coarse = any(_conflicts(one.t, one.values).any() for one in raw)
    return [_clocked(one, _Place(recorded, one.column), coarse=coarse) for one in raw]


class _Place:
    """Describes where the cells of one column stand in the file, for messages."""

    def __init__(self, recorded: Recorded, column: Column) -> None:
        self._rows, self._word = recorded.rows(column.index), recorded.place
        self.source, self.name = recorded.source, column.name

    def row(self, index: int) -> str:
        return self.at(int(self._rows[index]))

    def at(self, row: int) -> str:
        return f"{self._word} {row} of {self.source}"

    def fault(self, index: int, cells: Cells) -> InputError:
        cell = cells[index]
        shown = repr(cell if isinstance(cell, str) else float(cell))
        return InputError(f"{self.name!r} in {self.row(index)}", shown, "a finite number")


def _conflicts(t: Vec, values: Vec) -> Bools:
    """Return for each step (n - 1,) between valid samples whether only the value changes, not the time."""
    valid = np.isfinite(values) & np.isfinite(t)
    return np.asarray((np.diff(t[valid]) == 0.0) & (np.diff(values[valid]) != 0.0), dtype=np.bool_)


def _clocked(raw: Samples, place: _Place, *, coarse: bool) -> Samples:
    """Return the valid samples on a strictly increasing clock, or with the fault that prevents it."""
    valid = np.isfinite(raw.values) & np.isfinite(raw.t)
    t, values, rows = raw.t[valid], raw.values[valid], raw.rows[valid]
    fault, notes = raw.fault, raw.notes
    if len(t) < len(raw.values):
        notes += (f"{len(raw.values) - len(t)} of {len(raw.values)} cells of {place.name!r} are blank",)
    again = np.diff(t, prepend=np.nan) == 0.0
    if fault is None and again.any() and coarse:
        even = None if _interleaved(values, again) else clocks.even_out(t)
        if even is None:
            fault = _standing(t, rows, place, again)
        else:
            notes += (f"stamps are coarser than the rows: taken as evenly spaced, {even[1] - even[0]:.4g} s",)
            t = even
    elif again.any():
        notes += (f"{int(again.sum())} rows were written twice and left out",)
        t, values, rows = t[~again], values[~again], rows[~again]
    if fault is None and len(t) < 2:
        fault = InputError(f"number of samples of {place.name!r} in {place.source}", len(t), "at least 2")
    if fault is None and (np.diff(t) <= 0.0).any():
        fault = _backwards(t, rows, place)
    return Samples(raw.column, t, values, rows, notes, fault)


def _interleaved(values: Vec, again: Bools) -> bool:
    """Return whether rows with equal stamps alternate between several sources, such as two cars in one file.

    In a smooth signal the next value is nearer than the one after it; where sources alternate, it is not.
    """
    together = min(round(len(again) / max(1, int((~again).sum()))), 4)
    if together < 2 or len(values) < 8:
        return False
    near = float(np.sqrt(np.mean(np.diff(values) ** 2)))
    apart = float(np.sqrt(np.mean((values[together:] - values[:-together]) ** 2)))
    return near > 1.5 * apart


def _backwards(t: Vec, rows: Ints, place: _Place) -> InputError:
    at = int(np.argmax(np.diff(t) <= 0.0)) + 1
    value = f"{t[at] - t[0]:.9g} s after the first row"
    bound = f"after the row before, {t[at - 1] - t[0]:.9g} s"
    return InputError(f"time in {place.at(int(rows[at]))}", value, bound)


def _standing(t: Vec, rows: Ints, place: _Place, again: Bools) -> InputError:
    at, step = int(np.argmax(again)), (t[-1] - t[0]) / (len(t) - 1)
    bound = f"after the row before, {t[at - 1] - t[0]:.9g} s"
    if step > 0.0:
        bound += (
            f" ({int(again.sum())} stamps repeat, and evenly spaced rows do not explain them; if the "
            f"rows are evenly spaced all the same, map t=every:{step:.4g}s)"
        )
    return InputError(
        f"time in {place.at(int(rows[at]))}", f"{t[at] - t[0]:.9g} s after the first row", bound
    )
