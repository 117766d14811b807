"""The law that stops a platform, judged by integrating its motion finely and by brute force over commands."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from otolith.core.arrays import Mat
from otolith.core.frames import HEAVE, SURGE_PITCH, SWAY_ROLL, YAW
from otolith.interfaces import Outcome, PlatformState, Status
from otolith.platforms import load, parse_platform
from otolith.safety.law import EASE, Reach, advance, move, safe, stop
from otolith.safety.stopping import Stopping

PERIOD = 0.01
UNHURRIED = settings(deadline=None, max_examples=40)
INVALID = Outcome(status=Status.INVALID)
SHARES = st.floats(-1.0, 1.0, allow_nan=False, width=32)
LOPSIDED = parse_platform(
    """
    name = "lopsided"
    [surge]
    position_m = [-0.006, 20.0]
    velocity_mps = 3.0
    acceleration_mps2 = 1.0
    [pitch]
    angle_deg = [-1.0, 12.0]
    rate_degps = 8.0
    acceleration_degps2 = 15.0
    """,
    "lopsided.toml",
)


def law(name: str = "davsi", *, lag: float = 0.01, circle: float | None = None) -> Stopping:
    platform = LOPSIDED if name == "lopsided" else load(name)
    pairs = (SURGE_PITCH,) if name == "lopsided" or circle is None else (SURGE_PITCH, SWAY_ROLL)
    alone = (HEAVE, YAW) if name == "davsi" else ()
    return Stopping(platform, (*pairs, *alone), circle=circle, lag=lag, period=PERIOD)


def random_motion(reach: Reach, shares: list[float]) -> Mat:
    """A motion within the limits of place, speed and acceleration on every cued axis."""
    motion = np.zeros((3, 6))
    for i in np.flatnonzero(reach.command > 0.0):
        place, speed, acceleration = (shares[3 * i + k] for k in range(3))
        motion[0, i] = 0.5 * (reach.low[i] + reach.high[i] + place * (reach.high[i] - reach.low[i]))
        motion[1, i] = speed * reach.speed[i]
        motion[2, i] = acceleration * min(reach.command[i], reach.speed[i] / PERIOD)
    return motion


def outside(motion: Mat, reach: Reach) -> float:
    """How far the places are beyond the reach, largest of all axes and of the circle."""
    cued = reach.command > 0.0
    beyond = np.maximum(reach.low - motion[0], motion[0] - reach.high)[cued].max()
    return float(max(beyond, math.hypot(motion[0, 0], motion[0, 1]) - reach.circle))


def path(motion: Mat, u: np.ndarray, reach: Reach, parts: int = 4) -> list[Mat]:
    """The motion at several moments within a period under one held command."""
    found = []
    for k in range(1, parts + 1):
        then = motion.copy()
        move(then, u, reach.lag, reach.period * k / parts)
        found.append(then)
    return found


@pytest.mark.parametrize("lag", [0.0, 0.003, 0.05])
def test_motion_under_held_commands_is_that_of_the_differential_equation(lag: float) -> None:
    rng = np.random.default_rng(5)
    start, u = rng.normal(size=(3, 6)), rng.normal(size=6)
    if lag == 0.0:
        start[2] = u

    def flow(_: float, y: np.ndarray) -> np.ndarray:
        _p, v, a = y.reshape(3, 6)
        return np.concatenate([v, a, (u - a) / lag if lag else np.zeros(6)])

    theirs = solve_ivp(flow, (0.0, 0.13), start.ravel(), rtol=1e-10, atol=1e-12).y[:, -1].reshape(3, 6)
    move(start, u, lag, 0.13)
    assert_allclose(start, theirs, atol=1e-8)


@pytest.mark.parametrize("name", ["davsi", "thesis", "lopsided"])
@UNHURRIED
@given(shares=st.lists(SHARES, min_size=18, max_size=18))
def test_from_every_safe_state_it_comes_to_rest_inside(name: str, shares: list[float]) -> None:
    """At all times, within periods too; |w| falls, so the speed never passes the larger of v and w."""
    stopping = law(name)
    reach, motion, u = stopping.reach, random_motion(stopping.reach, shares), np.empty(6)
    if not safe(motion, reach) or outside(motion, reach) > 0.0:
        return
    fastest = np.maximum(np.abs(motion[1]), np.abs(motion[1] + reach.lag * motion[2]))
    for _ in range(500):
        stop(motion, reach, u)
        assert (np.abs(u) <= reach.command * (1.0 + 1e-9)).all()
        for then in path(motion, u, reach):
            assert outside(then, reach) < 2e-9
            assert (np.abs(then[1]) <= fastest + 1e-9).all()
        advance(motion, u, reach)
        assert safe(motion, reach)
    assert np.abs(motion[1:]).max() < 1e-6


@UNHURRIED
@given(shares=st.lists(SHARES, min_size=18, max_size=18))
def test_in_a_circle_it_stops_on_a_straight_way_inside(shares: list[float]) -> None:
    stopping = law("davsi-4dof", circle=0.165)
    reach, motion, u = stopping.reach, random_motion(stopping.reach, shares), np.empty(6)
    if not safe(motion, reach) or outside(motion, reach) > 0.0:
        return
    leading = [motion[0, :2] + reach.lag * motion[1, :2]]
    for _ in range(300):
        stop(motion, reach, u)
        for then in path(motion, u, reach):
            assert outside(then, reach) < 2e-9
        advance(motion, u, reach)
        leading.append(motion[0, :2] + reach.lag * motion[1, :2])
    assert np.abs(motion[1:]).max() < 1e-6
    way = np.array(leading)
    whole = way[-1] - way[0]
    across = np.abs(whole[0] * (way - way[0])[:, 1] - whole[1] * (way - way[0])[:, 0])
    assert across.max() < 1e-9


@pytest.mark.parametrize("name", ["davsi", "lopsided"])
@UNHURRIED
@given(shares=st.lists(SHARES, min_size=18, max_size=18), data=st.data())
def test_interruptions_by_any_commands_that_keep_it_safe_do_no_harm(
    name: str, shares: list[float], data: st.DataObject
) -> None:
    """Good and bad decisions in any order: whatever came before, the law goes on from a safe state."""
    stopping = law(name)
    reach, motion, u = stopping.reach, random_motion(stopping.reach, shares), np.empty(6)
    if not safe(motion, reach) or outside(motion, reach) > 0.0:
        return
    rng = np.random.default_rng(data.draw(st.integers(0, 2**32 - 1)))
    for _ in range(200):
        stop(motion, reach, u)
        wild = rng.uniform(-1.0, 1.0, 6) * np.minimum(reach.command, reach.speed / PERIOD)
        tried = motion.copy()
        advance(tried, wild, reach)
        chosen = wild if rng.random() < 0.7 and safe(tried, reach) else u.copy()
        for then in path(motion, chosen, reach, parts=3):
            assert outside(then, reach) < 1e-5  # between nodes a command that was no law's may pass the end
        advance(motion, chosen, reach)
        assert safe(motion, reach)
        assert outside(motion, reach) < 1e-8


def test_no_command_sequence_stops_sooner_than_full_braking() -> None:
    """Brute force: of all three-level sequences none ends at rest nearer than full braking does."""
    reach = law("lopsided", lag=0.0).reach
    U, q0, w0 = reach.command[0], 0.0, 0.027
    distances = []
    for code in range(3**6):
        q, w = q0, w0
        for k in range(6):
            u = ((code // 3**k) % 3 - 1) * U
            q, w = q + PERIOD * w + 0.5 * PERIOD**2 * u, w + PERIOD * u
            if w <= 0.0:
                break
        if w <= 0.0:
            distances.append(q)
    motion = np.zeros((3, 6))
    motion[1, 0] = w0
    tight = reach._replace(high=np.full(6, min(distances) + 1e-4))
    assert safe(motion, tight)
    assert not safe(motion, reach._replace(high=np.full(6, min(distances) - 1e-4)))


@pytest.mark.parametrize("name", ["davsi", "thesis", "lopsided"])
@pytest.mark.parametrize("share", [0.001, 0.01, 0.05])
@pytest.mark.parametrize("axis", [0, 4])
@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize("period", [PERIOD, 0.1])
def test_from_rest_outside_it_moves_back_inside_monotonically(
    name: str, share: float, axis: int, side: float, period: float
) -> None:
    stopping = law(name)
    reach, u = stopping.reach._replace(period=period), np.empty(6)
    end, span = (reach.high if side > 0.0 else reach.low)[axis], reach.high[axis] - reach.low[axis]
    motion = np.zeros((3, 6))
    motion[0, axis] = end + side * share * span
    places = [motion[0, axis]]
    for _ in range(3000):
        stop(motion, reach, u)
        assert abs(u[axis]) <= reach.command[axis]
        advance(motion, u, reach)
        assert abs(motion[1, axis]) <= reach.speed[axis]
        places.append(motion[0, axis])
    assert all(side * (later - sooner) <= 1e-12 for sooner, later in pairwise(places))
    assert outside(motion, reach) <= 0.0
    assert np.abs(motion[1:]).max() < 1e-6


def test_from_outside_a_circle_it_comes_back_along_the_radius() -> None:
    stopping = law("davsi-4dof", circle=0.165)
    reach, motion, u = stopping.reach, np.zeros((3, 6)), np.empty(6)
    motion[0, :2] = 0.17 * np.array([0.6, -0.8])
    radii = [0.17]
    for _ in range(600):
        stop(motion, reach, u)
        advance(motion, u, reach)
        radii.append(math.hypot(*motion[0, :2]))
        assert_allclose(motion[0, 0] * -0.8, motion[0, 1] * 0.6, atol=1e-12)
    assert all(later <= sooner + 1e-12 for sooner, later in pairwise(radii))
    assert radii[-1] <= 0.165
    assert np.abs(motion[1:]).max() < 1e-6


@pytest.mark.parametrize("circle", [None, 1e6])
@given(shares=st.lists(SHARES, min_size=6, max_size=6))
@UNHURRIED
def test_with_room_to_spare_no_axis_is_slowed_harder_than_is_comfortable(
    circle: float | None, shares: list[float]
) -> None:
    """From the largest speed in `EASE`, from less in less; surge and sway share one stop in a circle."""
    stopping = law("davsi-4dof", circle=circle)
    far = np.full(6, 1e6)
    reach, u = stopping.reach._replace(low=-far, high=far), np.empty(6)
    motion = np.zeros((3, 6))
    motion[1] = shares * reach.speed * (reach.command > 0.0)
    stop(motion, reach, u)
    assert (np.abs(u) <= reach.speed / EASE * (1.0 + 1e-9)).all()


@pytest.mark.parametrize("tiny", [1e-16, 1e-18, 1e-25, 1e-38, 1e-300])
def test_a_speed_that_is_only_rounding_counts_as_none(tiny: float) -> None:
    """It fits into the room any number of times; an integer would not hold how many."""
    stopping = law("davsi-4dof", circle=0.165)
    motion, u, with_tiny = np.zeros((3, 6)), np.empty(6), np.empty(6)
    motion[1, 0] = 0.05
    stop(motion, stopping.reach, u)
    motion[1, 1] = tiny
    assert safe(motion, stopping.reach)
    stop(motion, stopping.reach, with_tiny)
    assert_allclose(with_tiny, u, atol=1e-12)


def test_at_rest_there_is_nothing_to_plan() -> None:
    stopping = law("davsi")
    stopping.reset(PlatformState(twist=np.array([0.3, 0, 0, 0, 0, 0])))
    assert len(stopping.rest(INVALID).plan) > 0
    stopping.reset(PlatformState())
    command = stopping.rest(INVALID)
    assert not command.acceleration.any()
    assert len(command.plan) == 0


def test_a_plan_goes_on_to_rest_where_the_law_takes_it() -> None:
    stopping = law("davsi")
    stopping.reset(PlatformState(twist=np.array([0.3, 0.0, 0.0, 0.0, 0.02, 0.0])))
    given_plan = np.zeros((20, 6))
    given_plan[:, 0] = 1.0
    command = stopping.decided(given_plan, INVALID)
    motion = np.zeros((3, 6))
    motion[1, [0, 4]] = 0.3, 0.02
    advance(motion, command.acceleration, stopping.reach)
    assert_allclose(command.pose, motion[0])
    assert_allclose(command.twist, motion[1])
    assert_allclose(command.plan[:19], given_plan[1:])
    for u in command.plan:
        advance(motion, np.ascontiguousarray(u), stopping.reach)
        assert outside(motion, stopping.reach) <= 0.0
    for _ in range(20):
        advance(motion, np.zeros(6), stopping.reach)
    assert np.abs(motion[1:]).max() < 1e-6


def test_a_plan_of_any_length_is_followed_to_its_end() -> None:
    stopping = law("davsi")
    command = stopping.decided(np.tile([1e-4, 0, 0, 0, 0, 0], (3000, 1)), INVALID)
    assert_allclose(command.plan[:2999, 0], 1e-4)
    assert len(command.plan) > 2999
    assert command.plan[2999, 0] < 0.0


def test_at_its_limit_in_coarse_periods_it_turns_back_within_one() -> None:
    """From q at the limit and still moving, which is not safe: the next node is inside all the same."""
    reach = law("thesis", lag=0.0).reach._replace(period=0.1)
    motion, u = np.zeros((3, 6)), np.empty(6)
    motion[0, 0], motion[1, 0] = 0.5, 1e-3
    for _ in range(30):
        stop(motion, reach, u)
        advance(motion, u, reach)
        assert motion[0, 0] <= 0.5 + 1e-12
    assert abs(motion[1, 0]) < 1e-9


def test_what_is_no_measurement_leaves_what_is_believed() -> None:
    stopping = law("davsi")
    stopping.reset(PlatformState(twist=np.array([0.4, 0, 0, 0, 0, 0])))
    first = stopping.rest(INVALID)
    assert not stopping.observe(PlatformState(pose=np.full(6, np.nan)))
    again = stopping.rest(INVALID)
    assert 0.0 < again.twist[0] < first.twist[0] < 0.4


def test_axes_that_are_not_cued_stay_out_of_it() -> None:
    stopping = Stopping(load("davsi"), (SURGE_PITCH,), lag=0.01, period=PERIOD)
    stopping.reset(PlatformState(pose=np.full(6, 0.05), twist=np.full(6, 0.05)))
    command = stopping.rest(INVALID)
    idle = [1, 2, 3, 5]
    assert not command.acceleration[idle].any()
    assert not command.plan[:, idle].any()
    assert not command.pose[idle].any()


def test_the_law_asks_for_no_more_than_the_machine_may_give_and_be_asked_for() -> None:
    surge = load("davsi").surge
    assert surge is not None
    surge = surge.model_copy(update={"acceleration_mps2": 4.0, "command_mps2": 9.0})
    hasty = load("davsi").model_copy(update={"surge": surge})
    assert Stopping(hasty, (SURGE_PITCH,), lag=0.01, period=PERIOD).reach.command[0] == 4.0
    gentle = hasty.model_copy(update={"surge": surge.model_copy(update={"command_mps2": 3.0})})
    assert Stopping(gentle, (SURGE_PITCH,), lag=0.01, period=PERIOD).reach.command[0] == 3.0
