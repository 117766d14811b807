"""How a recorded drive was understood, as plain values and as a figure of its proofs."""

from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from otolith.core.arrays import Mat
from otolith.recordings.channels import Channel
from otolith.recordings.checks.relations import WINDOW, Relation
from otolith.recordings.columns import QUANTITIES, SI
from otolith.recordings.events import after_cut, before_cut, with_holes
from otolith.recordings.events.jumps import place_of
from otolith.recordings.span import rate
from otolith.recordings.understanding import Understanding
from otolith.report.figures import FONT, SMALL
from otolith.report.palette import BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, VERMILION

WIDTH: Final = 7.2  # [in]
PANEL: Final = 1.35  # [in]
MAP: Final = 3.0  # [in]
NAMED: Final = 12  # largest number of events named in the figure; more would hide the curves
WIDE: Final = 100  # largest number of letters of a legend in three columns
POINTS: Final = 20_000  # largest number of points of a curve
EVENTS: Final = {
    "gap": GREY,
    "pause": PURPLE,
    "held": SKY,
    "frozen sensor": PURPLE,
    "stray packet": VERMILION,
    "stray speed": SKY,
    "stray position": SKY,
    "jump": VERMILION,
    "replay": ORANGE,
    "chatter": GREY,
}
PANELS: Final = {
    "ax": ("ax [m/s²]", 1.0, ("ax",)),
    "ay": ("ay [m/s²]", 1.0, ("ay",)),
    "az": ("az [m/s²]", 1.0, ("az",)),
    "rates": ("rates [deg/s]", 180.0 / np.pi, ("roll_rate", "pitch_rate", "yaw_rate")),
    "vx": ("speed [km/h]", 3.6, ("vx",)),
}
COLORS: Final = {"roll_rate": GREEN, "pitch_rate": ORANGE}


def verdict(one: Relation) -> str:
    """Return the result of a relation in a few words."""
    if not one.informative:
        return "too quiet or too short to judge"
    if one.agrees:
        return "agrees"
    if not one.strong:
        return "hardly related"
    return "runs against" if one.correlation < 0.0 else "other size"


def log_summary(understood: Understanding) -> dict[str, Any]:
    """Return everything that was understood as plain JSON values."""
    stated, log, layout = understood.stated, understood.log, understood.stated.layout
    notes = [] if log is None else list(log.notes)
    found = None if log is None else log.found
    return {
        "file": stated.source,
        "accepted": log is not None,
        "refusal": understood.refusal or None,
        "layout": {
            "form": layout.form,
            "names": layout.header or None,
            "units": layout.units or None,
            "data_from": layout.first or None,
            "rows": layout.rows,
            "clock": layout.clock or None,
            "unused": [name for name in layout.unused if name != layout.clock_name],
        },
        "duration_s": None if log is None else log.duration,
        "channels": {key: _channel(one, understood) for key, one in understood.played.channels.items()},
        "axes": {
            "turned": list(understood.turned),
            "left_and_right_proven_by": (found.proof or None) if found is not None else None,
        },
        "relations": [
            {
                "quantity": one.key,
                "with": one.other,
                "correlation": one.correlation,
                "slope": one.slope,
                "windows": len(one.start),
                "verdict": verdict(one),
            }
            for one in understood.relations
        ],
        "events": [
            {"kind": e.kind, "start_s": e.start, "end_s": e.end, "size": e.size, "sure": e.sure}
            for e in understood.events
        ],
        "offsets": []
        if found is None
        else [_offset(one.key, one.value, one.hindrance) for one in found.offsets],
        "notes": notes,
    }


def _channel(one: Channel, understood: Understanding) -> dict[str, Any]:
    return {
        "column": one.column.name,
        "unit": one.column.unit,
        "unit_stated": not one.column.assumed,
        "sign": -1 if (one.column.factor < 0.0) != (one.key in understood.turned) else 1,
        "samples": len(one.t),
        "rate_hz": rate(one) if len(one.t) > 1 else None,
        "from_s": float(one.t[0]),
        "to_s": float(one.t[-1]),
        "least": float(one.values.min()),
        "most": float(one.values.max()),
        "si_unit": SI[QUANTITIES[one.key][0]],
        "gaps": [[float(a), float(b)] for a, b in one.holes],
        "why": one.column.why or None,
    }


def _offset(key: str, value: float, hindrance: str) -> dict[str, Any]:
    return {"quantity": key, "mps2": value, "not_removable_because": hindrance or None}


def log_figure(understood: Understanding) -> Figure:
    """Draw the forces with their predictions, the rates, the speed and the map; events are shaded."""
    channels = understood.played.channels
    shown = [name for name, (_, _, keys) in PANELS.items() if any(key in channels for key in keys)]
    place = place_of(channels)
    heights = [PANEL] * len(shown) + ([MAP] if place is not None else [])
    figure = Figure(
        figsize=(WIDTH, sum(heights) + 0.5), layout=ConstrainedLayoutEngine(w_pad=0.04, h_pad=0.04)
    )
    rows = figure.subplots(len(heights), 1, squeeze=False, gridspec_kw={"height_ratios": heights})[:, 0]
    for ax, name in zip(rows, shown, strict=False):
        _panel(ax, name, understood)
        if ax is not rows[0]:
            ax.sharex(rows[0])
    rows[len(shown) - 1].set_xlabel("time [s]", fontsize=FONT)
    if place is not None:
        _map(rows[-1], place[1])
    accepted = "accepted" if understood.log is not None else "refused in its present form"
    figure.suptitle(f"{understood.stated.source}: {accepted}", fontsize=FONT + 1)
    return figure


def _panel(ax: Axes, name: str, understood: Understanding) -> None:
    label, scale, keys = PANELS[name]
    channels = understood.played.channels
    for key in keys:
        if key in channels:
            one = channels[key]
            every = max(1, len(one.t) // POINTS)
            color = COLORS.get(key, BLUE)
            text = f"{key.replace('_', ' ')}: {one.column.name}"
            ax.plot(one.t[::every], scale * one.values[::every], color=color, linewidth=0.8, label=text)
    dashes = iter([(VERMILION, "-"), (ORANGE, "--"), (PURPLE, ":"), (GREEN, "-.")])
    for relation in understood.relations:
        if relation.key in keys and relation.powers and len(relation.start):
            _expected(ax, relation, scale, next(dashes), understood)
    _events(ax, understood, named=name == next(iter(PANELS)) or "ax" not in channels)
    ax.set_ylabel(label, fontsize=FONT)
    ax.grid(visible=True, color="#dddddd", linewidth=0.4)
    long = sum(len(str(line.get_label())) for line in ax.get_lines()) > WIDE
    ncols = 2 if long else 3
    ax.legend(fontsize=SMALL, frameon=False, ncols=ncols, loc="lower left", bbox_to_anchor=(0.0, 0.96))
    ax.tick_params(labelsize=FONT, width=0.5, length=2.5)


def _expected(
    ax: Axes, one: Relation, scale: float, style: tuple[str, str], understood: Understanding
) -> None:
    """Draw the prediction of a quantity at the middles of its windows, with its gaps.

    Relations are measured without the events, so their times are converted to those of the whole drive.
    """
    middle, expected = one.start + 0.5 * WINDOW, scale * one.expected
    cut = understood.log is not None and understood.settings.events == "cut"
    middle = before_cut(middle, with_holes(understood.events))
    if cut:
        middle = after_cut(middle, understood.events)
    apart = np.flatnonzero(np.diff(middle) > 1.5) + 1
    middle, expected = np.insert(middle, apart, np.nan), np.insert(expected, apart, np.nan)
    text = f"{one.other} ({verdict(one)}, {one.correlation:.2f})"
    ax.plot(middle, expected, color=style[0], linestyle=style[1], linewidth=0.9, label=text)


def _events(ax: Axes, understood: Understanding, *, named: bool) -> None:
    """Shade events; in a drive that was cut, mark only the seams, because its time skips the events."""
    cut = understood.log is not None and understood.settings.events == "cut"
    events = understood.events
    starts = np.array([event.start for event in events])
    if cut:
        starts = after_cut(starts, events)
    if named and len(events) <= NAMED:
        for event, start in zip(events, starts, strict=True):
            ax.annotate(event.kind, (start, 0.04), xycoords=("data", "axes fraction"), fontsize=SMALL)
    across = ax.get_xaxis_transform()  # time along x, the whole panel along y
    for kind in dict.fromkeys(event.kind for event in events):
        alike = [(event, start) for event, start in zip(events, starts, strict=True) if event.kind == kind]
        seams = [start for event, start in alike if cut and event.sure]
        shades = [(t, max(e.end - e.start, 1e-3)) for e, t in alike if not (cut and e.sure)]
        ax.vlines(seams, 0.0, 1.0, EVENTS[kind], "dotted", linewidth=0.8, transform=across)
        ax.broken_barh(shades, (0.0, 1.0), color=EVENTS[kind], alpha=0.25, linewidth=0.6, transform=across)


def _map(ax: Axes, xy: Mat) -> None:
    every = max(1, len(xy) // POINTS)
    ax.plot(*xy[::every].T, color=BLUE, linewidth=0.9)
    ax.plot(*xy[0], "o", color="black", markersize=3.0)
    ax.annotate("start", tuple(xy[0]), (4, 4), textcoords="offset points", fontsize=SMALL)
    ax.set_aspect("equal", adjustable="datalim")
    ax.set_xlabel("x or east [m]", fontsize=FONT)
    ax.set_ylabel("y or north [m]", fontsize=FONT)
    ax.tick_params(labelsize=FONT, width=0.5, length=2.5)
