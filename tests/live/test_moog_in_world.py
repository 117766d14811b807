"""A session drives the Moog base in software through the driver: arm, engage, cue, park, and its faults."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from otolith.interfaces import Cueing, PlatformState, Reference
from otolith.live.devices.driver import Request
from otolith.live.devices.emulator import Envelope, MoogEmulator
from otolith.live.devices.moog import FAULTS, Moog
from otolith.live.messages import DeviceState, Feedback, SetPoint, State, Word
from otolith.live.world import World, arm_and_engage, sines, states
from otolith.platforms import Platform
from tests.live.conftest import PARK

DRIVER = Moog(interface="CDS7237", neutral_heave=float(PARK[2]))  # the base rests where the session parks
ROOMY = (
    Envelope(  # the world's platform is larger and faster than a Moog base: only the protocol is tested here
        low=np.array([-2.0, -2.0, -2.0, -1.0, -1.0, -1.0]),
        high=np.array([2.0, 2.0, 0.5, 1.0, 1.0, 1.0]),
        speed=np.full(6, 3.0),
        acceleration=np.full(6, 60.0),
    )
)


@dataclass
class MoogInWorld:
    """Stands where the world's ideal device stands; every packet goes through the driver."""

    base: MoogEmulator = field(default_factory=lambda: MoogEmulator(envelope=ROOMY))

    def receive(self, now_ns: int, set_point: SetPoint, request: Request) -> None:
        self.base.receive(DRIVER.encode(set_point, request), now_ns)

    def step(self, now_ns: int) -> None:
        self.base.tick(now_ns)

    def feedback(self) -> Feedback:
        return DRIVER.decode(self.base.reply())

    @property
    def pose(self) -> np.ndarray:
        pose = self.feedback().pose
        assert pose is not None
        return pose

    @property
    def state(self) -> DeviceState:
        return self.feedback().state


@pytest.fixture
def world(washout: Cueing, machine: Platform) -> World:
    washout.step(PlatformState(), Reference(specific_force=np.zeros(3)))  # compiled now
    made = World(washout, machine, drive=sines({0: (1.0, 0.4), 1: (0.8, 0.3)}), park=PARK, tick=5e-3)
    made.device = MoogInWorld()
    return made


def base_of(world: World) -> MoogEmulator:
    assert isinstance(world.device, MoogInWorld)
    return world.device.base


def test_a_session_from_idle_to_parked(world: World):
    arm_and_engage(world)
    world.run(world.seconds + 4.0)
    assert world.state is State.ENGAGED, states(world)
    engaged = [row for row in world.trace if row.state is State.ENGAGED]
    travel = np.ptp([row.measured for row in engaged], axis=0)
    assert travel[0] > 0.01  # it is cued
    apart = np.abs([row.measured - row.motion[0] for row in engaged[100:]])
    assert apart.max() < 0.05
    world.say(Word.PARK)
    world.run(world.seconds + 12.0)
    assert world.state is State.PARKED, states(world)
    assert base_of(world).refusals == []
    assert base_of(world).fault_names == ()
    assert np.allclose(world.device.pose, PARK, atol=2e-3)


@pytest.mark.parametrize("bit", [0x8000, 0x0020, 0x0002])
def test_a_fault_of_the_base_ends_the_session_by_its_name(world: World, bit: int):
    arm_and_engage(world)
    world.run(world.seconds + 2.5)
    base_of(world).inject(bit, world.now_ns)
    world.run(world.seconds + 0.5)
    assert world.state is State.FAULT
    assert FAULTS[bit] in states(world)[-1][2]
