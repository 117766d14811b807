import numpy as np
import pytest
from numpy.testing import assert_allclose

from otolith.core.arrays import Vec
from otolith.core.frames import GRAVITY, HEAVE, SURGE_PITCH, SWAY_ROLL, YAW, specific_force
from otolith.cueing.washout.adaptive import adaptive
from otolith.cueing.washout.classical import classical
from otolith.cueing.washout.feedforward import Washout, cued, homing, scaling
from otolith.cueing.washout.kernels import (
    ACCELERATION,
    FORCE,
    TILT,
    TILT_RATE,
    demand,
    follow_tilt,
    go_home,
    tilt_for,
)
from otolith.cueing.washout.optimal import optimal, optimal_nonlinear
from otolith.interfaces import PlatformState, Reference, Status
from otolith.plant.ideal import Ideal
from tests.cueing.washout.loop import DAVSI, Task, along, drive

EVERY = pytest.mark.parametrize("make", [classical, adaptive, optimal, optimal_nonlinear])
SIX = Task(dofs=(SURGE_PITCH, SWAY_ROLL, HEAVE, YAW))


def wild(t):
    return 6.0 * np.sin(0.9 * t) + 3.0 * (t > 2.0)


@EVERY
def test_set_points_are_where_the_commands_lead(make) -> None:
    washout, plant, state = make(SIX), Ideal(lag=0.0), PlatformState()
    rng = np.random.default_rng(1)
    for _ in range(300):
        command = washout.step(
            state, Reference(specific_force=rng.normal(size=3), angular_rate=0.3 * rng.normal(size=3))
        )
        state = plant.step(command, 0.01)
        assert_allclose(state.pose, command.pose, atol=1e-12)
        assert_allclose(state.twist, command.twist, atol=1e-12)


@EVERY
def test_the_plan_brings_the_platform_to_rest(make) -> None:
    washout, state = make(SIX), PlatformState()
    for _ in range(100):
        command = washout.step(state, Reference(specific_force=np.array([2.0, 1.0, 1.0])))
    assert np.abs(command.twist).max() > 0.01
    assert_allclose(command.twist + 0.01 * command.plan.sum(axis=0), 0.0, atol=1e-12)


@EVERY
def test_tilt_stays_below_the_threshold_whatever_the_force(make) -> None:
    run = drive(make(Task()), 20.0, along(0, wild), plant_period=0.01)
    limit = Task().platform.limits(SURGE_PITCH)[1].velocity
    assert np.abs(run.twist[:, 4]).max() <= limit * (1 + 1e-9)
    assert np.abs(run.twist[:, 4]).max() > 0.99 * limit


@EVERY
def test_sway_and_roll_mirror_surge_and_pitch(make) -> None:
    """One code for all pairs: only the sign between tilt and angle differs."""
    same = Task(platform=Task().platform.model_copy(update={"tilt_coordination": _equal_thresholds()}))
    sideways = Task(platform=same.platform, dofs=(SWAY_ROLL,))
    long = drive(make(same), 10.0, along(0, np.sin), along(1, lambda t: -0.1 * np.cos(t)), plant_period=0.01)
    lat = drive(
        make(sideways), 10.0, along(1, np.sin), along(0, lambda t: 0.1 * np.cos(t)), plant_period=0.01
    )
    assert_allclose(lat.pose[:, 1], long.pose[:, 0], atol=1e-3 * np.abs(long.pose[:, 0]).max())
    assert_allclose(lat.pose[:, 3], -long.pose[:, 4], atol=1e-3 * np.abs(long.pose[:, 4]).max())


def _equal_thresholds():
    return Task().platform.tilt_coordination.model_copy(update={"roll_degps": 3.0})


@EVERY
def test_heave_and_yaw_answer_to_their_own_signals_alone(make) -> None:
    run = drive(make(SIX), 6.0, along(2, np.sin), along(2, lambda t: 0.1 * np.sin(2 * t)), plant_period=0.01)
    assert np.abs(run.pose[:, 2]).max() > 0.01
    assert np.abs(run.pose[:, 5]).max() > 0.001
    assert_allclose(run.pose[:, [3, 4]], 0.0, atol=1e-4)


@EVERY
def test_a_reference_that_is_no_number_counts_as_none_and_is_reported(make) -> None:
    bad, none = make(Task()), make(Task())
    command = bad.step(PlatformState(), Reference(specific_force=np.array([np.nan, 0.0, 0.0])))
    silent = none.step(PlatformState(), Reference(specific_force=np.zeros(3)))
    assert command.outcome.status is Status.INVALID
    assert silent.outcome.status is Status.DECIDED
    assert_allclose(command.acceleration, silent.acceleration)


@EVERY
def test_after_an_outage_the_tilt_goes_on_from_where_it_stopped_at_rates_nobody_notices(make) -> None:
    """And ends where it would have without, 30 s later."""
    threshold, ends = DAVSI.limits(SURGE_PITCH)[1].velocity, []
    for outage in (range(600, 800), range(0)):
        washout, plant, state = make(Task()), Ideal(lag=0.0), PlatformState()
        for k in range(3800):
            force = np.nan if k in outage else 2.0
            command = washout.step(state, Reference(specific_force=np.array([force, 0.0, 0.0])))
            assert command.outcome.status is (Status.INVALID if k in outage else Status.DECIDED)
            state = plant.step(command, 0.01)
            assert abs(state.twist[4]) <= threshold + 1e-9
            if k in outage[100:]:
                assert not state.twist.any()
        ends.append(state.pose[4])
    assert ends[0] == pytest.approx(ends[1], rel=0.01)


@EVERY
def test_a_platform_that_is_not_where_it_was_sent_is_taken_from_where_it_is(make) -> None:
    """Decisions were missed, and the platform stopped on its own: it comes home from there, not beside it."""
    washout, plant, state = make(Task()), Ideal(lag=0.0), PlatformState()
    for _ in range(100):
        state = plant.step(washout.step(state, Reference(specific_force=np.array([2.0, 0.0, 0.0]))), 0.01)
    state = PlatformState(pose=np.array([0.3, 0.0, 0.0, 0.0, 0.0, 0.0]))
    plant.reset(state)
    for _ in range(4000):
        state = plant.step(washout.step(state, Reference(specific_force=np.zeros(3))), 0.01)
    assert_allclose(state.pose, 0.0, atol=1e-3)


@EVERY
def test_a_platform_that_starts_elsewhere_comes_home(make) -> None:
    washout, plant = make(SIX), Ideal(lag=0.0)
    state = PlatformState(pose=np.array([0.2, -0.1, 0.1, 0.05, -0.05, 0.1]), twist=np.full(6, 0.05))
    washout.reset(state)
    plant.reset(state)
    for _ in range(4000):
        state = plant.step(washout.step(state, Reference(specific_force=np.zeros(3))), 0.01)
    assert_allclose(state.pose, 0.0, atol=1e-3)


def test_the_transformation_gives_exactly_the_force_that_is_wanted() -> None:
    """Accelerating by a_world at attitude R, the driver feels f: R and gravity by hand, about y."""
    washout = classical(Task())
    washout.reset(PlatformState(pose=np.array([0.0, 0.0, 0.0, 0.0, 0.2, 0.0])))
    demand(washout.compiled().held, np.array([0.5, 0.0, 0.0, 0.0, 0.0, 0.0]))
    wanted = washout.memory.demand
    c, s = np.cos(0.2), np.sin(0.2)
    a_driver = (
        np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]]) @ wanted[ACCELERATION : ACCELERATION + 3]
    )
    scaled = scaling(Task().tuning)[0](np.array([0.5, 0.0, 0.0]))
    assert_allclose(wanted[FORCE : FORCE + 3], scaled)
    assert_allclose(specific_force(a_driver, np.array([0.0, 0.2, 0.0])), scaled, atol=1e-12)


def followed(washout: Washout, angles: Vec, speeds: Vec) -> Vec:
    """Rates of a tilt about y that the channels want at these angles and speeds."""
    memory, rates = washout.memory, []
    memory.largest[1], memory.change[1] = 0.05, min(memory.change[1], 0.02)
    for angle, speed in zip(angles, speeds, strict=True):
        rate = np.zeros(3)
        memory.motion[TILT + 1], memory.motion[TILT_RATE + 1] = angle, speed
        follow_tilt(washout.compiled().held, rate)
        rates.append(rate[1])
    return np.array(rates)


def test_a_tilt_closes_up_after_it_fell_behind_without_a_jump_in_rate() -> None:
    t = 0.01 * np.arange(1, 3001)
    target = 0.2 * (1 - np.exp(-t)) ** 2
    rates = followed(classical(Task()), target, 0.4 * (1 - np.exp(-t)) * np.exp(-t))
    assert rates.max() == pytest.approx(0.05)
    assert np.abs(np.diff(rates)).max() < 0.01 * 0.5
    assert 0.01 * rates.sum() == pytest.approx(0.2, abs=1e-4)


def test_a_tilt_turns_no_sooner_than_the_platform_can() -> None:
    washout = classical(Task())
    washout.memory.change[1] = 0.02
    rates = followed(washout, np.full(10, 1.0), np.zeros(10))
    assert_allclose(rates, [0.02, 0.04, *[0.05] * 8])


def test_homing_has_the_poles_it_was_given() -> None:
    washout, p = classical(Task()), np.exp(-0.02)
    washout.memory.homing[:] = homing(2.0, 0.01)
    washout.memory.home[:] = 1.0
    v = []
    for _ in range(200):
        twist = np.zeros(6)
        go_home(washout.compiled().held, twist)
        v.append(twist[0])
    assert_allclose(v[2:] - 2 * p * np.array(v[1:-1]) + p**2 * np.array(v[:-2]), 0.0, atol=1e-13)


def test_tilt_gives_the_force_it_was_asked_for() -> None:
    h = 1e-6
    for force in (-3.0, 0.0, 2.0):
        angle, rate = tilt_for(force, 1.0)
        assert GRAVITY * np.sin(angle) == pytest.approx(force)
        assert rate == pytest.approx((tilt_for(force + h, 1.0)[0] - angle) / h, rel=1e-5)
    assert tilt_for(20.0, 1.0)[1] == 0.0


def test_cued_axes_are_those_of_the_task() -> None:
    assert_allclose(cued(Task()), [1, 0, 0, 0, 1, 0])
    assert_allclose(cued(SIX), np.ones(6))
