"""A drive on the map and along its path; for a run, also where the driver was misled."""

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from otolith.core.arrays import Mat, Vec
from otolith.report.figures import FONT, SMALL
from otolith.report.palette import BLUE, GREEN, GREY, ORANGE, PURPLE, VERMILION
from otolith.vehicle import Lap

WIDTH: Final = 7.2  # [in] width of two columns of a paper
MAP_HEIGHT: Final = 3.6  # [in] largest height of the map
PANEL_HEIGHT: Final = 1.25  # [in]
EVERY: Final = 1000.0  # [m] between marks along the path
# Kinds of `otolith.metrics.false_cues`; the first is drawn above the others
KINDS: Final = {"inverted": VERMILION, "unwanted": ORANGE, "missing": PURPLE, "scaled": GREEN}


class Marked(NamedTuple):
    """A stretch of time that is shown on the map, such as a false cue."""

    label: str  # a key of KINDS
    start: float  # [s]
    end: float  # [s]


def lap_figure(lap: Lap) -> Figure:
    """Draw the road from above, coloured by speed, and speed and accelerations along the path."""
    kmh = 3.6 * lap.velocity[:, 0]
    figure, rows = _frame(lap.position[:, :2], panels=2)
    top = rows[0]
    _road(top, lap.position[:, :2])
    points = lap.position[:, None, :2]
    colored = LineCollection(
        list(np.concatenate([points[:-1], points[1:]], axis=1)),
        array=kmh[:-1],
        cmap="viridis",
        linewidths=2.2,
    )
    top.add_collection(colored)
    bar = figure.colorbar(colored, ax=top, shrink=0.9, pad=0.02)
    bar.set_label("speed [km/h]", fontsize=FONT)
    bar.ax.tick_params(labelsize=FONT)
    _milestones(top, lap.way, lap.position[:, :2])
    way = 1e-3 * lap.way
    _series(rows[1], way, {"driven": (kmh, BLUE, "-"), "planned": (3.6 * lap.planned_speed, GREY, ":")})
    rows[1].set_ylabel("speed [km/h]", fontsize=FONT)
    ax, ay = lap.acceleration.T
    _series(rows[2], way, {"forward": (ax, VERMILION, "-"), "to the left": (ay, BLUE, "-")})
    rows[2].set_ylabel("acceleration [m/s²]", fontsize=FONT)
    rows[2].set_xlabel("way [km]", fontsize=FONT)
    return figure


def false_cue_map(time: Vec, position: Mat, cues: Sequence[Marked], *, numbered: int = 0) -> Figure:
    """Draw the path that was driven, and the stretches on which the simulator's driver was misled.

    Parameters
    ----------
    time, position : (n,) [s] and (n, 2) [m] of the car.
    cues : stretches of time, the gravest first; each kind has its own colour.
    numbered : how many of the gravest are numbered where they begin.
    """
    figure, rows = _frame(position, panels=0)
    _road(rows[0], position)
    for layer, (kind, color) in enumerate(KINDS.items()):
        of_kind = [cue for cue in cues if cue.label == kind]
        lines = [_between(time, position, cue) for cue in of_kind]
        if lines:
            seconds = sum(cue.end - cue.start for cue in of_kind)
            label, z = f"{kind}: {len(of_kind)}, {seconds:.1f} s", 4.0 - 0.1 * layer
            rows[0].add_collection(LineCollection(lines, colors=color, linewidths=2.6, label=label, zorder=z))
    for number, cue in enumerate(cues[:numbered], 1):
        _number(rows[0], number, _between(time, position, cue)[0], KINDS[cue.label])
    way = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(position, axis=0), axis=1))]
    _milestones(rows[0], way, position)
    handles, labels = rows[0].get_legend_handles_labels()
    if labels:
        rows[0].legend(handles, labels, fontsize=SMALL, frameon=False, loc="best")
    return figure


def _number(ax: Axes, number: int, point: Vec, color: str) -> None:
    """Draw a numbered disc next to the road."""
    disc = {"boxstyle": "circle,pad=0.2", "facecolor": "white", "edgecolor": color, "linewidth": 0.8}
    ax.annotate(
        str(number), (float(point[0]), float(point[1])), (-11, -9), textcoords="offset points",
        fontsize=SMALL, bbox=disc, zorder=6,
    )  # fmt: skip


def _between(time: Vec, position: Mat, cue: Marked) -> Mat:
    """Return the positions (k ≥ 2, 2) [m] during a cue, including its ends."""
    inside = time[(time > cue.start) & (time < cue.end)]
    instants = np.r_[cue.start, inside, cue.end]
    return np.stack([np.interp(instants, time, column) for column in position.T], axis=1)


def _frame(position: Mat, *, panels: int) -> tuple[Figure, list[Axes]]:
    """Return a figure with a map of the right shape and `panels` rows below it."""
    extent = np.ptp(position, axis=0)
    height = min(MAP_HEIGHT, max(1.2, 0.8 * WIDTH * float(extent[1] / max(extent[0], 1e-9))))
    figure = Figure(
        figsize=(WIDTH, height + panels * PANEL_HEIGHT),
        layout=ConstrainedLayoutEngine(w_pad=0.04, h_pad=0.04),
    )
    ratios = [height, *[PANEL_HEIGHT] * panels]
    rows = figure.subplots(1 + panels, 1, squeeze=False, gridspec_kw={"height_ratios": ratios})[:, 0]
    for ax in rows[2:]:
        ax.sharex(rows[1])
    return figure, list(rows)


def _road(ax: Axes, position: Mat) -> None:
    ax.plot(*position.T, color="#d0d0d0", linewidth=4.0, zorder=1)
    ax.set_aspect("equal", adjustable="datalim")
    ax.set_xlabel("x [m]", fontsize=FONT)
    ax.set_ylabel("y [m]", fontsize=FONT)
    _plain(ax)


def _milestones(ax: Axes, way: Vec, position: Mat) -> None:
    """Mark the start, and each kilometre along the path."""
    for s in np.arange(0.0, way[-1], EVERY):
        x, y = (float(np.interp(s, way, column)) for column in position.T)
        ax.plot([x], [y], "o", color="black", markersize=2.0, zorder=5)
        text = "start" if s == 0.0 else f"{1e-3 * s:g} km"
        ax.annotate(text, (x, y), (4, 4), textcoords="offset points", fontsize=SMALL)


def _series(ax: Axes, x: Vec, curves: dict[str, tuple[Vec, str, str]]) -> None:
    for label, (y, color, style) in curves.items():
        ax.plot(x, y, style, color=color, linewidth=0.8, label=label)
    ax.set_xlim(x[0], x[-1])
    ax.grid(visible=True, color="#dddddd", linewidth=0.4)
    ax.legend(fontsize=SMALL, frameon=False, ncols=len(curves), loc="lower left", bbox_to_anchor=(0.0, 0.96))
    _plain(ax)


def _plain(ax: Axes) -> None:
    ax.tick_params(labelsize=FONT, width=0.5, length=2.5)
    for spine in ax.spines.values():
        spine.set_linewidth(0.5)
