"""The roads that are shipped with the package: a race track, and standard test manoeuvres.

A manoeuvre starts with a straight run-up, and ends with a straight on which the car settles.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib.resources import files
from types import MappingProxyType
from typing import Final

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError, one_of
from otolith.core.formula import arguments
from otolith.vehicle.centreline import smooth_path
from otolith.vehicle.road import Road, from_clothoids, plain

RUN_UP: Final = 50.0  # [m]
RUN_OUT: Final = 100.0  # [m]
LANE_OFFSET: Final = 3.5  # [m] ISO 3888-1, between the right edges of the first and the second lane
HOCKENHEIM_START: Final = (0.1306, -0.9267, 2.018025)  # x [m], y [m], heading [rad]
HOCKENHEIM_SOURCE: Final = (
    "Hockenheim Grand Prix circuit: clothoids fitted to TUMFTM/racetrack-database (LGPL-3.0), "
    "from OpenStreetMap (© OpenStreetMap contributors, ODbL)"
)


def hockenheim() -> Road:
    """Return the circuit of thesis section 6.3, driven clockwise and flat (the real one rises by 4.3 m)."""
    text = (files("otolith.vehicle") / "data" / "hockenheim.csv").read_text(encoding="utf-8")
    segments = np.loadtxt(text.splitlines(), delimiter=",", skiprows=1)
    return from_clothoids(
        segments, name="hockenheim", start=HOCKENHEIM_START, closed=True, source=HOCKENHEIM_SOURCE
    )


def circle(radius: float = 50.0, turns: float = 2.0, transition: float = 40.0) -> Road:
    """Return a constant radius to the left after a clothoid (as for ISO 4138); lengths in metres."""
    _positive(radius=radius, turns=turns, transition=transition)
    curvature = 1.0 / radius
    arc = 2.0 * np.pi * radius * turns
    segments = np.array([[RUN_UP, 0.0, 0.0], [transition, 0.0, curvature], [arc, curvature, curvature]])
    return from_clothoids(segments, name="circle", source="constant radius after a clothoid")


def straight(length: float = 1000.0) -> Road:
    """Return a straight of this length [m]."""
    _positive(length=length)
    return from_clothoids(np.array([[length, 0.0, 0.0]]), name="straight", source="a straight")


def braking(run: float = 200.0, stop: float = 300.0) -> Road:
    """Return a straight where the car drives for `run` metres and must then stop before `stop`."""
    _positive(run=run, stop=stop - run)
    road = from_clothoids(np.array([[stop, 0.0, 0.0]]), name="braking", source="braking to rest")
    return replace(road, speed_limit=np.where(road.way > stop - 1.0, 0.0, np.inf))


def lane_change(width: float = 1.96) -> Road:
    """Return the double lane change of ISO 3888-1 to the left and back, for a car of this width [m].

    Lanes of 15, 25 and 30 m have gaps of 30 m and 25 m, and right edges 3.5 m apart; the path is the middle
    of each lane.
    """
    _positive(width=width)
    first, second, third = (factor * width + 0.25 for factor in (1.1, 1.2, 1.3))
    middle = LANE_OFFSET + 0.5 * (second - first)
    lanes = ((15.0, 0.0), (25.0, middle), (30.0, 0.5 * (third - first)))
    return _through_lanes("lane-change", lanes, gaps=(30.0, 25.0), source="ISO 3888-1, double lane change")


def avoidance(width: float = 1.96) -> Road:
    """Return the obstacle avoidance of ISO 3888-2 to the left and back, for a car of this width [m].

    Lanes of 12, 11 and 12 m have gaps of 13.5 m and 12.5 m, and 1 m between the first and the second.
    """
    _positive(width=width)
    first, second, third = 1.1 * width + 0.25, width + 1.0, max(3.0, 1.3 * width + 0.25)
    middle = 0.5 * (first + second) + 1.0
    lanes = ((12.0, 0.0), (11.0, middle), (12.0, 0.5 * (third - first)))
    return _through_lanes("avoidance", lanes, gaps=(13.5, 12.5), source="ISO 3888-2, obstacle avoidance")


def slalom(gap: float = 36.0, offset: float = 1.5, cones: int = 8) -> Road:
    """Return a slalom of cones `gap` apart [m], passed alternately at `offset` [m] on cosines.

    From the straight to the first cone, and from the last one back, the path is a polynomial that leaves the
    straight without curvature and joins the cosine with the cosine's curvature.
    """
    _positive(gap=gap, offset=offset, cones=float(cones))
    u = np.arange(0.0, gap * (cones + 1) + 0.5) / gap  # unit: gaps; the cones are at 1, 2, …
    y = -np.cos(np.pi * u)
    y = np.where(u < 1.0, _onset(u), y)
    y = np.where(u > cones, -np.cos(np.pi * cones) * _onset(cones + 1.0 - u), y)
    return _along(
        "slalom", np.stack([gap * u, offset * y], axis=1), f"slalom of {cones} cones, {gap:g} m apart"
    )


@dataclass(frozen=True, slots=True)
class Entry:
    """A named road; `build` takes the parameters of a text ``name:parameter=value``."""

    build: Callable[..., Road]
    description: str


ROADS: Final = MappingProxyType(
    {
        "hockenheim": Entry(hockenheim, "Hockenheim Grand Prix circuit, 4.57 km (thesis section 6.3)"),
        "lane-change": Entry(lane_change, "double lane change (ISO 3888-1)"),
        "avoidance": Entry(avoidance, "obstacle avoidance (ISO 3888-2)"),
        "slalom": Entry(slalom, "slalom between cones"),
        "circle": Entry(circle, "constant radius after a clothoid"),
        "braking": Entry(braking, "a straight, and a stop"),
        "straight": Entry(straight, "a straight"),
    }
)


def road(text: str) -> Road:
    """Return a road of `ROADS`, given its name or ``name:parameter=value,…``.

    Examples
    --------
    >>> road("slalom:gap=18,offset=1").name
    'slalom'

    Raises
    ------
    InputError : unknown name or parameter, or a value out of bounds.
    """
    name, _, rest = text.strip().partition(":")
    if name not in ROADS:
        raise InputError(
            "road", repr(name), one_of(ROADS, name, otherwise=", or a file of points (.csv, .gpx)")
        )
    return ROADS[name].build(**arguments(rest, name, ROADS[name].build))


def _through_lanes(
    name: str, lanes: tuple[tuple[float, float], ...], *, gaps: tuple[float, ...], source: str
) -> Road:
    """Return a road along lanes (length, offset), with smooth transitions over the gaps between them."""
    x, y = [0.0], [lanes[0][1]]
    for (length, offset), gap in zip(lanes, (*gaps, 0.0), strict=True):
        x += [x[-1] + length, x[-1] + length + gap]
        y += [offset, offset]
    u = np.arange(0.0, x[-1] + 0.5)
    v = np.full(len(u), lanes[0][1])
    for k in range(1, len(lanes)):
        start, gap = x[2 * k - 1], gaps[k - 1]
        v += (lanes[k][1] - lanes[k - 1][1]) * _blend((u - start) / gap)
    return _along(name, np.stack([u, v], axis=1), source)


def _along(name: str, curve: Mat, source: str) -> Road:
    """Return a road along (k, 2) points a metre apart, with run-up before and run-out after them."""
    before = np.stack([np.arange(-RUN_UP, -0.5), np.full(round(RUN_UP), curve[0, 1])], axis=1)
    behind = np.arange(1.0, RUN_OUT + 0.5)
    after = np.stack([curve[-1, 0] + behind, np.full(len(behind), curve[-1, 1])], axis=1)
    path, _ = smooth_path(np.vstack([before, curve, after]), closed=False, smoothing=0.0)
    return plain(path, name=name, closed=False, source=source)


def _blend(u: Vec) -> Vec:
    """Return 0 below 0, 1 above 1, and between them a polynomial with two continuous derivatives."""
    u = np.clip(u, 0.0, 1.0)
    return np.asarray(u**3 * (10.0 + u * (6.0 * u - 15.0)), dtype=np.float64)


def _onset(u: Vec) -> Vec:
    """Return a curve from 0 at 0, flat and straight, to 1 at 1, where it joins −cos(π u) smoothly."""
    u = np.clip(u, 0.0, 1.0)
    return np.asarray(_blend(u) - 0.5 * np.pi**2 * u**3 * (1.0 - u) ** 2, dtype=np.float64)


def _positive(**values: float) -> None:
    for name, value in values.items():
        if not (np.isfinite(value) and value > 0.0):
            raise InputError(name, value, "greater than 0")
