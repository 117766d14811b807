"""Figures for papers: the panels of a run at column width, drawn with matplotlib.

The module uses neither pyplot nor global settings, so it works in any thread and next to other plots.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.lines import Line2D
from matplotlib.textpath import text_to_path
from matplotlib.ticker import LogFormatterSciNotation, MaxNLocator

from otolith.core.errors import InputError
from otolith.core.folders import PICTURES
from otolith.loop import Run
from otolith.report.motion import motion_comparison, motion_panels
from otolith.report.overview import false_cue_panels, overview_panels, use_panel
from otolith.report.panels import (
    Axis,
    Bound,
    Curve,
    Panel,
    changes_panel,
    effort_panels,
    solves,
)
from otolith.report.ranking import ByCueing

COLUMN: Final = 3.5  # [in] width of one column of a two-column paper
HEIGHT: Final = {
    "force": 1.65,
    "heave": 1.5,
    "yaw": 1.5,
    "compare-force": 1.9,
    "compare-heave": 1.9,
    "compare-yaw": 1.9,
    "compare-changes": 1.75,
}  # [in] height of a panel, otherwise:
OTHER_HEIGHT: Final = 1.3
ROW, AROUND_ROWS = 0.13, 0.6  # [in] height per row of a panel with rows, and of the rest of it
NAME: Final = 110.0  # [pt] largest width of a row's name, with the gaps around it
BESIDE: Final = 34.0  # [pt] width of ticks and margin
DPI: Final = 300.0  # [1/in] resolution of a PNG
FONT: Final = 7.0  # [pt]
SMALL: Final = 6.5  # [pt] font size in legends
DASHES: Final[dict[str, Any]] = {
    "solid": "-",
    "dash": (0, (4, 1.8)),
    "dashdot": (0, (5, 1.5, 1, 1.5)),
    "dot": (0, (1, 1.2)),
}
MARGIN: Final = 0.6  # [in] left of the panels; legends may use the rest of the width
HANDLE: Final = 3.9  # [em] width of a line sample in a legend, with the gaps around it
MARKERS: Final = ("x", "v", "s", "+")


def cueing_figure(run: Run, dof: str, *, width: float = COLUMN, best: Run | None = None) -> Figure:
    """Draw one degree of freedom of a run over time: what is felt, the motion, and the solver's effort.

    Parameters
    ----------
    dof : name of an axis pair, a key of `otolith.core.frames.PAIRS`, or "heave" or "yaw".
    width : width of the figure [in].
    best : the best that is possible on the same drive, drawn with it.
    """
    return _draw(motion_panels(run, dof, best) + effort_panels(run), width)


def comparison_figure(
    runs: Sequence[Run], dof: str, *, width: float = COLUMN, best: Run | None = None
) -> Figure:
    """Draw several algorithms on one scenario: what is felt, the motion, false cues, reach, and effort.

    Parameters
    ----------
    dof, width, best : as in `cueing_figure`.

    Raises
    ------
    ValueError : there is no run, or the runs are not of one scenario.
    """
    panels = (
        *motion_comparison(runs, dof, best),
        *false_cue_panels(runs, dof),
        use_panel(runs),
        *([changes_panel(runs)] if any(solves(run) for run in runs) else []),
    )
    return _draw(panels, width)


def overview_figure(scenarios: Mapping[str, ByCueing], *, width: float = COLUMN) -> Figure:
    """Draw all algorithms on all scenarios: one panel per measure, one dot per scenario."""
    return _draw(overview_panels(scenarios), width)


def save_figure(figure: Figure, path: Path) -> None:
    """Write `figure` as PDF, SVG or PNG, by the ending of `path`; equal figures give equal bytes.

    Raises
    ------
    InputError : the name has another ending.
    """
    suffix = path.suffix.lower()
    if suffix not in PICTURES:
        raise InputError("figure file", path.name, f"a name that ends in {', '.join(PICTURES)}")
    stamp = {".pdf": {"CreationDate": None}, ".svg": {"Date": None}}.get(suffix)
    with mpl.rc_context({"pdf.fonttype": 42, "svg.hashsalt": "otolith"}):  # journals reject Type 3 fonts
        figure.savefig(path, dpi=DPI, metadata=stamp)


@contextmanager
def arranged(figure: Figure) -> Iterator[None]:
    """Arrange the figure's parts once, for every `save_figure` within the context.

    Without this, matplotlib arranges them anew for every file, and for that it draws everything twice.
    """
    engine, dpi = figure.get_layout_engine(), figure.dpi
    if engine is None:
        yield
        return
    figure.set_dpi(DPI)
    engine.execute(figure)
    figure.set_dpi(dpi)
    with mpl.rc_context({"figure.autolayout": False, "figure.constrained_layout.use": False}):
        figure.set_layout_engine(None)  # with these settings: none, for which nothing is drawn twice
    try:
        yield
    finally:
        figure.set_layout_engine(engine)


def _draw(panels: Sequence[Panel], width: float) -> Figure:
    heights = [_height(panel) for panel in panels]
    figure = Figure(
        figsize=(width, sum(heights)), layout=ConstrainedLayoutEngine(w_pad=0.02, h_pad=0.02, hspace=0.02)
    )
    rows = figure.subplots(len(panels), 1, squeeze=False, gridspec_kw={"height_ratios": heights})[:, 0]
    timed = [ax for ax, panel in zip(rows, panels, strict=True) if panel.over_time]
    for ax in timed[1:]:
        ax.sharex(timed[0])
    room = 72.0 * width - max(72.0 * MARGIN, *(_names_width(panel) for panel in panels))
    explained: set[str] = set()  # labels that a legend further up explains
    for ax, panel in zip(rows, panels, strict=True):
        _panel(ax, panel, explained, room)
        if panel.over_time and ax is not timed[-1]:
            ax.tick_params(labelbottom=False)
        else:
            ax.set_xlabel(panel.x_label, fontsize=FONT)
    figure.align_ylabels(rows)
    return figure


def _height(panel: Panel) -> float:
    """Return the height of a panel [in]; a panel with rows grows with them."""
    rows = len(panel.axes[0].ticks)
    return AROUND_ROWS + ROW * rows if rows else HEIGHT.get(panel.key, OTHER_HEIGHT)


def _names_width(panel: Panel) -> float:
    """Return the width of the names of a panel's rows [pt]."""
    return max((BESIDE + _width(_fitted(name, NAME)) for name in panel.axes[0].ticks), default=0.0)


def _panel(left: Axes, panel: Panel, explained: set[str], room: float) -> None:
    sides = [left] if len(panel.axes) == 1 else [left, left.twinx()]
    for ax, axis in zip(sides, panel.axes, strict=True):
        _axis(ax, axis)
    left.set_xlim(*panel.x_span)
    left.tick_params(axis="x", labelsize=FONT)
    left.grid(visible=True, color="#dddddd", linewidth=0.4)
    left.set_axisbelow(True)
    if len(sides) == 2:  # the left, main curve in front of the right one
        left.set_zorder(sides[1].get_zorder() + 1)
        left.patch.set_visible(False)
    drawn = [(_curve(sides[c.axis], c, k), c.label, "black") for k, c in enumerate(panel.curves)]
    drawn += [(_bound(sides[b.axis], b), b.label, b.color if b.far else "black") for b in panel.bounds]
    _legend(left, [entry for entry in drawn if entry[1] not in explained], room)
    explained.update(label for _, label, _ in drawn)


def _axis(ax: Axes, axis: Axis) -> None:
    ink = axis.color or "black"
    if axis.ticks:
        names = [_fitted(text, NAME) for text in axis.ticks]
        ax.set_yticks(range(len(names)), names, parse_math=False)
    elif axis.log:
        ax.set_yscale("log")
        ax.yaxis.set_major_formatter(LogFormatterSciNotation(minor_thresholds=(1.2, 0.6)))
        ax.yaxis.set_minor_formatter(LogFormatterSciNotation(minor_thresholds=(1.2, 0.6)))
    else:
        ax.yaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
    ax.set_ylim(*axis.span)
    ax.set_ylabel(axis.label, fontsize=FONT, color=ink)
    ax.tick_params(axis="y", which="both", labelsize=FONT, labelcolor=ink)
    for spine in ax.spines.values():
        spine.set_linewidth(0.5)
    ax.tick_params(which="both", width=0.5, length=2.5)


def _curve(ax: Axes, curve: Curve, place: int) -> Artist:
    if curve.kind == "stairs" and len(curve.x):
        bars = ax.stairs(curve.y[:-1], curve.x, fill=True, color=curve.color, linewidth=0, zorder=2)
        bars.set_label(curve.label)
        return bars
    marker, size, line = "", 0.0, DASHES[curve.dash]
    ends: Any = "butt" if curve.kind == "bars" else "projecting"
    if curve.kind == "dots":
        marker, size, line = ".", curve.width, "none"
    elif curve.kind == "points":
        marker, size = "o", 2.0
    elif curve.kind == "marks":
        marker, size, line = MARKERS[(place - 1) % len(MARKERS)], 4.0, "none"
    (drawn,) = ax.plot(
        curve.x,
        curve.y,
        color=curve.color,
        linestyle=line,
        linewidth=curve.width,
        marker=marker,
        markersize=size,
        clip_on=curve.kind != "marks",
        zorder={"marks": 4, "dots": 2}.get(curve.kind, 3),
        solid_capstyle=ends,
        label=curve.label,
    )
    return drawn


def _bound(ax: Axes, bound: Bound) -> Artist:
    style: dict[str, Any] = {"color": bound.color, "linestyle": DASHES[bound.dash], "linewidth": 0.8}
    if bound.far:
        return Line2D([], [], linestyle="none")
    lines = [ax.axhline(value, **style, zorder=2.5, label=bound.label) for value in bound.values]
    return lines[0]


def _legend(ax: Axes, entries: Sequence[tuple[Artist, str, str]], room: float) -> None:
    """Draw the legend above the panel, where it hides nothing; texts such as `_x` and `$` stay literal."""
    texts = [_fitted(text, room) for _, text, _ in entries]
    legend = ax.legend(
        [handle for handle, _, _ in entries],
        ["·"] * len(entries),
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        ncols=_columns(texts, room),
        fontsize=SMALL,
        frameon=False,
        borderaxespad=0.2,
        handlelength=1.8,
        columnspacing=1.0,
        labelspacing=0.2,
    )
    for shown, text, (_, _, color) in zip(legend.get_texts(), texts, entries, strict=True):
        shown.set_parse_math(False)
        shown.set_text(text)
        shown.set_color(color)


def _columns(texts: Sequence[str], room: float) -> int:
    """Return the largest number of columns, filled downwards, that fits into `room` [pt] and saves a row."""
    widths = [_width(text) + HANDLE * SMALL for text in texts]
    n = len(widths)
    for columns in range(min(4, n), 1, -1):
        total = sum(max(column) for column in np.array_split(widths, columns))
        if total <= room and -(-n // columns) < -(-n // (columns - 1)):
            return columns
    return 1


def _fitted(text: str, room: float) -> str:
    """Shorten `text` at its end if it would leave the figure."""
    while len(text) > 2 and _width(text) + HANDLE * SMALL > room:
        text = text[:-2] + "…"
    return text


def _width(text: str) -> float:
    """Return the width of `text` in a legend [pt]."""
    width, _, _ = text_to_path.get_text_width_height_descent(text, FontProperties(size=SMALL), ismath=False)
    return float(width)
