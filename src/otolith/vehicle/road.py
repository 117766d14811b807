"""A road: its path as curvature over distance, and its properties along the path.

Notation: s distance along the path [m]; κ curvature [1/m], + to the left; ψ heading [rad] from the x axis. A
clothoid is a stretch along which κ grows linearly with s.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from otolith.core.arrays import Mat, Vec, freeze
from otolith.core.errors import InputError

SPACING = 0.25  # [m] between nodes: 10 ms at 90 km/h, fine enough for the shortest clothoid of a lane change
MIN_RADIUS = 4.0  # [m] radius of the tightest turn of a car
MIN_LENGTH, MAX_LENGTH = 20.0, 100_000.0  # [m]

# Gauss-Legendre nodes and weights on (0, 1), order 6, for the integral of the unit tangent
_GAUSS = np.array([0.5 - np.sqrt(0.15), 0.5, 0.5 + np.sqrt(0.15)])
_WEIGHT = np.array([5.0, 8.0, 5.0]) / 18.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Road:
    """A path with nodes at equal distances; on a closed road, node 0 and node n are the same place.

    Axes are x east, y north (or any right-handed pair), z up. Between nodes everything is linear in s.
    """

    name: str
    step: float  # [m] distance between nodes
    curvature: Vec  # (n + 1,) [1/m], + = left
    heading: Vec  # (n + 1,) [rad], not wrapped
    position: Mat  # (n + 1, 2) [m]
    elevation: Vec  # (n + 1,) [m]
    banking: Vec  # (n + 1,) [rad], + = left side up, like the roll of a car
    speed_limit: Vec  # (n + 1,) [m/s]; inf for no limit
    width: Mat  # (n + 1, 2) [m] from the path to the right and left edge
    profile: Mat | None = None  # (m + 1, 2) [m] roughness under left and right wheels, see `roughness`
    closed: bool = False
    source: str = ""  # its origin and licence
    notes: tuple[str, ...] = ()  # sentences: what was assumed or repaired in a file

    def __post_init__(self) -> None:
        n = len(self.curvature)
        vectors = ("curvature", "heading", "elevation", "banking", "speed_limit")
        freeze(self, **dict.fromkeys(vectors, (n,)), position=(n, 2), width=(n, 2))
        if not MIN_LENGTH <= self.length <= MAX_LENGTH:
            bound = f"between {MIN_LENGTH:g} and {MAX_LENGTH:g} m"
            raise InputError(f"length of road {self.name}", f"{self.length:.6g} m", bound)
        tightest = int(np.argmax(np.abs(self.curvature)))
        if abs(self.curvature[tightest]) > 1.0 / MIN_RADIUS:
            where = f"radius of road {self.name} at {tightest * self.step:.1f} m"
            radius = 1.0 / abs(self.curvature[tightest])
            raise InputError(where, f"{radius:.3g} m", f"at least {MIN_RADIUS:g} m")

    @property
    def length(self) -> float:
        """Return the distance along the path from the first node to the last [m]."""
        return (len(self.curvature) - 1) * self.step

    @property
    def way(self) -> Vec:
        """Return the distance (n + 1,) [m] from the start, at each node."""
        return np.arange(len(self.curvature), dtype=np.float64) * self.step

    @property
    def grade(self) -> Vec:
        """Return the slope (n + 1,) [rad] along the path, + = uphill."""
        return np.asarray(np.arctan(self._along(self.elevation)), dtype=np.float64)

    @property
    def crest(self) -> Vec:
        """Return the second derivative of the elevation (n + 1,) [1/m]: + in a dip, − over a crest."""
        return self._along(self._along(self.elevation))

    def _along(self, values: Vec) -> Vec:
        """Return central differences with respect to s, across the seam of a closed road."""
        if not self.closed:
            return np.asarray(np.gradient(values, self.step), dtype=np.float64)
        ring = np.r_[values[-2], values, values[1]]
        return np.asarray((ring[2:] - ring[:-2]) / (2.0 * self.step), dtype=np.float64)

    def place(self, s: Vec, offset: Vec) -> Mat:
        """Return the world position (k, 3) of points `offset` to the left of the path at distance `s`.

        Both arguments are (k,) [m].
        """
        s = np.mod(s, self.length) if self.closed else s
        nodes = self.way
        x, y, z, psi = (
            np.interp(s, nodes, column) for column in (*self.position.T, self.elevation, self.heading)
        )
        return np.stack([x - offset * np.sin(psi), y + offset * np.cos(psi), z], axis=1)

    def limited(self, speed: float) -> "Road":
        """Return a copy of the road with a speed limit of at most `speed` [m/s]."""
        return replace(self, speed_limit=np.minimum(self.speed_limit, speed))


def from_clothoids(
    segments: Mat,
    *,
    name: str,
    start: tuple[float, float, float] = (0.0, 0.0, 0.0),
    closed: bool = False,
    spacing: float = SPACING,
    source: str = "",
) -> Road:
    """Make a road from consecutive clothoids; it is flat and has no speed limits.

    Parameters
    ----------
    segments : (k, 3) length [m], curvature at its start and at its end [1/m].
    start : x [m], y [m], heading [rad] of the first point.
    spacing : desired distance between nodes [m]; it is reduced so that it divides the length.
    """
    lengths, first, last = np.asarray(segments, dtype=np.float64).T
    ends = np.r_[0.0, np.cumsum(lengths)]
    turned = np.r_[0.0, np.cumsum(0.5 * (first + last) * lengths)]  # heading at the ends, exact
    n = int(np.ceil(ends[-1] / spacing))
    step = float(ends[-1] / n)

    def at(s: Vec) -> tuple[Vec, Vec]:
        """Return curvature and heading at distances from the start."""
        i = np.clip(np.searchsorted(ends, s, side="right") - 1, 0, len(lengths) - 1)
        u = s - ends[i]
        slope = (last - first)[i] / lengths[i]
        return first[i] + slope * u, turned[i] + first[i] * u + 0.5 * slope * u**2

    s = np.arange(n + 1, dtype=np.float64) * step
    curvature, heading = at(s)
    inner = at((s[:-1, None] + _GAUSS * step).ravel())[1].reshape(n, 3) + start[2]
    forward = step * np.stack([np.cos(inner) @ _WEIGHT, np.sin(inner) @ _WEIGHT], axis=1)
    position = np.vstack([np.zeros(2), np.cumsum(forward, axis=0)]) + np.array(start[:2])
    path = Path(step, curvature, heading + start[2], position)
    return plain(path, name=name, closed=closed, source=source)


class Path(NamedTuple):
    """The path of a road alone; fields as in `Road`."""

    step: float
    curvature: Vec
    heading: Vec
    position: Mat


def plain(path: Path, *, name: str, closed: bool, source: str) -> Road:
    """Return a road with this path: flat, without speed limits, 5 m wide on both sides."""
    nodes = len(path.curvature)
    return Road(
        **path._asdict(),
        name=name,
        elevation=np.zeros(nodes),
        banking=np.zeros(nodes),
        speed_limit=np.full(nodes, np.inf),
        width=np.full((nodes, 2), 5.0),
        closed=closed,
        source=source,
    )
