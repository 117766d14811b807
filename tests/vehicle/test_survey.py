"""Points of a road out of files as people have them."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from otolith.core.errors import InputError
from otolith.vehicle.survey import survey_of_gpx, survey_of_table

ANGLE = np.linspace(0.0, 2.0 * np.pi, 61)[:-1]
X, Y = 150.0 * np.cos(ANGLE), 60.0 * np.sin(ANGLE)
LAT, LON = 48.1 + Y / 111_192.0, 11.6 + X / 74_490.0  # as long as degrees are there, to 1e-4


def table(header: str, *columns: np.ndarray, delimiter: str = ",") -> str:
    rows = (delimiter.join(f"{value:.8f}" for value in row) for row in zip(*columns, strict=True))
    return "\n".join([header, *rows]) + "\n"


def gpx(points: str, *, namespace: str = ' xmlns="http://www.topografix.com/GPX/1/1"') -> str:
    return f'<?xml version="1.0"?>\n<gpx version="1.1"{namespace}>{points}</gpx>\n'


def track(lat: np.ndarray, lon: np.ndarray, ele: list[float | None] | None = None) -> str:
    heights = ele or [None] * len(lat)
    points = (
        f'<trkpt lat="{a:.8f}" lon="{b:.8f}">{"" if e is None else f"<ele>{e}</ele>"}</trkpt>'
        for a, b, e in zip(lat, lon, heights, strict=True)
    )
    return f"<trk><trkseg>{''.join(points)}</trkseg></trk>"


@pytest.mark.parametrize(
    ("header", "scale"),
    [
        ("x_m,y_m", 1.0),
        ("X [m],Y [m]", 1.0),
        ("x (km),y (km)", 1e-3),
        ("x_mm,y_mm", 1e3),
        ("Easting,Northing", 1.0),
        ("pos_x_ft,pos_y_ft", 1.0 / 0.3048),
        ("# 4fa2\n# x_m,y_m", 1.0),
    ],
)
def test_places_in_metres_by_their_names(header: str, scale: float) -> None:
    survey = survey_of_table(table(header, scale * X, scale * Y), "t.csv")
    assert_allclose(survey.points, np.stack([X, Y], axis=1), atol=1e-4)
    stated = "_" in header.split(",")[0][-3:] or "[" in header or "(" in header
    assert len(survey.notes) == (0 if stated else 1)
    assert stated or "no unit stated of Easting, Northing: taken as m" in survey.notes[0]


@pytest.mark.parametrize("header", ["lat,lon", "Latitude (deg),Longitude (deg)", "gps_lat;gps_lng"])
def test_degrees_become_metres_east_and_north_with_a_note(header: str) -> None:
    delimiter = ";" if ";" in header else ","
    survey = survey_of_table(table(header, LAT, LON, delimiter=delimiter), "t.csv")
    assert_allclose(survey.points, np.stack([X, Y], axis=1), atol=0.05)
    (note,) = survey.notes
    assert "latitude 48.10000, longitude 11.60000 deg (tangent plane of WGS 84)" in note
    assert "distances true to 1e-06; without heights" in note


def test_points_without_a_fix_are_left_out_and_said() -> None:
    lat, lon = (np.insert(v, [0, 30], 0.0) for v in (LAT, LON))
    survey = survey_of_table(table("lat,lon", lat, lon), "t.csv")
    assert_allclose(survey.points, np.stack([X, Y], axis=1), atol=0.05)
    assert survey.notes[0] == "2 points at latitude 0, longitude 0 left out"
    assert survey.places[0] == "line 3 of t.csv"


def test_stated_metres_go_before_degrees_and_degrees_before_numbers_of_no_unit() -> None:
    turned = np.stack([Y, X], axis=1)
    metres = survey_of_table(table("lat,lon,x_m,y_m", LAT, LON, Y, X), "t.csv")
    assert_allclose(metres.points, turned, atol=1e-6)
    degrees = survey_of_table(table("lat,lon,x,y", LAT, LON, Y, X), "t.csv")
    assert_allclose(degrees.points, np.stack([X, Y], axis=1), atol=0.05)


def test_coordinates_of_a_grid_are_told_from_the_middle_of_the_road() -> None:
    survey = survey_of_table(table("x_m,y_m", X + 691_000.0, Y + 5_334_000.0), "t.csv")
    assert_allclose(survey.points, np.stack([X, Y], axis=1), atol=1e-6)
    assert survey.notes == ("x and y are 691000 m and 5334000 m less than in the file",)


@pytest.mark.parametrize("namespace", ["", ' xmlns="http://www.topografix.com/GPX/1/0"'])
def test_a_track_is_read_with_its_heights(namespace: str) -> None:
    heights = [500.0 + k for k in range(len(LAT))]
    survey = survey_of_gpx(gpx(track(LAT, LON, list(heights)), namespace=namespace), "t.gpx")
    assert_allclose(survey.points, (1.0 + 530.0 / 6.371e6) * np.stack([X, Y], axis=1), atol=0.05)
    assert_allclose(survey.along["z"], heights)
    assert survey.places[4] == "point 5 of t.gpx"
    assert "without heights" not in survey.notes[-1]


def test_of_several_tracks_the_longest_is_taken_and_said() -> None:
    both = track(LAT[:9], LON[:9]) + track(LAT, LON) + track(LAT[:5], LON[:5])
    survey = survey_of_gpx(gpx(both), "t.gpx")
    assert len(survey.points) == len(LAT)
    assert "track of 60 points, the longest of 3" in survey.notes


def test_heights_of_some_points_only_are_left_out_and_said() -> None:
    survey = survey_of_gpx(gpx(track(LAT, LON, [None, *[500.0] * 59])), "t.gpx")
    assert "z" not in survey.along
    assert "1 of 60 points have no elevation: all are taken as flat" in survey.notes


def test_a_route_does_where_there_is_no_track() -> None:
    route = track(LAT, LON).replace("trkpt", "rtept").replace("<trkseg>", "").replace("</trkseg>", "")
    assert len(survey_of_gpx(gpx(route.replace("trk>", "rte>")), "t.gpx").points) == 60


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("<gpx><trk>", "GPX file t.gpx is no XML (no element found"),
        (gpx("<wpt lat='1' lon='2'/>"), "GPX file t.gpx is without a track or route, must be one with <trk>"),
        (
            gpx(track(LAT, LON).replace("lat=", "la=", 1)),
            "lat of point 1 of t.gpx is missing, must be a finite",
        ),
        (
            gpx(track(np.full(9, 91.0), np.zeros(9))),
            "lat of point 1 of t.gpx is 91 deg, must be between -90 and 90",
        ),
        (
            gpx(track(LAT, LON, [1.0] * 60)).replace("<ele>1.0", "<ele>x"),
            "ele of point 1 of t.gpx is 'x', must be",
        ),
        (
            '<!DOCTYPE g [<!ENTITY a "b">]><gpx/>',
            "GPX file t.gpx is a document with a DOCTYPE, must be plain GPX",
        ),
    ],
)
def test_a_gpx_file_that_tells_no_road_is_refused(text: str, sentence: str) -> None:
    with pytest.raises(InputError) as caught:
        survey_of_gpx(text, "t.gpx")
    assert sentence in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (table("road,track", X, Y), "column x_m of t.csv is missing, must be there, as in x_m, y_m"),
        (table("x_m,b", X, Y), "column y_m of t.csv is missing"),
        (table("lat,b", LAT, Y), "column lon of t.csv is missing"),
        (table("x_m,y_m,easting", X, Y, Y), "x in t.csv is given by 'x_m' and 'easting', must be one column"),
        (table("x [furlong],y [m]", X, Y), "unit of 'x [furlong]' in t.csv is 'furlong', must be one of m,"),
        (
            table("lat,lon", LAT + 50.0, LON),
            "lat of line 2 of t.csv is 98.1 deg, must be between -90 and 90 deg",
        ),
    ],
)
def test_a_table_that_tells_no_road_is_refused(text: str, sentence: str) -> None:
    with pytest.raises(InputError) as caught:
        survey_of_table(text, "t.csv")
    assert sentence in str(caught.value)
