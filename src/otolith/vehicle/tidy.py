"""Repairs the points of a measured road: repeated and stray points, and laps that overlap themselves.

Every function returns the points to keep and, if it changed anything, a note that says what and where.
"""

import math
from dataclasses import replace
from typing import Final

import numpy as np
import scipy  # scipy imports its modules on first use, so unused ones cost no time

from otolith.core.arrays import Ints, Mat, Vec
from otolith.vehicle.survey import Survey, chosen, noted

SAME: Final = 1e-9  # [m] distance below which two points are equal
REPEATED: Final = 0.05  # distance, relative to the usual one, below which two points count as one …
CLOSE: Final = 0.1  # [m] … but at most this distance
STRAY: Final = 4.0  # least path to a stray point and back, in usual distances …
DETOUR: Final = 4.0  # … and relative to the path past it
HOLE: Final = 100.0  # [m] gap between points, together with FAR usual distances, that is noted
FAR: Final = 20.0
LONGEST: Final = 20  # largest number of consecutive stray points beyond a gap
STRIDE: Final = 1.0  # [m] between the positions at which a road is compared with itself
BESIDE: Final = 8.0  # [m] largest distance of two passes of one road
SOONEST: Final = 80.0  # [m] shortest path after which a road can meet itself again
SIGHT: Final = 10.0  # [m] ahead and behind that determine a heading
ALIKE: Final = np.cos(np.radians(45.0))  # headings that differ by less count as the same direction
DRAWN: Final = 160.0  # [m] over which roads that join converge
MERGED: Final = 1.0  # [m] by which a meeting may be wider than the closest that follows
OFF: Final = 0.1  # [m] distance between end and start of a lap above which its end is moved
TURN: Final = -0.5  # cosine of the largest turn, 120 deg, between the two ends of a ring
GAPS: Final = 3.0  # largest gap between the two ends of a ring, in median distances of points
ORDERS: Final = range(2, 9)  # orders of the differences that separate noise from shape
MEDIAN: Final = {1: 0.4549, 2: 0.6931}  # median over mean of χ² with one and with two degrees of freedom


def without_repeats(survey: Survey) -> Survey:
    """Remove what a logger repeats, singly or in blocks, or writes while the car stands.

    Of consecutive points that are closer than a twentieth of the usual distance, and than 0.1 m, the first is
    kept.
    """
    if len(survey.points) < 2:
        return survey
    gaps = np.linalg.norm(np.diff(survey.points, axis=0), axis=1)
    rising = np.sort(gaps)
    usual = rising[
        np.searchsorted(np.cumsum(rising), 0.5 * rising.sum())
    ]  # half of the path consists of longer ones
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
    """Remove points far off from which the road returns at once: jumps of a receiver.

    If the road itself leaps because points are missing, a note says so.
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
    """Return how many points from k on lie far off while the next one is near the last good one; mostly 0."""
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
    """Return the distance [m] of neighbours such that half of the path has larger distances."""
    gaps = np.sort(np.linalg.norm(np.diff(points, axis=0), axis=1))
    return float(gaps[np.searchsorted(np.cumsum(gaps), 0.5 * gaps.sum())])


def without_seam(survey: Survey) -> Survey:
    """Return a ring without its last point if that repeats the first one."""
    twice = _place(survey.points[0]) == _place(survey.points[-1])
    return _chosen(survey, np.arange(len(survey.points) - 1), "") if twice else survey


def one_lap(survey: Survey) -> tuple[Survey, bool]:
    """Return the first lap of a road that meets itself again in the same direction, and whether there is one.

    Points before the meeting, and after it, are left out. If the end of the lap lies next to its start, as
    receivers drift, its last stretch is moved smoothly to the start.
    """
    way = way_along(survey.points)
    meeting = _meeting(survey.points, way)
    if meeting is None:
        return survey, False
    start, end = meeting
    gap = float(np.median(np.diff(way)))
    keep = np.flatnonzero((way >= start - 1e-9) & (way < end - 0.3 * gap))
    before, after = float(start), float(way[-1] - end)
    left_out = [f"the {before:.0f} m before it"] if before > STRIDE else []
    left_out += [f"the {after:.0f} m after it"] if after > STRIDE else []
    note = f"the road meets itself again: one lap is kept, {' and '.join(left_out)} left out"
    lap = _chosen(survey, keep, note if left_out else "")
    off = np.diff(_at(survey.points, way, np.array([start, end])), axis=0)[0]
    return _joined(lap, off, way[keep] - start, end - start), True


def _joined(lap: Survey, off: Vec, way: Vec, length: float) -> Survey:
    """Return the lap with its end, at `off` (2,) from its start, moved smoothly to the start."""
    beside = float(np.linalg.norm(off))
    if beside <= OFF:
        return lap
    stretch = min(0.5 * length, max(100.0, 40.0 * beside))
    share = np.clip((way - length) / stretch + 1.0, 0.0, 1.0)
    share = share**3 * (10.0 - share * (15.0 - 6.0 * share))
    note = f"its end lies {beside:.1f} m to the side of its start: its last {stretch:.0f} m are moved over"
    return noted(replace(lap, points=lap.points - share[:, None] * off), note)


def meets_its_start(points: Mat) -> bool:
    """Return whether the last point leads to the first: about one distance away, without turning back."""
    chords = np.diff(points, axis=0)
    gaps = np.linalg.norm(chords, axis=1)
    closing = float(np.linalg.norm(points[0] - points[-1]))
    turn = float(chords[0] @ chords[-1]) / float(gaps[0] * gaps[-1])
    return closing < GAPS * float(np.median(gaps)) and turn > TURN


def scatter(points: Mat) -> float:
    """Return the RMS scatter [m] of (n, m) points, with m = 1 or 2 coordinates, about a smooth curve; n ≥ 5.

    Differences of order k of a smooth curve vanish as k grows, and those of independent noise of variance σ²
    have the variance (2k)!/(k!)² σ². The smallest estimate over k is taken, by the median, so that single
    corners and gaps do not matter.
    """
    return min(_scatter_by(points, k) for k in ORDERS if k + 3 <= len(points))


def _scatter_by(points: Mat, order: int) -> float:
    squares = np.sum(np.diff(points, order, axis=0) ** 2, axis=1)
    mean = float(np.median(squares)) / MEDIAN[points.shape[1]]
    return math.sqrt(mean / math.comb(2 * order, order))


def way_along(points: Mat) -> Vec:
    """Return the distance (n,) [m] from the first of the points (n, 2), along the chords."""
    way: Vec = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))]
    return way


def _meeting(points: Mat, way: Vec) -> tuple[float, float] | None:
    """Return the distances [m] of the first two passes of one place; None if the road never meets itself."""
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
