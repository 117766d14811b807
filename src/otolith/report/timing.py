"""The distribution of step times of several QP engines, as a figure for a paper."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from otolith.core.arrays import Vec
from otolith.report.palette import CYCLE

_COLUMN = 3.5  # [in]
_FONT = 7.0  # [pt]
_LEGEND = 5.8  # [pt] small enough for two columns of labels
_DASHES = ("-", (0, (4, 1.8)), (0, (1, 1)))
_READ = {"median": 0.5, "p99": 0.01}  # shares at which a reader looks


class StepTimes(NamedTuple):
    """The step times of one engine, and where they are drawn."""

    panel: str  # what has a panel of its own, such as "2 DOF"
    engine: str  # what has a colour
    form: str  # what has a kind of line
    seconds: Vec  # (n,) [s]


def step_time_figure(times: Sequence[StepTimes]) -> Figure:
    """Draw the share of steps that take at least a given time, on logarithmic axes, with a panel for each
    kind of problem.
    """
    panels = list(dict.fromkeys(one.panel for one in times))
    engines, forms = (list(dict.fromkeys(names)) for names in zip(*(t[1:3] for t in times), strict=True))
    figure = Figure(figsize=(_COLUMN, 0.9 + 1.7 * len(panels)), layout="constrained")
    for panel, axes in zip(
        panels, figure.subplots(len(panels), sharex=True, squeeze=False).flat, strict=True
    ):
        for one in times:
            if one.panel == panel:
                color = CYCLE[engines.index(one.engine) % len(CYCLE)]
                dashes = _DASHES[forms.index(one.form) % len(_DASHES)]
                _draw(axes, one.seconds, color=color, ls=dashes, lw=1.1, label=f"{one.form} {one.engine}")
        _dress(axes, panel)
    axes.set_xlabel("step time [µs], thread CPU", fontsize=_FONT)
    shown = {
        label: line for a in figure.axes for line, label in zip(*a.get_legend_handles_labels(), strict=True)
    }
    legend = {"fontsize": _LEGEND, "frameon": False, "handlelength": 2.2}
    figure.legend(list(shown.values()), list(shown), loc="outside upper center", ncols=2, **legend)
    return figure


def _draw(axes: Axes, seconds: Vec, **style: Any) -> None:
    micro = np.sort(1e6 * seconds)
    share = 1.0 - np.arange(len(micro)) / len(micro)  # (n,) share of steps at least this long
    axes.plot(micro, share, **style)


def _dress(axes: Axes, panel: str) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_ylabel(f"{panel}: share at least so long", fontsize=_FONT)
    axes.tick_params(labelsize=_FONT)
    axes.grid(which="major", lw=0.4, color="0.85")
    for name, share in _READ.items():
        axes.axhline(share, lw=0.5, color="0.6", zorder=0)
        place = axes.get_yaxis_transform()
        axes.text(0.995, share, name, transform=place, ha="right", va="bottom", fontsize=_LEGEND, color="0.4")
