"""What a study measures of a closed loop: one number for each run, the smaller the better.

Tracking and perceived errors are relative to what is wanted, so that drives of different strength count
alike; travel is relative to the reach, so that platforms do.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from otolith.core.errors import InputError
from otolith.core.frames import AXES
from otolith.interfaces import Status
from otolith.loop import Run
from otolith.metrics import perceived_rmse, tracking_rmse
from otolith.metrics.axes import by_force, moving_axes
from otolith.metrics.limits import excesses, largest_use
from otolith.metrics.measure import root_sum_square
from otolith.metrics.parts import filtered, mean, root_mean_square
from otolith.metrics.values import sickness_doses
from otolith.metrics.workspace import reach
from otolith.perception import otoliths, sensing

_MOVED: Final = len(AXES) // 2  # the first axes translate


@dataclass(frozen=True, slots=True)
class Measure:
    """One measure of a run."""

    of: Callable[[Run, float], float]  # of a run and the least possible error [m/s²], which few need
    words: str
    unit: str
    needs_best: bool = False  # whether the least possible error has to be known
    timed: bool = False  # whether it differs each time, since it is a time


def tracking(run: Run, best: float = 0.0) -> float:
    """Return the RMSE of the felt force beyond the least possible one, relative to the RMS of the wanted."""
    wanted = root_mean_square(run, lambda part: part.reference_force)
    return (_together(run, tracking_rmse(run)) - best) / _some(run, wanted)


def perceived(run: Run, best: float = 0.0) -> float:  # noqa: ARG001 (as all measures)
    """Return the RMSE of the perceived force relative to the RMS of what would be perceived in the car."""
    organ = sensing(otoliths.telban(), run.plant_period, before=np.zeros(3))
    wanted = np.sqrt(mean(one**2 for one in filtered(run, organ, lambda part: part.reference_force)))
    return _together(run, perceived_rmse(run)) / _some(run, wanted)


def travel(run: Run, best: float = 0.0) -> float:  # noqa: ARG001
    """Return the largest share of the reach that is exceeded for 1 % of the time along an axis."""
    axes = moving_axes(run)
    translations = {name: i for name, i in axes.items() if i < _MOVED} or axes
    shares = []
    for name, i in translations.items():
        low, high = reach(run.platform, name)
        pose = np.concatenate([part.pose[:, i] for part in run.parts()])
        shares.append(float(np.percentile(np.where(pose < 0.0, pose / low, pose / high), 99.0)))
    return max(shares)


def sickness(run: Run, best: float = 0.0) -> float:  # noqa: ARG001
    """Return the motion sickness dose of the felt force along all cued axes [m/s^1.5]."""
    return root_sum_square(sickness_doses(run))


def step_time(run: Run, best: float = 0.0) -> float:  # noqa: ARG001
    """Return the CPU time that 99 % of the decisions kept to [s]."""
    return float(np.percentile(np.concatenate([part.step_time for part in run.parts()]), 99.0))


def late(run: Run, best: float = 0.0) -> float:
    """Return the step time as a share of the controller's period."""
    return step_time(run, best) / run.period


def violations(run: Run, best: float = 0.0) -> float:  # noqa: ARG001
    """Return the share of decisions that failed, or at whose node a hard limit of the machine was passed."""
    decided = sum(part.status.count(Status.DECIDED.value) for part in run.parts())
    return (_passed(run, comfort=False) + run.decisions - decided) / run.decisions


def peak(run: Run, best: float = 0.0) -> float:  # noqa: ARG001
    """Return the largest share of a hard limit of the machine that is used at a node."""
    return largest_use(run)


def noticed(run: Run, best: float = 0.0) -> float:  # noqa: ARG001
    """Return the share of decisions at whose node the platform tilts faster than drivers fail to notice."""
    return _passed(run, comfort=True) / run.decisions


def _passed(run: Run, *, comfort: bool) -> int:
    """Return at how many nodes hard limits are passed, of each limit one by one."""
    return sum(one.violations for one in excesses(run) if not one.soft and one.comfort is comfort)


MEASURES: Final[Mapping[str, Measure]] = {
    "tracking": Measure(tracking, "error of the felt force, of the wanted", ""),
    "tracking-above-optimum": Measure(
        tracking, "the same beyond the least possible error", "", needs_best=True
    ),
    "perceived": Measure(perceived, "error of the perceived force, of the wanted", ""),
    "travel": Measure(travel, "share of the reach, p99", ""),
    "sickness": Measure(sickness, "motion sickness dose", "m/s^1.5"),
    "step-time": Measure(step_time, "step time, p99", "s", timed=True),
    "late": Measure(late, "step time, p99, of the period", "", timed=True),
    "violations": Measure(violations, "share of decisions with a failure or a machine's limit passed", ""),
    "peak": Measure(peak, "largest share of a machine's limit that is used", ""),
    "noticed": Measure(noticed, "share of decisions at which a tilt is noticed", ""),
}


def _geometric(values: Sequence[float]) -> float:
    if min(values) <= 0.0:
        raise InputError("a measure whose geometric mean is asked for", min(values), "greater than 0")
    return math.exp(sum(map(math.log, values)) / len(values))


# How the values over several references become one
AVERAGES: Final[Mapping[str, Callable[[Sequence[float]], float]]] = {
    "mean": lambda values: math.fsum(values) / len(values),
    "geometric": _geometric,
    "worst": max,
}


def _together(run: Run, values: np.ndarray) -> float:
    """Return the total along all cued force axes."""
    of_forces = by_force(run, values)
    if not of_forces:
        raise InputError("dofs of a study", ",".join(run.dofs), "one with a specific force at least")
    return root_sum_square(of_forces)


def _some(run: Run, wanted: np.ndarray) -> float:
    """Return the total of what is wanted, to which an error is relative."""
    total = _together(run, wanted)
    if total == 0.0:
        bound = "one along a cued axis, since errors are relative to it"
        raise InputError(f"specific force of {run.scenario}", "0 m/s² throughout", bound)
    return total
