"""What the controller makes of packets: halves of frames, other kinds, damage, and a map that refuses."""

import struct

import numpy as np
import pytest

from otolith.core.errors import InputError
from otolith.interfaces import Cueing
from otolith.live.controller import Controller, ControllerInbox
from otolith.live.core.gate import Gate
from otolith.live.core.health import Count, Health
from otolith.live.messages import Telemetry
from otolith.live.wire.axes import AxisMap
from otolith.live.wire.f1 import F1
from otolith.live.wire.forza import Forza
from otolith.live.wire.joined import Joined
from tests.live.wire.golden import f1_further, f1_motion
from tests.live.wire.minute import DRIVE, forza_packet

MS = 1_000_000
SHOWN = AxisMap(source="game", force=("1", "2", "3"))


def test_an_f1_stream_counts_frames_and_only_damage_as_unreadable(washout: Cueing, gate: Gate):
    health = Health()
    controller = Controller(washout, gate, parse=Joined(F1()).parse, wanted=SHOWN.wanted, health=health)
    lap = struct.pack("<H5BQf2I2B", 2025, 25, 1, 0, 1, 2, 1, 1.0, 1, 1, 0, 255)
    for frame in range(1, 61):
        packets = [bytearray(f1_motion(2025).packet), bytearray(f1_further(2025).packet)]
        for packet in packets:
            struct.pack_into("<f", packet, 15, frame / 60)
            struct.pack_into("<I", packet, 23, frame)
        now = frame * 16 * MS
        arrived = tuple((now, bytes(one)) for one in (packets[0], lap, packets[1], b"damage"))
        controller.tick(now, ControllerInbox(packets=arrived))
    assert health.counts[Count.UNREADABLE] == 60
    assert health.counts[Count.TAKEN] + health.counts[Count.SPIKE] >= 50


def test_a_learned_map_stands_between_the_game_and_the_cueing(washout: Cueing, gate: Gate):
    """A game with left and right exchanged: what is cued is what was felt."""
    axes = AxisMap(source="forza", force=("1", "-2", "3"), rate=("1", "-2", "-3"))
    seen: list[np.ndarray] = []

    def wanted(telemetry: Telemetry) -> np.ndarray:
        seen.append(axes.wanted(telemetry))
        return seen[-1]

    controller = Controller(washout, gate, parse=Forza().parse, wanted=wanted)
    for k in range(1200, 1260):
        now = round(1e9 * DRIVE.t[k])
        controller.tick(now, ControllerInbox(packets=((now, forza_packet(k)),)))
    assert np.allclose(seen[-1][:3], DRIVE.force[1259] * [1, -1, 1], atol=1e-5)


def test_a_map_that_refuses_a_sample_counts_it_as_unreadable(washout: Cueing, gate: Gate):
    health = Health()
    world = AxisMap(source="forza", force=("1", "2", "3"), frame="world")  # Forza sends no attitude
    controller = Controller(washout, gate, parse=Forza().parse, wanted=world.wanted, health=health)
    controller.tick(20 * MS, ControllerInbox(packets=((10 * MS, forza_packet(900)),)))
    assert health.counts[Count.UNREADABLE] == 1
    assert health.counts[Count.TAKEN] == 0


def test_an_algorithm_that_moves_a_base_is_refused(washout: Cueing, gate: Gate):
    """Its plans count on a base that no live driver moves."""
    washout.carriers = 2  # type: ignore[attr-defined]
    try:
        with pytest.raises(
            InputError, match="one that moves a base, must be one that leaves the base at rest"
        ):
            Controller(washout, gate, parse=Forza().parse)
    finally:
        del washout.carriers  # type: ignore[attr-defined]
