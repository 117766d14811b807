"""Reach of cranks, the balls in which their poses hold, and the supervisor: against looking at poses."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from otolith.core.arrays import Vec
from otolith.core.frames import AXES
from otolith.core.rotation import place_of
from otolith.platforms.combined_limits import holds_all
from otolith.platforms.hexapod import DEAD_CENTRE, Hexapod
from otolith.platforms.holding import FLOOR, Ball, Joints, place_ball
from otolith.platforms.reach import reach_ends
from otolith.safety.supervisor import Reason, Supervisor
from tests.platforms.cranks import machine

STILL = np.zeros(6)
NARROW, WIDE = machine(), machine(range_deg=120.0, seed=1)  # whose reach ends with angles; with dead centres
JOINTED = replace(NARROW, lean_base=np.radians(18.0), lean_platform=np.radians(12.0))
MACHINES = pytest.mark.parametrize("hexapod", [NARROW, WIDE, JOINTED], ids=["narrow", "wide", "jointed"])


@MACHINES
@pytest.mark.parametrize("axis", AXES)
def test_reach_ends_where_the_first_pose_fails(hexapod: Hexapod, axis: str) -> None:
    """By 4,000 poses one after the other: none before the end fails, and the next one does."""
    i = AXES.index(axis)
    for end in reach_ends(hexapod)[axis]:
        poses = np.zeros((4000, 6))
        poses[:, i] = np.linspace(0.0, 1.002 * end.at, len(poses))
        out = ~hexapod.reaches(poses)
        assert out.any()
        assert poses[np.argmax(out), i] == pytest.approx(end.at, rel=2e-3)


def test_every_reason_of_an_end_is_named() -> None:
    ends = [
        end.why
        for hexapod in (NARROW, WIDE, JOINTED)
        for pair in reach_ends(hexapod).values()
        for end in pair
    ]
    for words in ("at its highest", "at its lowest", "near its dead centre", "base joint", "platform joint"):
        assert any(words in why for why in ends), words


@MACHINES
@pytest.mark.parametrize("seed", range(4))
def test_no_pose_in_a_ball_fails_to_hold(hexapod: Hexapod, seed: int) -> None:
    rng = np.random.default_rng(seed)
    pose = rng.uniform(-1.0, 1.0, 6) * [0.01, 0.01, 0.01, 0.04, 0.04, 0.04]
    joints, ball = Joints.of(hexapod), Ball.empty()
    place_of(pose, ball.place)
    place_ball(hexapod.lengths(pose), joints, ball)
    assert ball.radius[0] > FLOOR
    ways = rng.normal(size=(200, 6))
    ends = ball.centre + 0.999 * ball.radius[0] * ways / np.linalg.norm(ways, axis=1, keepdims=True)
    poses = np.array([hexapod.pose_of(end, near=pose) for end in ends])
    assert hexapod.holds(poses).all()
    np.testing.assert_allclose(hexapod.lengths(poses), ends, atol=1e-9)  # on one branch


far = st.lists(st.tuples(*[st.floats(-2.0, 2.0)] * 6), min_size=1, max_size=4)


@MACHINES
@settings(derandomize=True, max_examples=5, deadline=None)
@given(wanted=far)
def test_no_command_whatever_leaves_what_the_cranks_can_do(hexapod: Hexapod, wanted: list[Vec]) -> None:
    """Arcs jump to twice their range: limits are kept at every tick, and every tenth pose is in reach."""
    supervisor, pose, given_ = Supervisor(hexapod), STILL, []
    for share in wanted:
        for tick in range(400):
            supervisor.follow(hexapod.stroke[1] * np.array(share), STILL)
            given_.append(supervisor.lengths.copy())
            if tick % 10 == 0:
                pose = hexapod.pose_of(supervisor.lengths, near=pose)
                assert hexapod.reaches(pose[None])[0]
    speeds = np.diff(np.array(given_), axis=0) / 1e-3
    assert np.abs(speeds).max() <= hexapod.speed * (1 + 1e-9)
    assert np.abs(np.diff(speeds, axis=0)).max() <= 1e-3 * hexapod.acceleration * (1 + 1e-6)


def test_the_supervisor_stops_before_a_dead_centre_and_says_so() -> None:
    supervisor = Supervisor(WIDE)
    for arc in np.linspace(0.0, 1.0, 1500):
        supervisor.follow(WIDE.lengths(STILL) + arc * 0.05, STILL)
    dead = [one for one in supervisor.interventions if one.reason is Reason.DEAD_CENTRE]
    assert dead
    assert "slowed before the dead centre of a crank" in str(dead[0])
    leverage = WIDE.leverages(WIDE.pose_of(supervisor.lengths)[None]).min()
    assert DEAD_CENTRE < leverage < 2.0 * DEAD_CENTRE


def test_set_points_that_no_rod_reaches_brake() -> None:
    supervisor = Supervisor(NARROW)
    for _ in range(200):
        supervisor.follow(NARROW.lengths(np.array([0.0, 0.0, 0.3, 0.0, 0.0, 0.0])), STILL)
    assert supervisor.interventions[-1].reason is Reason.INVALID
    assert NARROW.reaches(NARROW.pose_of(supervisor.lengths)[None])[0]


def test_what_four_axes_do_together_is_proved_of_cranks() -> None:
    """Of a disc of 15 mm with tilts of 3 deg no pose fails, by 20,000 of them; 60 mm are refused."""
    assert holds_all(NARROW, 0.015, np.radians(3.0))
    rng = np.random.default_rng(0)
    poses = np.zeros((20_000, 6))
    poses[:, :2] = rng.uniform(-0.015, 0.015, (20_000, 2))
    poses[:, 3:5] = rng.uniform(-1.0, 1.0, (20_000, 2)) * np.radians(3.0)
    assert NARROW.reaches(poses[np.hypot(poses[:, 0], poses[:, 1]) <= 0.015]).all()
    assert not holds_all(NARROW, 0.06, np.radians(3.0))
