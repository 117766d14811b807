"""Witnesses of left and right: the course over ground, from positions or a heading.

A log whose y and z axes are both turned (SAE J670: y right, z down) is consistent with itself, because
lateral force and yaw rate change sign together. Only a reference to the ground can decide. Latitude and
longitude decide absolutely, and so does a compass heading in degrees. x and y of a map decide only if it is
drawn with z up, which only names such as "east" and "north" show.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.recordings.channels import Channel

EARTH: Final = 6_371_008.8  # [m] mean radius of the Earth (IUGG); ratios of lengths hardly depend on it
CHORD: Final = 8.0  # [m] least length of a chord that gives a course; larger than a receiver's noise …
GRAINS: Final = 12.0  # … and at least this many steps of the positions' last digit
STANDING: Final = 5.0  # [s] longest duration of a chord; slower motion gives no course
FASTEST: Final = 150.0  # [m/s] largest speed between two nodes; faster motion is a jump
GRID: Final = 0.5  # [s] between the values of a course


@dataclass(frozen=True, slots=True, eq=False)
class Witness:
    """A course over ground, with its speed if positions give it."""

    name: str  # in words, for sentences
    keys: tuple[str, ...]  # quantities it comes from
    absolute: bool  # whether it proves left and right; otherwise only if the map is drawn with z up
    course: Channel  # [rad] counter-clockwise seen from above, unwrapped
    speed: Channel | None  # [m/s]


def witnesses(channels: Mapping[str, Channel]) -> Iterator[Witness]:
    """Yield all courses that a drive's channels give, the most certain first."""
    if {"lat", "lon"} <= set(channels):
        yield from _on_earth(channels["lat"], channels["lon"])
    if "heading" in channels:
        yield _compass(channels["heading"])
    if {"x", "y"} <= set(channels):
        yield from _on_map(channels["x"], channels["y"])


def _on_earth(lat: Channel, lon: Channel) -> Iterator[Witness]:
    longitude = lon.on(lat.t)
    fix = (lat.values != 0.0) & (longitude != 0.0) & lon.known(lat.t)
    t, latitude, longitude = lat.t[fix], lat.values[fix], np.unwrap(longitude[fix])
    if len(t) == 0:
        return
    east = EARTH * np.cos(latitude[0]) * (longitude - longitude[0])
    place = np.stack([east, EARTH * (latitude - latitude[0])], axis=1)
    yield from _along(replace(lat, t=t, values=latitude, rows=lat.rows[fix]), place, ("lat", "lon"), True)


def _on_map(x: Channel, y: Channel) -> Iterator[Witness]:
    both = y.known(x.t)
    seen = replace(x, t=x.t[both], values=x.values[both], rows=x.rows[both])
    place = np.stack([seen.values, y.on(seen.t)], axis=1)
    named = bool(_EAST.search(x.column.name) and _NORTH.search(y.column.name))
    yield from _along(seen, place, ("x", "y"), named)


_EAST: Final = re.compile("east|utm_?e|utm_?x", re.IGNORECASE)
_NORTH: Final = re.compile("north|utm_?n|utm_?y", re.IGNORECASE)


def _compass(heading: Channel) -> Witness:
    in_degrees = not np.isclose(abs(heading.column.factor), 1.0)
    course = replace(heading, values=-np.unwrap(heading.values))
    return Witness(repr(heading.column.name), ("heading",), in_degrees, course, None)


def _along(clock: Channel, place: Mat, keys: tuple[str, ...], absolute: bool) -> Iterator[Witness]:
    """Yield course and speed of the chords between nodes of the path, if there are enough."""
    nodes = _nodes(place)
    chord, times = np.diff(place[nodes], axis=0), clock.t[nodes]
    length, duration = np.hypot(*chord.T), np.diff(times)
    going = (duration < STANDING) & (length < FASTEST * np.maximum(duration, 1e-9))
    if going.sum() < 2:
        return
    middle = (0.5 * (times[1:] + times[:-1]))[going]
    angle = np.unwrap(np.arctan2(chord[going, 1], chord[going, 0]))
    name = {"lat": "latitude and longitude", "x": "the positions x, y"}[keys[0]]
    course = _gridded(clock, middle, angle)
    speed = _gridded(clock, middle, length[going] / duration[going])
    if len(course.t) > 1:
        yield Witness(name, keys, absolute, course, speed)


def _nodes(place: Mat) -> Ints:
    """Return the indices of points along the path, each a chord's length from the one before."""
    least = max(CHORD, GRAINS * _grain(place))
    nodes, last = [0], place[0]
    for i in np.flatnonzero(np.r_[True, (np.diff(place, axis=0) != 0.0).any(axis=1)]):
        if (place[i, 0] - last[0]) ** 2 + (place[i, 1] - last[1]) ** 2 >= least**2:
            nodes.append(int(i))
            last = place[i]
    return np.array(nodes, dtype=np.int64)


def _grain(place: Mat) -> float:
    """Return the step [m] of the coordinates' last digit: the smallest difference between their values."""
    grains = [np.diff(np.unique(np.round(axis, 4))) for axis in place.T]
    return max((float(grain.min()) for grain in grains if len(grain)), default=0.0)


def _gridded(clock: Channel, t: Vec, values: Vec) -> Channel:
    """Interpolate on an even grid, leaving out stretches between distant nodes, where the vehicle stood."""
    grid = np.arange(t[0], t[-1], GRID)
    after = np.clip(np.searchsorted(t, grid, side="right"), 1, len(t) - 1)
    grid = grid[t[after] - t[after - 1] < STANDING]
    rows = clock.rows[np.clip(np.searchsorted(clock.t, grid), 0, len(clock.rows) - 1)]
    return replace(clock, t=grid, values=np.interp(grid, t, values), rows=rows)
