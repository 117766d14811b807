"""What legs may do between two nodes: a closed form, and motions that could leave the computed bound."""

from dataclasses import replace

import numpy as np
import pytest

from otolith.core.arrays import Mat, Vec
from otolith.cueing.mpc.between_nodes import Between, Reach
from otolith.plant.ideal import axis_dynamics, move_axes
from otolith.platforms import load
from otolith.platforms.hexapod import Hexapod, LegMotion

LEGS = load("davsi").six_legs()
LAG, PERIOD, LEAD = 0.01, 0.01, 0.087
PARTS = 20  # of a period
BOX = np.array([0.5, 0.5, 0.4, 0.4, 0.4, 0.4])


def computed(legs: Hexapod, reach: Reach) -> Between:
    return Between.of(legs, reach, lead=LEAD, lag=LAG, period=PERIOD)


def test_legs_that_are_linear_in_the_pose_leave_only_the_parabola_of_the_length() -> None:
    """Upright legs that only rise: an acceleration that turns within a period bends its parabola most."""
    upright = replace(LEGS, anchors=LEGS.joints - [0.0, 0.0, 1.6])
    rise = np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    found = computed(upright, Reach(np.array([-0.2, 0.2])[:, None] * rise, 0.4 * rise, 9.0 * rise))
    steepest = upright.acceleration * (2.0 / (1.0 - np.exp(-PERIOD / LAG)) - 1.0)
    assert found.length == pytest.approx(steepest * PERIOD**2 / 8, rel=1e-9)
    assert found.speed == pytest.approx(0.0, abs=1e-15)
    assert found.acceleration == pytest.approx(0.0, abs=1e-13)


def legs_of(motion: Mat) -> LegMotion:
    return LEGS.leg_motion(motion[0], motion[1], motion[2])


def at_limits(rng: np.random.Generator, reach: Reach) -> tuple[Mat, Vec] | None:
    """A motion (3, 6) with legs as fast as they may be, and a command that turns their acceleration round."""
    pose = LEGS.pose_of(rng.uniform(*LEGS.stroke, 6))
    if (np.abs(pose) > BOX).any():
        return None
    J = np.stack([LEGS.leg_motion(pose, unit, np.zeros(6)).speed for unit in np.eye(6)], axis=1)
    twist = np.clip(np.linalg.solve(J, LEGS.speed * rng.choice([-1, 1], 6)), -reach.speed, reach.speed)
    ends = []
    for _ in range(2):
        growth = np.linalg.solve(J, LEGS.acceleration * rng.choice([-1, 1], 6))
        growth = np.clip(growth, -reach.acceleration, reach.acceleration)
        fastest = np.abs(LEGS.leg_motion(pose, twist, growth).acceleration).max()
        ends.append(growth * min(1.0, LEGS.acceleration / fastest))
    return np.array([pose, twist, ends[0]]), ends[0] + (ends[1] - ends[0]) / (1.0 - np.exp(-PERIOD / LAG))


def leading(motions: list[Mat]) -> tuple[Mat, Mat, Mat]:
    """What the rows bound, of all legs (n, 6): leading length, leading speed, acceleration."""
    moves = [legs_of(motion) for motion in motions]
    L, v, a = (np.array([getattr(one, of) for one in moves]) for of in ("length", "speed", "acceleration"))
    ahead = v + LAG * a
    return L + LAG * v + LEAD * ahead, ahead, a


def test_no_motion_leaves_what_both_nodes_hold_by_more_than_the_bound() -> None:
    speed, growth = np.array([0.8, 0.8, 0.6, 0.05, 0.05, 0.7]), np.array([7.1, 7.1, 10.0, 4.5, 4.5, 8.9])
    reach = Reach(np.array([-BOX, BOX]), speed, growth)
    bound, rng, worst = np.array(computed(LEGS, reach)), np.random.default_rng(3), np.zeros(3)
    A, B = axis_dynamics(LAG, PERIOD / PARTS)
    for _ in range(200):
        if (drawn := at_limits(rng, reach)) is None:
            continue
        motion, command = drawn
        motions = [motion.copy()]
        for _ in range(PARTS):
            move_axes(motion, A, B, command)
            motions.append(motion.copy())
        for i, values in enumerate(leading(motions)):
            over = (values - np.maximum(values[0], values[-1])).max()
            under = (np.minimum(values[0], values[-1]) - values).max()
            worst[i] = max(worst[i], over, under)
    assert (worst <= bound).all()
    assert (worst >= 0.1 * bound).all()  # a bound that says something
