"""Mends the points of a measured road: repeated and stray ones, and laps that overlap themselves.

Every function returns points to keep and, where it changed anything, a note that says what and where.
"""

import math
from dataclasses import replace
from typing import Final

import numpy as np
import scipy  # its modules are imported on first use: none waits for one that it does not need

from otolith.core.arrays import Ints, Mat, Vec
from otolith.vehicle.survey import Survey, chosen, noted

SAME: Final = 1e-9  # [m] below which two points are one
REPEATED: Final = 0.05  # of the usual distance of points, below which two count as one …
CLOSE: Final = 0.1  # [m] … at most
STRAY: Final = 4.0  # usual distances to a point and back, at least, for it to be astray …
DETOUR: Final = 4.0  # … and times the way past it
HOLE: Final = 100.0  # [m] without points, and FAR usual distances, that are worth a note
FAR: Final = 20.0
LONGEST: Final = 20  # points in a row that may be astray, where they are beyond a hole
STRIDE: Final = 1.0  # [m] between the places at which a road is compared with itself
BESIDE: Final = 8.0  # [m] apart, two passes are passes of one road
SOONEST: Final = 80.0  # [m] of way before a road can meet itself again
SIGHT: Final = 10.0  # [m] ahead and behind, over which a heading is determined
ALIKE: Final = np.cos(np.radians(45.0))  # headings that differ by less are the same way round
DRAWN: Final = 160.0  # [m] over which roads that join draw together
MERGED: Final = 1.0  # [m] by which a meeting may be further apart than the closest that follows
OFF: Final = 0.1  # [m] between end and start of a lap, above which it is moved over
TURN: Final = -0.5  # cosine of the largest turn, 120 deg, at which two ends make a ring
GAPS: Final = 3.0  # median distances of points between the two ends of a ring at most
ORDERS: Final = range(2, 9)  # of the differences by which noise is distinguished from shape
MEDIAN: Final = {1: 0.4549, 2: 0.6931}  # of χ² of one and of two degrees of freedom, over its mean


def without_repeats(survey: Survey) -> Survey:
    """Each place once: without what a logger repeats, singly or in blocks, or writes while the car stands.

    Of points in a row that are nearer than a twentieth of the usual distance, and 0.1 m, the first stays.
    """
    if len(survey.points) < 2:
        return survey
    gaps = np.linalg.norm(np.diff(survey.points, axis=0), axis=1)
    rising = np.sort(gaps)
    usual = rising[
        np.searchsorted(np.cumsum(rising), 0.5 * rising.sum())
    ]  # half of the way is in longer ones
    least = max(SAME, min(CLOSE, REPEATED * float(usual)))
    keep, left_out, last = [0], list[int](), len(survey.points) - 1
    seen = {_place(survey.points[0])}
    for k, point in enumerate(survey.points[1:], 1):
        ring = k == last and _place(point) == _place(survey.points[0])  # written twice at its seam
        new = ring or _place(point) not in seen
        (keep if new and np.linalg.norm(point - survey.points[keep[-1]]) > least else left_out).append(k)
        seen.add(_place(point))
    if not left_out:
        return survey
    count, first = len(left_out), left_out[0]
    note = f"{count} repeated point{'s' if count > 1 else ''} left out, the first in {survey.places[first]}"
    return _chosen(survey, np.array(keep), note)


def without_strays(survey: Survey) -> Survey:
    """Without points far off, from which the road comes straight back: a receiver's jumps.

    Where the road itself leaps, its points lacking, a note says so.
    """
    points = survey.points
    usual = float(np.median(np.linalg.norm(np.diff(points, axis=0), axis=1)))
    keep, left_out, k = [0], list[int](), 1
    while k < len(points):
        run = _run_astray(points, keep[-1], k, usual)
        left_out.extend(range(k, k + run))
        keep.append(k + run)
        k += run + 1
    if left_out:
        s = "s" if len(left_out) > 1 else ""
        note = f"{len(left_out)} stray point{s} left out, the first in {survey.places[left_out[0]]}"
        survey = _chosen(survey, np.array(keep), note)
    gaps = np.linalg.norm(np.diff(survey.points, axis=0), axis=1)
    widest = int(np.argmax(gaps))
    if gaps[widest] <= max(HOLE, FAR * usual):
        return survey
    where = f"{survey.places[widest]} and {survey.places[widest + 1]}"
    note = f"there are no points for {gaps[widest]:.0f} m between {where}: the road there is a guess"
    return noted(survey, note)


def _run_astray(points: Mat, last: int, k: int, usual: float) -> int:
    """How many points from k on lie far off, with the one behind them near the last good one; mostly none."""
    out = float(np.linalg.norm(points[k] - points[last]))
    for run in range(1, 1 + (LONGEST if out > max(HOLE, FAR * usual) else 1)):
        if k + run >= len(points) or out <= 0.5 * STRAY * usual:
            return 0
        back = float(np.linalg.norm(points[k + run] - points[k + run - 1]))
        past = float(np.linalg.norm(points[k + run] - points[last]))
        if out + back > max(STRAY * usual, DETOUR * past) and (run == 1 or back > HOLE):
            return run
    return 0


def _usual_gap(points: Mat) -> float:
    """Distance [m] of neighbours: half of the way lies between points that are further apart."""
    gaps = np.sort(np.linalg.norm(np.diff(points, axis=0), axis=1))
    return float(gaps[np.searchsorted(np.cumsum(gaps), 0.5 * gaps.sum())])


def without_seam(survey: Survey) -> Survey:
    """A ring without its last point where that is the first once more."""
    twice = _place(survey.points[0]) == _place(survey.points[-1])
    return _chosen(survey, np.arange(len(survey.points) - 1), "") if twice else survey


def one_lap(survey: Survey) -> tuple[Survey, bool]:
    """The first lap of a road that meets itself again, going the same way; whether there is one.

    What lies before the place where the road is met again, and what follows it, is left out. Where the end of
    the lap comes to lie beside its start, as receivers drift, its last stretch is moved over.
    """
    way = way_along(survey.points)
    meeting = _meeting(survey.points, way)
    if meeting is None:
        return survey, False
    start, end = meeting
    gap = float(np.median(np.diff(way)))
    keep = np.flatnonzero((way >= start - 1e-9) & (way < end - 0.3 * gap))
    before, after = float(start), float(way[-1] - end)
    told = [f"the {before:.0f} m before it"] if before > STRIDE else []
    told += [f"the {after:.0f} m after it"] if after > STRIDE else []
    note = f"the road meets itself again: one lap is kept, {' and '.join(told)} left out"
    lap = _chosen(survey, keep, note if told else "")
    off = np.diff(_at(survey.points, way, np.array([start, end])), axis=0)[0]
    return _joined(lap, off, way[keep] - start, end - start), True


def _joined(lap: Survey, off: Vec, way: Vec, length: float) -> Survey:
    """The lap with its end, `off` (2,) from its start, moved to it smoothly over its last stretch."""
    beside = float(np.linalg.norm(off))
    if beside <= OFF:
        return lap
    stretch = min(0.5 * length, max(100.0, 40.0 * beside))
    share = np.clip((way - length) / stretch + 1.0, 0.0, 1.0)
    share = share**3 * (10.0 - share * (15.0 - 6.0 * share))
    note = f"its end lies {beside:.1f} m beside its start: its last {stretch:.0f} m are moved over"
    return noted(replace(lap, points=lap.points - share[:, None] * off), note)


def meets_its_start(points: Mat) -> bool:
    """True when the last point leads on to the first: about one distance away, and without turning back."""
    chords = np.diff(points, axis=0)
    gaps = np.linalg.norm(chords, axis=1)
    closing = float(np.linalg.norm(points[0] - points[-1]))
    turn = float(chords[0] @ chords[-1]) / float(gaps[0] * gaps[-1])
    return closing < GAPS * float(np.median(gaps)) and turn > TURN


def scatter(points: Mat) -> float:
    """RMS distance [m] that (n, m) points of m = 1 or 2 coordinates scatter about a smooth curve; n ≥ 5.

    Differences of order k of a smooth curve vanish as k grows, those of independent noise of variance σ² have
    the variance (2k)!/(k!)² σ²; the smallest estimate over k is taken, by the median, so that single corners
    and gaps do not count.
    """
    return min(_scatter_by(points, k) for k in ORDERS if k + 3 <= len(points))


def _scatter_by(points: Mat, order: int) -> float:
    squares = np.sum(np.diff(points, order, axis=0) ** 2, axis=1)
    mean = float(np.median(squares)) / MEDIAN[points.shape[1]]
    return math.sqrt(mean / math.comb(2 * order, order))


def way_along(points: Mat) -> Vec:
    """Way (n,) [m] from the first of the points (n, 2), along the chords."""
    way: Vec = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))]
    return way


def _meeting(points: Mat, way: Vec) -> tuple[float, float] | None:
    """Ways [m] of two passes of one place, the first such; None where the road never meets itself."""
    if len(points) < 2 or way[-1] < SOONEST:
        return None
    s = np.arange(0.0, way[-1] + 1e-9, STRIDE)
    at, ahead, behind = (_at(points, way, s + shift) for shift in (0.0, SIGHT, -SIGHT))
    chord = ahead - behind
    heading = chord / np.maximum(np.linalg.norm(chord, axis=1, keepdims=True), 1e-9)
    pairs: Ints = scipy.spatial.KDTree(at).query_pairs(BESIDE + STRIDE, output_type="ndarray")
    i, j = np.sort(pairs, axis=1).T
    apart = at[j] - at[i]
    along = np.sum(apart * heading[i], axis=1)
    beside = np.abs(apart[:, 0] * heading[i, 1] - apart[:, 1] * heading[i, 0])
    same = np.sum(heading[i] * heading[j], axis=1) > ALIKE
    passes = (s[j] - s[i] > SOONEST) & same & (np.abs(along) <= STRIDE) & (beside <= BESIDE)
    if not passes.any():
        return None
    i, j, beside, along = i[passes], j[passes], beside[passes], along[passes]
    soon = s[j] <= s[j].min() + DRAWN
    near = np.flatnonzero(soon & (beside <= beside[soon].min() + MERGED))
    k = near[np.lexsort((np.abs(along[near]), j[near]))[0]]
    return float(s[i[k]]), float(s[j[k]] - along[k])


def _at(points: Mat, way: Vec, s: Vec) -> Mat:
    s = np.clip(s, 0.0, way[-1])
    return np.stack([np.interp(s, way, column) for column in points.T], axis=1)


def _place(point: Vec) -> tuple[int, ...]:
    return tuple(round(float(x) / SAME) for x in point)


def _chosen(survey: Survey, keep: Ints, note: str) -> Survey:
    return noted(chosen(survey, keep), note) if note else chosen(survey, keep)
