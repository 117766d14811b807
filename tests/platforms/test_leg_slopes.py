"""Slopes of the legs' motion against finite differences of `Hexapod.leg_motion`, which shares no code."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from otolith.core.arrays import Mat, Vec
from otolith.platforms.hexapod import Hexapod
from otolith.platforms.leg_slopes import leg_slopes
from tests.core.test_slopes import by_differences, jet_of
from tests.platforms.cranks import machine
from tests.platforms.test_hexapod import MACHINES

SCALE = np.array([[0.3, 0.3, 0.25, 0.2, 0.2, 0.2], [0.5] * 6, [7.0] * 6])


@MACHINES
def test_values_are_the_motion_of_the_legs_and_slopes_their_derivatives(hexapod: Hexapod) -> None:
    def of_legs(motion: Mat) -> Vec:
        legs = hexapod.leg_motion(*motion)
        return np.concatenate([legs.length, legs.speed, legs.acceleration])

    rng = np.random.default_rng(4)
    for _ in range(40):
        motion = SCALE * rng.uniform(-1.0, 1.0, (3, 6))
        values, slopes = np.empty(18), np.empty((18, 18))
        leg_slopes(motion, jet_of(motion), hexapod.actuators, values, slopes)
        assert_allclose(values, of_legs(motion), atol=1e-12)
        assert_allclose(slopes, by_differences(of_legs, motion), atol=1e-6)


@pytest.mark.parametrize(
    "hexapod", [machine(seed=3), machine(push=False, seed=2)], ids=["pushing", "pulling"]
)
def test_the_same_of_cranks(hexapod: Hexapod) -> None:
    """Relative, for near its dead centre a crank amplifies what the platform does."""

    def of_cranks(motion: Mat) -> Vec:
        cranks = hexapod.leg_motion(*motion)
        return np.concatenate([cranks.length, cranks.speed, cranks.acceleration])

    rng, small = np.random.default_rng(4), SCALE * [[0.03], [0.4], [0.4]]
    for _ in range(40):
        motion = small * rng.uniform(-1.0, 1.0, (3, 6))
        values, slopes = np.empty(18), np.empty((18, 18))
        leg_slopes(motion, jet_of(motion), hexapod.actuators, values, slopes)
        assert_allclose(values, of_cranks(motion), atol=1e-12)
        assert_allclose(
            slopes, by_differences(of_cranks, motion), rtol=1e-5, atol=1e-7 * np.abs(slopes).max()
        )


@MACHINES
def test_speed_matters_to_the_acceleration_of_a_leg(hexapod: Hexapod) -> None:
    """At the speeds of cueing, the terms that a Jacobian leaves out exceed any margin on accelerations."""
    still, moving = np.zeros((3, 6)), np.zeros((3, 6))
    moving[1] = [0.4, -0.4, 0.3, 0.3, -0.3, 0.4]
    values, slopes = np.empty((2, 18)), np.empty((18, 18))
    for k, motion in enumerate((still, moving)):
        leg_slopes(motion, jet_of(motion), hexapod.actuators, values[k], slopes)
    assert np.abs(values[1, 12:] - values[0, 12:]).max() > 0.1
