"""The rows for an optimiser: against finite differences of the motion itself, for legs and for cranks."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose

from otolith.core.arrays import Mat, Vec
from otolith.platforms import load
from otolith.platforms.hexapod import Hexapod
from otolith.platforms.kinematics import leg_motion
from otolith.platforms.sensitivity import motion_and_derivatives
from tests.platforms.cranks import machine

unit = arrays(np.float64, 6, elements=st.floats(-1.0, 1.0))
SIZES = [(load("davsi").six_legs(), 0.2), (machine(seed=3), 0.01), (machine(push=False, seed=2), 0.01)]


def motion_of(hexapod: Hexapod, pose: Vec, twist: Vec, acceleration: Vec) -> Mat:
    motion = np.empty((3, 6))
    leg_motion(pose, twist, acceleration, hexapod.actuators, motion)
    return motion


@pytest.mark.parametrize(("hexapod", "size"), SIZES, ids=["legs", "pushing", "pulling"])
@settings(derandomize=True, max_examples=30, deadline=None)
@given(x=unit, v=unit, a=unit)
def test_blocks_are_the_derivatives_of_the_motion(
    hexapod: Hexapod, size: float, x: Vec, v: Vec, a: Vec
) -> None:
    pose = size * x * [1.0, 1.0, 1.0, 2.0, 2.0, 2.0]
    motion, blocks = np.empty((3, 6)), np.empty((3, 6, 6))
    motion_and_derivatives(pose, v, a, hexapod.actuators, motion, blocks)
    assert_allclose(motion, motion_of(hexapod, pose, v, a), atol=0.0)
    h, still = 1e-5, np.zeros(6)
    for j, e in enumerate(np.eye(6)):
        for row, (dx, dv, da) in enumerate(((e, still, still), (still, e, still), (still, still, e))):
            ahead = motion_of(hexapod, pose + h * dx, v + h * dv, a + h * da)
            behind = motion_of(hexapod, pose - h * dx, v - h * dv, a - h * da)
            found = (ahead - behind) / (2.0 * h)
            G, dG, K = blocks[:, :, j]
            expected = [(G, dG, K), (still, G, 2.0 * dG), (still, still, G)][row]
            assert_allclose(found, expected, rtol=1e-6, atol=1e-5 * (1.0 + np.abs(K).max()))
