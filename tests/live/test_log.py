"""The log: what cores are told comes back as it was, and another core says the same bit for bit."""

from dataclasses import fields
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from otolith.core.errors import CorruptFile
from otolith.core.frames import SURGE_PITCH, SWAY_ROLL
from otolith.cueing.design import Design
from otolith.cueing.washout.tuning import load_tuning
from otolith.interfaces import Cueing
from otolith.live.controller import Controller, ControllerInbox
from otolith.live.core.device import Device
from otolith.live.core.gate import Gate
from otolith.live.core.ladder import Reaction
from otolith.live.core.parameters import Parameters
from otolith.live.core.session import Event
from otolith.live.log import (
    MOST,
    NAMES,
    Kind,
    meaning,
    pack_event,
    pack_measured,
    pack_reaction,
    unpack_event,
    unpack_measured,
    unpack_reaction,
)
from otolith.live.messages import DeviceState, Feedback, Flag, Rung, State, Word
from otolith.live.output import Output, OutputInbox
from otolith.live.records import Record, Records, record
from otolith.live.replay import Replay
from otolith.live.virtual_log import VirtualLog
from otolith.live.wire.capture import is_capture, read_capture
from otolith.live.wire.generic import Generic
from otolith.live.world import World, arm_and_engage, sines
from otolith.platforms import Platform
from otolith.registry import make_cueing
from tests.live.conftest import PARK

TEXTS = st.text(max_size=30)
VECTORS = st.lists(st.floats(allow_nan=False), min_size=6, max_size=6).map(np.array)
FEEDBACKS = st.builds(
    Feedback,
    pose=st.none() | VECTORS,
    state=st.sampled_from(DeviceState),
    faults=st.lists(TEXTS.filter(lambda text: "\n" not in text), max_size=3).map(tuple),
    sequence=st.none() | st.integers(0, 2**32 - 1),
    token=st.none() | st.integers(0, 2**64 - 1),
)


def records(data: bytes) -> Records:
    return Records(data, "s.otl", NAMES, most=MOST)


@given(feedback=FEEDBACKS, now=st.integers(0, 2**62))
def test_what_a_device_reports_comes_back_as_it_was(feedback: Feedback, now: int) -> None:
    time_ns, found = unpack_measured(pack_measured(now, feedback))
    assert time_ns == now
    for name in ("state", "faults", "sequence", "token"):
        assert getattr(found, name) == getattr(feedback, name)
    if feedback.pose is None:
        assert found.pose is None
    else:
        assert found.pose is not None
        assert found.pose.tobytes() == feedback.pose.tobytes()  # bits, also of -0.0


@given(rung=st.sampled_from(Rung), reason=TEXTS, before=st.sampled_from(State), after=st.sampled_from(State))
def test_reactions_and_events_come_back_as_they_were(
    rung: Rung, reason: str, before: State, after: State
) -> None:
    assert unpack_reaction(pack_reaction(Reaction(rung, reason))) == Reaction(rung, reason)
    event = Event(12, before, after, reason)
    assert unpack_event(pack_event(event)) == event


def test_every_part_of_an_inbox_is_in_the_log() -> None:
    """A core that is told anything else cannot be replayed: log it, and name it here."""
    assert {one.name for one in fields(ControllerInbox)} == {"packets", "report", "missed", "change"}
    assert {one.name for one in fields(OutputInbox)} == {
        "plan",
        "beats",
        "feedback",
        "words",
        "page",
        "reaction",
    }
    assert {one.name for one in fields(Feedback)} == {"pose", "state", "faults", "sequence", "token"}


def eventful(washout: Cueing, machine: Platform, log: VirtualLog) -> World:
    """A session with faults of all links, of the device, of the schedulers and of the operator."""
    drive = sines({0: (0.5, 0.5), 1: (0.4, 0.7)})
    world = World(washout, machine, drive=drive, park=PARK, seed=5, tick=2e-3).record(log)
    world.at(5.0, lambda: setattr(world.links["telemetry"], "corruption", 0.3))
    world.at(5.2, lambda: setattr(world.links["telemetry"], "reordering", 0.2))
    world.at(6.0, lambda: world.silence("telemetry", 0.15))
    for at, scale in ((0.5, 0.9), (6.1, 0.5), (9.0, 1.0), (16.2, 0.7)):  # engaging, cued, and in a fault
        world.at(at, partial(setattr, world, "change", Parameters(scale=scale)))
    world.at(7.0, lambda: setattr(world, "costs_ns", [15_000_000] * 4))
    world.at(7.5, lambda: world.delay("output", 0.007, 0.2))
    world.at(8.0, lambda: setattr(world.source, "flags", Flag.PAUSED))
    world.at(8.3, lambda: setattr(world.source, "flags", Flag.RUNNING))
    world.at(10.0, lambda: setattr(world.device, "offset", np.array([0, 0, 0.02, 0, 0, 0])))
    world.at(10.5, lambda: setattr(world.device, "offset", np.zeros(6)))
    world.at(12.5, lambda: world.say(Word.REARM, Word.ENGAGE))
    world.at(14.5, lambda: world.silence("feedback", 0.15))
    world.at(16.0, lambda: setattr(world, "reaction", Reaction(Rung.FAULT, "the line to the device: EIO")))
    world.at(16.3, lambda: setattr(world, "reaction", Reaction()))
    world.at(16.5, lambda: world.say(Word.REARM))
    world.page_only = True
    world.command_by_page()
    world.at(11.0, lambda: world.stop("page", 0.9))
    return arm_and_engage(world).run(17.0)


@pytest.fixture(scope="module")
def told(machine: Platform) -> VirtualLog:
    log = VirtualLog()
    world = eventful(fresh_cueing(machine), machine, log)
    seen = {event.after for event in world.output.session.events}
    assert seen >= {State.ENGAGED, State.HOLDING, State.RETURNING, State.READY, State.FAULT, State.IDLE}
    return log


def fresh_cueing(machine: Platform) -> Cueing:
    design = Design(platform=machine, dofs=(SURGE_PITCH, SWAY_ROLL), washout=load_tuning("davsi"))
    return make_cueing("classical", design)


def fresh(machine: Platform, gate: Gate, travel: Gate) -> Replay:
    controller = Controller(fresh_cueing(machine), gate, parse=Generic().parse)
    return Replay(controller, Output(gate, travel, Device.at(PARK)), "s.otl")


def test_a_session_with_faults_replays_bit_for_bit(
    told: VirtualLog, machine: Platform, gate: Gate, travel: Gate
) -> None:
    replay = fresh(machine, gate, travel)
    replay.take(records(bytes(told.disk.data)))
    plans, set_points = replay.seen
    assert (plans.first, plans.different) == ("", 0)
    assert (set_points.first, set_points.different) == ("", 0)
    assert plans.compared > 1600
    assert set_points.compared > 8000
    assert plans.lost == set_points.lost == 0


def brings(one: Record) -> bool:
    found: Feedback = meaning(one, "s.otl")[1]
    return found.state is DeviceState.ENGAGED


def is_engaged(one: Record) -> bool:
    return meaning(one, "s.otl").state is State.ENGAGED


@pytest.mark.parametrize(
    ("kind", "seconds"),
    [
        (Kind.TELEMETRY, 1.0),
        (Kind.REPORT, 0.0),
        (Kind.PLAN, 1.0),
        (Kind.MEASURED, 0.0),
        (Kind.WORDS, 0.0),
        (Kind.CHANGE, 0.5),
    ],
)
def test_a_replay_that_is_told_one_thing_less_differs(
    kind: Kind, seconds: float, told: VirtualLog, machine: Platform, gate: Gate, travel: Gate
) -> None:
    """What decides is in the log: without one record the answers are others. The record that is left out is
    the first word, the reply or report that says "engaged", or a packet or plan in motion.
    """
    every = list(records(bytes(told.disk.data)))
    if kind in {Kind.REPORT, Kind.MEASURED}:
        left_out = next(
            n
            for n, one in enumerate(every)
            if one.kind == kind and (is_engaged(one) if kind == Kind.REPORT else brings(one))
        )
    else:
        begin = next(n for n, one in enumerate(every) if one.kind == Kind.REPORT and is_engaged(one))
        begin = begin + round(seconds * 1000) if seconds else 0
        left_out = next(n for n, one in enumerate(every) if n >= begin and one.kind == kind)
    replay = fresh(machine, gate, travel)
    replay.take(one for n, one in enumerate(every[: left_out + 2000]) if n != left_out)
    assert sum(seen.different for seen in replay.seen) > 0


def test_a_log_with_missing_ticks_is_compared_up_to_them(machine: Platform, gate: Gate, travel: Gate) -> None:
    """A ring that is too small for a late recorder: what is left out is counted, never half there."""
    log = VirtualLog(capacity=1 << 16)
    world = World(fresh_cueing(machine), machine, drive=sines({0: (0.5, 0.5)}), park=PARK, tick=2e-3)
    world.record(log)
    world.at(1.0, lambda: world.stop("recorder", 1.5))
    world.run(4.0)
    log.recorder.tick(world.now_ns)  # what came with the last tick
    assert log.rings[1].lost > 100
    assert "ticks are missing" in log.lamp(world.now_ns)
    replay = fresh(machine, gate, travel)
    replay.take(records(bytes(log.disk.data)))
    for seen, ring in zip(replay.seen, log.rings, strict=True):
        assert (seen.different, seen.lost) == (0, ring.lost)
    set_points = replay.seen[1]
    assert set_points.compared + set_points.lost + set_points.after == len(world.trace)


def test_a_log_is_a_capture_of_its_telemetry(told: VirtualLog) -> None:
    data = bytes(told.disk.data)
    assert is_capture(data)
    capture = read_capture(data, "s.otl")
    assert capture.source == "generic"
    assert len(capture.packets) > 900


def test_damage_is_named_and_what_came_before_is_read(told: VirtualLog) -> None:
    every = list(records(bytes(told.disk.data)))
    broken = every[4000]
    data = bytearray(told.disk.data)
    data[broken.place + 9] ^= 1
    found: list[Record] = []
    with pytest.raises(CorruptFile) as damage:
        found.extend(records(bytes(data)))
    assert str(damage.value) == (
        f"s.otl is damaged at byte {broken.place:,}, in a record {NAMES[broken.kind]}: its checksum is wrong"
    )
    assert found == every[:4000]


@settings(max_examples=30, deadline=None)
@given(data=st.data())
def test_a_log_that_was_cut_anywhere_has_all_records_but_one(told: VirtualLog, data: st.DataObject) -> None:
    whole = bytes(told.disk.data[:60_000])
    at = data.draw(st.integers(1, len(whole)))
    found = list(records(whole[:at]))
    length = sum(len(record(one.kind, one.payload)) for one in found)
    assert 0 <= at - length < 4096
    assert found == list(records(whole))[: len(found)]
