"""No pose within a proved ball fails to hold; a supervised machine comes to none, whatever is commanded."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from otolith.core.arrays import Mat, Vec
from otolith.core.rotation import place_of
from otolith.platforms import load
from otolith.platforms.hexapod import SINGULAR_CONDITION, Hexapod
from otolith.platforms.holding import FLOOR, Ball, Joints, place_ball, way_holds
from otolith.safety.supervisor import Reason, Supervisor

DAVSI = load("davsi").six_legs()
JOINTED = replace(DAVSI, lean_base=np.radians(8.0), lean_platform=np.radians(12.0))
LONG = replace(DAVSI, stroke=(0.5, 4.0), speed=5.0, acceleration=200.0)  # legs that reach singular poses
MACHINES = pytest.mark.parametrize("machine", [DAVSI, JOINTED, LONG], ids=["davsi", "jointed", "long"])
STILL = np.zeros(6)


def ball_at(machine: Hexapod, pose: Vec) -> tuple[Joints, Ball]:
    """The ball of a pose that is near enough to itself."""
    joints, ball = Joints.of(machine), Ball.empty()
    place_of(pose, ball.place)
    place_ball(machine.lengths(pose), joints, ball)
    return joints, ball


def directions(seed: int, n: int) -> Mat:
    """Unit vectors (n, 6)."""
    found = np.random.default_rng(seed).normal(size=(n, 6))
    return found / np.linalg.norm(found, axis=1, keepdims=True)


@MACHINES
@pytest.mark.parametrize("seed", range(6))
def test_no_pose_in_a_ball_fails_to_hold(machine: Hexapod, seed: int) -> None:
    """Judged by other code: poses by Newton's method, conditions and angles by numpy."""
    rng = np.random.default_rng(seed)
    pose = rng.uniform(-1.0, 1.0, 6) * np.array([0.2, 0.2, 0.15, 0.2, 0.2, 0.3])
    if not machine.holds(pose[None])[0]:
        pose = STILL
    _, ball = ball_at(machine, pose)
    assert ball.radius[0] > FLOOR
    ends = ball.centre + 0.999 * ball.radius[0] * directions(seed, 200)
    assert machine.holds(np.array([machine.pose_of(end, near=pose) for end in ends])).all()


@MACHINES
def test_a_pose_that_does_not_hold_has_no_ball(machine: Hexapod) -> None:
    """Yaw of 90 deg is singular for joints in pairs on circles, and leans farther than any joint allows."""
    _, ball = ball_at(machine, np.array([0.0, 0.0, 0.0, 0.0, 0.0, np.radians(89.9)]))
    assert ball.radius[0] == 0.0


def test_a_way_ends_shortly_before_the_first_pose_that_does_not_hold() -> None:
    """Along yaw, in straight pieces between poses a fiftieth of a degree apart."""
    joints, ball = ball_at(LONG, STILL)
    at, reached = LONG.lengths(STILL), 0.0
    for degrees in np.arange(0.02, 91.0, 0.02):
        to = LONG.lengths(np.array([0.0, 0.0, 0.0, 0.0, 0.0, np.radians(degrees)]))
        if not way_holds(at, to, joints, ball)[0]:
            break
        at, reached = to, degrees
    yaw = np.radians(np.arange(0.0, 91.0, 0.02))
    held = LONG.holds(np.column_stack([np.zeros((len(yaw), 5)), yaw]))
    end = np.degrees(yaw[np.argmin(held)])
    assert end - 0.6 <= reached < end


hostile = st.lists(
    st.tuples(st.integers(200, 800), st.tuples(*[st.floats(-0.9, 0.9)] * 3, *[st.floats(-2.5, 2.5)] * 3)),
    min_size=1,
    max_size=4,
)


@MACHINES
@settings(derandomize=True, max_examples=12, deadline=None)
@given(stretches=hostile)
def test_no_command_whatever_reaches_a_singular_pose(
    machine: Hexapod, stretches: list[tuple[int, Vec]]
) -> None:
    """Set-points jump to poses far beyond: what is passed on holds at every tenth tick, on one branch."""
    supervisor, pose = Supervisor(machine), STILL
    for ticks, wanted in stretches:
        lengths = machine.lengths(np.array(wanted))
        for tick in range(ticks):
            supervisor.follow(lengths, STILL)
            if tick % 10:
                continue
            pose = machine.pose_of(supervisor.lengths, near=pose)
            assert machine.reaches(pose[None])[0]


def test_it_says_which_limit_of_the_pose_it_kept_and_comes_back() -> None:
    for machine, reason, words in (
        (JOINTED, Reason.JOINT, "slowed for the joint angle of leg "),
        (LONG, Reason.SINGULAR, "slowed before a singular pose, up to "),
    ):
        supervisor = Supervisor(machine)
        turned = machine.lengths(np.array([0.0, 0.0, 0.0, 0.0, 0.0, np.radians(100.0)]))
        for share in np.r_[np.linspace(0.0, 1.0, 1500), np.ones(200)]:
            yaw = np.radians(100.0) * share
            turned = machine.lengths(np.array([0.0, 0.0, 0.0, 0.0, 0.0, yaw]))
            supervisor.follow(turned, STILL)
        assert supervisor.interventions[-1].reason is reason
        assert words in str(supervisor.interventions[-1])
        home = machine.lengths(STILL)
        for _ in range(3000):
            supervisor.follow(home, STILL)
        np.testing.assert_allclose(supervisor.lengths, home, atol=1e-6)
        assert machine.condition(machine.pose_of(supervisor.lengths)) < SINGULAR_CONDITION
