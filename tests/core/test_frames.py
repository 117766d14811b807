import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from otolith.core.errors import InputError
from otolith.core.frames import (
    AXES,
    DOFS,
    GRAVITY,
    HEAVE,
    SURGE_PITCH,
    SWAY_ROLL,
    YAW,
    Dof,
    dofs_named,
    pairs_of,
    specific_force,
)

ANGLE = st.floats(-1.5, 1.5)


@given(roll=ANGLE, pitch=ANGLE, yaw=st.floats(-3.1, 3.1))
def test_gravity_is_turned_as_scipy_turns_it(roll: float, pitch: float, yaw: float) -> None:
    R_driver_to_world = Rotation.from_euler("ZYX", [yaw, pitch, roll])
    expected = R_driver_to_world.inv().apply([0, 0, GRAVITY]) - [0, 0, GRAVITY]
    assert_allclose(specific_force(np.zeros(3), np.array([roll, pitch, yaw])), expected, atol=1e-12)


def test_nose_up_is_felt_as_acceleration() -> None:
    """Positive pitch is nose-down in z-up axes, so the driver is pushed back by a negative one."""
    assert specific_force(np.zeros(3), np.array([0.0, -0.1, 0.0]))[0] == pytest.approx(GRAVITY * np.sin(0.1))


@pytest.mark.parametrize("pair", pairs_of(DOFS.values()), ids=lambda pair: pair.name)
@given(tilt=ANGLE, translation=st.floats(-5, 5))
def test_every_planar_model_feels_a_plus_g_sin_tilt(pair: Dof, tilt: float, translation: float) -> None:
    acceleration, pose = np.zeros(3), np.zeros(6)
    acceleration[pair.translation], pose[pair.rotation] = translation, pair.sign * tilt
    felt = specific_force(acceleration, pose[3:])[pair.felt]
    assert felt == pytest.approx(translation + GRAVITY * np.sin(tilt), abs=1e-12)


def test_the_pairs_are_the_thesiss() -> None:
    assert (SURGE_PITCH.translation, SURGE_PITCH.rotation) == (0, 4)
    assert (SWAY_ROLL.translation, SWAY_ROLL.rotation) == (1, 3)


def test_every_axis_belongs_to_one_degree_of_freedom() -> None:
    assert sorted(i for dof in DOFS.values() for i in dof.axes) == list(range(6))
    for name, dof in DOFS.items():
        assert name == dof.name == "-".join(AXES[i] for i in dof.axes)


def test_names_in_any_order_give_degrees_of_freedom_in_theirs() -> None:
    assert dofs_named(["yaw", "sway-roll", "yaw"]) == (SWAY_ROLL, YAW)
    assert (HEAVE.felt, HEAVE.feels_rate, YAW.felt, YAW.feels_rate) == (2, False, 2, True)
    with pytest.raises(InputError, match=r"--dofs is 'heav', must be one of .*did you mean heave"):
        dofs_named(["heav"])
    with pytest.raises(InputError, match="--dofs is 'yaw', must be one of surge-pitch, sway-roll"):
        dofs_named(["yaw"], ("surge-pitch", "sway-roll"))
