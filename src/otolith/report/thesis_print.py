"""The reproduction of the thesis as a PDF for print: tables as set text, diagrams between them."""

import textwrap
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import matplotlib as mpl
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure

from otolith.report.thesis import MARKS, RULE, Values, heading_of, number, pivot
from otolith.report.thesis_figures import columns, draw_on

PAPER: Final = (8.27, 11.69)  # [in] A4
MARGIN: Final = 0.6  # [in]
SIZES: Final = {"title": 15.0, "heading": 10.0, "text": 8.0, "table": 6.8}  # [pt]
LEADING: Final = 1.42  # line distance over size
COLUMNS: Final = {"title": 60, "heading": 88, "text": 118, "table": 124}  # characters of a line
DIAGRAM: Final = (3.0, 2.15)  # [in] width at most, height
FRAME: Final = (0.5, 0.78, 0.25, 0.45)  # [in] left, below, above and right of the axes, for their words
MONO: Final = "DejaVu Sans Mono"

Line = tuple[str, str]  # a key of SIZES, the text


def save_pdf(document: Values, path: Path) -> None:
    """Write the reproduction as PDF; `document` as for `otolith.report.thesis.page`."""
    with mpl.rc_context({"pdf.fonttype": 42}), PdfPages(path, metadata={"CreationDate": None}) as pdf:
        writer = _Writer(pdf)
        writer.write(_front(document))
        for name, item in document["items"].items():
            writer.write(_item(name, item, document["items"]))
            if item["panels"]:
                writer.picture(item["panels"])
        writer.end()


class _Writer:
    """Sets lines on pages, one below the other."""

    def __init__(self, pdf: PdfPages) -> None:
        self._pdf = pdf
        self._begin()

    def _begin(self) -> None:
        self._figure = Figure(figsize=PAPER)
        self._y = PAPER[1] - MARGIN  # [in] of the next line's top

    def write(self, lines: Iterator[Line]) -> None:
        """Set lines; a heading is never the last thing on a page."""
        for kind, text in lines:
            height = SIZES[kind] * LEADING / 72.0
            room = 6.0 * height if kind == "heading" else height
            if self._y - room < MARGIN:
                self._turn()
            self._figure.text(
                MARGIN / PAPER[0],
                self._y / PAPER[1],
                text,
                fontsize=SIZES[kind],
                family=MONO if kind == "table" else "DejaVu Sans",
                weight="bold" if kind in ("title", "heading") else "normal",
                va="top",
                parse_math=False,
            )
            self._y -= height

    def picture(self, panels: Sequence[Values]) -> None:
        """Diagrams side by side below the text so far, as many rows as they need."""
        across = columns(len(panels))
        width = min(DIAGRAM[0], (PAPER[0] - 2.0 * MARGIN) / across)
        left, below, above, right = FRAME
        for place, panel in enumerate(panels):
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
            self._pdf.savefig(self._figure)  # type: ignore[no-untyped-call]
        self._begin()

    def end(self) -> None:
        """Write the last page."""
        self._turn()


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
    yield "table", f"{'':16}" + "".join(f"{name:>14}" for name in MARKS) + f"{'statements':>14}"
    for name, item in with_numbers.items():
        claims = f"{sum(c['holds'] for c in item['claims'])} of {len(item['claims'])}"
        counts = "".join(f"{item['verdicts'][key]:>14}" for key in MARKS)
        yield "table", f"{name:16}{counts}{claims:>14}"
    yield "text", ""


def _item(name: str, item: Values, items: Mapping[str, Values]) -> Iterator[Line]:
    yield "text", ""
    for line in textwrap.wrap(heading_of(name, item), COLUMNS["heading"]):
        yield "heading", line
    yield from _wrapped(f"thesis, section {item['section']}. {item['text']}")
    for claim in item["claims"]:
        answer = "yes" if claim["holds"] else "no"
        yield from _wrapped(f"{answer}: {claim['text']} ({claim['figures']})", "– ")
    if item["numbers"]:
        yield "text", "published / ours / ratio"
        yield from _numbers(item["numbers"])
    for grid in item["grids"]:
        yield "text", ""
        yield from _wrapped(grid["title"])
        yield from _columns([grid["header"], *grid["rows"]])
    if item["reasons"]:
        tested = "; ".join(items[name]["title"] if name in items else name for name in item["reasons"])
        yield from _wrapped(f"Tested as reasons for what differs: {tested}.")


def _wrapped(text: str, mark: str = "") -> Iterator[Line]:
    for place, line in enumerate(textwrap.wrap(text, COLUMNS["text"] - len(mark))):
        yield "text", (mark if place == 0 else " " * len(mark)) + line


def _numbers(numbers: Sequence[Values]) -> Iterator[Line]:
    columns, rows = pivot(numbers)
    table: list[list[Any]] = [["", *(column.replace("_", " ") for column in columns)]]
    for row, cells in rows.items():
        table.append([row, *(_cell(cells.get(column)) for column in columns)])
    yield from _columns(table)


def _cell(one: Values | None) -> str:
    if one is None:
        return "–"
    ratio = "" if one["ratio"] is None else f" {one['ratio']:.2f}"
    bound = ">" if one["at_least"] else ""
    return f"{bound}{number(one['published'])} / {number(one['ours'])}{ratio} {MARKS[one['verdict']]}"


def _columns(rows: Sequence[Sequence[Any]]) -> Iterator[Line]:
    """Rows in aligned columns, the first to the left; a table too wide goes on below."""
    cells = [[number(cell) for cell in row] for row in rows]
    widths = [max(len(row[k]) for row in cells) for k in range(len(cells[0]))]
    for chosen in _fitting(widths):
        for row in cells:
            line = row[0].ljust(widths[0]) + "".join("  " + row[k].rjust(widths[k]) for k in chosen)
            yield "table", line[: COLUMNS["table"]]


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
