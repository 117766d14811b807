"""Diagrams of a reproduction: panels as plain values, drawn side by side with matplotlib."""

import io
from collections.abc import Mapping, Sequence
from typing import Any, Final

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.transforms import ScaledTranslation

from otolith.report.palette import CYCLE, GREY

ACROSS: Final = 3  # largest number of panels in a row
PANEL: Final = (3.4, 2.35)  # [in]
FONT: Final = 8.0  # [pt]
BELOW: Final = 0.37  # [in] distance from the axes down to the legend, with ticks and label between


def columns(panels: int) -> int:
    """Return the number of panels in a row."""
    return 2 if panels == 4 else min(ACROSS, panels)


def draw(panels: Sequence[Mapping[str, Any]]) -> Figure:
    """Draw all panels of an item, up to three in a row, with a legend below each.

    Parameters
    ----------
    panels : plain values with title, x_label, y_label, right_label, log_x, optionally equal (one scale for
        both axes), and curves; a curve has label, x, y, dash and right.
    """
    across = columns(len(panels))
    down = -(-len(panels) // across)
    figure = Figure(
        figsize=(PANEL[0] * across, PANEL[1] * down),
        layout=ConstrainedLayoutEngine(w_pad=0.06, h_pad=0.06, wspace=0.03, hspace=0.05),
    )
    places = figure.subplots(down, across, squeeze=False).ravel()
    for ax, panel in zip(places, panels, strict=False):
        draw_on(ax, panel)
    for ax in places[len(panels) :]:
        ax.set_visible(False)
    return figure


def draw_on(left: Axes, panel: Mapping[str, Any]) -> None:
    """Draw one panel on existing axes, with its legend below."""
    right = left.twinx() if panel["right_label"] else left
    drawn = []
    for place, curve in enumerate(panel["curves"]):
        ax = right if curve["right"] else left
        color = GREY if curve["dash"] and not curve["right"] else CYCLE[place % len(CYCLE)]
        style = (0, (4, 2)) if curve["dash"] else "-"
        drawn += ax.plot(
            curve["x"], curve["y"], color=color, linestyle=style, linewidth=1.1, label=curve["label"]
        )
    if panel["log_x"]:
        left.set_xscale("log")
    if panel.get("equal"):
        left.set_aspect("equal", adjustable="datalim")
    left.set_title(panel["title"], fontsize=FONT + 0.5, loc="left")
    left.set_xlabel(panel["x_label"], fontsize=FONT)
    left.set_ylabel(panel["y_label"], fontsize=FONT)
    left.grid(visible=True, color="#dddddd", linewidth=0.5)
    left.set_axisbelow(True)
    if right is not left:
        right.set_ylabel(panel["right_label"], fontsize=FONT)
        left.set_zorder(right.get_zorder() + 1)
        left.patch.set_visible(False)
    for ax in (left, right):
        ax.tick_params(labelsize=FONT - 1.0, width=0.5, length=2.5)
        for spine in ax.spines.values():
            spine.set_linewidth(0.5)
    down = ScaledTranslation(0.0, -BELOW, left.figure.dpi_scale_trans)
    left.legend(
        drawn,
        [str(line.get_label()) for line in drawn],
        fontsize=FONT - 1.5,
        frameon=False,
        loc="upper center",
        bbox_to_anchor=(0.5, 0.0),
        bbox_transform=left.transAxes + down,
        ncols=2 if len(drawn) > 1 else 1,
        handlelength=1.6,
        columnspacing=1.0,
        labelspacing=0.2,
        borderaxespad=0.0,
    )


def svg(figure: Figure) -> str:
    """Return the figure as an SVG element for a page; equal figures give equal text."""
    text = io.StringIO()
    with mpl.rc_context({"svg.fonttype": "none", "svg.hashsalt": "otolith", "path.simplify_threshold": 0.3}):
        figure.savefig(text, format="svg", metadata={"Date": None}, transparent=True)
    found = text.getvalue()
    return found[found.index("<svg") :]
