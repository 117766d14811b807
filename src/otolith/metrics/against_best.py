"""How far a run is from the best that is possible on its drive.

The errors of several degrees of freedom count together, with the weights of the optimum's cost. No motion
within the limits has a smaller sum, while one force may be followed better at the expense of another.
"""

import math
from collections.abc import Mapping
from typing import Any, Final, Protocol

import numpy as np

from otolith.core.errors import InputError
from otolith.loop import Run
from otolith.metrics.axes import by_force, by_rate
from otolith.metrics.measure import Summary
from otolith.metrics.parts import root_mean_square
from otolith.metrics.tracking import rate_rmse, tracking_rmse

WITHIN_REACH: Final = 0.02  # of what is wanted; an optimum whose error is less, its lag aside, is perfect
NOT_COMPUTED: Final = "add --optimum"


class Best(Protocol):
    """The best run, as `otolith.cueing.optimum` finds it; figures by degree of freedom [m/s² or rad/s]."""

    @property
    def run(self) -> Run:
        """Return the run."""

    @property
    def through_lag(self) -> Mapping[str, float]:
        """Return the RMS errors that no platform with this lag can avoid, since it cannot follow jumps."""

    @property
    def weights(self) -> Mapping[str, float]:
        """Return the weights of the squared errors."""


def against_best(run: Run, best: Best) -> dict[str, Any]:
    """Compare a run's errors with the least possible ones, in total and by degree of freedom.

    Returns
    -------
    JSON values. `times` is the ratio of the run's error to the least. It is None if the best has no error but
    that of its lag, since there is nothing to divide by.

    Raises
    ------
    InputError : the runs differ in drive, platform or degrees of freedom.
    """
    _check_alike(run, best.run)
    error, least, still = _errors(run), _errors(best.run), _wanted(run)

    def together(of: Mapping[str, float]) -> float:
        return math.sqrt(sum(best.weights[dof] * value**2 for dof, value in of.items()))

    times, standing = _times(*map(together, (error, least, best.through_lag, still)))
    return {
        "times": times,
        "standing_still": standing,
        "by_dof": {
            dof: {
                "times": _times(error[dof], least[dof], best.through_lag[dof], still[dof])[0],
                "error": least[dof],
                "through_lag": best.through_lag[dof],
            }
            for dof in run.dofs
        },
        "plant": best.run.plant,
        "certificate": float(best.run.residual.max()),
    }


def not_computed(reason: str = NOT_COMPUTED) -> dict[str, Any]:
    """Return the entry of a summary if the best was not computed or not found."""
    return {"not_computed": reason}


def _check_alike(run: Run, best: Run) -> None:
    """Check that both are of the same drive; they may decide at different periods."""
    same = run.dofs == best.dofs and run.platform == best.platform and run.samples == best.samples
    wanted, first = best.reference_force, 0
    for part in run.parts() if same else ():
        same = same and np.array_equal(part.reference_force, wanted[first : first + part.samples])
        first += part.samples
    if not same:
        raise InputError("the optimum", "of another drive, platform or --dofs", "of those of the run")


def _errors(run: Run) -> dict[str, float]:
    """Return the RMS of felt minus wanted, by degree of freedom [m/s² or rad/s]."""
    return by_force(run, tracking_rmse(run)) | by_rate(run, rate_rmse(run))


def _wanted(run: Run) -> dict[str, float]:
    """Return the RMS of what is wanted, by degree of freedom [m/s² or rad/s]."""
    force = root_mean_square(run, lambda part: part.reference_force)
    rate = root_mean_square(run, lambda part: part.reference_rate)
    return by_force(run, force) | by_rate(run, rate)


def _times(error: float, least: float, lag: float, still: float) -> tuple[float | None, float | None]:
    """Return the ratios of a run's error and of standing still's to the least; None if within reach."""
    if math.sqrt(max(least**2 - lag**2, 0.0)) <= WITHIN_REACH * still:
        return None, None
    return error / least, still / least


def times_or_words(entry: Mapping[str, Any]) -> float | str:
    """Return what a column of a table shows for the result of `against_best`."""
    if "not_computed" in entry:
        return "not computed"
    times: float | None = entry["times"]
    return "within reach" if times is None else times


def best_in_words(summary: Summary) -> str:
    """Describe how far a run is from the best that is possible, or why that is unknown."""
    entry = summary.get("optimum")
    if entry is None:
        return ""
    if "not_computed" in entry:
        return f"the best that is possible is not computed; {entry['not_computed']}"
    several = len(entry["by_dof"]) > 1
    each = ", ".join(_least(dof if several else "", one, summary) for dof, one in entry["by_dof"].items())
    if entry["times"] is None:
        text = f"a perfect answer is within reach of this platform on this drive ({each})"
    else:
        text = f"its error is {entry['times']:.2f} times the best that is possible on this drive ({each})"
    if entry["plant"] != summary["plant"]:
        text += f", measured on the plant {entry['plant']}"
    if entry["times"] is not None and (summary.get("violations") or summary.get("soft_exceeded")):
        text += ", which keeps the limits that this run passed"
    return text


def _least(dof: str, one: Mapping[str, Any], summary: Summary) -> str:
    """Describe the least error of one degree of freedom; with a name, the run's ratio to it, too."""
    turns = dof == "yaw" or summary["dofs"] == "yaw"
    size = f"{math.degrees(one['error']):.3f} deg/s" if turns else f"{one['error']:.4f} m/s²"
    if not dof:
        return size
    return f"{dof} within reach, {size}" if one["times"] is None else f"{dof} {one['times']:.2f} times {size}"
