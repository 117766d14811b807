"""Unwanted cues: too much force in a direction, classified by whether force had been wanted in it before.

A direction is *remembered* from the moment at which at least τ is wanted in it. It is forgotten when at least
τ is wanted in the opposite direction and the felt force has left it, too. A force counts as too much where it
is at least τ and exceeds what is wanted in its direction by at least τ:

| kind    | direction of the felt force | what it is                                                        |
|---------|-----------------------------|-------------------------------------------------------------------|
| lag     | remembered                  | a force that was wanted is felt longer than it was wanted         |
| rebound | not remembered              | the force is felt against what is or was wanted, or without cause |

While force is wanted in the direction of the felt force, a felt force larger than any wanted so far is
neither. It is a cue of the wrong size, `scaled` in `otolith.metrics.false_cues`. The size of lag and rebound
is the felt force less the force wanted in the same direction. What is missing in the other direction does not
count. The inverted and unwanted cues of that module are exactly those samples of lag and rebound at which
nothing is wanted in the felt direction.

A pure delay gives lag and no rebound, as long as it is shorter than every cue that is followed by one in the
other direction. Rebound comes from a washout that swings back, from a platform that returns too fast, and
from one that moves before it should.
"""

from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from otolith.core.arrays import Bools, Ints, Vec
from otolith.loop import Run
from otolith.metrics.axes import force_axes, moving_axes
from otolith.metrics.false_cues import SHORTEST, THRESHOLD, FalseCue, classified, spans, totals
from otolith.metrics.workspace import reach

KINDS: Final = ("lag", "rebound")
NEUTRAL: Final = 0.01  # share of the reach, our choice: nearer than this the platform is at neutral


def unwanted_cues(run: Run, *, threshold: float = THRESHOLD, shortest: float = SHORTEST) -> list[FalseCue]:
    """Find lag and rebound along every cued force axis, in the order of their start.

    Parameters
    ----------
    threshold : τ [m/s²] of the module's table.
    shortest : stretches shorter than this [s] are left out.
    """
    return classified(run, _judge, KINDS, threshold=threshold, shortest=shortest)


def unwanted_totals(run: Run) -> dict[str, dict[str, dict[str, Any]]]:
    """Return count, duration [s], peak and mean [m/s²] of lag and rebound, by degree of freedom and kind."""
    cues = unwanted_cues(run)
    return {
        name: {
            kind: _with_mean(total)
            for kind, total in totals([cue for cue in cues if cue.dof == name], KINDS).items()
        }
        for name in force_axes(run)
    }


def seconds(kind: str, of_axes: Mapping[str, Mapping[str, Mapping[str, float]]]) -> float:
    """Return the time [s] with cues of one kind, summed over all axes of `unwanted_totals`."""
    return float(sum(of_axis[kind]["duration_s"] for of_axis in of_axes.values()))


def turns_against(run: Run, *, threshold: float = THRESHOLD, shortest: float = SHORTEST) -> dict[str, int]:
    """Count how often the felt force turns against what is still wanted, along every cued force axis.

    Every change of the felt force from at least τ in the wanted direction to at least τ against it counts,
    within each stretch in which at least τ is wanted in one direction.

    Parameters
    ----------
    threshold : τ [m/s²].
    shortest : stretches shorter than this [s] are left out.
    """
    found = {}
    for name, axis in force_axes(run).items():
        wanted, felt = run.reference_force[:, axis], run.felt_force[:, axis]
        found[name] = sum(
            _turns(way * wanted, way * felt, threshold, round(shortest / run.plant_period))
            for way in (1.0, -1.0)
        )
    return found


def neutral_crossings(run: Run) -> dict[str, int]:
    """Count how often every used axis of the platform passes through neutral.

    A crossing leads from more than 1 % of the reach on one side to more than 1 % on the other.
    """
    found = {}
    for name, i in moving_axes(run).items():
        low, high = (NEUTRAL * end for end in reach(run.platform, name))
        found[name] = len(np.flatnonzero(np.diff(_sides(run.pose[:, i], low, high))))
    return found


def _judge(wanted: Vec, felt: Vec, threshold: float) -> tuple[Ints, Vec]:
    """Return an index into KINDS for every sample, −1 for neither, and the size of the cue [m/s²].

    A felt force that is not a number counts as rebound.
    """
    codes = np.where(np.isnan(felt), 1, -1).astype(np.int64)
    for way in (1.0, -1.0):
        lag, rebound = _too_much(way * wanted, way * felt, threshold)
        codes[lag], codes[rebound] = 0, 1
    return codes, np.abs(felt) - np.maximum(np.sign(felt) * wanted, 0.0)


def _too_much(wanted: Vec, felt: Vec, threshold: float) -> tuple[Bools, Bools]:
    """Return where the felt force lags and where it rebounds, in the positive direction alone."""
    most = np.zeros(len(wanted))  # largest force wanted in this direction while it is remembered [m/s²]
    forgotten = (wanted <= -threshold) & (felt <= 0.0)
    for first, stop in spans(~forgotten):
        most[first:stop] = np.maximum.accumulate(wanted[first:stop])
    too_much = (felt >= threshold) & (felt - wanted >= threshold)
    of_wrong_size = (wanted >= threshold) & (felt - most >= threshold)
    remembered = most >= threshold
    return too_much & remembered & ~of_wrong_size, too_much & ~remembered


def _turns(wanted: Vec, felt: Vec, threshold: float, shortest: int) -> int:
    """Count the changes of the felt force from with to against a positive wanted force."""
    count = 0
    for first, stop in spans(wanted >= threshold):
        if stop - first >= shortest:
            count += int(np.sum(np.diff(_sides(felt[first:stop], -threshold, threshold)) < 0))
    return count


def _sides(series: Vec, low: float, high: float) -> Ints:
    """Return the sides, 1 or −1, on which a series is beyond `high` or `low`, without samples between."""
    sides = (series >= high).astype(np.int64) - (series <= low)
    beyond: Ints = sides[sides != 0]
    return beyond


def _with_mean(total: Mapping[str, Any]) -> dict[str, Any]:
    """Replace the integral in a total by the mean size [m/s²]."""
    lasted = total["duration_s"]
    kept = {key: value for key, value in total.items() if key != "integral"}
    return kept | {"mean": total["integral"] / lasted if lasted > 0.0 else 0.0}
