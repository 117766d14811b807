"""The axis test in a world of virtual time, and what a gate does not let pass."""

from dataclasses import dataclass

import numpy as np
import pytest

from otolith.core.errors import InputError
from otolith.core.frames import AXES
from otolith.interfaces import Cueing
from otolith.live.audit import audit
from otolith.live.axis_test import CRANKS, LASTS, LEGS, AxisRefused, AxisTest, goal_of, movable, profile
from otolith.live.controller import ControllerInbox
from otolith.live.core.gate import Gate
from otolith.live.messages import Plan, State, Word
from otolith.live.world import World, arm_and_engage, sines
from otolith.platforms import Platform, load, parse_platform
from otolith.platforms.template import template
from tests.live.conftest import PARK


@dataclass
class Controlling:
    """An axis test in the place of a world's controller."""

    test: AxisTest
    cueing: Cueing

    def tick(self, now_ns: int, inbox: ControllerInbox) -> Plan:
        return self.test.tick(now_ns, inbox.report)


def test_every_axis_moves_alone_by_its_way_and_comes_back(
    washout: Cueing, machine: Platform, gate: Gate
) -> None:
    names = movable(gate)
    assert names == ["surge", "sway", "roll", "pitch"]
    test = AxisTest([goal_of(name, machine) for name in names], gate, gate.reach.period)
    test.check(names)
    world = World(washout, machine, drive=sines({}), park=PARK)
    world.controller = Controlling(test, washout)  # type: ignore[assignment]
    arm_and_engage(world)
    for name in names:
        first = len(world.trace)
        world.run(world.seconds + LASTS + 0.2)
        pose = np.array([row.motion[0] for row in world.trace[first:]])
        farthest = np.zeros(6)
        farthest[AXES.index(name)] = 10e-3 if name in AXES[:3] else np.radians(1.0)
        np.testing.assert_allclose(pose.max(axis=0), farthest, rtol=0.01, atol=1e-6)
        assert pose.min() > -2e-5
        assert np.abs(pose[-1]).max() < 2e-5
        assert max(np.abs(row.motion[1]).max() for row in world.trace[first:]) < 0.02
        world.say(Word.RETURN, Word.ENGAGE)
        world.run(world.seconds + 0.1)
        assert world.state is State.READY
        world.say(Word.ENGAGE)
    assert test.begun == len(names)
    assert audit(world.trace, machine) == []


def test_a_leg_alone_becomes_longer_by_10_mm() -> None:
    platform = load("davsi")
    hexapod = platform.six_legs()
    rest = hexapod.lengths(np.zeros(6))
    for leg, name in enumerate(LEGS):
        longer = hexapod.lengths(goal_of(name, platform)) - rest
        np.testing.assert_allclose(longer, 10e-3 * (np.arange(6) == leg), atol=1e-9)


def test_a_crank_alone_turns_by_10_mm() -> None:
    platform = parse_platform(template("cranks"), "cranks.toml")
    hexapod = platform.six_legs()
    rest = hexapod.lengths(np.zeros(6))
    for crank, name in enumerate(CRANKS):
        further = hexapod.lengths(goal_of(name, platform)) - rest
        np.testing.assert_allclose(further, 10e-3 * (np.arange(6) == crank), atol=1e-9)
    with pytest.raises(
        InputError, match="axis is leg1, must be crank1 to crank6, or an axis, on this platform"
    ):
        goal_of("leg1", platform)


def test_a_profile_ends_where_it_began() -> None:
    """The leading position is the double sum of commands: exactly at the goal, then exactly back."""
    goal = np.array([10e-3, 0, 0, 0, -0.02, 0])
    speed = np.concatenate([np.zeros((1, 6)), np.cumsum(profile(goal, 0.01), axis=0) * 0.01])
    place = np.concatenate([np.zeros((1, 6)), np.cumsum(0.5 * (speed[1:] + speed[:-1]), axis=0) * 0.01])
    np.testing.assert_allclose(place[200:301], np.tile(goal, (101, 1)), atol=1e-12)
    np.testing.assert_allclose(place[-1], np.zeros(6), atol=1e-12)


def test_what_a_platform_cannot_do_is_refused_before_anything_moves(machine: Platform, gate: Gate) -> None:
    heave = AxisTest([goal_of("heave", machine)], gate, 0.01)
    with pytest.raises(AxisRefused, match="the test of heave is refused: heave leaves its reach"):
        heave.check(["heave"])
    with pytest.raises(InputError, match="axis is 'leg7'"):
        goal_of("leg7", machine)
    with pytest.raises(InputError, match="this platform's file has no legs"):
        goal_of("leg1", machine.model_copy(update={"hexapod": None}))
