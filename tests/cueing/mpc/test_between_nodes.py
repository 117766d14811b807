"""What legs may do between two nodes: closed forms, and motions that could leave the computed bound."""

from dataclasses import replace

import numpy as np
import pytest

from otolith.core.arrays import Mat, Vec
from otolith.cueing.mpc.between_nodes import Between, Reach
from otolith.plant.ideal import axis_dynamics, move_axes
from otolith.platforms import load
from otolith.platforms.hexapod import Hexapod

LEGS = load("davsi").six_legs()
LAG, PERIOD, LEAD = 0.01, 0.01, 0.087
PARTS = 20  # of a period
HEIGHT = 1.6  # [m] of upright legs
NEARLY = 0.98  # of a limit, at one node, so that the other keeps it too
BOX = np.array([0.5, 0.5, 0.4, 0.4, 0.4, 0.4])
SPEED, GROWTH = np.array([0.8, 0.8, 0.6, 0.05, 0.05, 0.7]), np.array([7.1, 7.1, 10.0, 4.5, 4.5, 8.9])


def computed(legs: Hexapod, reach: Reach, *, lag: float = LAG, lead: float = LEAD) -> Between:
    return Between.of(legs, reach, lead=lead, lag=lag, period=PERIOD)


def upright(acceleration: float = LEGS.acceleration) -> Hexapod:
    """Parallel legs: whatever moves along x, all of them have the length √(h² + x²)."""
    return replace(LEGS, anchors=LEGS.joints - [0.0, 0.0, HEIGHT], acceleration=acceleration)


def test_legs_that_are_linear_in_the_pose_leave_only_the_parabola_of_the_length() -> None:
    """Upright legs that only rise: an acceleration that turns within a period bends its parabola most."""
    legs, rise = upright(), np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    found = computed(legs, Reach(np.array([-0.2, 0.2])[:, None] * rise, 0.4 * rise, 9.0 * rise))
    steepest = legs.acceleration * (2.0 / (1.0 - np.exp(-PERIOD / LAG)) - 1.0)
    assert found.length == pytest.approx(steepest * PERIOD**2 / 8, rel=1e-9)
    assert found.speed == pytest.approx(0.0, abs=1e-15)
    assert found.acceleration == pytest.approx(0.0, abs=1e-13)


def along_x(low: float, high: float, speed: float, acceleration: float) -> Reach:
    surge = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    return Reach(np.array([low, high])[:, None] * surge, speed * surge, acceleration * surge)


@pytest.mark.parametrize("lead", [0.0, 1.0])
@pytest.mark.parametrize(("lag", "longest"), [(PERIOD / 5000, PERIOD), (PERIOD * 1000, PERIOD / 2)])
def test_a_leg_that_swings_about_the_upright_has_a_closed_form(
    lag: float, longest: float, lead: float
) -> None:
    """There L̈ = (v² + x a)/h, whose rate at a given a is 3 v a/h.

    A quick lag takes the acceleration to its end at once, and L̈ may change at that rate for the whole period.
    A slow one takes it there along a line: half of the way at most counts, one half with either end's a.
    """
    v, a, slow = 2.0, 5.0, 1e-6  # legs that may hardly speed up leave what is not linear alone
    found = computed(upright(acceleration=slow), along_x(-1e-6, 1e-6, v, a), lag=lag, lead=lead)
    off = 3 * v * a / HEIGHT * longest
    whole = 1.0 - np.exp(-PERIOD / lag)
    assert found.acceleration == pytest.approx(off, rel=0.01)
    assert found.speed == pytest.approx(off * PERIOD / 2 + off * lag, rel=0.01)
    of_speed = found.speed * lead + off * lag * PERIOD / 2  # the leading speed's share, and that of the lag
    parabola = slow * (2.0 / whole - 1.0) * PERIOD**2 / 8
    assert found.length == pytest.approx(of_speed + off * PERIOD**2 / 8 + parabola, rel=0.01)


@pytest.mark.parametrize("reach", [(-0.3, 0.05), (-0.05, 0.3)])
def test_a_leg_that_swings_at_a_steady_speed_has_a_closed_form(reach: tuple[float, float]) -> None:
    """There L̈ = h² v²/L³, whose rate is 3 h² x v³/L⁵, the largest at the farther end of this reach."""
    v, x = 2.0, 0.3
    found = computed(upright(), along_x(*reach, v, 0.0), lag=PERIOD * 1000)
    rate = 3 * HEIGHT**2 * x * v**3 / np.hypot(HEIGHT, x) ** 5
    assert found.acceleration == pytest.approx(rate * PERIOD / 2, rel=0.01)
    assert found.acceleration <= rate * PERIOD / 2


def keeps(legs: Hexapod, motion: Mat) -> bool:
    """Whether legs and axes are within their limits, but for a thousandth."""
    moved, some = legs.leg_motion(*motion), 1.001
    axes = (np.abs(motion[1]) <= some * SPEED).all() and (np.abs(motion[2]) <= some * GROWTH).all()
    slow = np.abs(moved.speed).max() <= some * legs.speed
    return bool(axes and slow and np.abs(moved.acceleration).max() <= some * legs.acceleration)


def at_limits(legs: Hexapod, rng: np.random.Generator) -> tuple[Mat, Vec] | None:
    """A motion (3, 6) with legs as fast as they may be, and axes' acceleration (6,) with all legs' reversed.

    What changes L̈ is then reversed as well: nothing departs more from a chord.
    """
    pose = legs.pose_of(rng.uniform(*legs.stroke, 6))
    if (np.abs(pose) > BOX).any():
        return None
    J = np.stack([legs.leg_motion(pose, unit, np.zeros(6)).speed for unit in np.eye(6)], axis=1)

    def rates(of_legs: Vec, axes: Vec) -> Vec:
        return np.clip(np.linalg.solve(J, of_legs), -NEARLY * axes, NEARLY * axes)

    twist = rates(NEARLY * legs.speed * rng.choice([-1, 1], 6), SPEED)
    offset = legs.leg_motion(pose, twist, np.zeros(6)).acceleration
    growth = NEARLY * legs.acceleration * rng.choice([-1, 1], 6)
    return np.array([pose, twist, rates(growth - offset, GROWTH)]), rates(-growth - offset, GROWTH)


def leading(legs: Hexapod, motions: list[Mat], lag: float, lead: float) -> tuple[Mat, Mat, Mat]:
    """What the rows bound, of all legs (n, 6): leading length, leading speed, acceleration."""
    moves = [legs.leg_motion(*motion) for motion in motions]
    L, v, a = (np.array([getattr(one, of) for one in moves]) for of in ("length", "speed", "acceleration"))
    ahead = v + lag * a
    return L + lag * v + lead * ahead, ahead, a


@pytest.mark.parametrize(
    ("acceleration", "lag", "lead", "least"),
    [
        (7.8, LAG, LEAD, (0.6, 0.3, 0.5)),
        (7.8, 5 * PERIOD, 1.0, (0.5, 0.5, 0.6)),  # nearly all of the bounds comes from what is not linear
        (0.5, LAG, LEAD, (0.7, 0.5, 0.87)),  # here, much from velocities
    ],
)
def test_no_motion_departs_from_what_is_linear_by_more_than_the_bound(
    acceleration: float, lag: float, lead: float, least: tuple[float, float, float]
) -> None:
    """Lengths and speeds depart from their chords, accelerations from the curve of the lag."""
    legs, rng, worst = replace(LEGS, acceleration=acceleration), np.random.default_rng(3), np.zeros(3)
    bound = np.array(computed(legs, Reach(np.array([-BOX, BOX]), SPEED, GROWTH), lag=lag, lead=lead))
    A, B = axis_dynamics(lag, PERIOD / PARTS)
    line = np.linspace(0.0, 1.0, PARTS + 1)[:, None]
    curve = np.expm1(-line * PERIOD / lag) / np.expm1(-PERIOD / lag)
    for _ in range(1500):
        if (drawn := at_limits(legs, rng)) is None:
            continue
        motion, last = drawn
        command = motion[2] - (last - motion[2]) / np.expm1(-PERIOD / lag)
        motions = [motion.copy()]
        for _ in range(PARTS):
            move_axes(motion, A, B, command)
            motions.append(motion.copy())
        if not (keeps(legs, motions[0]) and keeps(legs, motions[-1])):
            continue
        values = leading(legs, motions, lag, lead)
        for i, (one, along) in enumerate(zip(values, (line, line, curve), strict=True)):
            worst[i] = max(worst[i], np.abs(one - one[0] - along * (one[-1] - one[0])).max())
    assert (worst <= bound).all()
    assert (worst >= least * bound).all()  # a bound that says something
