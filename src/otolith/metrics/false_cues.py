"""False cues: where, in which way and by how much the felt force misleads.

Grant & Reid (J. Aircraft 34, 1997) distinguish cues that are false (of opposite sign, or where none is
expected), missing, and scaled. Their text was not at hand; this is an executable form of our own, with one
threshold τ, and every noticeable mismatch |felt − wanted| ≥ τ has exactly one kind:

| kind      | wanted                   | felt                              |
|-----------|--------------------------|-----------------------------------|
| inverted  | at least τ               | at least τ, of the opposite sign  |
| unwanted  | less than τ              | at least τ                        |
| missing   | at least τ               | less than τ                       |
| scaled    | at least τ               | at least τ, of the same sign      |

Two forces below τ are no cue, even if they differ by τ. A delayed cue shows as missing, then unwanted;
`otolith.metrics.similarity.delay` measures it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from otolith.core.arrays import Bools, Ints, Vec
from otolith.loop import Run
from otolith.metrics.axes import force_axes

KINDS: Final = ("inverted", "unwanted", "missing", "scaled")
MISLEADING: Final = KINDS[:3]  # a scaled cue does not mislead
THRESHOLD: Final = 0.17  # [m/s²] of horizontal force in common use, as by Reid & Nahon (UTIAS 296, 1985)
SHORTEST: Final = 0.05  # [s] our choice: what is shorter is no cue


@dataclass(frozen=True, slots=True, kw_only=True)
class FalseCue:
    """One stretch of time with one kind of mismatch."""

    dof: str  # e.g. "surge-pitch"
    kind: str  # of KINDS
    start: float  # [s]
    end: float  # [s]
    peak: float  # largest |felt − wanted| [m/s²]
    integral: float  # ∫ |felt − wanted| dt [m/s]

    @property
    def duration(self) -> float:
        """Length [s]."""
        return self.end - self.start


def false_cues(run: Run, *, threshold: float = THRESHOLD, shortest: float = SHORTEST) -> list[FalseCue]:
    """False cues along every cued force axis, in the order of their start.

    Parameters
    ----------
    threshold : τ [m/s²] of the module's table.
    shortest : stretches shorter than this [s] are left out.
    """
    cues = []
    for dof, axis in force_axes(run).items():
        wanted, felt = run.reference_force[:, axis], run.felt_force[:, axis]
        error = np.abs(felt - wanted)
        for code, first, stop in _stretches(_classify(wanted, felt, threshold)):
            cue = FalseCue(
                dof=dof,
                kind=KINDS[code],
                start=float(run.time[first] - run.plant_period),  # a sample stands for the step before it
                end=float(run.time[stop - 1]),
                peak=float(np.max(error[first:stop])),
                integral=float(np.sum(error[first:stop]) * run.plant_period),
            )
            if cue.duration >= shortest:
                cues.append(cue)
    return sorted(cues, key=lambda cue: cue.start)


def totals(cues: Sequence[FalseCue]) -> dict[str, dict[str, Any]]:
    """Count, duration [s], peak [m/s²] and integral [m/s] of all cues of each kind, as plain JSON values."""
    return {kind: _total([cue for cue in cues if cue.kind == kind]) for kind in KINDS}


def misleading_time(cues: Mapping[str, Mapping[str, Mapping[str, float]]]) -> float:
    """Time with inverted, unwanted or missing cues over all axes [s], of `totals` by degree of freedom."""
    return float(sum(of_axis[kind]["duration_s"] for of_axis in cues.values() for kind in MISLEADING))


def spans(condition: Bools) -> list[tuple[int, int]]:
    """Stretches in which a condition (n,) holds, as first index and one past the last."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], condition, [False]]).astype(np.int8)))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]


def _classify(wanted: Vec, felt: Vec, threshold: float) -> Ints:
    """Index into KINDS for every sample, −1 where there is none; what is not a number counts as felt."""
    called, given = np.abs(wanted) >= threshold, ~(np.abs(felt) < threshold)
    noticed = ~(np.abs(felt - wanted) < threshold)
    conditions = [
        noticed & called & given & (wanted * felt < 0.0),
        noticed & ~called & given,
        noticed & called & ~given,
        noticed & called & given,
    ]
    return np.select(conditions, range(len(KINDS)), default=-1).astype(np.int64)


def _stretches(codes: Ints) -> list[tuple[int, int, int]]:
    """Code, first index and one past the last of every stretch of one kind."""
    return [(k, *span) for k in range(len(KINDS)) for span in spans(codes == k)]


def _total(cues: Sequence[FalseCue]) -> dict[str, Any]:
    return {
        "count": len(cues),
        "duration_s": sum(cue.duration for cue in cues),
        "peak": max((cue.peak for cue in cues), default=0.0),
        "integral": sum(cue.integral for cue in cues),
    }
