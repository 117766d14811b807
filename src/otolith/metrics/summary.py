"""The key figures of one run, and of several side by side, as plain JSON values."""

import math
from typing import Any

from otolith.core.frames import AXES, PAIRS
from otolith.metrics.effort import effort
from otolith.metrics.limits import excesses
from otolith.metrics.tracking import tracking_rmse, travel_rms
from otolith.simulate import Run

BASELINE = "implicit"  # percentages are against this model, as in Table 5.6


def summarise(run: Run) -> dict[str, Any]:
    """Key figures of section 5.1, the limits' excesses, and what is needed to repeat the run.

    `rmse` is over the force axes that were cued together [m/s²]; `rmse_per_pair` tells them apart.
    """
    rmse, travel = tracking_rmse(run), travel_rms(run)
    per_pair = {name: float(rmse[PAIRS[name].translation]) for name in run.pairs}
    over = excesses(run)
    return {
        "scenario": run.scenario,
        "cueing": run.cueing,
        "plant": run.plant,
        "platform": run.platform.name,
        "dofs": ",".join(run.pairs),
        "duration_s": float(run.time[-1]),
        "period_s": run.period,
        "rmse": math.sqrt(sum(value**2 for value in per_pair.values())),
        "rmse_per_pair": per_pair,
        "travel_rms": {
            axis: float(travel[AXES.index(axis)]) for name in run.pairs for axis in name.split("-")
        },
        **effort(run),
        "violations": sum(excess.violations for excess in over),
        "worst_excess": {e.quantity: e.at_nodes for e in over},
        "worst_excess_between_nodes": {e.quantity: e.between_nodes for e in over},
        "settings": run.settings,
    }


def compare(runs: list[Run]) -> dict[str, dict[str, Any]]:
    """Summaries by cueing name, each with its mean changes against the implicit MPC's [%].

    Negative means fewer changes; absent when the baseline is not among the runs or made no change.
    """
    summaries = {run.cueing: summarise(run) for run in runs}
    base = summaries.get(BASELINE, {}).get("changes", {}).get("mean", 0.0)
    if base > 0.0:
        for summary in summaries.values():
            summary["changes_against_implicit_percent"] = 100.0 * (summary["changes"]["mean"] / base - 1.0)
    return summaries
