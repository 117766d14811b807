"""Numbers out of delimited text, fast where all is well, and with the line named where it is not."""

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from operator import methodcaller

import numpy as np

from otolith.core.arrays import Mat
from otolith.core.errors import InputError
from otolith.scenarios.columns import UNITS, Column, canonical


@dataclass(frozen=True, slots=True)
class Table:
    """The text of a log, split into header and body."""

    source: str
    delimiter: str | None  # None: any white space
    names: list[str]  # (c,) of the columns
    units: list[str]  # (c,) from a row of their own, empty where there is none
    body: list[str]  # (n,) lines of numbers
    first_line: int  # number in the file, from 1, of body[0]
    notes: tuple[str, ...] = ()

    def where(self, row: int) -> str:
        """Where a row of the body stands, for error sentences."""
        return f"line {self.first_line + row} of {self.source}"

    def numbers(self, columns: Sequence[Column]) -> Mat:
        """The chosen columns as they stand in the file, without conversion: (n, len(columns)), all finite.

        Raises
        ------
        InputError : a cell is empty, text, NaN or infinite.
        """
        try:
            values = np.loadtxt(
                self.body,
                delimiter=self.delimiter,
                usecols=[column.index for column in columns],
                comments=None,
                ndmin=2,
                dtype=np.float64,
            )
        except ValueError:
            raise _bad_cell(self, columns) from None
        if not np.isfinite(values).all():
            raise _bad_cell(self, columns)
        return values


def decode(data: bytes, source: str) -> tuple[str, tuple[str, ...]]:
    """Text of a log's bytes, and a note where they are not UTF-8: spreadsheets write others.

    Raises
    ------
    InputError : the bytes are no text.
    """
    wide = data.startswith((b"\xff\xfe", b"\xfe\xff"))
    for encoding in ["utf-16"] if wide else ["utf-8-sig", "cp1252"]:
        try:
            text = data.decode(encoding)
        except UnicodeDecodeError:
            continue
        if "\0" in text:
            break
        return text, () if encoding == "utf-8-sig" else (f"{source}: not in UTF-8, read as {encoding}",)
    raise InputError(f"log {source}", "not text", "a text file, or one with the ending of its format")


def split(text: str, source: str, notes: tuple[str, ...] = ()) -> Table:
    """Header and body of a log; lines before the header that are empty or start with # are skipped.

    Where numbers follow at once, the last line that starts with # holds the names, as numpy and the public
    database of race tracks write them.

    Delimiter: the first of semicolon, tab, comma and bar that the header holds, else white space.

    Raises
    ------
    InputError : the file is empty, has no header, or has rows of another width.
    """
    lines = text.removeprefix("\ufeff").splitlines()
    while lines and not lines[-1].strip():
        lines.pop()
    start = next((i for i, line in enumerate(lines) if line.strip() and not line.startswith("#")), None)
    if start is None:
        raise InputError(source, "empty", "a table with one line of column names and one row per time")
    header = lines[start]
    delimiter = next((d for d in ";\t,|" if d in header), None)
    names = _cells(header, delimiter)
    if all(_is_number(name) for name in names):
        names = _commented_header(lines[:start], len(names), delimiter)
        start -= 1
    if not names:
        raise InputError(f"line {start + 2} of {source}", "numbers", "the names of the columns")
    body, first_line = lines[start + 1 :], start + 2
    units = [""] * len(names)
    if body and _is_unit_row(_cells(body[0], delimiter)):
        units = [cell.strip(" []()-") for cell in _cells(body[0], delimiter)]
        body, first_line = body[1:], first_line + 1
    if delimiter != "," and any("," in line for line in body):
        body = "\n".join(body).replace(",", ".").split("\n")
    if any('"' in line for line in body):
        body = "\n".join(body).replace('"', "").split("\n")
    table = Table(source, delimiter, names, units, body, first_line, notes)
    _check_widths(table)
    return table


def _check_widths(table: Table) -> None:
    width, source = len(table.names), table.source
    if len(table.body) < 2:
        raise InputError(f"number of rows in {source}", len(table.body), "at least 2")
    if table.delimiter is None:
        widths = [len(line.split()) for line in table.body]
    else:
        widths = [count + 1 for count in map(methodcaller("count", table.delimiter), table.body)]
    counts = np.array(widths)
    wrong = np.flatnonzero(counts != width)
    if all(not table.body[row].strip() for row in wrong[:1]) and len(wrong):
        raise InputError(table.where(int(wrong[0])), "empty", "a row of numbers")
    if len(wrong):
        where = f"number of values in {table.where(int(wrong[0]))}"
        raise InputError(where, int(counts[wrong[0]]), f"{width}, as in the header")


def _bad_cell(table: Table, columns: Sequence[Column]) -> InputError:
    for row, line in enumerate(table.body):
        cells = line.split(table.delimiter)
        for column in columns:
            cell = cells[column.index].strip()
            if not _is_number(cell) or not np.isfinite(float(cell)):
                where = f"{column.name!r} in {table.where(row)}"
                return InputError(where, repr(cell) if cell else "empty", "a finite number")
    return InputError(table.source, "not readable as numbers", "a table of numbers")


def _commented_header(lines: list[str], width: int, delimiter: str | None) -> list[str]:
    """The names in the last of these lines, or none if it does not hold `width` of them."""
    last = next((line for line in reversed(lines) if line.startswith("#")), "")
    names = _cells(last.lstrip("# "), delimiter)
    return names if len(names) == width and not any(map(_is_number, names)) else []


def _cells(line: str, delimiter: str | None) -> list[str]:
    if delimiter is None:
        return line.split()
    return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True))]


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _is_unit_row(cells: list[str]) -> bool:
    known = {unit for units in UNITS.values() for unit in units}
    return any(canonical(cell.strip(" []()")) in known for cell in cells) and not any(map(_is_number, cells))
