"""The coming forces, foreseen from an earlier drive along the same road.

A driver who knows the road foresees a bend. A cueing algorithm can do so from an earlier lap. `Follower`
finds where on the path of the earlier drive the car is now, from the car's places until now alone.
`Foresight` returns what was felt from there on. Two differences between the drives are taken into account,
and both fade. A car that is faster or slower than before keeps this pace for about `PACE_LASTS`. A difference
between the forces felt at this place, now and then, lasts for about `DIFFERENCE_LASTS`.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from otolith.core.arrays import Mat, Vec, freeze
from otolith.core.errors import InputError
from otolith.recordings.logs import Log

NEAR: Final = 20.0  # [m] largest distance from the earlier path; beyond it the car is on another road
BEFORE: Final = 1.0  # [s] a car on the path is searched this far behind its last place,
AFTER: Final = 3.0  # [s] and this far ahead of it
SAME_WAY: Final = 0.5  # cosine of the largest angle between the directions of the two drives
LONG_ENOUGH: Final = 1.0  # [m] shortest way that yields a direction
PACE_OVER: Final = 0.5  # [s] over which the pace is averaged
PACE_LASTS: Final = 2.0  # [s]
DIFFERENCE_LASTS: Final = 0.6  # [s] as long as a large force lasts in the adaptive prediction
SLOWEST: Final = 0.5  # smallest pace that can last, since a car that stands will start again
FASTEST: Final = 2.0
JUMP: Final = 4.0  # a pace that differs more from 1 is not real: the car left the path, or a new lap began


@dataclass(frozen=True, eq=False)
class Path:
    """The places of a drive over time.

    Raises
    ------
    InputError : the drive has fewer than two places.
    """

    time: Vec  # (n,) [s], increasing
    place: Mat  # (n, 2) [m] on a map

    def __post_init__(self) -> None:
        n = len(self.time)
        if n < 2:
            raise InputError("places of the drive", n, "at least 2")
        freeze(self, time=(n,), place=(n, 2))

    def nearest(self, place: Vec, first: int, last: int) -> tuple[float, float]:
        """Find the point nearest to a place (2,) on the segments from `first` to `last` − 1.

        Returns
        -------
        The time on the path [s], and the distance [m].
        """
        begin = self.place[first:last]
        along = self.place[first + 1 : last + 1] - begin
        square = np.maximum(np.sum(along**2, axis=1), 1e-12)
        share = np.clip(np.sum((place - begin) * along, axis=1) / square, 0.0, 1.0)
        away = np.hypot(*(begin + share[:, None] * along - place).T)
        best = int(np.argmin(away))
        start, end = self.time[first + best], self.time[first + best + 1]
        return float(start + share[best] * (end - start)), float(away[best])

    def direction(self, time: float) -> Vec:
        """Return the unit vector (2,) along the path at a time; zero where the drive stands."""
        k = int(np.clip(np.searchsorted(self.time, time, side="right"), 1, len(self.time) - 1))
        return _unit(self.place[k] - self.place[k - 1])


class Follower:
    """The position of a car on the path of an earlier drive, found from one place after another.

    A car that was on the path a moment ago is searched near its last place, so that a road that crosses
    itself causes no confusion. Otherwise the whole path is searched, where it leads in the same direction.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._there: float | None = None
        self._last: Vec | None = None
        self._heading = np.zeros(2)

    def at(self, place: Vec) -> float | None:
        """Return the time at which the earlier drive was at the car's place (2,) [m]; None: it never was."""
        self._turn(place)
        there = self._near_by(place)
        self._there = self._anywhere(place) if there is None else there
        return self._there

    def _turn(self, place: Vec) -> None:
        """Update the car's direction."""
        if self._last is None:
            self._last = place
        way = place - self._last
        if np.hypot(*way) >= LONG_ENOUGH:
            self._heading, self._last = _unit(way), place

    def _near_by(self, place: Vec) -> float | None:
        """Search the piece of path that the car can have reached; return None beyond the end of the path."""
        if self._there is None:
            return None
        time = self.path.time
        first = max(int(np.searchsorted(time, self._there - BEFORE, side="right")) - 1, 0)
        last = min(int(np.searchsorted(time, self._there + AFTER)), len(time) - 1)
        if last <= first:
            return None
        there, away = self.path.nearest(place, first, last)
        return there if away <= NEAR and there < time[-1] else None

    def _anywhere(self, place: Vec) -> float | None:
        """Search the whole path where it leads in the car's direction; return None while that is unknown."""
        if not self._heading.any():
            return None
        away = np.hypot(*(self.path.place - place).T)
        close = np.flatnonzero(away <= 2.0 * NEAR)
        for k in map(int, close[np.argsort(away[close])]):
            if self.path.direction(self.path.time[k]) @ self._heading >= SAME_WAY:
                there, near = self.path.nearest(place, max(k - 1, 0), min(k + 1, len(away) - 1))
                if near <= NEAR:
                    return there
        return None


def _unit(way: Vec) -> Vec:
    """Return the direction of a way (2,), or zero if it is too short to have one."""
    length = float(np.hypot(*way))
    return way / length if length > 1e-9 else np.zeros(2)


@dataclass(frozen=True, eq=False)
class Foresight:
    """The forces that an earlier drive felt from the car's present place on.

    `there` and `pace` hold what was known at each node of the present drive, and nothing later.
    """

    period: float  # [s] between two nodes
    # (k,) [s] -> (k, 3) [m/s²] of the present drive; only the present value is read
    force: Callable[[Vec], Mat]
    earlier: Callable[[Vec], Mat]  # (k,) [s] -> (k, 3) [m/s²] of the earlier one
    there: Vec  # (m,) [s] time of the earlier drive at every node; NaN: on another road
    pace: Vec  # (m,) seconds of the earlier drive per second of the present one
    again: float | None  # [s] time of the earlier drive at which it passed its own end, on a closed road
    end: float = field(default=np.inf)  # [s] end of the earlier drive

    def __call__(self, time: float, dt: float, n: int) -> Mat:
        """Return the forces foreseen for the ends of the next n periods of dt [s]: (k, 3), k ≤ n [m/s²].

        There are fewer than n where the earlier drive ends, and none where the car is on another road.
        """
        k = min(int((time + 1e-9) / self.period), len(self.there) - 1)
        if not np.isfinite(self.there[k]):
            return np.empty((0, 3))
        ahead = dt * np.arange(1.0, n + 1.0)
        lead = ahead + (self.pace[k] - 1.0) * PACE_LASTS * (1.0 - np.exp(-ahead / PACE_LASTS))
        coming = self.there[k] + lead
        if self.again is None:
            coming = coming[coming <= self.end]
        else:
            coming = np.where(coming > self.end, coming - self.end + self.again, coming)
        here = self.force(np.array([time]))[0] - self.earlier(self.there[k : k + 1])[0]
        fading: Vec = np.exp(-ahead[: len(coming)] / DIFFERENCE_LASTS)
        foreseen: Mat = self.earlier(coming) + fading[:, None] * here
        return foreseen


def foresight(
    log: Log,
    earlier: Log,
    *,
    period: float,
    force: Callable[[Vec], Mat],
    forces_then: Callable[[Vec], Mat],
) -> Foresight:
    """Follow a drive along an earlier one.

    Parameters
    ----------
    period : [s] between two nodes at which the place is looked up.
    force, forces_then : what is to be felt in the present drive, and what was in the earlier one: (k,) [s] ->
        (k, 3) [m/s²], after all treatment.

    Raises
    ------
    InputError : one of the logs holds no places, or the drives have no road in common.
    """
    path, own = _path(earlier), _path(log)
    follower = Follower(path)
    nodes = np.arange(round(log.duration / period) + 1, dtype=np.float64) * period
    places = np.stack([np.interp(nodes, own.time, column) for column in own.place.T], axis=1)
    found = [follower.at(place) for place in places]
    there = np.array([np.nan if one is None else one for one in found])
    if np.isnan(there).all():
        bound = f"along the same road: within {NEAR:g} m of it and in its direction somewhere"
        raise InputError(f"road of {earlier.source}", f"another one than that of {log.source}", bound)
    return Foresight(
        period=period,
        force=force,
        earlier=forces_then,
        there=there,
        pace=_pace(there, period),
        again=_closed(path),
        end=float(path.time[-1]),
    )


def _path(log: Log) -> Path:
    """Return the places of a log over time."""
    if log.place is None:
        bound = "there to foresee its road: columns x and y, or latitude and longitude"
        raise InputError(f"places of {log.source}", "absent", bound)
    return Path(log.t, log.place)


def _pace(there: Vec, period: float) -> Vec:
    """Return the seconds of the earlier drive per second of the present one; 1 where unknown."""
    over = max(1, round(PACE_OVER / period))
    pace = np.ones(len(there))
    pace[over:] = (there[over:] - there[:-over]) / (over * period)
    pace[~(np.abs(pace - 1.0) < JUMP)] = 1.0
    likely: Vec = np.clip(pace, SLOWEST, FASTEST)
    return likely


def _closed(path: Path) -> float | None:
    """Return the time in its first half at which the path passes its own end; None on an open road.

    A lap may end just before its start. Then the time is negative.
    """
    middle, end = len(path.time) // 2, float(path.time[-1])
    if middle < 2:
        return None
    there, away = path.nearest(path.place[-1], 0, middle)
    ahead = path.direction(end)
    if away > NEAR or path.direction(there) @ ahead < SAME_WAY:
        return None
    arrival = np.array([np.interp(there, path.time, column) for column in path.place.T])
    speed = np.hypot(*(path.place[-1] - path.place[-2])) / (path.time[-1] - path.time[-2])
    return there - float((arrival - path.place[-1]) @ ahead / speed)
