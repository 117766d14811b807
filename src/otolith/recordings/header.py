"""Where the table stands in a text: its delimiter, the lines of its names and units, and its first row.

Loggers write much before the table: titles, metadata in quotes, blank lines, comments, rows of units, types
and sources. The table is found by its content and not by the name of the tool: its rows have one width and
hold numbers, and its names are the most informative line of that width before them.
"""

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

from otolith.core.errors import InputError
from otolith.recordings.inscribed import measured
from otolith.recordings.units import canonical, is_unit
from otolith.recordings.words import interpret, split_unit

DELIMITERS: Final = (";", "\t", ",", "|", None)  # None stands for white space
WINDOW: Final = 1000  # number of lines searched for the beginning of the table
MARKS: Final = "#%!"  # characters that begin a comment
_SECTION: Final = re.compile(r"\s*\[[^\]]*\]\s*")  # a line such as [data]
_CLOCK: Final = re.compile(r"(?:.*[T ])?\d{1,3}:\d{2}(?::\d{2})?.*|\d{4}-\d{2}-\d{2}T\d.*")
_PIPED: Final = re.compile(r'([^|]+)\|"?([^|"]*)"?(?:\|[^|]*){2,}')  # NAME|"unit"|min|max|rate
_TAGGED: Final = re.compile(r"[^:]+:([^:]+):([^:]*):\d+:\d+:\d+")  # key:name:unit:digits:0:0


@dataclass(frozen=True, slots=True)
class Place:
    """Where the parts of a table stand; lines are counted from 0, and -1 stands for a missing line."""

    delimiter: str | None
    names: tuple[str, ...]  # (c,)
    units: tuple[str, ...]  # (c,) empty strings where none is stated
    origins: tuple[str, ...]  # (c,) from a row of sources; an empty tuple without such a row
    header: int
    unit_row: int
    first: int  # first line of data


def cells(line: str, delimiter: str | None) -> list[str]:
    """Split a line into cells, without the quotes and blanks around them."""
    if delimiter is None:
        return [cell.strip('"') for cell in line.split()]
    parsed = next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])
    return [cell.strip() for cell in parsed]


def is_number(text: str, *, comma: bool = False) -> bool:
    """Return whether a cell is a number; with `comma`, also one with a decimal comma."""
    try:
        float(text.replace(",", ".") if comma else text)
    except ValueError:
        return False
    return "_" not in text


def is_value(text: str, *, comma: bool = False) -> bool:
    """Return whether a cell is a number, alone or followed by a unit."""
    return is_number(text, comma=comma) or measured(text) is not None


def find(lines: Sequence[str], source: str, header: int | None = None, units: int | None = None) -> Place:
    """Find the table in a text.

    Parameters
    ----------
    lines : all lines of the file.
    header, units : lines of the names and of the units, counted from 1, where the user states them.

    Raises
    ------
    InputError : there is no table, it has no names, or the stated lines do not fit it.
    """
    for option, line in (("header", header), ("units", units)):
        if line is not None and not 1 <= line <= len(lines):
            raise InputError(f"--{option}", line, f"a line of {source}, 1 to {len(lines)}")
    after = max(header or 0, units or 0)
    delimiter, width, start = _rows(lines, after, source)
    lines = _ended(lines, start, delimiter, width)
    if header is None:
        at, names = _names(lines, width, delimiter, source, start)
    else:
        at, names = header - 1, _split(lines[header - 1], delimiter, width)
        names = _with_rows_named(names, lines[start:], width, delimiter)
        if len(names) != width:
            field = f"number of names in line {header} of {source}"
            raise InputError(field, len(names), f"{width}, as many as in the rows from line {start + 1} on")
    unit_row, rows, first = _below_names(lines, at, delimiter, width)
    if units is None and unit_row < 0:
        _refuse_torn_units(lines[at + 1 : first + 1], at + 2, delimiter, width, source)
    if units is not None:
        unit_row, rows[units - 1] = units - 1, _split(lines[units - 1], delimiter, width)
        first = max(first, units)
        if len(rows[unit_row]) != width:
            raise InputError(f"number of units in line {units} of {source}", len(rows[unit_row]), f"{width}")
    stated = rows.get(unit_row, [""] * width)
    named = _numbered([_unwrapped(name) for name in names])
    return Place(
        delimiter=delimiter,
        names=tuple(name for name, _ in named),
        units=tuple(own or unit.strip(" []()-") for (_, own), unit in zip(named, stated, strict=True)),
        origins=_origins([row for line, row in rows.items() if line != unit_row], width),
        header=at,
        unit_row=unit_row,
        first=first,
    )


def _rows(lines: Sequence[str], after: int, source: str) -> tuple[str | None, int, int]:
    """Return delimiter, width and first line of the longest run of rows that hold numbers."""
    window = [(i, lines[i]) for i in range(after, min(len(lines), after + WINDOW)) if _may_be_row(lines[i])]
    best: tuple[tuple[float, ...], str | None, int, int] | None = None
    for order, delimiter in enumerate(DELIMITERS):
        run = _longest_run([(i, cells(line, delimiter)) for i, line in window], comma=delimiter != ",")
        if run is None:
            continue
        rows, width, start, share = run
        score = (float(rows > 2), round(share, 2), float(width), -float(order))
        if best is None or score > best[0]:
            best = score, delimiter, width, start
    if best is not None:
        return best[1:]
    if any(_may_be_row(line) for line in lines):
        raise InputError(f"number of rows in {source}", 0, "at least 2")
    raise InputError(source, "empty", "a table with one line of column names and one row per time")


def _ended(lines: Sequence[str], start: int, delimiter: str | None, width: int) -> Sequence[str]:
    """Return the lines; where only the rows end with a delimiter, the lines before them get one too."""
    if delimiter is None or not lines[start].rstrip().endswith(delimiter):
        return lines
    if any(len(_split(line, delimiter, width)) == width for line in lines[:start]):
        return lines  # the last cell of the rows is blank
    head = [line if line.rstrip().endswith(delimiter) else f"{line}{delimiter}" for line in lines[:start]]
    return [*head, *lines[start:]]


def _may_be_row(line: str) -> bool:
    """Return whether a line may be a row: not blank, not a comment, not the heading of a section."""
    return bool(line.strip()) and line.lstrip()[0] not in MARKS and not _SECTION.fullmatch(line)


def _longest_run(rows: list[tuple[int, list[str]]], *, comma: bool) -> tuple[int, int, int, float] | None:
    """Return the run of rows of equal width that holds most numbers.

    Returns
    -------
    Number of rows, width, first line, and share of the cells that are numbers; None without such rows.
    """
    best: tuple[int, tuple[int, int, int, float]] | None = None
    run: list[tuple[int, int, int]] = []
    width = 0
    for line, row in [*rows, (-1, [])]:
        filled = [cell for cell in row if cell]
        counted = sum(is_value(cell, comma=comma) or bool(_CLOCK.fullmatch(cell)) for cell in filled)
        if run and (len(row) != width or not counted):
            run = _without_names(run)
            numbers = sum(c for _, c, _ in run)
            if best is None or numbers > best[0]:
                best = numbers, (len(run), width, run[0][0], numbers / sum(f for _, _, f in run))
            run = []
        if counted and len(row) > 1:
            width = len(row)
            run.append((line, counted, len(filled)))
    return None if best is None else best[1]


def _without_names(run: list[tuple[int, int, int]]) -> list[tuple[int, int, int]]:
    """Drop the first rows of a run that hold far fewer numbers than the others: names such as "1" and "2"."""
    usual = sorted(counted for _, counted, _ in run)[len(run) // 2]
    start = next(i for i, (_, counted, _) in enumerate(run) if 2 * counted > usual)
    return run[start:]


def _names(
    lines: Sequence[str], width: int, delimiter: str | None, source: str, start: int
) -> tuple[int, list[str]]:
    """Return number and cells of the line before the rows that is most informative; of equals the last."""
    preamble = lines[:start]
    found: list[tuple[tuple[float, int], int, list[str]]] = []
    for line, text in enumerate(preamble):
        row = _split(text, delimiter, width)
        numeric = sum(is_value(cell) for cell in row)
        if len(row) == width and 2 * numeric <= width and any(row) and not _is_unit_row(row):
            own = 0.5 * (len(cells(text.lstrip(MARKS + " "), delimiter)) == width)
            found.append(((_informativeness(row) + own, line), line, row))
    if found:
        _, at, names = max(found)
        return _first_of_repeated(
            at, [line for _, line, row in found if row == names], preamble, delimiter
        ), names
    texts = [i for i in range(start) if preamble[i].strip() and not _SECTION.fullmatch(preamble[i])]
    if not texts:
        raise InputError(f"line {start + 1} of {source}", "numbers", "the names of the columns")
    nearest = max(texts, key=lambda i: (_informativeness(_split(preamble[i], delimiter, width)), i))
    names = _with_rows_named(_split(preamble[nearest], delimiter, width), lines[start:], width, delimiter)
    if len(names) == width:
        return nearest, names
    way = "complete that line, or state the line of the names with --header LINE"
    if delimiter == "," and len(names) < width <= 2 * len(names) and "." not in lines[start]:
        way = "do commas mark decimals and also separate columns? then write decimal points"
    bound = f"{width}, as in the rows from line {start + 1} on ({way})"
    raise InputError(f"number of names in line {nearest + 1} of {source}", len(names), bound)


def _with_rows_named(names: list[str], rows: Sequence[str], width: int, delimiter: str | None) -> list[str]:
    """Add a name for the row numbers if only they have none; R writes tables in this way."""
    if len(names) != width - 1:
        return names
    counts = [cells(row, delimiter)[0] for row in rows[:WINDOW] if _may_be_row(row)]
    numbered = all(count.isdecimal() for count in counts)
    steps = {int(b) - int(a) for a, b in pairwise(counts)} if numbered else set[int]()
    return ["row", *names] if steps == {1} else names


def _first_of_repeated(at: int, same: Sequence[int], preamble: Sequence[str], delimiter: str | None) -> int:
    """Return the first of several equal lines of names if rows of data lie between it and the last one."""
    width = len(_split(preamble[at], delimiter, 0))
    between = [cells(line, delimiter) for line in preamble[same[0] + 1 : at] if _may_be_row(line)]
    numeric = [row for row in between if len(row) == width and any(map(is_value, row))]
    return same[0] if numeric and 2 * len(numeric) > len(between) else at


def _informativeness(row: Sequence[str]) -> float:
    """Score how informative a line of names is: 1 for each quantity, less for units and other words."""
    quantities = sum(1.0 for name in row if (u := _unwrapped(name))[0] and interpret(u[0], u[1]) is not None)
    return (
        quantities
        + sum(0.1 for name in row if split_unit(name)[1])
        + 0.01 * len({name for name in row if name})
    )


def _split(text: str, delimiter: str | None, width: int) -> list[str]:
    """Split a line before the table, which may be a comment or have another delimiter than the rows."""
    bare = text.strip().lstrip(MARKS).strip() if text.lstrip()[:1] in MARKS else text
    own = cells(bare, delimiter)
    if len(own) == width:
        return own
    others = (cells(bare, other) for other in DELIMITERS if other != delimiter)
    return next((row for row in others if len(row) == width), own)


def _below_names(
    lines: Sequence[str], header: int, delimiter: str | None, width: int
) -> tuple[int, dict[int, list[str]], int]:
    """Return the line of the units, the rows of text below the names, and the first line of data."""
    rows: dict[int, list[str]] = {}
    line = header + 1
    while line < len(lines):
        text = lines[line]
        row = _split(text, delimiter, width)
        passive = len(row) != width and (not _may_be_row(text) or not any(map(str.isalnum, text)))
        numeric = [cell for cell in row if is_value(cell, comma=delimiter != ",") or _CLOCK.fullmatch(cell)]
        if not passive and (len(row) != width or (numeric and not _is_unit_row(row))):
            break
        if not passive:
            rows[line] = row
        line += 1
    units = [at for at, row in rows.items() if _is_unit_row(row)]
    return (units[0] if units else -1), rows, line


def _refuse_torn_units(
    lines: Sequence[str], first: int, delimiter: str | None, width: int, source: str
) -> None:
    """Refuse a row of units that has not one unit for each column, because their assignment would be a guess.

    Parameters
    ----------
    lines : the lines that follow the names.
    first : number in the file of the first of these lines, from 1.
    """
    for number, text in enumerate(lines, first):
        row = _split(text, delimiter, width)
        if len(row) != width and _is_unit_row(row):
            bound = (
                f"{width}, one for each column, with - where there is none (or state the line with --units "
                "LINE; or take this one out and state units by hand, as in yaw_rate=NAME:deg/s)"
            )
            raise InputError(f"number of units in line {number} of {source}", len(row), bound)


def _is_unit_row(row: Sequence[str]) -> bool:
    """Return whether most cells are units, and none is a number except 1, the unit of plain numbers."""
    filled = [cell.strip(" []()") for cell in row if cell.strip(" []()-")]
    known = [cell for cell in filled if is_unit(cell)]
    numbers = [cell for cell in filled if is_value(cell) and canonical(cell) != "1"]
    words = [cell for cell in known if not is_number(cell)]
    names = sum(interpret(cell) is not None for cell in filled)
    return bool(words) and not numbers and 2 * len(known) >= len(filled) and names < len(known)


def _origins(rows: Sequence[Sequence[str]], width: int) -> tuple[str, ...]:
    """Join the rows next to the names that state where each column was measured, such as "gps"."""
    return tuple(" ".join(row[i] for row in rows) for i in range(width)) if rows else ()


def _numbered(named: list[tuple[str, str]]) -> list[tuple[str, str]]:
    """Name columns "1" and "2" after one with a unit as components of its vector, in the same unit."""
    out: list[tuple[str, str]] = []
    for name, unit in named:
        follows = bool(out) and name.isdigit() and (name == "1" or out[-1][0] == str(int(name) - 1))
        out.append((name, unit or (out[-1][1] or split_unit(out[-1][0])[1] if follows else "")))
    return out


def _unwrapped(name: str) -> tuple[str, str]:
    """Return name and unit of a name that carries both between marks: ``Yaw|"Deg/Sec"|-120|120|25``."""
    for form in (_PIPED, _TAGGED):
        found = form.fullmatch(name)
        if found:
            return found.group(1).strip(), found.group(2).strip()
    return name, ""
