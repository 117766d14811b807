"""The points of a road as a file gives them: delimited text or GPX, metres or degrees, with notes.

This module does not judge the points; `otolith.vehicle.tidy` repairs them, and `otolith.vehicle.centreline`
makes the road.
"""

import re
from dataclasses import dataclass, replace
from typing import Final
from xml.etree import ElementTree

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.errors import InputError
from otolith.recordings.columns import Column
from otolith.recordings.table import Table, split
from otolith.vehicle.geodesy import local_plane

FAR: Final = 1e5  # [m] from the origin; larger coordinates belong to a map's grid and are shifted
_METRES: Final = {"m": 1.0, "meter": 1.0, "metre": 1.0, "meters": 1.0, "metres": 1.0}
_UNITS: Final = {
    "length": _METRES | {"km": 1e3, "cm": 1e-2, "mm": 1e-3, "ft": 0.3048},
    "angle": {"deg": 1.0, "°": 1.0, "degrees": 1.0, "rad": 180.0 / np.pi},  # factors to degrees
}
_SPELLINGS: Final = {
    "x": ("x", "x_ref", "easting", "east", "utm_x", "utm_easting", "pos_x", "x_pos", "position_x"),
    "y": ("y", "y_ref", "northing", "north", "utm_y", "utm_northing", "pos_y", "y_pos", "position_y"),
    "lat": ("lat", "latitude", "gps_lat", "gps_latitude", "position_lat"),
    "lon": ("lon", "lng", "long", "longitude", "gps_lon", "gps_lng", "gps_long", "gps_longitude"),
    "z": ("z", "ele", "elevation", "alt", "altitude", "height", "pos_z", "position_z"),
    "right": ("w_tr_right", "width_right", "right_width", "w_right"),
    "left": ("w_tr_left", "width_left", "left_width", "w_left"),
    "width": ("width", "track_width", "road_width"),
    "banking": ("banking",),
}
_KINDS: Final = dict.fromkeys(_SPELLINGS, "length") | dict.fromkeys(("lat", "lon", "banking"), "angle")
_KNOWN: Final = {name: key for key, names in _SPELLINGS.items() for name in names}
_FORM: Final = "x_m, y_m, w_tr_right_m, w_tr_left_m, or lat, lon"


@dataclass(frozen=True, slots=True)
class Survey:
    """Points along a road, in the order of the file."""

    source: str  # name of the file
    points: Mat  # (n, 2) [m] east and north, or x and y of the file
    along: dict[str, Vec]  # (n,) each, if present: z [m], right, left, width [m], banking [deg]
    places: tuple[str, ...]  # (n,) place of each point in the file, for messages
    notes: tuple[str, ...]  # sentences: how the file was interpreted


def survey_of_table(text: str, source: str) -> Survey:
    """Read points from delimited text with columns x and y [m], or lat and lon [deg].

    Other columns are those of `Survey.along`.

    Raises
    ------
    InputError : columns are missing, given twice or have an unknown unit, or cells are not finite numbers.
    """
    table = split(text, source)
    columns, notes = _columns(table)
    numbers = table.numbers(list(columns.values()))
    data = {
        key: column.factor * values for (key, column), values in zip(columns.items(), numbers.T, strict=True)
    }
    places = tuple(table.where(row) for row in range(len(numbers)))
    return _survey(source, data, places, notes)


def survey_of_gpx(text: str, source: str) -> Survey:
    """Read points from a GPX file (topografix.com/GPX/1/1, 1/0): its longest track, else longest route.

    Raises
    ------
    InputError : the text is not XML, has no track or route, or a point has no latitude and longitude.
    """
    if re.search("<!(DOCTYPE|ENTITY)", text):
        raise InputError(f"GPX file {source}", "a document with a DOCTYPE", "plain GPX, which has none")
    try:
        root = ElementTree.fromstring(text)  # noqa: S314  entities, the danger of XML, are refused above
    except ElementTree.ParseError as error:
        raise InputError(f"GPX file {source}", f"no XML ({error})", "a GPX file with a track") from None
    kind, lines = next(
        ((kind, found) for kind in ("trk", "rte") if (found := [e for e in root.iter() if _tag(e) == kind])),
        ("", []),
    )
    if not lines:
        raise InputError(f"GPX file {source}", "without a track or route", "one with <trk> or <rte>")
    candidates = [[e for e in line.iter() if _tag(e) in ("trkpt", "rtept")] for line in lines]
    longest = max(candidates, key=len)
    word = "track" if kind == "trk" else "route"
    notes = [f"{word} of {len(longest)} points, the longest of {len(lines)}"] if len(lines) > 1 else []
    places = tuple(f"point {k + 1} of {source}" for k in range(len(longest)))
    data = {
        name: np.array([_attribute(e, name, place) for e, place in zip(longest, places, strict=True)])
        for name in ("lat", "lon")
    }
    heights = [next((child.text for child in e if _tag(child) == "ele"), None) for e in longest]
    if longest and None not in heights:
        data["z"] = np.array([_number(h, "ele", p) for h, p in zip(heights, places, strict=True)])
    elif any(h is not None for h in heights):
        notes.append(
            f"{heights.count(None)} of {len(heights)} points have no elevation: all are taken as flat"
        )
    return _survey(source, data, places, notes)


def _survey(source: str, data: dict[str, Vec], places: tuple[str, ...], notes: list[str]) -> Survey:
    """Convert points to metres near the origin, whatever their unit."""
    along = {key: values for key, values in data.items() if key not in ("x", "y", "lat", "lon")}
    if "x" in data:
        points = np.stack([data["x"], data["y"]], axis=1)
        if np.abs(points).max(initial=0.0) > FAR:
            shift = np.round(np.median(points, axis=0))
            points = points - shift
            notes = [*notes, f"x and y are {shift[0]:.0f} m and {shift[1]:.0f} m less than in the file"]
        return Survey(source, points, along, places, tuple(notes))
    return _on_plane(
        Survey(source, np.stack([data["lat"], data["lon"]], axis=1), along, places, tuple(notes))
    )


def _on_plane(survey: Survey) -> Survey:
    """Convert a survey in latitude and longitude [deg] to one in metres east and north."""
    fixed = np.flatnonzero(survey.points.any(axis=1))  # receivers write 0, 0 without a fix
    lost = len(survey.points) - len(fixed)
    survey = chosen(survey, fixed)
    if lost:
        survey = noted(survey, f"{lost} point{'s' if lost > 1 else ''} at latitude 0, longitude 0 left out")
    for key, values, bound in zip(("lat", "lon"), survey.points.T, (90.0, 360.0), strict=True):
        wrong = np.flatnonzero(~(np.abs(values) <= bound))
        if len(wrong):
            where, value = f"{key} of {survey.places[wrong[0]]}", f"{values[wrong[0]]:g} deg"
            raise InputError(where, value, f"between -{bound:g} and {bound:g} deg")
    if not survey.places:
        return survey
    heights = survey.along.get("z", np.zeros(len(survey.points)))
    latitude, longitude = np.radians(survey.points.T)
    points, (lat, lon) = local_plane(latitude, longitude, heights)
    farthest = float(np.linalg.norm(points, axis=1).max())
    short = max(1e-6, 0.5 * (farthest / 6_371e3) ** 2)
    middle = f"latitude {np.degrees(lat):.5f}, longitude {np.degrees(lon):.5f} deg"
    level = (
        "" if "z" in survey.along else "; without heights, less 1e-4 of them for every 640 m above the sea"
    )
    note = f"x east, y north of {middle} (tangent plane of WGS 84): distances true to {short:.0e}{level}"
    return noted(replace(survey, points=points), note)


def noted(survey: Survey, note: str) -> Survey:
    """Return the survey with another note."""
    return replace(survey, notes=(*survey.notes, note))


def chosen(survey: Survey, keep: Ints) -> Survey:
    """Return the survey with only the points whose indices are in `keep`."""
    return replace(
        survey,
        points=survey.points[keep],
        along={key: values[keep] for key, values in survey.along.items()},
        places=tuple(survey.places[k] for k in keep),
    )


def _columns(table: Table) -> tuple[dict[str, Column], list[str]]:
    """Return the columns of a road by their key, and notes on what was assumed."""
    found: dict[str, Column] = {}
    for index, name in enumerate(table.names):
        key, unit = _recognised(name)
        if not key:
            continue
        unit = unit or table.units[index].strip().lower()
        known = _UNITS[_KINDS[key]]
        if unit and unit not in known:
            raise InputError(f"unit of {name!r} in {table.source}", repr(unit), f"one of {', '.join(known)}")
        if key in found:
            both = f"given by {found[key].name!r} and {name!r}"
            raise InputError(f"{key} in {table.source}", both, "one column")
        found[key] = Column(key, index, name, known.get(unit, 1.0), unit, assumed=not unit)
    pair = _pair(found, table)
    others = [key for key in found if key not in ("x", "y", "lat", "lon")]
    notes = []
    for kind, unit in (("length", "m"), ("angle", "deg")):
        bare = [found[k].name for k in (*pair, *others) if found[k].assumed and _KINDS[k] == kind]
        if bare and bare != [found[k].name for k in ("lat", "lon") if k in found]:
            notes.append(f"no unit stated of {', '.join(bare)}: taken as {unit}")
    return {key: found[key] for key in (*pair, *others)}, notes


def _pair(found: dict[str, Column], table: Table) -> tuple[str, str]:
    """Return the two columns of the position: metres before degrees, unless the metre is only assumed."""
    metres, degrees = ("x" in found and "y" in found), ("lat" in found and "lon" in found)
    if degrees and (not metres or found["x"].assumed):
        return "lat", "lon"
    if metres:
        return "x", "y"
    one, other = ("lat", "lon") if "lat" in found or "lon" in found else ("x", "y")
    lacking = other if one in found else one
    raise InputError(
        f"column {lacking}{'_m' if lacking in 'xy' else ''} of {table.source}",
        "missing",
        f"there, as in {_FORM}",
    )


def _recognised(name: str) -> tuple[str, str]:
    """Return key and unit of a column by its name, empty if unknown: ``x_m``, ``X [m]``, ``lat (deg)``."""
    match = re.fullmatch(r"(.*?)[\s_]*[\[(]\s*([^\])]*?)\s*[\])]", name.strip())
    base, unit = (match.group(1), match.group(2).lower()) if match else (name.strip(), "")
    words = re.sub(r"[\s.-]+", "_", base).lower()
    if words in _KNOWN:
        return _KNOWN[words], unit
    stem, _, ending = words.rpartition("_")
    return (_KNOWN[stem], ending) if not unit and stem in _KNOWN and ending in _endings(stem) else ("", "")


def _endings(stem: str) -> dict[str, float]:
    return _UNITS[_KINDS[_KNOWN[stem]]]


def _tag(element: ElementTree.Element) -> str:
    """Return the name of an element without its namespace."""
    return str(element.tag).rpartition("}")[2]


def _attribute(element: ElementTree.Element, name: str, place: str) -> float:
    return _number(element.get(name), name, place)


def _number(text: str | None, name: str, place: str) -> float:
    try:
        number = float(text if text is not None else "")
    except ValueError:
        number = np.nan
    if not np.isfinite(number):
        raise InputError(f"{name} of {place}", "missing" if text is None else repr(text), "a finite number")
    return number
