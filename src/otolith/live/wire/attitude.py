"""Attitudes as sources state them (angles, direction vectors), and vectors turned from the world to the
car.

An attitude is the unit quaternion (w x y z) of the rotation that maps the car's axes, x forward, y left, z
up, to a world with z up. Sources whose world has y up are turned there first (`formats.turning`).
"""

from collections.abc import Sequence
from typing import Final

import numpy as np
from scipy.spatial.transform import Rotation

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
    R = np.empty((3, 3))
    rotation_of(np.r_[0.0, 0.0, 0.0, attitude], R)
    return R


def axes_of(forward: Vec, left: Vec, source: str) -> Mat:
    """Return the matrix (3, 3) of the car's axes in the world, from two measured directions.

    Raises
    ------
    WireError : a direction is not a unit vector, or the two are not perpendicular.
    """
    for name, one in (("forward direction", forward), ("left direction", left)):
        length = float(np.linalg.norm(one))
        if abs(length - 1.0) > UNIT_WITHIN:
            raise WireError(f"length of {name} of {source}", f"{length:.4g}", f"1 within {UNIT_WITHIN:g}")
    cosine = float(forward @ left)
    if abs(cosine) > SQUARE_WITHIN:
        bound = f"0 within {SQUARE_WITHIN:g}"
        raise WireError(f"cosine between forward and left direction of {source}", f"{cosine:.4g}", bound)
    x = forward / np.linalg.norm(forward)
    y = left - (left @ x) * x
    y /= np.linalg.norm(y)
    return np.stack([x, y, np.cross(x, y)], axis=1)


def quaternion(R: Mat) -> Vec:
    """Return the attitude (4,) of a rotation matrix (3, 3), with w not negative."""
    x, y, z, w = Rotation.from_matrix(R).as_quat(canonical=True)
    return np.array([w, x, y, z])


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
