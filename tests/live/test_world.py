"""A whole session with the software Moog base, through its bytes: it refuses whatever Moog refuses."""

import numpy as np
import pytest

from otolith.interfaces import Cueing
from otolith.live.audit import audit
from otolith.live.devices.emulator import Envelope
from otolith.live.devices.moog import FAULTS
from otolith.live.machines import MoogDevice
from otolith.live.messages import DeviceState, State, Word
from otolith.live.world import World, arm_and_engage, sines, states
from otolith.platforms import Platform, load


def session(washout: Cueing, machine: Platform) -> World:
    device = MoogDevice()
    drive = sines({0: (0.5, 0.5), 1: (0.4, 0.7)})
    return World(washout, machine, drive=drive, park=device.park, tick=2e-3, device=device)


def test_a_moog_base_engages_is_cued_returns_and_parks(washout: Cueing, machine: Platform) -> None:
    world = arm_and_engage(session(washout, machine))
    world.run(world.seconds + 5.0)
    assert world.state is State.ENGAGED
    measured = np.array([row.measured for row in world.trace if row.state is State.ENGAGED])
    sent = np.array([row.motion[0] for row in world.trace if row.state is State.ENGAGED])
    assert np.ptp(sent[:, 0]) > 0.02
    assert np.abs(measured - sent).max() < 0.02  # one packet and the links behind
    world.say(Word.PARK)
    world.run(world.seconds + 12.0)
    assert world.state is State.PARKED
    assert world.device.state is DeviceState.IDLE
    refusals = world.device.base.refusals
    assert [text for text in refusals if not text.startswith("PARK in idle")] == []
    assert len(refusals) <= 1  # sent before the reply that says "idle" has arrived
    assert world.device.faults == ()
    assert audit(world.trace, machine) == []


def test_a_large_platform_is_rehearsed_on_a_base_as_large(washout: Cueing) -> None:
    """`davsi` reaches further than the base of the public figures, which fails with "command range"."""
    davsi, drive = load("davsi"), sines({0: (4.0, 0.3)})
    farthest = []
    for envelope in (None, Envelope.holding(davsi, -0.2)):
        device = MoogDevice(envelope=envelope)
        world = arm_and_engage(World(washout, davsi, drive=drive, park=device.park, tick=2e-3, device=device))
        world.run(world.seconds + 5.0)
        farthest.append(max(abs(row.motion[0, 0]) for row in world.trace))
        assert world.device.faults == (("command range",) if envelope is None else ())
    assert farthest[1] > 0.259


def test_a_stop_pressed_at_the_moog_base_is_named_and_left_by_the_word_only(
    washout: Cueing, machine: Platform
) -> None:
    world = arm_and_engage(session(washout, machine))
    world.run(world.seconds + 3.0)
    world.device.base.press_stop(world.now_ns)
    world.run(world.seconds + 1.0)
    assert world.state is State.FAULT
    assert "emergency stop" in world.output.session.ladder.kept.reason
    world.device.base.release_stop()
    world.run(world.seconds + 5.0)
    assert world.state is State.FAULT
    world.say(Word.REARM)
    world.run(world.seconds + 1.0)
    assert world.state is State.IDLE
    assert world.device.state is DeviceState.IDLE
    assert np.abs(world.device.pose - world.device.park).max() < 1e-3


@pytest.mark.parametrize("bit", [0x8000, 0x0020, 0x0002])
def test_a_fault_of_the_base_ends_the_session_by_its_name(
    bit: int, washout: Cueing, machine: Platform
) -> None:
    world = arm_and_engage(session(washout, machine))
    world.run(world.seconds + 1.0)
    world.device.base.inject(bit, world.now_ns)
    world.run(world.seconds + 0.5)
    assert world.state is State.FAULT
    assert FAULTS[bit] in states(world)[-1][2]
