"""Latitude and longitude as metres, against the published series and against distances on the earth."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from otolith.vehicle.geodesy import earth_centred, local_plane


def metres_per_degree(latitude_deg: float) -> tuple[float, float]:
    """North and east: the series of the meridian and of the parallel (NGA, length of a degree, WGS 84)."""
    phi = np.radians(latitude_deg)
    north = 111132.954 - 559.822 * np.cos(2 * phi) + 1.175 * np.cos(4 * phi) - 0.0023 * np.cos(6 * phi)
    east = 111412.84 * np.cos(phi) - 93.5 * np.cos(3 * phi) + 0.118 * np.cos(5 * phi)
    return float(north), float(east)


@pytest.mark.parametrize("latitude", [-65.0, -23.0, 0.0, 48.1, 70.0])
@pytest.mark.parametrize("longitude", [-179.999, 11.6, 180.0])
def test_a_degree_is_as_long_as_the_series_of_the_meridian_says(latitude: float, longitude: float) -> None:
    step = 0.005  # [deg], half a kilometre
    lat = np.radians(latitude + step * np.array([1.0, -1.0, 0.0, 0.0]))
    lon = np.radians(longitude + step * np.array([0.0, 0.0, 1.0, -1.0]))
    points, origin = local_plane(lat, (lon + np.pi) % (2 * np.pi) - np.pi, np.zeros(4))
    north, east = metres_per_degree(latitude)
    assert points[0, 1] - points[1, 1] == pytest.approx(2 * step * north, rel=2e-6)
    assert points[2, 0] - points[3, 0] == pytest.approx(2 * step * east, rel=2e-6)
    assert_allclose(points[:2, 0], 0.0, atol=1e-6)  # the meridian through the origin is the axis
    assert np.degrees(origin[0]) == pytest.approx(latitude, abs=1e-9)


def test_points_of_the_earth_are_where_geometry_puts_them() -> None:
    """Equator, pole, and 1000 m above a place: closed forms."""
    zero, right = np.zeros(1), np.array([np.pi / 2])
    assert_allclose(earth_centred(zero, zero, zero), [[6378137.0, 0.0, 0.0]])
    assert_allclose(earth_centred(right, zero, zero), [[0.0, 0.0, 6356752.3142]], atol=1e-3)
    place = np.radians([48.1]), np.radians([11.6])
    raised = earth_centred(*place, np.array([1000.0])) - earth_centred(*place, np.zeros(1))
    up = [np.cos(place[0]) * np.cos(place[1]), np.cos(place[0]) * np.sin(place[1]), np.sin(place[0])]
    assert_allclose(raised, 1000.0 * np.array(up).T, atol=1e-6)


@pytest.mark.parametrize(("away", "bound"), [(9e3, 1.0e-6), (50e3, 3.1e-5)])
def test_distances_are_as_true_as_the_docstring_says(away: float, bound: float) -> None:
    """A hundred metres outwards at the edge of a road, against the chord through the earth."""
    lat0, lon0 = np.radians(48.1), np.radians(11.6)
    worst = 0.0
    for bearing in np.linspace(0.0, 2 * np.pi, 24, endpoint=False):
        r = np.array([-away, 0.0, 0.0, away, away + 100.0]) / 6371e3
        lat, lon = lat0 + r * np.cos(bearing), lon0 + r * np.sin(bearing) / np.cos(lat0)
        points, _ = local_plane(lat, lon, np.zeros(5))
        chord = np.linalg.norm(np.diff(earth_centred(lat, lon, np.zeros(5))[3:], axis=0))
        worst = max(worst, float(abs(np.linalg.norm(points[4] - points[3]) / chord - 1.0)))
    assert 0.3 * bound < worst <= bound * 1.05


def test_height_lengthens_distances_by_its_share_of_the_radius() -> None:
    lat, lon = np.radians(48.1 + np.array([-0.01, 0.01])), np.radians(np.array([11.6, 11.6]))
    low, high = (local_plane(lat, lon, np.full(2, h))[0] for h in (0.0, 640.0))
    assert high[1, 1] / low[1, 1] - 1.0 == pytest.approx(1e-4, rel=0.01)
