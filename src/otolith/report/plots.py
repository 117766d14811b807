"""Panels as interactive diagrams: the description of each for plotly.js, as JSON in the page.

The page includes the library's basic bundle (`assets/plotly/README.md`); plotly's reference explains the
fields.
"""

import base64
import html
import json
from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from otolith.core.arrays import Vec
from otolith.report.palette import BLUE, GREY
from otolith.report.panels import Axis, Bound, Curve, Panel
from otolith.report.series import MAX_POINTS, decimate

HEIGHT: Final = 320  # [px]
MODES: Final = {
    "line": "lines",
    "stairs": "lines",
    "dots": "markers",
    "points": "lines+markers",
    "marks": "markers",
    "bars": "lines",
}
SYMBOLS: Final = ("x", "triangle-down", "square", "cross")
ROW: Final = 30  # [px] height per row of a panel with rows
AROUND_ROWS: Final = 110  # [px] height of its legend and axis
SIZES: Final = {"dots": 3.5, "points": 5.0, "marks": 9.0}  # [px] size of markers
SCALE: Final = 1.4  # screen pixels per point on paper
GRID: Final = "rgba(128,128,128,0.25)"


def plot_json(panel: Panel, *, points: int = MAX_POINTS) -> str:
    """Return data and layout of `panel`, safe inside a script element.

    Parameters
    ----------
    points : largest number of points of a line.
    """
    curves = [_curve(curve, k, points) for k, curve in enumerate(panel.curves)]
    bounds = [_bound(bound, panel) for bound in panel.bounds]
    text = json.dumps(
        {"data": curves + bounds, "layout": _layout(panel)}, ensure_ascii=False, separators=(",", ":")
    )
    return text.replace("<", "\\u003c")


def _layout(panel: Panel) -> dict[str, Any]:
    layout: dict[str, Any] = {
        "height": height(panel),
        "margin": {
            "l": 140 if panel.axes[0].ticks else 64,
            "r": 64 if len(panel.axes) > 1 else 16,
            "t": 8,
            "b": 44,
        },
        "paper_bgcolor": "rgba(0,0,0,0)",
        "plot_bgcolor": "rgba(0,0,0,0)",
        "font": {"family": "system-ui, sans-serif", "size": 13},
        "showlegend": True,
        "hovermode": "x unified" if panel.over_time else "closest",
        "modebar": {"bgcolor": "rgba(0,0,0,0)", "color": GREY, "activecolor": BLUE},
        "legend": {"orientation": "h", "x": 0, "y": 1.02, "yanchor": "bottom"},
        "xaxis": {
            "title": {"text": panel.x_label},
            "range": panel.x_span,
            "gridcolor": GRID,
            "zeroline": False,
        },
        "yaxis": _axis(panel.axes[0]),
    }
    if len(panel.axes) > 1:
        layout["yaxis2"] = _axis(panel.axes[1]) | {
            "overlaying": "y",
            "side": "right",
            "showgrid": False,
            "tickmode": "auto",
        }
    return layout


def _axis(axis: Axis) -> dict[str, Any]:
    span = [float(np.log10(end)) if axis.log else end for end in axis.span]
    ink = {"color": axis.color} if axis.color else {}
    return {
        "title": {"text": axis.label, "font": ink},
        "tickfont": ink,
        "type": "log" if axis.log else "linear",
        "range": span,
        "gridcolor": GRID,
        "zerolinecolor": "rgba(128,128,128,0.5)",
        **({"dtick": 1} if axis.log else {}),
        **_named_rows(axis),
    }


def height(panel: Panel) -> int:
    """Return the height of a diagram [px]."""
    rows = len(panel.axes[0].ticks)
    return AROUND_ROWS + ROW * rows if rows else HEIGHT


def _named_rows(axis: Axis) -> dict[str, Any]:
    if not axis.ticks:
        return {}
    return {
        "tickvals": list(range(len(axis.ticks))),
        "ticktext": [_label(text) for text in axis.ticks],
        "zeroline": False,
    }


def _curve(curve: Curve, place: int, points: int) -> dict[str, Any]:
    x, y = decimate(curve.x, curve.y, points) if curve.kind in ("line", "dots") else (curve.x, curve.y)
    marked = curve.kind == "marks"
    return {
        "type": "scatter",
        "x": _short(x),
        "y": _short(y),
        "name": _label(curve.label),
        "mode": MODES[curve.kind],
        "yaxis": _side(curve.axis),
        "line": {
            "color": curve.color,
            "width": SCALE * curve.width,
            "dash": curve.dash,
            "shape": "hv" if curve.kind == "stairs" else "linear",
        },
        "marker": {
            "color": curve.color,
            "size": SIZES.get(curve.kind, 0),
            "symbol": SYMBOLS[(place - 1) % len(SYMBOLS)] if marked else "circle",
        },
        "fill": "tozeroy" if curve.kind == "stairs" else "none",
        "cliponaxis": not marked,
    }


def _bound(bound: Bound, panel: Panel) -> dict[str, Any]:
    """Return both sides of a limit as one interrupted line; a far one appears only in the legend."""
    xs: Sequence[float | None] = () if bound.far else (*panel.x_span, None) * len(bound.values)
    ys = [None if x is None else bound.values[k // 3] for k, x in enumerate(xs)]
    return {
        "type": "scatter",
        "x": list(xs) or [None],
        "y": ys or [None],
        "name": _label(bound.label),
        "mode": "lines",
        "yaxis": _side(bound.axis),
        "line": {"color": bound.color, "width": 0 if bound.far else 1.2, "dash": bound.dash},
        "hoverinfo": "skip",
        "showlegend": True,
    }


def _side(axis: int) -> str:
    return "y" if axis == 0 else "y2"


def _short(values: Vec) -> dict[str, str]:
    """Encode values in single precision, as plotly.js reads typed arrays; a screen shows fewer digits."""
    return {"dtype": "f4", "bdata": base64.b64encode(values.astype("<f4").tobytes()).decode("ascii")}


def _label(text: str) -> str:
    """Escape a label, because plotly interprets some HTML in labels."""
    return html.escape(text, quote=False)
