"""Where the table stands in a text: its delimiter, the lines of its names and units, and its first row.

Loggers write much before the table: titles, metadata in quotes, blank lines, comments, rows of units, types
and sources. The table is found by its content and not by the tool's name: its rows are of one width and hold
numbers, and its names are the line before them, of that width, that says the most.
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
from otolith.recordings.words import parted, tells

DELIMITERS: Final = (";", "\t", ",", "|", None)  # None: white space
WINDOW: Final = 1000  # lines that are searched for the beginning of the table
MARKS: Final = "#%!"  # that comments begin with
_SECTION: Final = re.compile(r"\s*\[[^\]]*\]\s*")  # a line such as [data]
_CLOCK: Final = re.compile(r"(?:.*[T ])?\d{1,3}:\d{2}(?::\d{2})?.*|\d{4}-\d{2}-\d{2}T\d.*")
_PIPED: Final = re.compile(r'([^|]+)\|"?([^|"]*)"?(?:\|[^|]*){2,}')  # NAME|"unit"|min|max|rate
_TAGGED: Final = re.compile(r"[^:]+:([^:]+):([^:]*):\d+:\d+:\d+")  # key:name:unit:digits:0:0


@dataclass(frozen=True, slots=True)
class Place:
    """Where the parts of a table stand; lines are counted from 0, -1 where there is none."""

    delimiter: str | None
    names: tuple[str, ...]  # (c,)
    units: tuple[str, ...]  # (c,) empty where none is stated
    origins: tuple[str, ...]  # (c,) from a row of sources; or nothing at all
    header: int
    unit_row: int
    first: int  # of the rows of data


def cells(line: str, delimiter: str | None) -> list[str]:
    """The cells of a line, without the quotes and blanks around them."""
    if delimiter is None:
        return [cell.strip('"') for cell in line.split()]
    parsed = next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])
    return [cell.strip() for cell in parsed]


def is_number(text: str, *, comma: bool = False) -> bool:
    """Return whether a cell is a number, with a decimal comma too if `comma`."""
    try:
        float(text.replace(",", ".") if comma else text)
    except ValueError:
        return False
    return "_" not in text


def is_value(text: str, *, comma: bool = False) -> bool:
    """Return whether a cell is a number, alone or with a unit behind it."""
    return is_number(text, comma=comma) or measured(text) is not None


def find(lines: Sequence[str], source: str, header: int | None = None, units: int | None = None) -> Place:
    """Find the table in a text.

    Parameters
    ----------
    lines : of the file.
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
    unit_row, rows, first = _beside(lines, at, delimiter, width)
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
    """Delimiter, width and first line of the longest run of rows that hold numbers."""
    window = [(i, lines[i]) for i in range(after, min(len(lines), after + WINDOW)) if _holds(lines[i])]
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
    if any(_holds(line) for line in lines):
        raise InputError(f"number of rows in {source}", 0, "at least 2")
    raise InputError(source, "empty", "a table with one line of column names and one row per time")


def _ended(lines: Sequence[str], start: int, delimiter: str | None, width: int) -> Sequence[str]:
    """The lines, those before the rows ended with a delimiter if only the rows are."""
    if delimiter is None or not lines[start].rstrip().endswith(delimiter):
        return lines
    if any(len(_split(line, delimiter, width)) == width for line in lines[:start]):
        return lines  # the rows' last cell is blank
    head = [line if line.rstrip().endswith(delimiter) else f"{line}{delimiter}" for line in lines[:start]]
    return [*head, *lines[start:]]


def _holds(line: str) -> bool:
    """Return whether a line may be a row: not blank, no comment, no mark of a section."""
    return bool(line.strip()) and line.lstrip()[0] not in MARKS and not _SECTION.fullmatch(line)


def _longest_run(rows: list[tuple[int, list[str]]], *, comma: bool) -> tuple[int, int, int, float] | None:
    """Number of rows, width, first line and share of numbers of the run of equal width with most numbers."""
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
    """The run without first rows that hold far fewer numbers than the others: names such as "1" and "2"."""
    usual = sorted(counted for _, counted, _ in run)[len(run) // 2]
    start = next(i for i, (_, counted, _) in enumerate(run) if 2 * counted > usual)
    return run[start:]


def _names(
    lines: Sequence[str], width: int, delimiter: str | None, source: str, start: int
) -> tuple[int, list[str]]:
    """The line of that width before the rows that says the most, the last of equals."""
    preamble = lines[:start]
    found: list[tuple[tuple[float, int], int, list[str]]] = []
    for line, text in enumerate(preamble):
        row = _split(text, delimiter, width)
        numeric = sum(is_value(cell) for cell in row)
        if len(row) == width and 2 * numeric <= width and any(row) and not _is_unit_row(row):
            own = 0.5 * (len(cells(text.lstrip(MARKS + " "), delimiter)) == width)
            found.append(((_says(row) + own, line), line, row))
    if found:
        _, at, names = max(found)
        return _first_of_repeated(
            at, [line for _, line, row in found if row == names], preamble, delimiter
        ), names
    texts = [i for i in range(start) if preamble[i].strip() and not _SECTION.fullmatch(preamble[i])]
    if not texts:
        raise InputError(f"line {start + 1} of {source}", "numbers", "the names of the columns")
    nearest = max(texts, key=lambda i: (_says(_split(preamble[i], delimiter, width)), i))
    names = _with_rows_named(_split(preamble[nearest], delimiter, width), lines[start:], width, delimiter)
    if len(names) == width:
        return nearest, names
    way = "complete that line, or state the line of the names with --header LINE"
    if delimiter == "," and len(names) < width <= 2 * len(names) and "." not in lines[start]:
        way = "decimal commas beside commas that part columns? then write decimal points"
    bound = f"{width}, as in the rows from line {start + 1} on ({way})"
    raise InputError(f"number of names in line {nearest + 1} of {source}", len(names), bound)


def _with_rows_named(names: list[str], rows: Sequence[str], width: int, delimiter: str | None) -> list[str]:
    """The names, with one for the numbers of the rows if only those have none, as R writes a table."""
    if len(names) != width - 1:
        return names
    counts = [cells(row, delimiter)[0] for row in rows[:WINDOW] if _holds(row)]
    numbered = all(count.isdecimal() for count in counts)
    steps = {int(b) - int(a) for a, b in pairwise(counts)} if numbered else set[int]()
    return ["row", *names] if steps == {1} else names


def _first_of_repeated(at: int, same: Sequence[int], preamble: Sequence[str], delimiter: str | None) -> int:
    """The first of equal lines of names, if rows of data lie between it and the last one."""
    width = len(_split(preamble[at], delimiter, 0))
    between = [cells(line, delimiter) for line in preamble[same[0] + 1 : at] if _holds(line)]
    numeric = [row for row in between if len(row) == width and any(map(is_value, row))]
    return same[0] if numeric and 2 * len(numeric) > len(between) else at


def _says(row: Sequence[str]) -> float:
    """How much a line says as one of names: quantities count one, units in brackets and mere words less."""
    said = sum(1.0 for name in row if (u := _unwrapped(name))[0] and tells(u[0], u[1]) is not None)
    return said + sum(0.1 for name in row if parted(name)[1]) + 0.01 * len({name for name in row if name})


def _split(text: str, delimiter: str | None, width: int) -> list[str]:
    """The cells of a line before the table, which may be a comment or parted otherwise than the rows."""
    bare = text.strip().lstrip(MARKS).strip() if text.lstrip()[:1] in MARKS else text
    own = cells(bare, delimiter)
    if len(own) == width:
        return own
    others = (cells(bare, other) for other in DELIMITERS if other != delimiter)
    return next((row for row in others if len(row) == width), own)


def _beside(
    lines: Sequence[str], header: int, delimiter: str | None, width: int
) -> tuple[int, dict[int, list[str]], int]:
    """Line of the units, rows without numbers that follow the names, and the first line of data."""
    rows: dict[int, list[str]] = {}
    line = header + 1
    while line < len(lines):
        text = lines[line]
        row = _split(text, delimiter, width)
        passive = len(row) != width and (not _holds(text) or not any(map(str.isalnum, text)))
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
    """Refuse a row of units that has not one for each column: which unit is whose is a guess.

    `first` is the number in the file of the first of these lines, which follow the names.
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
    """Return whether most of what stands here are units, and no number but the 1 of what has none."""
    filled = [cell.strip(" []()") for cell in row if cell.strip(" []()-")]
    known = [cell for cell in filled if is_unit(cell)]
    numbers = [cell for cell in filled if is_value(cell) and canonical(cell) != "1"]
    words = [cell for cell in known if not is_number(cell)]
    names = sum(tells(cell) is not None for cell in filled)
    return bool(words) and not numbers and 2 * len(known) >= len(filled) and names < len(known)


def _origins(rows: Sequence[Sequence[str]], width: int) -> tuple[str, ...]:
    """What rows beside the names say of where each column was measured, joined."""
    return tuple(" ".join(row[i] for row in rows) for i in range(width)) if rows else ()


def _numbered(named: list[tuple[str, str]]) -> list[tuple[str, str]]:
    """Columns named "1" and "2" after one with a unit are the other parts of its vector, in its unit."""
    out: list[tuple[str, str]] = []
    for name, unit in named:
        follows = bool(out) and name.isdigit() and (name == "1" or out[-1][0] == str(int(name) - 1))
        out.append((name, unit or (out[-1][1] or parted(out[-1][0])[1] if follows else "")))
    return out


def _unwrapped(name: str) -> tuple[str, str]:
    """Name and unit of a name that carries both between marks: ``Yaw|"Deg/Sec"|-120|120|25``."""
    for form in (_PIPED, _TAGGED):
        found = form.fullmatch(name)
        if found:
            return found.group(1).strip(), found.group(2).strip()
    return name, ""
