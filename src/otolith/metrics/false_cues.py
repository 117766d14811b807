"""False cues: where, in which way and by how much the felt force misleads.

Grant & Reid (J. Aircraft 34, 1997) distinguish cues that are false (of opposite sign, or where none is
expected), missing, and scaled. Their paper was not available. The definitions below are our own executable
form with one threshold τ. Every noticeable mismatch |felt − wanted| ≥ τ has exactly one kind:

| kind      | wanted                   | felt                              |
|-----------|--------------------------|-----------------------------------|
| inverted  | at least τ               | at least τ, of the opposite sign  |
| unwanted  | less than τ              | at least τ                        |
| missing   | at least τ               | less than τ                       |
| scaled    | at least τ               | at least τ, of the same sign      |

Two forces below τ are no cue, even if they differ by τ. A delayed cue appears as missing, then unwanted.
`otolith.metrics.similarity.delay` measures the delay, and `otolith.metrics.unwanted` distinguishes a delayed
cue from one that swings back.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Final

import numpy as np

from otolith.core.arrays import Bools, Ints, Vec
from otolith.loop import Run
from otolith.metrics.axes import force_axes

KINDS: Final = ("inverted", "unwanted", "missing", "scaled")
MISLEADING: Final = KINDS[:3]  # a scaled cue does not mislead
THRESHOLD: Final = 0.17  # [m/s²] of horizontal force in common use, as by Reid & Nahon (UTIAS 296, 1985)
SHORTEST: Final = 0.05  # [s] our choice: a shorter stretch is no cue

# wanted (n,), felt (n,) -> index of the kind (n,) or −1, size of the mismatch (n,) [m/s²]; is called for
# one part of a run after the other
Judge = Callable[[Vec, Vec], tuple[Ints, Vec]]


@dataclass(frozen=True, slots=True, kw_only=True)
class FalseCue:
    """One stretch of time with one kind of mismatch."""

    dof: str  # e.g. "surge-pitch"
    kind: str  # one of the kinds of the classification, e.g. those in KINDS
    start: float  # [s]
    end: float  # [s]
    peak: float  # largest mismatch, here |felt − wanted| [m/s²]
    integral: float  # of the mismatch over time [m/s]

    @property
    def duration(self) -> float:
        """Return the length [s]."""
        return self.end - self.start


def false_cues(run: Run, *, threshold: float = THRESHOLD, shortest: float = SHORTEST) -> list[FalseCue]:
    """Find the false cues along every cued force axis, in the order of their start.

    Parameters
    ----------
    threshold : τ [m/s²] of the module's table.
    shortest : stretches shorter than this [s] are left out.
    """
    return classified(run, lambda: partial(_judge, threshold=threshold), KINDS, shortest=shortest)


def classified(
    run: Run, judge: Callable[[], Judge], kinds: Sequence[str], *, shortest: float
) -> list[FalseCue]:
    """Find the stretches of one kind each along every cued force axis, in the order of their start.

    Parameters
    ----------
    judge : makes, for every axis, what gives for every sample an index into `kinds`, −1 where there is no
        mismatch, and the mismatch's size.
    shortest : stretches shorter than this [s] are left out.
    """
    axes, dt = force_axes(run), run.plant_period
    judges = {dof: judge() for dof in axes}
    found: dict[str, list[_Stretch]] = {dof: [] for dof in axes}
    before = 0  # samples of the parts before
    for part in run.parts():
        wanted, felt, time = part.reference_force, part.felt_force, part.time
        for dof, axis in axes.items():
            codes, size = judges[dof](wanted[:, axis], felt[:, axis])
            found[dof] += [
                _Stretch(
                    code=code,
                    first=before + first,
                    stop=before + stop,
                    start=float(time[first] - dt),  # a sample stands for the step before it
                    end=float(time[stop - 1]),
                    peak=float(np.max(size[first:stop])),
                    total=float(np.sum(size[first:stop])),
                )
                for code, first, stop in _stretches(codes, len(kinds))
            ]
        before += part.samples
    cues = [one.cue(dof, kinds, dt) for dof in axes for one in _joined(found[dof])]
    return sorted((cue for cue in cues if cue.duration >= shortest), key=lambda cue: cue.start)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Stretch:
    """Consecutive samples of one kind, from `first` up to `stop`."""

    code: int
    first: int
    stop: int
    start: float  # [s]
    end: float  # [s]
    peak: float  # of the sizes
    total: float  # sum of the sizes

    def cue(self, dof: str, kinds: Sequence[str], dt: float) -> FalseCue:
        """Return the stretch as a cue."""
        return FalseCue(
            dof=dof,
            kind=kinds[self.code],
            start=self.start,
            end=self.end,
            peak=self.peak,
            integral=self.total * dt,
        )


def _joined(stretches: Iterable[_Stretch]) -> list[_Stretch]:
    """Join stretches of one kind where the border between two parts cuts them."""
    joined: list[_Stretch] = []
    for one in sorted(stretches, key=lambda one: (one.code, one.first)):
        last = joined[-1] if joined else None
        if last is None or last.code != one.code or last.stop != one.first:
            joined.append(one)
            continue
        peak, total = float(np.maximum(last.peak, one.peak)), last.total + one.total
        joined[-1] = replace(last, stop=one.stop, end=one.end, peak=peak, total=total)
    return joined


def totals(cues: Sequence[FalseCue], kinds: Sequence[str] = KINDS) -> dict[str, dict[str, Any]]:
    """Return count, duration [s], peak [m/s²] and integral [m/s] of the cues of each kind, as JSON values."""
    return {kind: _total([cue for cue in cues if cue.kind == kind]) for kind in kinds}


def misleading_time(cues: Mapping[str, Mapping[str, Mapping[str, float]]]) -> float:
    """Return the time [s] with inverted, unwanted or missing cues, summed over all axes.

    Parameters
    ----------
    cues : the `totals` of each degree of freedom.
    """
    return float(sum(of_axis[kind]["duration_s"] for of_axis in cues.values() for kind in MISLEADING))


def spans(condition: Bools) -> list[tuple[int, int]]:
    """Return the stretches in which a condition (n,) holds: first index, and last index plus one."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], condition, [False]]).astype(np.int8)))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]


def _judge(wanted: Vec, felt: Vec, threshold: float) -> tuple[Ints, Vec]:
    """Return an index into KINDS for every sample, −1 without a mismatch, and the mismatch [m/s²].

    A felt force that is not a number counts as at least τ.
    """
    error = np.abs(felt - wanted)
    called, given = np.abs(wanted) >= threshold, ~(np.abs(felt) < threshold)
    noticed = ~(error < threshold)
    conditions = [
        noticed & called & given & (wanted * felt < 0.0),
        noticed & ~called & given,
        noticed & called & ~given,
        noticed & called & given,
    ]
    return np.select(conditions, range(len(KINDS)), default=-1).astype(np.int64), error


def _stretches(codes: Ints, kinds: int) -> list[tuple[int, int, int]]:
    """Return the kind, first index, and last index plus one of every stretch of one kind."""
    return [(k, *span) for k in range(kinds) for span in spans(codes == k)]


def _total(cues: Sequence[FalseCue]) -> dict[str, Any]:
    """Return count, duration [s], peak and integral of these cues."""
    return {
        "count": len(cues),
        "duration_s": sum(cue.duration for cue in cues),
        "peak": max((cue.peak for cue in cues), default=0.0),
        "integral": sum(cue.integral for cue in cues),
    }
