"""Parameters that are changed while a session runs: what is felt, replays, states in which it happens."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest

from otolith.core.errors import CorruptFile, InputError
from otolith.core.frames import SURGE_PITCH
from otolith.cueing.design import Design, reweigh
from otolith.cueing.washout.tuning import Corners
from otolith.interfaces import Cueing
from otolith.live.compilations import compiled
from otolith.live.controller import Controller
from otolith.live.core.device import Device
from otolith.live.core.gate import Gate
from otolith.live.core.ladder import Reaction
from otolith.live.core.parameters import SLEW, Parameters, Tuned
from otolith.live.log import NAMES, Kind, meaning
from otolith.live.messages import Plan, Rung, State, Word
from otolith.live.output import Output
from otolith.live.records import Record, Records
from otolith.live.replay import Replay
from otolith.live.settings import changes_from
from otolith.live.virtual_log import VirtualLog
from otolith.live.wire.generic import Generic
from otolith.live.world import World, arm_and_engage, sines
from otolith.platforms import Platform, load
from otolith.registry import make_cueing
from tests.live.conftest import PARK

DESIGN = Design(platform=load("davsi"), dofs=(SURGE_PITCH,))
OFFERED = ("scale", "liveliness", "high_pass", "low_pass")


def tuned_(name: str) -> tuple[Cueing, Tuned]:
    """An algorithm, and what gives it other parameters, as a session does."""
    cueing = make_cueing(name, DESIGN)

    def use(parameters: Parameters) -> None:
        corners = Corners(high_pass=parameters.high_pass, low_pass=parameters.low_pass)
        reweigh(cueing, name, replace(DESIGN, liveliness=parameters.liveliness, corners=corners))

    return cueing, Tuned(Parameters(), use)


def played(log: VirtualLog, asked: dict[float, Parameters], name: str) -> World:
    """A session that is asked for parameters at times after it was engaged [s]."""
    cueing, tuned = tuned_(name)
    world = World(cueing, DESIGN.platform, drive=sines({0: (0.8, 0.15)}), park=PARK, tick=2e-3)
    world.controller.tuned = tuned
    world.record(log)
    arm_and_engage(world)
    begun = world.seconds
    for seconds, parameters in asked.items():
        world.at(begun + seconds, partial(setattr, world, "change", parameters))
    world.run(begun + 8.0)
    log.recorder.tick(world.now_ns)
    return world


def records(log: VirtualLog) -> Records:
    return Records(bytes(log.disk.data), "s.otl", NAMES, most=1 << 20)


def fresh(name: str) -> Replay:
    cueing, tuned = tuned_(name)
    gate, travel = (Gate(DESIGN.platform, lag=0.01, period=0.01, park=park) for park in (None, PARK))
    controller = Controller(cueing, gate, parse=Generic().parse, tuned=tuned)
    return Replay(controller, Output(gate, travel, Device.at(PARK)), "s.otl")


def replayed(log: VirtualLog, name: str, keep: Callable[[Record], bool] = lambda _: True) -> Replay:
    replay = fresh(name)
    replay.take(one for one in records(log) if keep(one))
    return replay


@pytest.mark.parametrize(
    ("name", "first", "then"),
    [
        ("predictive", Parameters(liveliness=0.9), Parameters(scale=0.2, liveliness=0.1)),
        ("classical", Parameters(high_pass=0.6), Parameters(high_pass=1.2, low_pass=1.5)),
    ],
)
def test_changes_replay_bit_for_bit_and_compile_nothing(
    name: str, first: Parameters, then: Parameters
) -> None:
    log = VirtualLog()
    steady = played(VirtualLog(), {}, name)  # what is compiled is compiled now
    before = compiled()
    world = played(log, {0.3: first, 3.0: then}, name)
    assert compiled() == before
    assert world.controller.tuned.now == then
    assert world.controller.refused == 0
    replay = replayed(log, name)
    assert [(seen.first, seen.different) for seen in replay.seen] == [("", 0)] * 2
    assert replay.seen[0].compared > 700
    without = replayed(log, name, lambda one: one.kind != Kind.CHANGE)
    assert without.seen[0].different > 100
    moved = [np.array([row.motion[0] for row in one.trace[-1000:]]) for one in (world, steady)]
    assert np.abs(moved[0] - moved[1]).max() > 5e-3  # they do matter


def test_a_log_that_is_older_than_some_parameters_replays() -> None:
    """Its changes hold scale and liveliness alone, and nothing else could be changed then."""
    log = VirtualLog()
    played(log, {0.3: Parameters(scale=0.4, liveliness=0.9)}, "predictive")

    def older(one: Record) -> Record:
        return one._replace(payload=one.payload[:16]) if one.kind == Kind.CHANGE else one

    replay = fresh("predictive")
    replay.take(map(older, records(log)))
    assert [(seen.first, seen.different) for seen in replay.seen] == [("", 0)] * 2
    assert replay.seen[0].compared > 700


@pytest.mark.parametrize("length", [0, 8, 17, 40])
def test_a_change_of_another_length_is_damage(length: int) -> None:
    with pytest.raises(CorruptFile, match=r"old\.otl is damaged at byte 7"):
        meaning(Record(kind=Kind.CHANGE, payload=bytes(length), place=7), "old.otl")


def cued(washout: Cueing, machine: Platform) -> World:
    world = World(washout, machine, drive=sines({0: (0.8, 0.5)}), park=PARK, tick=2e-3)
    arm_and_engage(world)
    return world


def test_a_scale_is_what_is_asked_for_and_comes_gradually(washout: Cueing, machine: Platform) -> None:
    world = cued(washout, machine)
    asked: list[float] = []

    def note(plan: Plan) -> Plan:
        asked.append(float(np.linalg.norm(world.controller.asked)))
        return plan

    world.on_plan = note
    world.run(world.seconds + 6.0)
    full = max(asked[-200:])
    world.change = Parameters(scale=0.25)
    world.run(world.seconds + 1.0)
    assert world.controller.tuned.now.scale == pytest.approx(1.0 - SLEW, abs=0.003)
    world.run(world.seconds + 6.0)
    assert max(asked[-200:]) == pytest.approx(0.25 * full, rel=0.02)


@pytest.mark.parametrize("at", [State.IDLE, State.ENGAGING, State.FAULT])
def test_a_change_in_any_state_moves_nothing_and_counts_from_the_next_engagement(
    at: State, washout: Cueing, machine: Platform
) -> None:
    world = World(washout, machine, drive=sines({0: (0.8, 0.5)}), park=PARK, tick=2e-3)
    world.run(0.2)
    if at is State.ENGAGING:
        world.say(Word.ARM)
    if at is State.FAULT:
        world.reaction = Reaction(Rung.FAULT, "the line to the device: EIO")
    for _ in range(300):
        if world.state is not at:
            world.run(world.seconds + 0.01)
    assert world.state is at
    twin = world.again()
    world.change = Parameters(scale=0.3)
    for one in (world, twin):
        one.run(one.seconds + 0.4)
    changed, same = (np.array([row.motion for row in one.trace]) for one in (world, twin))
    np.testing.assert_array_equal(changed, same)
    assert world.controller.tuned.asked.scale == 0.3
    assert world.controller.tuned.now.scale == pytest.approx(1.0 - 0.4 * SLEW, abs=0.003)


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ({}, "the change is empty, must be one of scale, liveliness, high_pass, low_pass"),
        ({"scale": 1.5}, "greater than 0 and at most 1"),
        ({"scale": 0}, "greater than 0 and at most 1"),
        ({"scale": float("nan")}, "a finite number"),
        ({"scale": 10**400}, "a finite number"),
        ({"liveliness": -1e-9}, "between 0 and 1"),
        ({"liveliness": float("inf")}, "a finite number"),
        ({"liveliness": True}, "a number"),
        ({"high_pass": 0.4}, "between 0.5 and 2"),
        ({"low_pass": 2.1}, "between 0.5 and 2"),
        ({"scale": "0.5"}, "a number"),
        ({"scale": [0.5]}, "a number"),
        ({"scale": None}, "scale is empty, must be a number"),
        ({"lag": 0.1}, "must be one of scale, liveliness"),
        ({"scale": 0.5, "liveliness": 7.0}, "between 0 and 1"),
    ],
)
def test_a_value_out_of_bounds_is_one_sentence(values: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InputError) as refused:
        changes_from(values, OFFERED)
    assert sentence in str(refused.value)
    assert "\n" not in str(refused.value)


def test_only_what_the_algorithm_reads_is_offered() -> None:
    assert changes_from({"scale": 1}, ("scale",)) == {"scale": 1.0}
    with pytest.raises(InputError, match="must be one of scale"):
        changes_from({"liveliness": 0.5}, ("scale",))
