"""Attitudes from directions, angles and numbers, against scipy's rotations."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from otolith.live.wire.attitude import axes_of, from_angles, matrix, quaternion, unit_quaternion
from otolith.live.wire.formats import WireError

ROTATIONS = Rotation.random(200, random_state=5)
HALF_TURNS = Rotation.from_quat(np.r_[np.eye(4), [[1, 1, 0, 0], [0, 1, 1, 0], [0, 1, 0, 1], [1, 0, 0, 1]]])


@pytest.mark.parametrize("rotation", [*ROTATIONS, *HALF_TURNS])
def test_quaternion_of_any_rotation(rotation: Rotation):
    R = rotation.as_matrix()
    q = quaternion(R)
    assert q[0] >= 0.0
    assert np.linalg.norm(q) == pytest.approx(1.0, abs=1e-14)
    assert np.allclose(matrix(q), R, atol=1e-14)
    assert abs(np.dot(q, np.roll(rotation.as_quat(), 1))) == pytest.approx(1.0, abs=1e-14)


def test_axes_of_directions_that_are_a_little_off():
    generator = np.random.default_rng(6)
    for rotation in ROTATIONS:
        R = rotation.as_matrix()
        forward, left = R[:, 0] * 1.01, R[:, 1] * 0.99 + 0.01 * generator.normal(size=3)
        axes = axes_of(forward, left, "game")
        assert np.allclose(axes.T @ axes, np.eye(3), atol=1e-14)
        assert np.linalg.det(axes) == pytest.approx(1.0)
        assert np.allclose(axes[:, 0], R[:, 0], atol=1e-12)  # forward is kept …
        assert abs(axes[:, 2] @ left) < 1e-12  # … and left stays in the plane of both


def test_axes_of_wrong_directions_are_refused():
    x, y = np.eye(3)[:2]
    with pytest.raises(WireError, match=r"length of left direction of game is 0.9, must be 1 within 0.05"):
        axes_of(x, 0.9 * y, "game")
    with pytest.raises(WireError, match=r"cosine between forward and left direction of game is 0.1"):
        axes_of(x, np.array([0.1, np.sqrt(0.99), 0.0]), "game")
    with pytest.raises(WireError, match=r"length of forward direction of game is 0,"):
        axes_of(np.zeros(3), y, "game")


def test_angles_are_yaw_then_pitch_then_roll():
    for roll, pitch, yaw in np.random.default_rng(7).uniform(-1.5, 1.5, size=(50, 3)):
        R = Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_matrix()
        assert np.allclose(matrix(from_angles(roll, pitch, yaw)), R, atol=1e-14)


def test_a_stated_quaternion_is_normalised_absent_or_refused():
    found = unit_quaternion((1.01, 0.0, 0.0, 0.0), "game")
    assert found is not None
    assert np.array_equal(found, [1.0, 0.0, 0.0, 0.0])
    assert unit_quaternion((0.0, 0.0, 0.0, 0.0), "game") is None
    with pytest.raises(
        WireError, match=r"length of the attitude of game is 0.5, must be 1 within 0.05, or 0 for none"
    ):
        unit_quaternion((0.5, 0.0, 0.0, 0.0), "game")
