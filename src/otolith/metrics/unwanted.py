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
from numpy.typing import NDArray

from otolith.core.arrays import Bools, Ints, Vec
from otolith.loop import Run
from otolith.metrics.axes import force_axes, moving_axes
from otolith.metrics.false_cues import SHORTEST, THRESHOLD, FalseCue, classified, spans, totals
from otolith.metrics.workspace import reach

KINDS: Final = ("lag", "rebound")
Bytes = NDArray[np.int8]
NEUTRAL: Final = 0.01  # share of the reach, our choice: nearer than this the platform is at neutral


def unwanted_cues(run: Run, *, threshold: float = THRESHOLD, shortest: float = SHORTEST) -> list[FalseCue]:
    """Find lag and rebound along every cued force axis, in the order of their start.

    Parameters
    ----------
    threshold : τ [m/s²] of the module's table.
    shortest : stretches shorter than this [s] are left out.
    """
    return classified(run, lambda: _Memory(threshold).judge, KINDS, shortest=shortest)


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
    least = round(shortest / run.plant_period)
    return {
        name: sum(_turns(way * wanted, way * felt, least) for way in (1, -1))
        for name, (wanted, felt) in _beyond(run, threshold).items()
    }


def _beyond(run: Run, threshold: float) -> dict[str, tuple[Bytes, Bytes]]:
    """Return, for every cued force axis, the sides on which wanted and felt force are beyond ±τ (n,)."""
    axes = force_axes(run)
    found: dict[str, list[tuple[Bytes, Bytes]]] = {name: [] for name in axes}
    for part in run.parts():
        wanted, felt = part.reference_force, part.felt_force
        for name, i in axes.items():
            both = (_side(series[:, i], -threshold, threshold) for series in (wanted, felt))
            found[name].append((next(both), next(both)))
    return {
        name: (np.concatenate([one[0] for one in parts]), np.concatenate([one[1] for one in parts]))
        for name, parts in found.items()
    }


def neutral_crossings(run: Run) -> dict[str, int]:
    """Count how often every used axis of the platform passes through neutral.

    A crossing leads from more than 1 % of the reach on one side to more than 1 % on the other.
    """
    found: dict[str, list[Bytes]] = {name: [] for name in moving_axes(run)}
    for part in run.parts():
        pose = part.pose
        for name, i in moving_axes(run).items():
            low, high = (NEUTRAL * end for end in reach(run.platform, name))
            found[name].append(_side(pose[:, i], low, high))
    return {name: int(np.count_nonzero(_changes(np.concatenate(sides)))) for name, sides in found.items()}


class _Memory:
    """Tells lag from rebound by what was wanted before, from part to part of a run."""

    def __init__(self, threshold: float) -> None:
        self._threshold = threshold
        # largest force wanted in either direction while it is remembered [m/s²]; −∞: it is forgotten
        self._most = {1.0: -np.inf, -1.0: -np.inf}

    def judge(self, wanted: Vec, felt: Vec) -> tuple[Ints, Vec]:
        """Return an index into KINDS for every sample, −1 for neither, and the size of the cue [m/s²].

        A felt force that is not a number counts as rebound.
        """
        codes = np.where(np.isnan(felt), 1, -1).astype(np.int64)
        for way in self._most:
            lag, rebound = self._too_much(way, way * wanted, way * felt)
            codes[lag], codes[rebound] = 0, 1
        return codes, np.abs(felt) - np.maximum(np.sign(felt) * wanted, 0.0)

    def _too_much(self, way: float, wanted: Vec, felt: Vec) -> tuple[Bools, Bools]:
        """Return where the felt force lags and where it rebounds, in the positive direction alone."""
        threshold = self._threshold
        most = np.zeros(len(wanted))  # largest force wanted in this direction while it is remembered [m/s²]
        forgotten = (wanted <= -threshold) & (felt <= 0.0)
        for first, stop in spans(~forgotten):
            known = self._most[way] if first == 0 else -np.inf
            most[first:stop] = np.maximum(known, np.maximum.accumulate(wanted[first:stop]))
        self._most[way] = -np.inf if forgotten[-1] else float(most[-1])
        too_much = (felt >= threshold) & (felt - wanted >= threshold)
        of_wrong_size = (wanted >= threshold) & (felt - most >= threshold)
        remembered = most >= threshold
        return too_much & remembered & ~of_wrong_size, too_much & ~remembered


def _turns(wanted: Bytes, felt: Bytes, shortest: int) -> int:
    """Count the changes of the felt force from with to against a positive wanted force, given their sides."""
    return sum(
        int(np.sum(_changes(felt[first:stop]) < 0))
        for first, stop in spans(wanted > 0)
        if stop - first >= shortest
    )


def _side(series: Vec, low: float, high: float) -> Bytes:
    """Return the side, 1 or −1, on which every sample is beyond `high` or `low`, and 0 between."""
    return np.subtract(series >= high, series <= low, dtype=np.int8)


def _changes(sides: Bytes) -> Bytes:
    """Return the changes of side, without samples between the sides."""
    beyond: Bytes = np.diff(sides[sides != 0])
    return beyond


def _with_mean(total: Mapping[str, Any]) -> dict[str, Any]:
    """Replace the integral in a total by the mean size [m/s²]."""
    lasted = total["duration_s"]
    kept = {key: value for key, value in total.items() if key != "integral"}
    return kept | {"mean": total["integral"] / lasted if lasted > 0.0 else 0.0}
