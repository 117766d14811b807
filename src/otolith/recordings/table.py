"""Numbers from delimited text: read fast if all cells are sound, else with the faulty line named."""

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from operator import methodcaller
from typing import Final

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.disk import check_lines
from otolith.core.errors import InputError
from otolith.recordings import vbox
from otolith.recordings.channels import Layout
from otolith.recordings.columns import Column
from otolith.recordings.header import MARKS, Place, cells, find, is_number, is_value
from otolith.recordings.inscribed import without_units
from otolith.recordings.recorded import Cells

LONGEST_LINE: Final = 100_000  # characters; a thousand channels take 20,000
FOOTER: Final = 20  # number of last lines in which text below the table is looked for
_QUOTED: Final = re.compile(r'"[+-]?\d+,(\d+)"(?=,|$|\r|\n)', re.MULTILINE)  # in a table separated by commas
_FORTRAN: Final = re.compile(r"(?<![\w.])([+-]?(?:\d+[.,]\d*|[.,]\d+))[dD]([+-]\d{1,3})(?![\w.])")  # 1.5D+00
_NMEA: Final = re.compile(r"\$[A-Z]{2}[A-Z]{3},")
_WORDS: Final = {";": "semicolons", "\t": "tabs", ",": "commas", "|": "bars", None: "blanks"}


@dataclass(frozen=True, slots=True)
class Table:
    """The text of a log, split into names, units and rows."""

    source: str
    delimiter: str | None  # None stands for any white space
    names: list[str]  # (c,) names of the columns
    units: list[str]  # (c,) from a row of units, empty where there is none
    body: list[str]  # (n,) the rows, each as one line
    lines: Ints  # (n,) line number of each row in the file, from 1
    notes: tuple[str, ...] = ()
    origins: tuple[str, ...] = ()
    layout: Layout = field(default_factory=lambda: Layout(form="text"))
    place: str = "line"
    clocked: bool = False

    def where(self, row: int) -> str:
        """Describe where a row of the body stands, for error messages."""
        return f"line {self.lines[row]} of {self.source}"

    def rows(self, _index: int) -> Ints:
        """Return the line of each cell of a column."""
        return self.lines

    def clock(self, _index: int) -> Vec | None:
        """Return None: all columns of a table share one clock, which is one of them."""
        return None

    def cells(self, indices: Sequence[int]) -> list[Cells]:
        """Return the cells of these columns: numbers where all cells are numbers, otherwise texts."""
        if not indices:
            return []
        try:
            return list(self._loaded(indices).T)
        except ValueError:
            pass
        parsed = self._parsed()
        out: list[Cells] = []
        for index in indices:
            texts = [row[index].strip() for row in parsed]
            try:
                out.append(np.array(texts, dtype=np.float64) if "_" not in "".join(texts) else texts)
            except ValueError:
                out.append(texts)
        return out

    def numbers(self, columns: Sequence[Column]) -> Mat:
        """Return these columns of the file without conversion: (n, len(columns)), all finite.

        Raises
        ------
        InputError : a cell is empty, text, NaN or infinite.
        """
        try:
            values = self._loaded([column.index for column in columns])
        except ValueError:
            raise _bad_cell(self, columns) from None
        if not np.isfinite(values).all():
            raise _bad_cell(self, columns)
        return values

    def _loaded(self, indices: Sequence[int]) -> Mat:
        return np.loadtxt(
            self.body, delimiter=self.delimiter, usecols=indices, comments=None, ndmin=2, dtype=np.float64
        )

    def _parsed(self) -> list[list[str]]:
        if self.delimiter is None:
            return [line.split() for line in self.body]
        if any('"' in line for line in self.body):
            return list(csv.reader(self.body, delimiter=self.delimiter, skipinitialspace=True))
        return [line.split(self.delimiter) for line in self.body]


def decode(data: bytes, source: str) -> tuple[str, tuple[str, ...]]:
    """Decode the bytes of a log, and note where they are not UTF-8, as some spreadsheets write them.

    Raises
    ------
    InputError : the bytes are not text.
    """
    wide = data.startswith((b"\xff\xfe", b"\xfe\xff"))
    # space on a memory card that was reserved when the power failed
    data = data if wide else data.rstrip(b"\0")
    for encoding in ["utf-16"] if wide else ["utf-8-sig", "cp1252"]:
        try:
            text = data.decode(encoding)
        except UnicodeDecodeError:
            continue
        if "\0" in text:
            break
        return text, () if encoding == "utf-8-sig" else (f"{source}: not in UTF-8, read as {encoding}",)
    raise InputError(f"log {source}", "not text", "a text file, or one with the ending of its format")


def split(
    text: str,
    source: str,
    notes: tuple[str, ...] = (),
    *,
    header: int | None = None,
    units: int | None = None,
) -> Table:
    """Split a text into the names, units and rows of its table, wherever it stands; see `header.find`.

    Delimiter (comma, semicolon, tab, bar, white space), decimal commas, quotes, byte order mark, line ends,
    rows of units and sources, comments and blank lines are recognised.

    Parameters
    ----------
    header, units : lines of the names and of the units, counted from 1, where the user states them.

    Raises
    ------
    InputError : the file is empty, has no table or no names, or rows have different widths.
    """
    lines = _plain_numbers(text.removeprefix("\ufeff")).splitlines()
    check_lines(lines, source, most=LONGEST_LINE)
    _refuse_nmea(lines, source)
    place = find(lines, source, header, units)
    kept, left = _kept(place, lines, source)
    body = [lines[i] for i in kept]
    if place.delimiter != "," and any("," in line for line in body):
        body = "\n".join(body).replace(",", ".").split("\n")
    if any('"' in line for line in body) and not _quoted_delimiters(body, place.delimiter):
        body = "\n".join(body).replace('"', "").split("\n")
    body, stated = without_units(body, place.delimiter, place.units)
    more = tuple[str, ...]()
    if vbox.is_vbox(lines[: place.first]):
        stated = vbox.stated_units(place.names, place.units, lines[: place.first])
        more = (
            f"{source}: a VBOX file, whose coordinates are minutes of arc, west positive; read together with "
            "a heading only",
        )
    table = Table(
        source=source,
        delimiter=place.delimiter,
        names=list(place.names),
        units=stated,
        body=body,
        lines=np.array(kept, dtype=np.int64) + 1,
        notes=notes + _layout_notes(place, lines, kept, source) + left + more,
        origins=place.origins,
        layout=Layout(
            form=f"text, columns separated by {_WORDS[place.delimiter]}",
            header=f"line {place.header + 1}",
            units=f"line {place.unit_row + 1}" if place.unit_row >= 0 else "",
            first=f"line {place.first + 1}",
            rows=len(body),
        ),
    )
    _check_widths(table)
    return table


def _footer(last: Sequence[str], delimiter: str | None) -> int:
    """Return how many of the last lines are text below the table, without any number."""
    numeric = [any(is_value(cell, comma=delimiter != ",") for cell in cells(x, delimiter)) for x in last]
    return numeric[::-1].index(True) if any(numeric) else 0


def _kept(place: Place, lines: Sequence[str], source: str) -> tuple[list[int], tuple[str, ...]]:
    """Return which lines are rows, and notes about repeated names, text below and a torn last row."""
    names = lines[place.header].strip()
    rows = [i for i in range(place.first, len(lines)) if (line := lines[i].lstrip()) and line[0] not in MARKS]
    again = [i for i in rows if lines[i].strip() == names]
    rows = [i for i in rows if lines[i].strip() != names] if again else rows
    below = _footer([lines[i] for i in rows[-FOOTER:]], place.delimiter)
    notes = []
    if again:
        places = ", ".join(str(i + 1) for i in again[:3])
        notes.append(f"{source}: the names stand again in line {places}: left out")
    if below:
        notes.append(f"{source}: {below} line{'s' if below > 1 else ''} of text below the table left out")
    rows = rows[: len(rows) - below]
    width = len(place.names)
    if rows and (count := len(cells(lines[rows[-1]], place.delimiter))) < width:
        last = rows.pop() + 1
        notes.append(f"{source}: the last row, line {last}, is torn: {count} of {width} cells; left out")
    return rows, tuple(notes)


def _plain_numbers(text: str) -> str:
    """Return the text with plain minus signs, exponents with E, and no decimal commas in quoted cells.

    Fortran writes 1.5D+00 in double precision. If all quoted numbers have three digits after the comma, they
    may be thousands and stay unchanged.
    """
    text = text.replace("\u2212", "-")
    if _FORTRAN.search(text, 0, 100_000):
        text = _FORTRAN.sub(r"\1E\2", text)
    behind = {len(digits) for digits in _QUOTED.findall(text[:100_000])}
    return _QUOTED.sub(lambda m: m.group().strip('"').replace(",", "."), text) if behind - {3} else text


def _refuse_nmea(lines: Sequence[str], source: str) -> None:
    """Refuse the sentences of a satellite receiver: they hold positions but no forces."""
    if lines and _NMEA.match(lines[0]):
        bound = "a drive with accelerations (a logger writes such sentences beside those of its sensors)"
        raise InputError(source, "NMEA 0183, places of a receiver without forces", bound)


def _quoted_delimiters(body: Sequence[str], delimiter: str | None) -> bool:
    """Return whether quoted cells contain delimiters, so that the quotes must not be removed."""
    if delimiter is None:
        return False
    quoted = (line for line in body if '"' in line)
    return any(
        line.count(delimiter) + 1 != len(next(csv.reader([line], delimiter=delimiter))) for line in quoted
    )


def _layout_notes(place: Place, lines: Sequence[str], kept: Sequence[int], source: str) -> tuple[str, ...]:
    """Note where the table stands if not simply in the first line, and which lines are left out."""
    notes = []
    plain = place.first - place.header - 1 == (place.unit_row >= 0)
    before = sum(bool(line.strip()) for line in lines[: place.header])
    if before or not plain:
        units = f", units in line {place.unit_row + 1}" if place.unit_row >= 0 else ""
        notes.append(
            f"{source}: names in line {place.header + 1}{units}, data from line {place.first + 1}"
            + (f"; {before} lines before are not read" if before else "")
        )
    inside = [line for line in lines[place.first : kept[-1] if kept else 0] if not line.strip()]
    comments = sum(line.lstrip()[:1] in MARKS for line in lines[place.first :] if line.strip())
    if inside or comments:
        notes.append(
            f"{source}: {len(inside)} blank lines and {comments} comments among the data were left out"
        )
    return tuple(notes)


def _check_widths(table: Table) -> None:
    width, source = len(table.names), table.source
    if len(table.body) < 2:
        raise InputError(f"number of rows in {source}", len(table.body), "at least 2")
    if table.delimiter is None:
        widths = [len(line.split()) for line in table.body]
    elif any('"' in line for line in table.body):
        widths = [len(row) for row in csv.reader(table.body, delimiter=table.delimiter)]
    else:
        widths = [count + 1 for count in map(methodcaller("count", table.delimiter), table.body)]
    wrong = np.flatnonzero(np.array(widths) != width)
    if len(wrong):
        where = f"number of values in {table.where(int(wrong[0]))}"
        raise InputError(where, int(widths[wrong[0]]), f"{width}, as in the header")


def _bad_cell(table: Table, columns: Sequence[Column]) -> InputError:
    for row, line in enumerate(table.body):
        cells = line.split(table.delimiter)
        for column in columns:
            cell = cells[column.index].strip()
            if not is_number(cell) or not np.isfinite(float(cell)):
                where = f"{column.name!r} in {table.where(row)}"
                return InputError(where, repr(cell) if cell else "empty", "a finite number")
    return InputError(table.source, "not readable as numbers", "a table of numbers")
