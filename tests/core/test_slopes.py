"""Slopes of felt force and body rates against finite differences of the motion that a plant would record."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from otolith.core.arrays import Mat, Vec
from otolith.core.rotation import felt, rate_along
from otolith.core.slopes import felt_slopes, rate_slopes, rotation_jet

STEP = 1e-6
SCALE = np.array([[0.4, 0.4, 0.3, 0.4, 0.4, 0.4], [1.0] * 6, [5.0] * 6])


def motions(n: int = 40) -> list[Mat]:
    rng = np.random.default_rng(3)
    return [SCALE * rng.uniform(-1.0, 1.0, (3, 6)) for _ in range(n)]


def jet_of(motion: Mat) -> Mat:
    jet = np.empty((4, 3, 3, 3))
    rotation_jet(motion, jet)
    return jet


def by_differences(function, motion: Mat) -> Mat:
    """Central differences (m, 18) of a function of a motion (3, 6)."""
    columns = []
    for k in range(18):
        change = np.zeros((3, 6))
        change.flat[k] = STEP
        columns.append((function(motion + change) - function(motion - change)) / (2.0 * STEP))
    return np.array(columns).T


def test_a_jet_is_the_rotation_and_its_derivatives_along_the_motion() -> None:
    """Along q + v t + ½ a t², against scipy's rotations at three moments."""
    h = 1e-4
    for motion in motions():
        jet = jet_of(motion)

        def turned(t: float, motion: Mat = motion) -> Mat:
            angles = motion[0, 3:] + t * motion[1, 3:] + 0.5 * t * t * motion[2, 3:]
            return Rotation.from_euler("ZYX", angles[::-1]).as_matrix()

        before, now, after = turned(-h), turned(0.0), turned(h)
        assert_allclose(jet[0, 0], now, atol=1e-14)
        assert_allclose(jet[0, 1], (after - before) / (2.0 * h), atol=1e-6)
        assert_allclose(jet[0, 2], (after - 2.0 * now + before) / h**2, atol=1e-5)


@pytest.mark.parametrize("head", [np.zeros(3), np.array([-0.3, 0.1, 1.1])], ids=["at the point", "above"])
def test_slopes_of_the_felt_force_are_its_derivatives(head: Vec) -> None:
    def force_of(motion: Mat) -> Vec:
        force = np.empty(3)
        felt(head, motion[0], motion[1], motion[2], force)
        return force

    for motion in motions():
        values, slopes = np.empty(6), np.empty((6, 18))
        felt_slopes(head, motion, values, slopes)
        assert_allclose(values[:3], force_of(motion), atol=1e-12)
        assert_allclose(slopes[:3], by_differences(force_of, motion), atol=1e-6)
        rate, by_rate = np.empty(3), np.empty((3, 18))
        rate_slopes(motion, rate, by_rate)
        assert_allclose(values[3:], rate, atol=0.0)
        assert_allclose(slopes[3:], by_rate, atol=0.0)


def test_slopes_of_body_rates_are_their_derivatives() -> None:
    def rate_of(motion: Mat) -> Vec:
        rate = np.empty((1, 3))
        rate_along(motion[:1], motion[1:2], rate)
        return rate[0]

    for motion in motions():
        rate, slopes = np.empty(3), np.empty((3, 18))
        rate_slopes(motion, rate, slopes)
        assert_allclose(rate, rate_of(motion), atol=1e-14)
        assert_allclose(slopes, by_differences(rate_of, motion), atol=1e-6)
