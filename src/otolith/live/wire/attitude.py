"""Attitudes as sources state them (angles, direction vectors), and vectors turned from the world to the
car.

An attitude is the unit quaternion (w x y z) of the rotation that maps the car's axes, x forward, y left, z
up, to a world with z up. Sources whose world has y up are turned there first (`formats.turning`).
"""

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.rotation import place_of, rotation_of
from otolith.live.wire.formats import WireError

UNIT_WITHIN: Final = 0.05  # deviation from 1 of the length of a direction or a quaternion
SQUARE_WITHIN: Final = 0.05  # cosine between two directions that should be perpendicular


def from_angles(roll: float, pitch: float, yaw: float) -> Vec:
    """Return the attitude (4,) of roll, pitch (positive nose down) and yaw [rad], R = Rz Ry Rx."""
    place = np.empty(7)
    place_of(np.array([0.0, 0.0, 0.0, roll, pitch, yaw]), place)
    return place[3:]


def matrix(attitude: Vec) -> Mat:
    """Return the rotation matrix (3, 3) of an attitude, from the car to the world."""
    R, place = np.empty((3, 3)), np.zeros(7)
    place[3:] = attitude
    rotation_of(place, R)
    return R


def axes_of(forward: Vec, left: Vec, source: str) -> Mat:
    """Return the matrix (3, 3) of the car's axes in the world, from two measured directions.

    Raises
    ------
    WireError : a direction is not a unit vector, or the two are not perpendicular.
    """
    fx, fy, fz = forward.tolist()
    lx, ly, lz = left.tolist()
    size, side = math.sqrt(fx * fx + fy * fy + fz * fz), math.sqrt(lx * lx + ly * ly + lz * lz)
    for name, length in (("forward direction", size), ("left direction", side)):
        if abs(length - 1.0) > UNIT_WITHIN:
            raise WireError(f"length of {name} of {source}", f"{length:.4g}", f"1 within {UNIT_WITHIN:g}")
    cosine = (fx * lx + fy * ly + fz * lz) / (size * side)
    if abs(cosine) > SQUARE_WITHIN:
        bound = f"0 within {SQUARE_WITHIN:g}"
        raise WireError(f"cosine between forward and left direction of {source}", f"{cosine:.4g}", bound)
    fx, fy, fz = fx / size, fy / size, fz / size
    across = cosine * side  # of `left` along `forward`, which is taken out
    lx, ly, lz = lx - across * fx, ly - across * fy, lz - across * fz
    side = math.sqrt(lx * lx + ly * ly + lz * lz)
    lx, ly, lz = lx / side, ly / side, lz / side
    return np.array([[fx, lx, fy * lz - fz * ly], [fy, ly, fz * lx - fx * lz], [fz, lz, fx * ly - fy * lx]])


def quaternion(R: Mat) -> Vec:
    """Return the attitude (4,) of a rotation matrix (3, 3), with w not negative.

    The largest of w, x, y, z is found first and divides the others, so that nothing small divides (Shepperd,
    Quaternion from rotation matrix, 1978).
    """
    (a, b, c), (d, e, f), (g, h, i) = R.tolist()
    squares = (1.0 + a + e + i, 1.0 + a - e - i, 1.0 - a + e - i, 1.0 - a - e + i)  # 4 w², 4 x², 4 y², 4 z²
    largest = squares.index(max(squares))
    row = (
        (squares[0], h - f, c - g, d - b),
        (h - f, squares[1], b + d, c + g),
        (c - g, b + d, squares[2], f + h),
        (d - b, c + g, f + h, squares[3]),
    )[largest]
    scale = math.copysign(0.5 / math.sqrt(squares[largest]), row[0])
    return np.array([scale * one for one in row])


def unit_quaternion(stated: Sequence[float], source: str) -> Vec | None:
    """Return a stated attitude normalised; None if all four numbers are zero, as who has none sends it.

    Raises
    ------
    WireError : its length is not about 1.
    """
    q = np.array(stated, dtype=np.float64)
    length = float(np.linalg.norm(q))
    if length == 0.0:
        return None
    if abs(length - 1.0) > UNIT_WITHIN:
        bound = f"1 within {UNIT_WITHIN:g}, or 0 for none"
        raise WireError(f"length of the attitude of {source}", f"{length:.4g}", bound)
    return q / length
