"""The key figures of one run, and of several side by side, as plain JSON values."""

import math
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from otolith.metrics import similarity
from otolith.metrics.axes import force_axes, moving_axes, rate_axes
from otolith.metrics.effort import effort
from otolith.metrics.false_cues import false_cues, totals
from otolith.metrics.limits import excesses
from otolith.metrics.perceived import perceived_rate_rmse, perceived_rmse
from otolith.metrics.rating import mismatch_rating
from otolith.metrics.sickness import sickness_dose
from otolith.metrics.tracking import rate_rmse, tracking_rmse, travel_rms
from otolith.metrics.workspace import workspace_use
from otolith.simulate import Run

BASELINE = "implicit"  # percentages are against this model, as in Table 5.6


def summarise(run: Run) -> dict[str, Any]:
    """Key figures of section 5.1, the limits' excesses, and what is needed to repeat the run.

    `rmse` is over the force axes that were cued together [m/s²], None where there is none;
    `rmse_per_pair` tells them apart; `wanted_rms` is what a platform that stands still would get. Yaw,
    where it was cued, has `rate_rmse` [rad/s]. `violations` counts the nodes at which a hard limit was
    passed, `soft_exceeded` those at which a soft one was; `limits` tells them apart, each in its
    own unit.
    """
    rmse, travel = tracking_rmse(run), travel_rms(run)
    per_pair = {name: float(rmse[axis]) for name, axis in force_axes(run).items()}
    over = excesses(run)
    return {
        "scenario": run.scenario,
        "cueing": run.cueing,
        "plant": run.plant,
        "platform": run.platform.name,
        "dofs": ",".join(run.dofs),
        "duration_s": float(run.time[-1]),
        "period_s": run.period,
        "rmse": math.sqrt(sum(value**2 for value in per_pair.values())) if per_pair else None,
        "rmse_per_pair": per_pair,
        "wanted_rms": _wanted(run),
        **_rates(run),
        "travel_rms": {axis: float(travel[i]) for axis, i in moving_axes(run).items()},
        **fidelity(run),
        **effort(run),
        "violations": sum(excess.violations for excess in over if not excess.soft),
        "soft_exceeded": sum(excess.violations for excess in over if excess.soft),
        "limits": {excess.quantity: excess.as_json() for excess in over},
        "supervisor": supervised(run),
        "settings": run.settings,
    }


def supervised(run: Run) -> dict[str, dict[str, float]]:
    """What the supervisor of the legs did, by the limit that it kept; empty where it never had to act.

    For each: how many times, for how long together [s], and how far a leg stayed behind at most [m].
    """
    told: dict[str, dict[str, float]] = {}
    for one in run.interventions:
        of_limit = told.setdefault(one.reason.limit, {"times": 0, "seconds": 0.0, "behind_m": 0.0})
        of_limit["times"] += 1
        of_limit["seconds"] += one.end - one.start
        of_limit["behind_m"] = max(of_limit["behind_m"], one.behind)
    return told


def fidelity(run: Run) -> dict[str, Any]:
    """How well the motion is felt, beyond RMSE; per degree of freedom, None where a value is not defined.

    Correlation, delay and scale are of force, or for yaw of its rate; the others of force alone.
    Units: `delay_s` [s], `mean_absolute_difference`, `perceived_rmse`, `mismatch_rating` [m/s²],
    `sickness_dose` [m/s^1.5]; `correlation`, `scale_ratio` and shares of the workspace have none.
    """
    axes, perceived = force_axes(run), perceived_rmse(run)
    forces = {name: (run.reference_force[:, i], run.felt_force[:, i]) for name, i in axes.items()}
    felt_rate = run.felt_rate
    signals = forces | {n: (run.reference_rate[:, i], felt_rate[:, i]) for n, i in rate_axes(run).items()}
    cues, rating = false_cues(run), mismatch_rating(run)
    return {
        "correlation": _known({name: similarity.correlation(*pair) for name, pair in signals.items()}),
        "delay_s": _known(
            {name: similarity.delay(*pair, run.plant_period) for name, pair in signals.items()}
        ),
        "scale_ratio": _known({name: similarity.scale_ratio(*pair) for name, pair in signals.items()}),
        "mean_absolute_difference": {
            name: similarity.mean_absolute_difference(*pair) for name, pair in forces.items()
        },
        "perceived_rmse": {name: float(perceived[i]) for name, i in axes.items()},
        "false_cues": {name: totals([cue for cue in cues if cue.dof == name]) for name in axes},
        "mismatch_rating": {"mean": float(np.mean(rating)), "max": float(np.max(rating))},
        "sickness_dose": {
            name: sickness_dose(run.felt_force[:, i], run.plant_period) for name, i in axes.items()
        },
        "workspace": {name: asdict(use) for name, use in workspace_use(run).items()},
    }


def _rates(run: Run) -> dict[str, Any]:
    """Errors of the rates that were cued for their own sake; nothing where none was."""
    axes = rate_axes(run)
    if not axes:
        return {}
    physical, sensed = rate_rmse(run), perceived_rate_rmse(run)
    return {
        "rate_rmse": {name: float(physical[i]) for name, i in axes.items()},
        "perceived_rate_rmse": {name: float(sensed[i]) for name, i in axes.items()},
    }


def _wanted(run: Run) -> dict[str, float]:
    """Root mean square of what should be felt: force [m/s²], and for yaw its rate [rad/s]."""
    force, rate = force_axes(run), rate_axes(run)
    wanted = {name: run.reference_force[:, i] for name, i in force.items()}
    wanted |= {name: run.reference_rate[:, i] for name, i in rate.items()}
    return {name: float(np.sqrt(np.mean(series**2))) for name, series in wanted.items()}


def _known(values: Mapping[str, float]) -> dict[str, float | None]:
    """NaN, which JSON does not have, becomes None."""
    return {name: None if math.isnan(value) else value for name, value in values.items()}


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
