"""A platform on a base: the joint motion in world."""

import numpy as np
import pytest

from otolith.core.arrays import Mat
from otolith.core.carried import carried
from otolith.core.rotation import place_of, rotation_of


def moved(coefficients: Mat, t: float) -> Mat:
    """Pose, twist and acceleration (6, 6) of polynomials of the third degree in time, (12, 4)."""
    powers = np.array([[1.0, t, t**2, t**3], [0.0, 1.0, 2 * t, 3 * t**2], [0.0, 0.0, 2.0, 6 * t]])
    rows = powers @ coefficients.T
    motion = np.concatenate([rows[:, :6], rows[:, 6:]])
    motion[3:, 2:5] = 0.0  # a base neither lifts nor tilts
    return np.ascontiguousarray(motion)


def world(motion: Mat) -> Mat:
    out = np.empty((3, 6))
    carried(motion, out)
    return out


def rotation(pose: Mat) -> Mat:
    place, R = np.empty(7), np.empty((3, 3))
    place_of(pose, place)
    rotation_of(place, R)
    return R


@pytest.mark.parametrize("seed", range(5))
def test_its_derivatives_are_those_of_its_pose(seed: int) -> None:
    c, h = np.random.default_rng(seed).normal(0.0, 0.4, (12, 4)), 1e-4
    before, now, after = (world(moved(c, t)) for t in (0.7 - h, 0.7, 0.7 + h))
    np.testing.assert_allclose(now[1], (after[0] - before[0]) / (2 * h), atol=1e-6)
    np.testing.assert_allclose(now[2], (after[1] - before[1]) / (2 * h), atol=1e-6)


@pytest.mark.parametrize("seed", range(5))
def test_its_pose_is_the_base_s_after_which_comes_the_platform_s(seed: int) -> None:
    motion = moved(np.random.default_rng(seed).normal(0.0, 0.4, (12, 4)), 0.3)
    R = rotation(motion[3])
    np.testing.assert_allclose(world(motion)[0, :3], motion[3, :3] + R @ motion[0, :3], atol=1e-12)
    np.testing.assert_allclose(rotation(world(motion)[0]), R @ rotation(motion[0]), atol=1e-12)
