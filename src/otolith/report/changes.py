"""The distribution of working-set changes from several initial guesses, as a figure for a paper."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from otolith.core.arrays import Vec
from otolith.report.palette import CYCLE

_SIZE = (3.5, 2.6)  # [in]
_FONT = 7.0  # [pt]


def changes_figure(starts: Sequence[tuple[str, Vec]]) -> Figure:
    """Draw the share of decisions that need at least k working-set changes, on logarithmic axes.

    Parameters
    ----------
    starts : label and changes (n,) of each initial guess; values that are not finite are left out.
    """
    figure = Figure(figsize=_SIZE, layout="constrained")
    axes = figure.add_subplot()
    for i, (label, changes) in enumerate(starts):
        asked = np.sort(changes[np.isfinite(changes)])
        share = 1.0 - np.arange(len(asked)) / len(asked)  # share of decisions with at least this many
        some = asked > 0
        axes.step(asked[some], share[some], where="pre", color=CYCLE[i % len(CYCLE)], lw=1.1, label=label)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("working-set changes", fontsize=_FONT)
    axes.set_ylabel("share of decisions with at least so many", fontsize=_FONT)
    axes.tick_params(labelsize=_FONT)
    axes.grid(which="major", lw=0.4, color="0.85")
    axes.legend(fontsize=_FONT, frameon=False)
    return figure
