"""Roads through points: a measured centreline from a file, or a curve that a manoeuvre prescribes."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np
from scipy.interpolate import splev, splprep

from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError
from otolith.scenarios.columns import Column
from otolith.scenarios.table import Table, split
from otolith.vehicle.road import SPACING, Path, Road, plain

SMOOTHING: Final = 0.1  # [m] RMS by which the path may leave measured points: their usual noise
DEGREE: Final = 5  # of the spline, so that the curvature is smooth
MIN_POINTS: Final = 8
_REQUIRED: Final = ("x_m", "y_m")
_OPTIONAL: Final = ("w_tr_right_m", "w_tr_left_m", "z_m", "banking_deg")


def parse_centreline(text: str, source: str, *, smoothing: float = SMOOTHING) -> Road:
    """Road from delimited text with the columns x_m, y_m and, optionally, w_tr_right_m, w_tr_left_m
    (the form of TUMFTM/racetrack-database), z_m (elevation) and banking_deg (+ = left side up).

    A spline of degree 5 goes past the points; it is closed if its ends are about one spacing apart.

    Parameters
    ----------
    source : name of the file, for the road's name and for errors.
    smoothing : [m] RMS distance that the spline may keep from the points; 0 goes through all of them.

    Raises
    ------
    InputError : columns missing, fewer than 8 points, a repeated point, numbers that are none, widths
        that are not positive, or a path that no car can follow.
    """
    table = split(text, source)
    columns = _columns(table)
    data = dict(zip((c.key for c in columns), table.numbers(columns).T, strict=True))
    points = np.stack([data["x_m"], data["y_m"]], axis=1)
    _check(points, table)
    gaps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    closing = float(np.linalg.norm(points[-1] - points[0]))
    closed = closing < 3.0 * float(np.median(gaps))
    if closed and closing > 1e-6:  # a ring that is not written twice at its seam
        data = {key: np.r_[values, values[0]] for key, values in data.items()}
        points = np.vstack([points, points[0]])
    path, s = smooth_path(points, closed=closed, smoothing=smoothing)
    flat = plain(path, name=source.removesuffix(".csv"), closed=closed, source=source)
    return _furnished(flat, s, data)


def smooth_path(points: Mat, *, closed: bool, smoothing: float) -> tuple[Path, Vec]:
    """Path of equal steps past (k, 2) points [m], and the way (k,) at which it passes them.

    The spline's parameter is the chord length; the arc length is integrated on a ten times finer grid,
    and curvature and heading come from the spline's own derivatives.
    """
    fitted, chord = splprep(points.T, k=DEGREE, per=closed, s=len(points) * smoothing**2)
    tck: Any = tuple(fitted)  # knots, coefficients of x and y, degree
    length = float(np.sum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
    fine = np.linspace(0.0, 1.0, 10 * int(np.ceil(length / SPACING)) + 1)
    speed = np.hypot(*splev(fine, tck, der=1))  # [m per unit of the parameter]
    way = np.r_[0.0, np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(fine))]
    n = int(np.ceil(way[-1] / SPACING))
    u = np.interp(np.linspace(0.0, way[-1], n + 1), way, fine)
    (x, y), (dx, dy), (ddx, ddy) = (splev(u, tck, der=order) for order in range(3))
    curvature = (dx * ddy - dy * ddx) / np.hypot(dx, dy) ** 3
    heading = np.unwrap(np.arctan2(dy, dx))
    path = Path(float(way[-1] / n), curvature, heading, np.stack([x, y], axis=1))
    return path, np.interp(chord, fine, way)


def _columns(table: Table) -> list[Column]:
    names = [name.strip().lower() for name in table.names]
    missing = [name for name in _REQUIRED if name not in names]
    if missing:
        form = "x_m, y_m, w_tr_right_m, w_tr_left_m"
        raise InputError(f"column {missing[0]} of {table.source}", "missing", f"there, as in {form}")
    known: Sequence[str] = [name for name in (*_REQUIRED, *_OPTIONAL) if name in names]
    return [Column(name, names.index(name), name, 1.0, "", assumed=False) for name in known]


def _check(points: Mat, table: Table) -> None:
    if len(points) < MIN_POINTS:
        raise InputError(f"number of points in {table.source}", len(points), f"at least {MIN_POINTS}")
    repeated = np.flatnonzero(np.linalg.norm(np.diff(points, axis=0), axis=1) < 1e-6)
    if len(repeated):
        where = f"point in {table.where(int(repeated[0]) + 1)}"
        raise InputError(where, "the same as the one before", "another one")


def _furnished(road: Road, s: Vec, data: dict[str, Vec]) -> Road:
    """The road with those of width, elevation and banking that the file gives at the ways `s`."""

    def along(key: str, default: Vec) -> Vec:
        return np.interp(road.way, s, data[key]) if key in data else default

    width = np.stack(
        [along("w_tr_right_m", road.width[:, 0]), along("w_tr_left_m", road.width[:, 1])], axis=1
    )
    if width.min() <= 0.0:
        raise InputError(f"width of {road.source}", f"{width.min():g} m", "greater than 0 m")
    return replace(
        road,
        width=width,
        elevation=_smooth(along("z_m", road.elevation), road),
        banking=_smooth(np.radians(along("banking_deg", road.banking)), road),
    )


def _smooth(values: Vec, road: Road) -> Vec:
    """Moving average over 20 m, twice: elevation is given coarsely, and its second derivative is felt."""
    half = max(1, round(10.0 / road.step))
    window = np.ones(2 * half + 1) / (2 * half + 1)
    mode = "wrap" if road.closed else "edge"
    for _ in range(2):
        inner = values[:-1] if road.closed else values
        smooth = np.convolve(np.pad(inner, half, mode=mode), window, mode="valid")  # type: ignore[call-overload]
        values = np.r_[smooth, smooth[0]] if road.closed else smooth
    return values
