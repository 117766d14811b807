"""The distribution of step times of several QP engines, as a figure for a paper."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from otolith.core.arrays import Vec
from otolith.report.palette import CYCLE

_COLUMN = 3.5  # [in]
_FONT = 7.0  # [pt]
_LEGEND = 5.8  # [pt] small enough for two columns of labels


def step_time_figure(times: Sequence[tuple[str, Vec]]) -> Figure:
    """Draw the share of steps that take at least a given time, on logarithmic axes.

    Parameters
    ----------
    times : label and step times (n,) [s] of each engine.
    """
    figure = Figure(figsize=(_COLUMN, 3.4), layout="constrained")
    axes = figure.add_subplot()
    for i, (label, seconds) in enumerate(times):
        micro = np.sort(1e6 * seconds)
        share = 1.0 - np.arange(len(micro)) / len(micro)  # (n,) share of steps at least this long
        dashed = "-" if i < len(times) / 2 else (0, (4, 1.8))
        axes.plot(
            micro,
            share,
            color=CYCLE[i % max(1, len(times) // 2) % len(CYCLE)],
            ls=dashed,
            lw=1.1,
            label=label,
        )
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("step time [µs], thread CPU", fontsize=_FONT)
    axes.set_ylabel("share of steps at least so long", fontsize=_FONT)
    axes.tick_params(labelsize=_FONT)
    axes.grid(which="major", lw=0.4, color="0.85")
    figure.legend(loc="outside upper center", ncols=2, fontsize=_LEGEND, frameon=False, handlelength=1.6)
    return figure
