import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from otolith.core.frames import GRAVITY, PAIRS, SURGE_PITCH, SWAY_ROLL, AxisPair, specific_force

ANGLE = st.floats(-1.5, 1.5)


@given(roll=ANGLE, pitch=ANGLE, yaw=st.floats(-3.1, 3.1))
def test_gravity_is_turned_as_scipy_turns_it(roll: float, pitch: float, yaw: float) -> None:
    R_driver_to_world = Rotation.from_euler("ZYX", [yaw, pitch, roll])
    expected = R_driver_to_world.inv().apply([0, 0, GRAVITY]) - [0, 0, GRAVITY]
    assert_allclose(specific_force(np.zeros(3), np.array([roll, pitch, yaw])), expected, atol=1e-12)


def test_nose_up_is_felt_as_acceleration() -> None:
    """Positive pitch is nose-down in z-up axes, so the driver is pushed back by a negative one."""
    assert specific_force(np.zeros(3), np.array([0.0, -0.1, 0.0]))[0] == pytest.approx(GRAVITY * np.sin(0.1))


@pytest.mark.parametrize("pair", PAIRS.values(), ids=lambda pair: pair.name)
@given(tilt=ANGLE, translation=st.floats(-5, 5))
def test_every_planar_model_feels_a_plus_g_sin_tilt(pair: AxisPair, tilt: float, translation: float) -> None:
    attitude = pair.axes(0.0, tilt)[3:]
    acceleration = pair.axes(translation, 0.0)[:3]
    felt = specific_force(acceleration, attitude)[pair.translation]
    assert felt == pytest.approx(translation + GRAVITY * np.sin(tilt), abs=1e-12)
    assert pair.planar(pair.axes(translation, tilt)) == (translation, tilt)


def test_the_pairs_are_the_thesiss() -> None:
    assert (SURGE_PITCH.translation, SURGE_PITCH.rotation) == (0, 4)
    assert (SWAY_ROLL.translation, SWAY_ROLL.rotation) == (1, 3)
