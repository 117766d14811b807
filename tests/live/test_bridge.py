"""The bridge for Windows, as far as it can run here: its packets against our parser, its readers by hand."""

import importlib.util
import struct
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from otolith.live.messages import Flag
from otolith.live.wire.generic import Generic

G = 9.80665
PATH = Path(__file__).parents[2] / "bridge" / "otolith_bridge.py"


@pytest.fixture(scope="module")
def bridge() -> ModuleType:
    spec = importlib.util.spec_from_file_location("otolith_bridge", PATH)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_packets_are_read_by_our_parser(bridge: ModuleType):
    sample = bridge.Sample(1.0, 3, (1.0, 2.0, 3.0), (0.25, 0.5, 0.75), (20.0, 0.0, 0.0), 2)
    read = Generic().parse(bridge.packet(sample, 2**32 + 5, 123))
    assert (read.sequence, read.sender_ns, read.source_id) == (5, 123, 2)
    assert read.flags == Flag.RUNNING | Flag.PAUSED
    assert read.attitude is None
    assert np.array_equal(read.acceleration, [1.0, 2.0, 3.0])  # type: ignore[arg-type]
    assert np.array_equal(read.angular_rate, [0.25, 0.5, 0.75])  # type: ignore[arg-type]
    assert read.speed == 20.0


def test_flags_are_those_of_the_format(bridge: ModuleType):
    assert (bridge.RUNNING, bridge.PAUSED, bridge.REPLAY) == (Flag.RUNNING, Flag.PAUSED, Flag.REPLAY)


def test_iracing_without_the_standing_g(bridge: ModuleType):
    names = (
        "LongAccel LatAccel VertAccel RollRate PitchRate YawRate VelocityX VelocityY VelocityZ SessionTime"
    )
    sdk = dict(zip(names.split(), (2.0, 3.0, G, 0.1, 0.2, 0.3, 30.0, 0.5, 0.0, 99.0), strict=True))
    sample = bridge.of_iracing({**sdk, "IsOnTrack": True, "IsReplayPlaying": False})
    assert sample == bridge.Sample(99.0, 1, (2.0, 3.0, 0.0), (0.1, 0.2, 0.3), (30.0, 0.5, 0.0), 1)
    assert bridge.of_iracing({**sdk, "IsOnTrack": False, "IsReplayPlaying": True}).flags == 2 | 4


def _physics() -> bytes:
    """The beginning of SPageFilePhysics, field by field in the order of its public description."""
    fields = struct.pack(
        "<i3f2if", 77, 0.5, 0.0, 30.0, 3, 5000, 0.1
    )  # number, pedals, fuel, gear, rpm, steering
    fields += struct.pack("<f3f3f", 108.0, 1.0, 2.0, 3.0, 0.5, 1.0, -0.25)  # speed, velocity, accG
    fields += bytes(4 * 4 * 9)  # nine numbers per wheel, from slip to suspension travel
    fields += struct.pack(
        "<2f3ff", 0, 0, 1.0, 0.1, 0.2, 0.3
    )  # DRS, TC, heading, pitch, roll, centre of gravity
    fields += bytes(20) + struct.pack("<2i3fi2f", 0, 0, 0, 0, 0, 0, 0.1, 0.1)  # damage … ride height
    fields += struct.pack("<5f", 0, 0, 1.2, 20, 30) + struct.pack("<3f", 0.125, 0.5, 0.25)  # air, road; rates
    return fields + bytes(512 - len(fields))


def test_assetto_corsa(bridge: ModuleType):
    sample = bridge.of_assetto_corsa(_physics(), struct.pack("<2i", 1, 2) + bytes(56))
    assert sample.stamp == 77.0
    assert sample.force == pytest.approx((-0.25 * G, 0.5 * G, G))
    assert sample.rate == (0.25, 0.125, 0.5)
    assert sample.velocity == pytest.approx((30.0, 0.0, 0.0))
    flags = [
        bridge.of_assetto_corsa(_physics(), struct.pack("<2i", 1, n) + bytes(56)).flags for n in range(4)
    ]
    assert flags == [2, 4, 1, 2]


def _rfactor(begun: int = 5, ended: int = 5, cars: int = 1) -> bytes:
    car = struct.pack("<idd", 3, 0.02, 61.5) + struct.pack("<id", 2, 40.0) + bytes(128)  # id … names
    car += struct.pack(
        "<3d3d3d", 0, 0, 0, 0.5, 0.25, -40.0, 3.0, 0.5, -2.0
    )  # position, velocity, acceleration
    car += bytes(72) + struct.pack("<3d", -0.125, -0.5, 0.25)  # orientation, rates
    memory = struct.pack("<2I2i", begun, ended, 0, cars) + car
    return memory + bytes(4096 - len(memory))


def test_rfactor(bridge: ModuleType):
    sample = bridge.of_rfactor(_rfactor())
    assert sample == bridge.Sample(61.5, 1, (2.0, 3.0, 0.5), (0.25, 0.125, 0.5), (40.0, 0.5, 0.25), 3)
    assert bridge.of_rfactor(_rfactor(begun=6)) is None  # is being written
    assert bridge.of_rfactor(_rfactor(cars=0)) is None


def test_what_is_sent_when(bridge: ModuleType):
    running = bridge.Sample(1.0, 1, (0.0,) * 3, (0.0,) * 3, (0.0,) * 3, 1)
    paused = running._replace(flags=2)
    assert bridge.is_due(running, None, 0.0)
    assert not bridge.is_due(running, running, 5.0)  # frozen: silence tells
    assert bridge.is_due(running._replace(stamp=1.1), running, 0.0)
    assert bridge.is_due(paused, running, 0.0)
    assert not bridge.is_due(paused, paused, 0.05)
    assert bridge.is_due(paused, paused, 0.2)
