"""The emulator: it goes where it is sent, within its legs, and says what is felt at the head."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError
from otolith.core.rotation import felt_along
from otolith.interfaces import Command, Outcome, PlatformState, Status
from otolith.plant.hexapod import HexapodPlant, hexapod
from otolith.plant.ideal import Ideal
from otolith.platforms import load, parse_platform
from otolith.platforms.template import template
from otolith.platforms.unreachable import LegOutsideStroke
from otolith.safety.supervisor import Reason

DAVSI = load("davsi").six_legs()
RIG = parse_platform(template("cranks"), "cranks.toml").six_legs()


def commanding(acceleration: Vec) -> Command:
    zero = np.zeros(6)
    outcome = Outcome(status=Status.DECIDED)
    return Command(acceleration=acceleration, pose=zero, twist=zero, plan=np.zeros((0, 6)), outcome=outcome)


def shaking(t: float) -> Vec:
    """Accelerations that sway about the neutral pose along all axes."""
    rates = 2 * np.pi * np.array([0.5, 0.7, 1.0, 0.6, 0.4, 0.5])
    return np.array([0.4, 0.3, 0.3, 0.1, 0.1, 0.1]) * np.cos(rates * t)


def driven(plant: object, n: int, scale: float = 1.0) -> list[PlatformState]:
    return [plant.step(commanding(scale * shaking(1e-3 * k)), 1e-3) for k in range(n)]  # type: ignore[attr-defined]


def poses(states: list[PlatformState]) -> Mat:
    return np.array([state.pose for state in states])


def test_within_its_limits_it_moves_as_the_ideal_platform() -> None:
    plant = HexapodPlant(DAVSI)
    there, here = driven(Ideal(), 3000), driven(plant, 3000)
    assert_allclose(poses(here), poses(there), atol=1e-4)
    assert np.abs(poses(there)).max() > 0.05
    assert plant.interventions == ()


def test_after_reset_the_same_motion_comes_out_bit_for_bit() -> None:
    plant = HexapodPlant(DAVSI)
    first = poses(driven(plant, 200))
    plant.reset(PlatformState())
    np.testing.assert_array_equal(poses(driven(plant, 200)), first)


def test_its_rates_are_the_derivatives_of_its_pose() -> None:
    states = driven(HexapodPlant(DAVSI), 1000)
    pose, twist = poses(states), np.array([s.twist for s in states])
    acceleration = np.array([s.acceleration for s in states])
    assert_allclose(np.diff(pose, axis=0) / 1e-3, 0.5 * (twist[1:] + twist[:-1]), atol=1e-6)
    assert_allclose(np.diff(twist, axis=0) / 1e-3, acceleration[1:], atol=1e-4)


def test_what_is_felt_is_at_the_head() -> None:
    """Rotation and lever arm: the sensed force is that of the reported motion, at the head."""
    head = np.array([0.2, -0.3, 0.9])
    states = driven(HexapodPlant(replace(DAVSI, head=head)), 500)
    pose, twist, acceleration = (
        np.array([getattr(s, name) for s in states]) for name in ("pose", "twist", "acceleration")
    )
    expected, at_reference = np.empty((500, 3)), np.empty((500, 3))
    felt_along(head, pose, twist, acceleration, expected)
    felt_along(np.zeros(3), pose, twist, acceleration, at_reference)
    felt = np.array([s.specific_force for s in states])
    assert_allclose(felt, expected, atol=1e-10)
    assert np.abs(felt - at_reference).max() > 0.02


def test_ten_times_beyond_the_workspace_no_leg_breaks_a_limit() -> None:
    plant = HexapodPlant(DAVSI)
    low, high = DAVSI.stroke
    for k in range(6000):
        plant.step(commanding(30.0 * shaking(1e-3 * k)), 1e-3)
        targets = plant.servo_targets.targets
        assert low <= targets[0].min() <= targets[0].max() <= high
        assert np.abs(targets[1]).max() <= DAVSI.speed * (1 + 1e-9)
        assert low - 1e-3 < plant.legs[0].min() <= plant.legs[0].max() < high + 1e-3 or k == 0
    assert {i.reason for i in plant.interventions} >= {Reason.STROKE}


def test_ten_times_beyond_the_workspace_no_crank_breaks_a_limit() -> None:
    """Angles, speeds and accelerations of six cranks, as the servos are given them."""
    plant, given = HexapodPlant(RIG), []
    for k in range(3000):
        plant.step(commanding(30.0 * shaking(1e-3 * k)), 1e-3)
        given.append(plant.servo_targets.targets[:2].copy())
    arcs, speeds = np.moveaxis(np.array(given), 1, 0)
    assert RIG.stroke[0] <= arcs.min() <= arcs.max() <= RIG.stroke[1]
    assert np.abs(speeds).max() <= RIG.speed * (1 + 1e-9)
    assert np.abs(np.diff(speeds, axis=0)).max() <= 1e-3 * RIG.acceleration * (1 + 1e-9)
    assert plant.interventions
    assert {i.reason for i in plant.interventions} <= set(Reason) - {Reason.INVALID}


def test_cranks_go_where_they_are_sent() -> None:
    """Gently: every crank is within half a degree of its set-point, and the pose within 1 mm and 0.1 deg."""
    plant = HexapodPlant(RIG)
    for k in range(1500):
        before = plant.servo_targets.targets[0].copy()
        state = plant.step(commanding(0.3 * shaking(1e-3 * k)), 1e-3)
        assert k == 0 or np.abs(RIG.angles(plant.legs[0] - before)).max() < np.radians(0.5)
        off = state.pose - plant.servo_targets.drive.motion[0]
        assert np.abs(off[:3]).max() < 1e-3
        assert np.abs(off[3:]).max() < np.radians(0.1)
    assert np.ptp(RIG.angles(plant.legs[0])) > np.radians(1.0)
    assert plant.interventions == ()


@pytest.mark.parametrize("bad", [np.nan, np.inf, 1e200])
def test_a_command_that_is_no_number_brakes(bad: float) -> None:
    plant = HexapodPlant(DAVSI)
    driven(plant, 300)
    for _ in range(600):
        state = plant.step(commanding(np.full(6, bad)), 1e-3)
    assert np.abs(state.twist).max() < 1e-3 or bad == 1e200
    assert np.isfinite(state.pose).all()
    assert DAVSI.reaches(state.pose[None]).all()
    assert plant.interventions


def test_longer_steps_are_several_servo_periods() -> None:
    fine, coarse = HexapodPlant(DAVSI), HexapodPlant(DAVSI)
    command = commanding(np.array([0.3, 0, 0, 0, 0, 0]))
    for _ in range(10):
        last = fine.step(command, 1e-3)
    np.testing.assert_array_equal(coarse.step(command, 1e-2).pose, last.pose)
    with pytest.raises(ValueError, match="must be a multiple of its servo period"):
        fine.step(command, 1.5e-3)


def test_it_starts_from_any_pose_within_its_legs() -> None:
    plant, pose = HexapodPlant(DAVSI), np.array([0.1, 0.1, 0.1, 0.05, 0.1, 0.1])
    plant.reset(PlatformState(pose=pose))
    for _ in range(100):
        state = plant.step(commanding(np.zeros(6)), 1e-3)
    assert_allclose(state.pose, pose, atol=1e-9)
    with pytest.raises(LegOutsideStroke):
        plant.reset(PlatformState(pose=np.array([0.0, 0, 2.0, 0, 0, 0])))


def test_a_platform_without_legs_is_refused() -> None:
    with pytest.raises(InputError, match=r"\[hexapod\] of platform benchmark is missing"):
        hexapod(load("benchmark"))


def test_unstable_servos_are_refused_before_a_run() -> None:
    with pytest.raises(InputError, match=r"hexapod\.legs\.damping_nspm is 2e\+06, must be between"):
        HexapodPlant(replace(DAVSI, damping=2e6))
