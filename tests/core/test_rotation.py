"""Rigid motion against scipy's rotations and finite differences of known paths."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from otolith.core import rotation as turning
from otolith.core.arrays import Mat, Vec
from otolith.core.frames import GRAVITY, specific_force

poses = arrays(np.float64, 6, elements=st.floats(-1.4, 1.4))
moving = arrays(np.float64, 6, elements=st.floats(-3.0, 3.0))
exactly = settings(derandomize=True, max_examples=100, deadline=None)


def placed(pose: Vec) -> Vec:
    place = np.empty(7)
    turning.place_of(pose, place)
    return place


def rotation(pose: Vec) -> Mat:
    R = np.empty((3, 3))
    turning.rotation_of(placed(pose), R)
    return R


def path(pose: Vec, twist: Vec, acceleration: Vec, t: float) -> Vec:
    return pose + twist * t + 0.5 * acceleration * t**2


@exactly
@given(poses)
def test_quaternion_and_rotation_are_scipys(pose: Vec) -> None:
    theirs = Rotation.from_euler("ZYX", pose[5:2:-1])
    assert_allclose(rotation(pose), theirs.as_matrix(), atol=1e-14)
    q = theirs.as_quat(scalar_first=True)
    assert_allclose(placed(pose)[3:] * np.sign(placed(pose)[3]), q * np.sign(q[0]), atol=1e-14)


@exactly
@given(poses)
def test_a_pose_survives_its_quaternion(pose: Vec) -> None:
    back = np.empty(6)
    turning.pose_of(placed(pose), back)
    assert_allclose(back, pose, atol=1e-13)


@exactly
@given(poses, arrays(np.float64, 3, elements=st.floats(-3.0, 3.0)))
def test_turning_is_a_product_of_rotations_in_world(pose: Vec, vector: Vec) -> None:
    place = placed(pose)
    turning.turn(place, *vector)
    R = np.empty((3, 3))
    turning.rotation_of(place, R)
    assert_allclose(R, Rotation.from_rotvec(vector).as_matrix() @ rotation(pose), atol=1e-13)
    assert_allclose(np.linalg.norm(place[3:]), 1.0, atol=1e-15)


@exactly
@given(poses, moving)
def test_the_angular_rate_turns_the_rotation(pose: Vec, twist: Vec) -> None:
    """Ṙ = [ω]× R, by central differences."""
    h, velocity = 1e-5, np.empty(6)
    turning.velocity_of(pose, twist, velocity)
    R_dot = (rotation(pose + h * twist) - rotation(pose - h * twist)) / (2 * h)
    W = R_dot @ rotation(pose).T
    assert_allclose(velocity[3:], [W[2, 1], W[0, 2], W[1, 0]], atol=1e-8)
    assert_allclose(velocity[:3], twist[:3])


@exactly
@given(poses, moving, moving)
def test_the_angular_acceleration_is_the_derivative_of_the_rate(pose: Vec, twist: Vec, acc: Vec) -> None:
    h, now = 1e-5, np.empty(6)
    ends = [np.empty(6), np.empty(6)]
    for end, t in zip(ends, (-h, h), strict=True):
        turning.velocity_of(path(pose, twist, acc, t), twist + acc * t, end)
    turning.acceleration_of(pose, twist, acc, now)
    assert_allclose(now, (ends[1] - ends[0]) / (2 * h), atol=1e-7)


@exactly
@given(poses, moving, moving)
def test_twist_and_acceleration_survive_the_way_there_and_back(pose: Vec, twist: Vec, acc: Vec) -> None:
    velocity, acceleration, twist_back, acc_back = (np.empty(6) for _ in range(4))
    turning.velocity_of(pose, twist, velocity)
    turning.acceleration_of(pose, twist, acc, acceleration)
    turning.twist_of(pose, velocity, twist_back)
    turning.pose_acceleration_of(pose, twist_back, acceleration, acc_back)
    assert_allclose(twist_back, twist, atol=1e-11)
    assert_allclose(acc_back, acc, atol=1e-9)


@exactly
@given(poses, moving, moving, arrays(np.float64, 3, elements=st.floats(-2.0, 2.0)))
def test_felt_force_is_that_of_the_heads_own_path(pose: Vec, twist: Vec, acc: Vec, head: Vec) -> None:
    """The head's position differentiated twice: no formula of rotating frames is used."""
    h = 1e-4

    def where(t: float) -> Vec:
        now = path(pose, twist, acc, t)
        return now[:3] + rotation(now) @ head

    a_world = (where(h) - 2 * where(0.0) + where(-h)) / h**2
    standing = np.array([0.0, 0.0, GRAVITY])
    expected = rotation(pose).T @ (a_world + standing) - standing
    force = np.empty((1, 3))
    turning.felt_along(head, pose[None], twist[None], acc[None], force)
    assert_allclose(force[0], expected, atol=2e-5)


@exactly
@given(poses, moving)
def test_the_rate_felt_is_the_worlds_in_the_platforms_frame(pose: Vec, twist: Vec) -> None:
    velocity, rate = np.empty(6), np.empty((1, 3))
    turning.velocity_of(pose, twist, velocity)
    turning.rate_along(pose[None], twist[None], rate)
    assert_allclose(rate[0], rotation(pose).T @ velocity[3:], atol=1e-13)


def test_at_rest_at_the_reference_point_it_is_the_planar_force() -> None:
    pose = np.array([0.1, 0.2, 0.3, 0.05, -0.07, 0.2])
    force = np.empty((1, 3))
    turning.felt_along(np.zeros(3), pose[None], np.zeros((1, 6)), np.zeros((1, 6)), force)
    assert_allclose(force[0], specific_force(np.zeros(3), pose[3:]), atol=1e-14)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-8])
def test_tiny_turns_do_not_divide_by_nothing(angle: float) -> None:
    place = placed(np.zeros(6))
    turning.turn(place, 0.0, angle, 0.0)
    assert_allclose(place[5], 0.5 * angle, rtol=1e-12)
