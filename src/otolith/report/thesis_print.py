"""The reproduction of the thesis as a PDF for print: tables as set text, diagrams between them."""

import textwrap
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import matplotlib as mpl
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from otolith.report.thesis import (
    MARKS,
    RULE,
    Values,
    beside,
    column_of,
    heading_of,
    number,
    pivot,
    sorted_reasons,
    unexplained,
    wordy,
)
from otolith.report.thesis_figures import columns, draw_on

PAPER: Final = (8.27, 11.69)  # [in] A4
MARGIN: Final = 0.6  # [in]
SIZES: Final = {"title": 15.0, "heading": 10.0, "text": 8.0, "gap": 4.0, "head": 6.8, "table": 6.8}  # [pt]
LEADING: Final = 1.42  # line distance over size
COLUMNS: Final = {"title": 60, "heading": 88, "text": 118, "table": 124}  # characters of a line
KEPT: Final = {"heading": 6.0, "head": 4.0}  # lines that must still fit on the page below such a one
DIAGRAM: Final = (3.0, 2.15)  # [in] width at most, height
FRAME: Final = (0.55, 0.78, 0.25, 0.6)  # [in] left, below, above and right of the axes, for their words
BARE: Final = 0.15  # [in] right of axes without words there
MONO: Final = "DejaVu Sans Mono"
LINESPACING: Final = LEADING / 1.164  # matplotlib counts in heights of this letter
GLYPH: Final = 0.602  # width of its letters over their size
HEAD: Final = 14  # characters up to which a column's head stays on one line

Line = tuple[str, str]  # a key of SIZES, the text


def save_pdf(document: Values, path: Path) -> None:
    """Write the reproduction as PDF; `document` as for `otolith.report.thesis.page`."""
    with mpl.rc_context({"pdf.fonttype": 42}), PdfPages(path, metadata={"CreationDate": None}) as pdf:
        writer = _Writer(pdf)
        writer.write(_front(document))
        for name, item in document["items"].items():
            opening = list(_opening(name, item))
            if item["panels"]:
                writer.keep(opening, DIAGRAM[1])
            writer.write(iter(opening))
            if item["panels"]:
                writer.picture(item["panels"])
            writer.write(_tables(name, item, document["items"]))
        writer.end()


class _Writer:
    """Sets lines on pages, one below the other."""

    def __init__(self, pdf: PdfPages) -> None:
        self._pdf = pdf
        self._page = 1
        self._head = ""  # of the table that is being set
        self._begin()

    def _begin(self) -> None:
        self._figure = Figure(figsize=PAPER)
        self._y = PAPER[1] - MARGIN  # [in] of the next line's top

    def write(self, lines: Iterator[Line]) -> None:
        """Set lines; a heading is never last on a page, a table's head is on each of its pages."""
        for kind, text in lines:
            if kind != "table":
                self._head = text if kind == "head" else ""
            room = KEPT.get(kind, 1.0) + text.count("\n")
            if self._y - room * _height(kind) < MARGIN:
                self._turn()
                if kind == "table" and self._head:
                    self._set("head", self._head)
            self._set(kind, text)

    def _set(self, kind: str, text: str) -> None:
        self._figure.text(
            MARGIN / PAPER[0],
            self._y / PAPER[1],
            text,
            fontsize=SIZES[kind],
            linespacing=LINESPACING,
            family=MONO if kind in ("head", "table") else "DejaVu Sans",
            weight="bold" if kind in ("title", "heading", "head") else "normal",
            va="top",
            parse_math=False,
        )
        self._y -= _height(kind) * (1 + text.count("\n"))
        if kind == "head":
            self._rule(max(map(len, text.split("\n"))))

    def _rule(self, characters: int) -> None:
        """A line below a table's head, as wide as its text."""
        wide = characters * SIZES["head"] * GLYPH / 72.0
        y = (self._y + 0.02) / PAPER[1]
        line = Line2D([MARGIN / PAPER[0], (MARGIN + wide) / PAPER[0]], [y, y], color="black", linewidth=0.5)
        self._figure.add_artist(line)

    def keep(self, lines: Sequence[Line], below: float) -> None:
        """Begin a page where lines, and what stands so high [in] below them, do not fit on this one."""
        high = sum(_height(kind) for kind, _ in lines) + below
        if self._y - high < MARGIN and high < PAPER[1] - 2.0 * MARGIN:
            self._turn()

    def picture(self, panels: Sequence[Values]) -> None:
        """Diagrams side by side below the text so far, as many rows as they need."""
        across = columns(len(panels))
        width = min(DIAGRAM[0], (PAPER[0] - 2.0 * MARGIN) / across)
        left, below, above, _ = FRAME
        for place, panel in enumerate(panels):
            right = FRAME[3] if panel["right_label"] else BARE
            if place % across == 0:
                if self._y - DIAGRAM[1] < MARGIN:
                    self._turn()
                self._y -= DIAGRAM[1]
            x = MARGIN + (place % across) * width + left
            box = (x, self._y + below, width - left - right, DIAGRAM[1] - below - above)
            scale = (PAPER[0], PAPER[1], PAPER[0], PAPER[1])
            axes = self._figure.add_axes(tuple(a / b for a, b in zip(box, scale, strict=True)))  # type: ignore[arg-type]
            draw_on(axes, panel)

    def _turn(self) -> None:
        if self._figure.texts or self._figure.axes:
            self._figure.text(
                0.5, 0.5 * MARGIN / PAPER[1], str(self._page), fontsize=SIZES["text"], ha="center"
            )
            self._pdf.savefig(self._figure)  # type: ignore[no-untyped-call]
            self._page += 1
        self._begin()

    def end(self) -> None:
        """Write the last page."""
        self._turn()


def _height(kind: str) -> float:
    """Of a line [in]."""
    return SIZES[kind] * LEADING / 72.0


def _front(document: Values) -> Iterator[Line]:
    yield "title", "The thesis’s numbers beside ours"
    text = (
        "Hybrid MPC based Motion Cueing Algorithm for Driving Simulators (TU Delft; arXiv:2304.03232), "
        f"computed again by Otolith {document['version']} on {document['date']} in "
        f"{number(round(document['seconds']))} s."
    )
    yield from _wrapped(text)
    yield "text", ""
    yield from _wrapped("; ".join(f"{MARKS[name]} {name}: {words}" for name, words in RULE) + ".")
    yield "text", ""
    with_numbers = {name: item for name, item in document["items"].items() if item["numbers"]}
    yield "head", f"{'':16}" + "".join(f"{name:>14}" for name in MARKS) + f"{'statements':>14}"
    for name, item in with_numbers.items():
        claims = f"{sum(c['holds'] for c in item['claims'])} of {len(item['claims'])}"
        counts = "".join(f"{item['verdicts'][key]:>14}" for key in MARKS)
        yield "table", f"{name:16}{counts}{claims:>14}"
    yield "gap", ""


def _opening(name: str, item: Values) -> Iterator[Line]:
    """What stands above an item's diagrams."""
    yield "text", ""
    for line in textwrap.wrap(heading_of(name, item), COLUMNS["heading"]):
        yield "heading", line
    yield from _wrapped(f"thesis, section {item['section']}. {item['text']}")
    for claim in item["claims"]:
        answer = "yes" if claim["holds"] else "no"
        yield from _wrapped(f"{answer}: {claim['text']} ({claim['figures']})", "– ")


def _tables(name: str, item: Values, items: Mapping[str, Values]) -> Iterator[Line]:
    """What stands below them."""
    if item["numbers"]:
        yield "gap", ""
        yield "text", "published / ours / ratio"
        yield from _numbers(item["numbers"])
    for grid in item["grids"]:
        yield "gap", ""
        yield from _wrapped(grid["title"])
        yield from _columns([grid["header"], *grid["rows"]])
    yield "gap", ""
    if told := unexplained(name, items):
        yield from _wrapped(told)
    for heading, studies in sorted_reasons(name, items):
        titles = "; ".join(items[study]["title"] if study in items else study for study in studies)
        yield from _wrapped(f"{heading} {titles}.")


def _wrapped(text: str, mark: str = "") -> Iterator[Line]:
    for place, line in enumerate(textwrap.wrap(text, COLUMNS["text"] - len(mark))):
        yield "text", (mark if place == 0 else " " * len(mark)) + line


def _numbers(numbers: Sequence[Values]) -> Iterator[Line]:
    columns, rows = pivot(numbers)
    table: list[list[Any]] = [["", *(column_of(column) for column in columns)]]
    for row, cells in rows.items():
        table.append([row, *(_cell(cells.get(column)) for column in columns)])
    yield from _columns(table)


def _cell(one: Values | None) -> str:
    if one is None:
        return "–"
    ratio = "" if one["ratio"] is None else f" {one['ratio']:.2f}"
    bound = ">" if one["at_least"] else ""
    printed, ours = beside(one["published"], one["ours"])
    return f"{bound}{printed} / {ours}{ratio} {MARKS[one['verdict']]}"


def _columns(rows: Sequence[Sequence[Any]]) -> Iterator[Line]:
    """Rows in aligned columns, words to the left; long heads are broken, a table too wide goes on below."""
    body = [[number(cell) for cell in row] for row in rows[1:]]
    heads = [
        _broken(str(cell), max((len(row[k]) for row in body), default=0)) for k, cell in enumerate(rows[0])
    ]
    widths = [max(map(len, [*head, *(row[k] for row in body)])) for k, head in enumerate(heads)]
    left = [k == 0 or wordy([row[k] for row in rows[1:]]) for k in range(len(widths))]

    def line(cells: Sequence[str], chosen: Sequence[int]) -> str:
        set_ = (cells[k].ljust(widths[k]) if left[k] else cells[k].rjust(widths[k]) for k in (0, *chosen))
        return "  ".join(set_)[: COLUMNS["table"]]

    for place, chosen in enumerate(_fitting(widths)):
        if place:
            yield "gap", ""
        deep = max(len(heads[k]) for k in (0, *chosen))
        padded = [[""] * (deep - len(head)) + head for head in heads]
        head = [line([cells[level] for cells in padded], chosen) for level in range(deep)]
        yield "head", "\n".join(head)
        for row in body:
            yield "table", line(row, chosen)


def _broken(head: str, body: int) -> list[str]:
    """A column's head on several lines where it is much wider than what stands below."""
    return textwrap.wrap(head, max(body, HEAD), break_long_words=False) or [""]


def _fitting(widths: Sequence[int]) -> Iterator[list[int]]:
    """Groups of columns that fit beside the first."""
    group: list[int] = []
    used = widths[0]
    for k in range(1, len(widths)):
        if group and used + widths[k] + 2 > COLUMNS["table"]:
            yield group
            group, used = [], widths[0]
        group.append(k)
        used += widths[k] + 2
    yield group
