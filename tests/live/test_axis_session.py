"""The session of an axis test in virtual time: what comes late on a busy machine, and wrong devices."""

import os
import re
from collections.abc import Callable
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from otolith.interfaces import Cueing
from otolith.live.axis_test import AxisTest, goal_of
from otolith.live.controller import ControllerInbox
from otolith.live.core.gate import Gate
from otolith.live.messages import DeviceState, Plan, Report, State, Word
from otolith.live.shell import axis_session
from otolith.live.world import MS, World, sines
from otolith.platforms import Platform
from tests.live.conftest import PARK

NAMES = ("surge", "sway", "roll")


class Late:
    """An axis test as a world's controller, which hears of an engagement late."""

    def __init__(self, platform: Platform, gate: Gate, cueing: Cueing) -> None:
        self.test = AxisTest([goal_of(name, platform) for name in NAMES], gate, gate.reach.period)
        self.cueing, self.late_ns, self.since_ns = cueing, 0, 0

    def tick(self, now_ns: int, inbox: ControllerInbox) -> Plan:
        report = inbox.report
        if report is None or report.state is not State.ENGAGED:
            self.since_ns = now_ns
        return self.test.tick(now_ns, report if now_ns - self.since_ns >= self.late_ns else None)


class Virtual:
    """A session of processes, all of them in a world of virtual time."""

    def __init__(self, world: World) -> None:
        self.world = world

    def __call__(self, *_: Any, **__: Any) -> "Virtual":
        return self

    def start(self, _: Callable[[], None]) -> None:
        self.world.run(self.world.seconds + 0.1)

    def say(self, *words: Word) -> None:
        self.world.say(*words)

    def look(self) -> State:
        return self.world.state

    def alive(self, _: str) -> bool:
        return True

    def end(self) -> None:
        pass

    @property
    def report(self) -> Report | None:
        return self.world._report


@dataclass
class Nodding:
    """A person to whom every motion looks right."""

    ready_: Callable[[], None] = lambda: None  # is called before every motion

    def tell(self, _: str) -> None: ...

    def look(self) -> None: ...

    def ready(self, _: str) -> bool:
        self.ready_()
        return True

    def saw(self, _: str) -> bool:
        return True


@pytest.fixture
def world(washout: Cueing, machine: Platform, gate: Gate, monkeypatch: pytest.MonkeyPatch) -> World:
    """A world whose time is that of the sessions of axis tests."""
    world = World(washout, machine, drive=sines({}), park=PARK)
    world.controller = Late(machine, gate, washout)  # type: ignore[assignment]
    monkeypatch.setattr(axis_session, "Live", Virtual(world))

    def sleep(seconds: float) -> None:
        world.run(world.seconds + seconds)

    clock = SimpleNamespace(monotonic=lambda: world.seconds, sleep=sleep)
    monkeypatch.setattr(axis_session, "time", clock)
    return world


def played(world: World, platform: Platform, ready: Callable[[], None] = lambda: None) -> list[str]:
    gate = world.gate
    session: Any = SimpleNamespace(
        device=("virtual", os.getpid()), gate=lambda: gate, platform=platform, period=gate.reach.period
    )
    return axis_session.played(session, NAMES, Nodding(ready))


def motion_begins_late(world: World) -> None:
    controller: Any = world.controller
    controller.late_ns = 1500 * MS


def pose_is_late(world: World) -> None:
    world.device.lag = 1.4


@pytest.mark.parametrize("late", [motion_begins_late, pose_is_late])
def test_a_device_is_judged_where_the_set_points_have_arrived_however_late_that_is(
    world: World,
    machine: Platform,
    late: Callable[[World], None],
) -> None:
    assert played(world, machine, lambda: late(world)) == []


def test_a_device_that_goes_nowhere_or_too_far_or_half_of_the_way_is_found(
    world: World, machine: Platform
) -> None:
    world.device.share = np.array([0.0, 1.5, 1.0, 0.5, 1.0, 1.0])
    assert played(world, machine) == [
        "surge: the device reports the pose [0.0, 0.0, 0.0, 0.0, 0.0, 0.0], "
        "must be near [0.01, 0.0, 0.0, 0.0, 0.0, 0.0]",
        "sway: the device reports the pose [0.0, 0.015, 0.0, 0.0, 0.0, 0.0], "
        "must be near [0.0, 0.01, 0.0, 0.0, 0.0, 0.0]",
        "roll: the device reports the pose [0.0, 0.0, 0.0, 0.0087, 0.0, 0.0], "
        "must be near [0.0, 0.0, 0.0, 0.0175, 0.0, 0.0]",
    ]


def test_a_device_that_goes_the_other_way_is_found_on_the_way_and_nothing_else_is_moved(
    world: World, machine: Platform
) -> None:
    world.device.share = np.array([1.0, -1.0, 1.0, 1.0, 1.0, 1.0])
    (wrong,) = played(world, machine)
    assert re.fullmatch(
        r"sway: the session became returning before the set-points rested at the pose \[0.0, 0.01, .*\]: "
        r"the device reported \[0.0, -0.00\d+, .*\] for set-points at \[0.0, 0.00\d+, .*\]",
        wrong,
    )
    assert world.output.session.generation == 2  # roll was not begun
    assert world.device.state is DeviceState.ENGAGED


def test_set_points_that_never_arrive_are_told_and_not_waited_for_without_end(
    world: World, machine: Platform, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(axis_session, "PATIENCE", 5.0)
    controller: Any = world.controller
    controller.late_ns = 10**18
    begin = world.seconds
    wrong = played(world, machine)
    assert wrong[0] == (
        "surge: the set-points were not seen to rest at the pose [0.01, 0.0, 0.0, 0.0, 0.0, 0.0], "
        "so the device could not be judged"
    )
    assert len(wrong) == len(NAMES)
    assert world.seconds - begin < len(NAMES) * axis_session.PATIENCE + 10.0
