"""Values of key figures as a summary stores them: plain JSON, by degree of freedom or by axis.

`otolith.metrics.catalogue` explains their meaning; the modules that they come from compute them.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from otolith.core.arrays import Vec
from otolith.loop import Run
from otolith.metrics.axes import by_force, force_axes, rate_axes
from otolith.metrics.false_cues import false_cues, totals
from otolith.metrics.limits import excesses
from otolith.metrics.measure import root_sum_square
from otolith.metrics.parts import mean
from otolith.metrics.rating import rating_in_parts
from otolith.metrics.sickness import dose_in_parts
from otolith.metrics.similarity import Pairs
from otolith.metrics.tracking import tracking_rmse
from otolith.metrics.workspace import workspace_use

ByName = dict[str, float]
OfSignals = Callable[[Pairs], float]  # argument: the wanted and the felt signal, in parts


def rmse(run: Run) -> float | None:
    """Return the RMSE over all cued force axes together [m/s²]; None if there are none."""
    per_axis = by_force(run, tracking_rmse(run))
    return root_sum_square(per_axis) if per_axis else None


def wanted_rms(run: Run) -> ByName:
    """Return the RMS of what should be felt: force [m/s²], or for yaw its rate [rad/s]."""
    return {
        name: float(np.sqrt(mean(wanted**2 for wanted, _ in pairs))) for name, pairs in _signals(run).items()
    }


def of_signals(run: Run, figure: OfSignals) -> dict[str, float | None]:
    """Apply a figure to wanted and felt force, or for yaw to its rate; None where it is undefined."""
    figures = {name: figure(pairs) for name, pairs in _signals(run).items()}
    return {name: None if math.isnan(value) else value for name, value in figures.items()}


def of_forces(run: Run, figure: OfSignals) -> ByName:
    """Apply a figure to wanted and felt force along every cued axis."""
    return {name: figure(pairs) for name, pairs in _forces(run).items()}


def false_cues_by_kind(run: Run) -> dict[str, Any]:
    """Return count, duration [s], peak [m/s²] and integral [m/s] of false cues by axis pair and kind."""
    cues = false_cues(run)
    return {name: totals([cue for cue in cues if cue.dof == name]) for name in force_axes(run)}


def mean_and_largest_rating(run: Run) -> ByName:
    """Return mean and maximum of the predicted mismatch rating over time [m/s²]."""
    largest, ratings = [], rating_in_parts(run)

    def noted(rating: Vec) -> Vec:
        largest.append(float(np.max(rating)))
        return rating

    return {"mean": float(mean(map(noted, ratings))), "max": float(np.max(largest))}


def sickness_doses(run: Run) -> ByName:
    """Return the motion sickness dose of the force along every cued axis [m/s^1.5]."""
    return {
        name: dose_in_parts((part.felt_force[:, i] for part in run.parts()), run.plant_period)
        for name, i in force_axes(run).items()
    }


def workspace(run: Run) -> dict[str, ByName]:
    """Return the use of every cued axis, and of the circle, as shares of the reach."""
    return {name: asdict(use) for name, use in workspace_use(run).items()}


def largest_use_percent(of_axes: Mapping[str, Mapping[str, float]]) -> float:
    """Return the largest share of the reach used along any axis [%]; beyond 100 the platform hits its end."""
    return 100.0 * max((use["largest"] for use in of_axes.values()), default=0.0)


def nodes_beyond(run: Run, *, soft: bool) -> int:
    """Count the controller nodes at which hard, or soft, limits were passed, summed over these limits."""
    return sum(excess.violations for excess in excesses(run) if excess.soft == soft)


def limits(run: Run) -> dict[str, Any]:
    """Return by limited quantity whether the limit was hard or soft, and by how much it was passed."""
    return {excess.quantity: excess.as_json() for excess in excesses(run)}


def supervised(run: Run) -> dict[str, ByName]:
    """Return the interventions of the legs' supervisor by the limit that it kept; empty if there were none.

    The entries are the number of interventions, their total duration [s], and the largest deviation of a leg
    [m].
    """
    by_limit: dict[str, ByName] = {}
    for one in run.interventions:
        of_limit = by_limit.setdefault(one.reason.limit, {"times": 0, "seconds": 0.0, "behind_m": 0.0})
        of_limit["times"] += 1
        of_limit["seconds"] += one.end - one.start
        of_limit["behind_m"] = max(of_limit["behind_m"], one.behind)
    return by_limit


def _forces(run: Run) -> dict[str, "_Signals"]:
    """Return wanted and felt specific force [m/s²] along every cued axis."""
    return {name: _Signals(run, i, rate=False) for name, i in force_axes(run).items()}


def _signals(run: Run) -> dict[str, "_Signals"]:
    """Return wanted and felt force [m/s²], or for yaw the rates [rad/s], by degree of freedom."""
    return _forces(run) | {name: _Signals(run, i, rate=True) for name, i in rate_axes(run).items()}


@dataclass(frozen=True)
class _Signals:
    """What was wanted and felt along, or about, one axis of a run, in parts."""

    run: Run
    axis: int
    rate: bool

    def __iter__(self) -> Iterator[tuple[Vec, Vec]]:
        for part in self.run.parts():
            if self.rate:
                yield part.reference_rate[:, self.axis], part.felt_rate[:, self.axis]
            else:
                yield part.reference_force[:, self.axis], part.felt_force[:, self.axis]
