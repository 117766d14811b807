"""Roads through points: a measured centreline from a file, or the path of a manoeuvre."""

from dataclasses import replace
from typing import Any, Final

import numpy as np
import scipy  # scipy imports its modules on first use, so unused ones cost no time

from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError
from otolith.vehicle.road import MAX_LENGTH, MIN_LENGTH, MIN_RADIUS, SPACING, Path, Road, plain
from otolith.vehicle.survey import Survey, noted, survey_of_gpx, survey_of_table
from otolith.vehicle.tidy import (
    meets_its_start,
    one_lap,
    scatter,
    way_along,
    without_repeats,
    without_seam,
    without_strays,
)

SMOOTHING: Final = 0.1  # [m] RMS distance of the path from measured points: their usual noise
NOISIEST: Final = 10.0  # [m] RMS; points that scatter more do not describe a road
DEGREE: Final = 5  # degree of the spline, high enough for a smooth curvature
MIN_POINTS: Final = 8


def parse_centreline(
    text: str, source: str, *, smoothing: float | None = None, closed: bool | None = None
) -> Road:
    """Read a road from delimited text with columns x and y [m], or lat and lon [deg].

    Further columns are used if present: w_tr_right_m and w_tr_left_m (as in TUMFTM/racetrack-database), or
    width_m for both, z_m (elevation) and banking_deg (+ = left side up). The road's notes state what was
    assumed or repaired. Other parameters and errors are those of `road_through`.
    """
    return road_through(survey_of_table(text, source), smoothing=smoothing, closed=closed)


def parse_gpx(text: str, source: str, *, smoothing: float | None = None, closed: bool | None = None) -> Road:
    """Read a road from a GPX file, along its longest track or route; see `road_through`."""
    return road_through(survey_of_gpx(text, source), smoothing=smoothing, closed=closed)


def road_through(survey: Survey, *, smoothing: float | None = None, closed: bool | None = None) -> Road:
    """Return a road along points, without repeated and stray points, overlapping laps and noise.

    Parameters
    ----------
    smoothing : [m] RMS distance of the spline from the points; 0 goes through all of them. The default is
        `SMOOTHING`, or the scatter of the points if it is larger.
    closed : whether the road leads back to its first point. By default it does if it meets itself again in
        the same direction, or if its ends are less than three point distances apart and the path from the
        last to the first point does not turn back.

    Raises
    ------
    InputError : there are fewer than 8 points, points scatter by more than 10 m, widths are not positive, or
        no car can follow the path.
    """
    _check_count(survey)
    survey = without_strays(without_repeats(survey))
    _check_count(survey)
    _check_length(survey)
    allowed, survey = _allowed(survey, smoothing)
    survey, is_lap = one_lap(survey) if closed is not False else (survey, False)
    _check_count(survey)
    ring = (is_lap or meets_its_start(survey.points)) if closed is None else closed
    survey = without_seam(survey) if ring else survey
    points, along = survey.points, survey.along
    if ring:
        points = np.vstack([points, points[0]])
        along = {key: np.r_[values, values[0]] for key, values in along.items()}
    path, s = smooth_path(points, closed=ring, smoothing=allowed)
    _check_path(path, s, survey)
    name = survey.source.rpartition(".")[0] or survey.source
    flat = plain(path, name=name, closed=ring, source=survey.source)
    return replace(_furnished(flat, s, along), notes=survey.notes)


def smooth_path(points: Mat, *, closed: bool, smoothing: float) -> tuple[Path, Vec]:
    """Return a path with equal steps along (k, 2) points [m], and the distances (k,) at which it passes them.

    The spline's parameter is the chord length. The arc length is integrated on a ten times finer grid, and
    curvature and heading are computed from the spline's derivatives.
    """
    fitted, chord = scipy.interpolate.splprep(points.T, k=DEGREE, per=closed, s=len(points) * smoothing**2)
    tck: Any = tuple(fitted)  # knots, coefficients of x and y, degree
    length = float(np.sum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
    fine = np.linspace(0.0, 1.0, 10 * int(np.ceil(length / SPACING)) + 1)
    speed = np.hypot(*scipy.interpolate.splev(fine, tck, der=1))  # [m per unit of the parameter]
    way = np.r_[0.0, np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(fine))]
    n = int(np.ceil(way[-1] / SPACING))
    u = np.interp(np.linspace(0.0, way[-1], n + 1), way, fine)
    (x, y), (dx, dy), (ddx, ddy) = (scipy.interpolate.splev(u, tck, der=order) for order in range(3))
    curvature = (dx * ddy - dy * ddx) / np.hypot(dx, dy) ** 3
    heading = np.unwrap(np.arctan2(dy, dx))
    path = Path(float(way[-1] / n), curvature, heading, np.stack([x, y], axis=1))
    return path, np.interp(chord, fine, way)


def _allowed(survey: Survey, smoothing: float | None) -> tuple[float, Survey]:
    """Return the permitted RMS distance [m] of the spline, and the survey with its elevation smoothed."""
    if smoothing is not None:
        return smoothing, survey
    noise = scatter(survey.points)
    if not noise <= NOISIEST:
        bound = f"at most {NOISIEST:g} m for a road to be found from them"
        raise InputError(f"scatter of the points in {survey.source}", f"{noise:.3g} m RMS", bound)
    if noise > SMOOTHING:
        note = f"the points scatter by {noise:.2g} m (RMS): the road may keep as far from them, and is smooth"
        survey = noted(survey, note)
    return max(SMOOTHING, noise), _levelled(survey)


def _levelled(survey: Survey) -> Survey:
    """Return the survey with smoothed elevations [m], because a receiver's noise should not be felt."""
    z = survey.along.get("z")
    noise = 0.0 if z is None else scatter(z[:, None])
    if z is None or noise <= SMOOTHING:
        return survey
    way = way_along(survey.points)
    smooth = scipy.interpolate.splev(way, scipy.interpolate.splrep(way, z, k=3, s=len(way) * noise**2))
    note = f"the elevation scatters by {noise:.2g} m (RMS) and is smoothed as much"
    return noted(replace(survey, along={**survey.along, "z": smooth}), note)


def _check_count(survey: Survey) -> None:
    if len(survey.points) < MIN_POINTS:
        count = len(survey.points)
        raise InputError(f"number of points in {survey.source}", count, f"at least {MIN_POINTS}")


def _check_length(survey: Survey) -> None:
    """Refuse a road that is too short or too long for coordinates in metres."""
    length = float(way_along(survey.points)[-1])
    if not MIN_LENGTH <= length <= MAX_LENGTH:
        meant = "degrees belong into columns lat and lon" if length < MIN_LENGTH else "is it in mm?"
        bound = f"between {MIN_LENGTH:g} and {MAX_LENGTH:g} m ({meant})"
        raise InputError(f"length of the road in {survey.source}", f"{length:.3g} m", bound)


def _check_path(path: Path, s: Vec, survey: Survey) -> None:
    """Refuse a path that no car can follow; name the place in the file and a remedy."""
    tightest = int(np.argmax(np.abs(path.curvature)))
    radius = 1.0 / max(abs(float(path.curvature[tightest])), 1e-9)
    if radius < MIN_RADIUS:
        nearest = int(np.argmin(np.abs(s[: len(survey.places)] - tightest * path.step)))
        bound = f"at least {MIN_RADIUS:g} m (where points are not exact, --smoothing METRES helps)"
        raise InputError(f"radius of the road near {survey.places[nearest]}", f"{radius:.3g} m", bound)


def _furnished(road: Road, s: Vec, data: dict[str, Vec]) -> Road:
    """Return the road with the width, elevation and banking that the file gives at the distances `s`."""

    def along(key: str, default: Vec) -> Vec:
        return np.interp(road.way, s, data[key]) if key in data else default

    halves = {"right": 0.5 * data["width"], "left": 0.5 * data["width"]} if "width" in data else {}
    data = {**halves, **data}
    width = np.stack([along("right", road.width[:, 0]), along("left", road.width[:, 1])], axis=1)
    if width.min() <= 0.0:
        raise InputError(f"width of {road.source}", f"{width.min():g} m", "greater than 0 m")
    return replace(
        road,
        width=width,
        elevation=_smooth(along("z", road.elevation), road),
        banking=_smooth(np.radians(along("banking", road.banking)), road),
    )


def _smooth(values: Vec, road: Road) -> Vec:
    """Average over 20 m twice, because elevations are coarse and their second derivative is felt."""
    half = max(1, round(10.0 / road.step))
    window = np.ones(2 * half + 1) / (2 * half + 1)
    mode = "wrap" if road.closed else "edge"
    for _ in range(2):
        inner = values[:-1] if road.closed else values
        smooth = np.convolve(np.pad(inner, half, mode=mode), window, mode="valid")  # type: ignore[call-overload]
        values = np.r_[smooth, smooth[0]] if road.closed else smooth
    return values
