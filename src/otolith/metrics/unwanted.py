"""Unwanted cues: too much force in a direction, told apart by whether something had been wanted in it.

A direction is *remembered* from the moment at which at least τ is wanted in it, until at least τ is wanted in
the other one and the felt force, too, has left it. Where the felt force is at least τ, and exceeds what is
wanted in its direction by at least τ:

| kind    | direction of the felt force | what it is                                                        |
|---------|-----------------------------|-------------------------------------------------------------------|
| lag     | remembered                  | what was wanted is felt longer than wanted                        |
| rebound | not remembered              | felt against what is or was wanted, or where nothing was          |

While something is wanted in the direction of the felt force, more than was wanted so far is neither: it is a
cue of the wrong size, `scaled` in `otolith.metrics.false_cues`. The size of lag and rebound is what is felt
in the direction beyond what is wanted in it; what is missing in the other direction is not in it. Inverted
and unwanted cues of that module are exactly those samples of lag and rebound at which nothing is wanted in
the felt direction.

A pure delay gives lag and no rebound, as long as it is shorter than every cue that is followed by one of the
other direction. A washout that swings back, a platform that is called home too fast, and one that sets out
before it should give rebound.
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
    """Lag and rebound along every cued force axis, in the order of their start.

    Parameters
    ----------
    threshold : τ [m/s²] of the module's table.
    shortest : stretches shorter than this [s] are left out.
    """
    return classified(run, _judge, KINDS, threshold=threshold, shortest=shortest)


def unwanted_totals(run: Run) -> dict[str, dict[str, dict[str, Any]]]:
    """Count, duration [s], peak and mean [m/s²] of lag and rebound, by degree of freedom and kind."""
    cues = unwanted_cues(run)
    return {
        name: {
            kind: _with_mean(total)
            for kind, total in totals([cue for cue in cues if cue.dof == name], KINDS).items()
        }
        for name in force_axes(run)
    }


def seconds(kind: str, of_axes: Mapping[str, Mapping[str, Mapping[str, float]]]) -> float:
    """Time with cues of one kind over all axes [s], of `unwanted_totals`."""
    return float(sum(of_axis[kind]["duration_s"] for of_axis in of_axes.values()))


def turns_against(run: Run, *, threshold: float = THRESHOLD, shortest: float = SHORTEST) -> dict[str, int]:
    """How often the felt force turns against what is still wanted, along every cued force axis.

    Counted within each stretch in which at least `threshold` τ [m/s²] is wanted in one direction, for at
    least `shortest` [s]: every change of the felt force from at least τ in that direction to at least τ in
    the other.
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
    """How often every used axis of the platform passes through neutral, from beyond 1 % of its reach to 1 %
    beyond on the other side.
    """
    found = {}
    for name, i in moving_axes(run).items():
        low, high = (NEUTRAL * end for end in reach(run.platform, name))
        found[name] = len(np.flatnonzero(np.diff(_sides(run.pose[:, i], low, high))))
    return found


def _judge(wanted: Vec, felt: Vec, threshold: float) -> tuple[Ints, Vec]:
    """Index into KINDS for every sample, −1 where there is none; what is not a number counts as rebound."""
    codes = np.where(np.isnan(felt), 1, -1).astype(np.int64)
    for way in (1.0, -1.0):
        lag, rebound = _too_much(way * wanted, way * felt, threshold)
        codes[lag], codes[rebound] = 0, 1
    return codes, np.abs(felt) - np.maximum(np.sign(felt) * wanted, 0.0)


def _too_much(wanted: Vec, felt: Vec, threshold: float) -> tuple[Bools, Bools]:
    """Where the felt force lags, and where it rebounds, in the direction that is positive here."""
    most = np.zeros(len(wanted))  # wanted in this direction as far as it is remembered [m/s²]
    forgotten = (wanted <= -threshold) & (felt <= 0.0)
    for first, stop in spans(~forgotten):
        most[first:stop] = np.maximum.accumulate(wanted[first:stop])
    too_much = (felt >= threshold) & (felt - wanted >= threshold)
    of_wrong_size = (wanted >= threshold) & (felt - most >= threshold)
    remembered = most >= threshold
    return too_much & remembered & ~of_wrong_size, too_much & ~remembered


def _turns(wanted: Vec, felt: Vec, threshold: float, shortest: int) -> int:
    """Changes of the felt force from with to against what is wanted in the direction positive here."""
    count = 0
    for first, stop in spans(wanted >= threshold):
        if stop - first >= shortest:
            count += int(np.sum(np.diff(_sides(felt[first:stop], -threshold, threshold)) < 0))
    return count


def _sides(series: Vec, low: float, high: float) -> Ints:
    """The sides, −1 or 1, on which a series is beyond the low or the high end, without what is between."""
    sides = (series >= high).astype(np.int64) - (series <= low)
    beyond: Ints = sides[sides != 0]
    return beyond


def _with_mean(total: Mapping[str, Any]) -> dict[str, Any]:
    """A total with the mean size [m/s²] in place of its integral."""
    lasted = total["duration_s"]
    kept = {key: value for key, value in total.items() if key != "integral"}
    return kept | {"mean": total["integral"] / lasted if lasted > 0.0 else 0.0}
