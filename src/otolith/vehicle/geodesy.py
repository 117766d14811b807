"""Latitude and longitude as metres on a plane.

Notation: φ latitude, λ longitude, h height; a, e² of the ellipsoid; N = a/√(1 − e² sin²φ) its radius of
curvature across the meridian. A point is (N + h)(cos φ cos λ, cos φ sin λ) and (N (1 − e²) + h) sin φ in the
axes of the Earth (Hofmann-Wellenhof et al., GNSS, 2008, eqs. 8.1 and 8.5). Its difference from the plane's
origin, rotated into the directions of east and north there, is (x, y). Checked by
test_a_degree_is_as_long_as_the_series_of_the_meridian_says.

Accuracy: the plane touches the Earth at its origin, and points at a distance D are seen at a slant. A
distance there is too short by at most D²/(2 R²), R = 6371 km: 1e-6 at 9 km, 3e-5 at 50 km. Without heights
all points lie on the ellipsoid, which shortens every distance by h/R: 1e-4 at 640 m.
"""

from typing import Final

import numpy as np

from otolith.core.arrays import Mat, Vec

SEMI_MAJOR: Final = 6_378_137.0  # a [m], WGS 84 (NIMA TR 8350.2, 2000, table 3.1)
FLATTENING: Final = 1.0 / 298.257223563
ECCENTRICITY2: Final = FLATTENING * (2.0 - FLATTENING)  # e²


def earth_centred(latitude: Vec, longitude: Vec, height: Vec) -> Mat:
    """Return points (n, 3) [m] in the axes of the Earth.

    Parameters
    ----------
    latitude, longitude : (n,) [rad].
    height : (n,) [m] above the ellipsoid.
    """
    N = SEMI_MAJOR / np.sqrt(1.0 - ECCENTRICITY2 * np.sin(latitude) ** 2)
    across = (N + height) * np.cos(latitude)
    up = (N * (1.0 - ECCENTRICITY2) + height) * np.sin(latitude)
    return np.stack([across * np.cos(longitude), across * np.sin(longitude), up], axis=1)


def local_plane(latitude: Vec, longitude: Vec, height: Vec) -> tuple[Mat, tuple[float, float]]:
    """Return points east and north (n, 2) [m] on the plane that touches the Earth at their median.

    Parameters
    ----------
    latitude, longitude : (n,) [rad]; roads across the date line remain in one piece.
    height : (n,) [m] above the ellipsoid; for a road at sea level zeros suffice.

    Returns
    -------
    The points, and latitude and longitude [rad] of the origin.
    """
    longitude = np.unwrap(longitude)
    phi, lam, h = (float(np.median(values)) for values in (latitude, longitude, height))
    middle = np.array([phi]), np.array([lam]), np.array([h])
    away = earth_centred(latitude, longitude, height) - earth_centred(*middle)
    east = np.array([-np.sin(lam), np.cos(lam), 0.0])
    north = np.array([-np.sin(phi) * np.cos(lam), -np.sin(phi) * np.sin(lam), np.cos(phi)])
    return away @ np.stack([east, north], axis=1), (phi, lam)
