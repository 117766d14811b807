"""One packet of each format, packed by hand from the documents with the struct module, and what it means.

Nothing here uses our descriptions of packets: an offset that is wrong there disagrees with these bytes.
"""

import json
import math
import struct
import zlib
from dataclasses import dataclass, field
from typing import Any

from otolith.live.messages import Flag
from otolith.live.wire.beamng import BeamNG
from otolith.live.wire.codemasters import custom, legacy
from otolith.live.wire.f1 import F1
from otolith.live.wire.forza import Forza
from otolith.live.wire.generic import Generic
from otolith.live.wire.lfs import OutSim, OutSim2
from otolith.live.wire.source import Source
from otolith.live.wire.wrc import wrc

G = 9.80665
QUARTER = math.sqrt(0.5)  # cos(45 deg): component of a quaternion of a quarter turn


@dataclass(frozen=True)
class Golden:
    """A source, a packet of it, and the sample that it means."""

    name: str
    source: Source
    packet: bytes
    means: dict[str, Any] = field(default_factory=dict)


def generic() -> Golden:
    """Accelerating with 2 m/s², turning left with 0.5 rad/s, heading a quarter turn to the left, 20 m/s."""
    body = b"OTLM" + struct.pack("<HHIQII", 1, 96, 7, 123_456_789, 1, 42)
    body += struct.pack(
        "<3f3f4f3f", 2.0, 10.0, -0.5, 0.0, 0.125, 0.5, QUARTER, 0.0, 0.0, QUARTER, 20.0, 0.0, 0.0
    )
    body += bytes(12)
    means = {
        "sequence": 7,
        "sender_ns": 123_456_789,
        "flags": Flag.RUNNING,
        "acceleration": [2.0, 10.0, -0.5],
        "angular_rate": [0.0, 0.125, 0.5],
        "attitude": [QUARTER, 0.0, 0.0, QUARTER],
        "velocity": [20.0, 0.0, 0.0],
        "speed": 20.0,
        "source_id": 42,
    }
    return Golden("generic", Generic(), body + struct.pack("<I", zlib.crc32(body)), means)


def forza(size: int) -> Golden:
    """A left turn: 3 m/s² forward, 5 m/s² to the left (X is right), yaw to the left (clockwise from above is
    positive in left-handed axes with Y up).
    """
    data = bytearray(size)
    struct.pack_into("<iI", data, 0, 1, 1500)  # the race is on; 1.5 s
    struct.pack_into("<3f", data, 20, -5.0, 0.25, 3.0)  # X right, Y up, Z forward
    struct.pack_into("<3f", data, 32, 0.0, 0.0, 30.0)
    struct.pack_into("<3f", data, 44, 0.125, -0.5, 0.25)  # pitch, yaw, roll
    means = {
        "sender_ns": 1_500_000_000,
        "flags": Flag.RUNNING,
        "acceleration": [3.0, 5.0, 0.25],
        "angular_rate": [-0.25, 0.125, 0.5],
        "velocity": [30.0, 0.0, 0.0],
        "speed": 30.0,
    }
    return Golden(f"forza-{size}", Forza(), bytes(data), means)


def beamng(signs: str) -> Golden:
    """Both versions of motionSim.lua for one attitude: roll 0.1, pitch 0.2, yaw 0.3 of the older file."""
    angles = (0.1, 0.2, 0.3) if signs == "old" else (0.1, -0.2, -0.3)
    numbers = (
        1.0,
        2.0,
        3.0,
        0.0,
        25.0,
        0.0,
        -4.0,
        1.5,
        0.5,
        0.0,
        0.0,
        1.0,
        *angles,
        0.01,
        0.02,
        0.03,
        0.0,
        0.0,
        0.0,
    )
    half = [0.5 * angle for angle in (0.1, 0.2, 0.3)]
    cr, cp, cy = map(math.cos, half)
    sr, sp, sy = map(math.sin, half)
    attitude = [
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    ]
    means = {
        "acceleration": [1.5, 4.0, 0.5],  # nominally X right, Y forward, Z up
        "angular_rate": [0.01, 0.02, 0.03],
        "attitude": attitude,
        "velocity": [0.0, 25.0, 0.0],  # in world axes, as it is sent
        "position": [1.0, 2.0, 3.0],
        "speed": 25.0,
    }
    return Golden(f"beamng-{signs}", BeamNG(signs), struct.pack("<4s21f", b"BNG1", *numbers), means)


def codemasters() -> Golden:
    """Driving along +x of the world, which is left at heading zero: a quarter turn to the left."""
    data = bytearray(264)
    struct.pack_into("<f", data, 0, 12.5)
    struct.pack_into("<3f", data, 16, 100.0, 5.0, -50.0)  # position
    struct.pack_into("<f", data, 28, 15.0)  # speed
    struct.pack_into("<3f", data, 32, 15.0, 0.0, 0.0)  # velocity in the world
    struct.pack_into("<3f", data, 44, 0.0, 0.0, -1.0)  # left direction
    struct.pack_into("<3f", data, 56, 1.0, 0.0, 0.0)  # forward direction
    struct.pack_into("<2f", data, 136, 0.5, -0.25)  # lateral, longitudinal force in g
    means = {
        "sender_ns": 12_500_000_000,
        "acceleration": [-0.25 * G, 0.5 * G, 0.0],
        "attitude": [QUARTER, 0.0, 0.0, QUARTER],
        "velocity": [15.0, 0.0, 0.0],
        "position": [-50.0, 100.0, 5.0],
        "speed": 15.0,
    }
    return Golden("codemasters", legacy(), bytes(data), means)


CUSTOM_XML = """<?xml version="1.0" encoding="utf-8"?>
<custom_udp>
  <fourcc value="moti"/>
  <float channel="total_time" scale="1.0"/>
  <uint32 channel="paused" scale="1.0"/>
  <float channel="roll_velocity" scale="1.0"/>
  <float channel="pitch_velocity" scale="1.0"/>
  <float channel="yaw_velocity" scale="57.29577951308232"/>
  <float channel="local_velocity_x" scale="1.0"/>
  <float channel="local_velocity_y" scale="1.0"/>
  <float channel="local_velocity_z" scale="3.6"/>
  <float channel="gforce_lateral" scale="1.0"/>
  <float channel="gforce_longitudinal" scale="1.0"/>
  <float channel="gforce_vertical" scale="1.0"/>
  <float channel="gear" scale="1.0"/>
</custom_udp>
"""


def codemasters_custom() -> Golden:
    """Yaw rate in deg/s and the speed ahead in km/h, as the scales of the file say."""
    data = b"moti" + struct.pack("<fI10f", 3.0, 1, 0.1, 0.2, 90.0, 0.0, 0.0, 72.0, 0.5, -0.25, 0.125, 3.0)
    means = {
        "sender_ns": 3_000_000_000,
        "flags": Flag.PAUSED,
        "acceleration": [-0.25 * G, 0.5 * G, 0.125 * G],
        "angular_rate": [0.1, 0.2, math.pi / 2],
        "velocity": [20.0, 0.0, 0.0],
        "speed": 20.0,
    }
    return Golden("codemasters-custom", custom(CUSTOM_XML, "packet_data.xml"), data, means)


WRC_CHANNELS = [
    "packet_uid",
    "shiftlights_rpm_valid",
    "vehicle_gear_index",
    *(f"vehicle_{what}_{axis}" for what in ("position", "velocity", "acceleration") for axis in "xyz"),
    *(f"vehicle_{side}_direction_{axis}" for side in ("left", "forward", "up") for axis in "xyz"),
    "stage_current_distance",
    "game_total_time",
]
WRC_JSON = json.dumps(
    {
        "versions": {"schema": 1, "data": 3},
        "id": "otolith",
        "header": {"channels": ["packet_4cc"]},
        "packets": [{"id": "session_update", "channels": WRC_CHANNELS}],
    }
)


def ea_wrc() -> Golden:
    """Heading a quarter turn to the left (along world x), accelerating forward, to the left and upward."""
    data = struct.pack("<4sQBB", b"sesu", 99, 1, 3)
    data += struct.pack("<3f3f3f", 10.0, 20.0, 30.0, 25.0, 0.0, 0.0, 2.0, 0.5, -3.0)
    data += struct.pack("<3f3f3f", 0.0, 0.0, -1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0)  # left, forward, up
    data += struct.pack("<df", 1234.5, 60.25)
    means = {
        "sender_ns": 60_250_000_000,
        "acceleration": [2.0, 3.0, 0.5],
        "attitude": [QUARTER, 0.0, 0.0, QUARTER],
        "velocity": [25.0, 0.0, 0.0],
        "position": [30.0, 10.0, 20.0],
        "speed": 25.0,
    }
    return Golden("wrc", wrc(WRC_JSON, "otolith.json"), data, means)


def _f1_header(year: int, kind: int, own: int) -> bytes:
    head = struct.pack("<H5BQf2I2B", year, year - 2000, 1, 0, 1, kind, 2**63, 17.5, 1000, 2000, own, 255)
    assert len(head) == 29
    return head


def f1_motion(year: int) -> Golden:
    """Own car 19 heads along +z of the world; all other cars hold bytes that would be refused."""
    cars, size = (24, 54) if year == 2026 else (22, 60)
    head = struct.pack("<6f6h", 7.0, 8.0, 9.0, 0.0, 0.0, 50.0, 0, 0, 32767, -32767, 0, 0)
    force = struct.pack("<3h", -2000, 500, 1000) if year == 2026 else struct.pack("<3f", -2.0, 0.5, 1.0)
    car = head + force + struct.pack("<3f", 0.0, 0.0, 0.0)
    assert len(car) == size
    data = _f1_header(year, 0, 19) + b"\xff" * (19 * size) + car + b"\xff" * ((cars - 20) * size)
    assert len(data) == (1325 if year == 2026 else 1349)
    means = {
        "sequence": 2000,
        "sender_ns": 17_500_000_000,
        "acceleration": [0.5 * G, 2.0 * G, G],  # lateral counts to the right, nominally
        "attitude": [1.0, 0.0, 0.0, 0.0],
        "velocity": [50.0, 0.0, 0.0],
        "position": [9.0, 7.0, 8.0],
        "speed": 50.0,
        "source_id": 19,
    }
    return Golden(f"f1-{year}-motion", F1(), data, means)


def f1_further(year: int) -> Golden:
    """Velocity at 161 and angular velocity at 173."""
    data = bytearray({2023: 217, 2024: 237, 2025: 273, 2026: 273}[year])
    data[:29] = _f1_header(year, 13, 3)
    struct.pack_into("<3f3f3f", data, 161, 1.0, 0.25, 60.0, 0.125, 0.5, 0.25, 9.0, 9.0, 9.0)
    means = {
        "sequence": 2000,
        "sender_ns": 17_500_000_000,
        "angular_rate": [0.25, 0.125, 0.5],
        "velocity": [60.0, 1.0, 0.25],
        "speed": math.hypot(1.0, 0.25, 60.0),
        "source_id": 3,
    }
    return Golden(f"f1-{year}-further", F1(), bytes(data), means)


_LFS_MAIN = struct.pack(
    "<3f3f3f3f3i",
    *(0.0, 0.0, 0.5),  # angular velocity, about Z (up)
    *(math.pi / 2, 0.0, 0.0),  # heading: a quarter turn anticlockwise, so forward is -X
    *(-2.0, -4.0, 0.5),  # acceleration: forward 2, and to the left, which is -Y now, 4
    *(-30.0, 0.0, 0.0),  # velocity
    *(65536 * 3, -65536 * 5, 32768),  # position 3, -5, 0.5 m
)
_LFS_MEANS = {
    "sender_ns": 2_345_000_000,
    "acceleration": [2.0, 4.0, 0.5],
    "angular_rate": [0.0, 0.0, 0.5],
    "attitude": [QUARTER, 0.0, 0.0, QUARTER],
    "velocity": [30.0, 0.0, 0.0],
    "position": [-5.0, -3.0, 0.5],
    "speed": 30.0,
}


def lfs(with_id: bool) -> Golden:
    """Heading a quarter turn to the left."""
    data = struct.pack("<I", 2345) + _LFS_MAIN + (struct.pack("<i", 77) if with_id else b"")
    means = {**_LFS_MEANS, "source_id": 77 if with_id else 0}
    return Golden(f"lfs-{len(data)}", OutSim(), data, means)


def lfs2(options: int) -> Golden:
    """The same motion with any parts; those without motion are filled with bytes that would be refused."""
    parts = {1: b"LFST", 2: struct.pack("<i", 77), 4: struct.pack("<I", 2345), 8: _LFS_MAIN}
    junk = {0x10: 20, 0x20: 12, 0x40: 8, 0x80: 160, 0x100: 8}
    parts |= {bit: b"\xff" * size for bit, size in junk.items()}
    data = b"".join(part for bit, part in parts.items() if options & bit)
    means: dict[str, Any] = {**_LFS_MEANS, "source_id": 77 if options & 2 else 0}
    if not options & 4:
        means["sender_ns"] = None
    return Golden(f"lfs2-{options:#x}", OutSim2(options), data, means)


GOLDEN = [
    generic(),
    *map(forza, (232, 311, 324, 331)),
    *map(beamng, ("old", "new")),
    codemasters(),
    codemasters_custom(),
    ea_wrc(),
    *map(f1_motion, (2023, 2024, 2025, 2026)),
    *map(f1_further, (2023, 2024, 2025, 2026)),
    lfs(False),
    lfs(True),
    *map(lfs2, (0x1FF, 0x008, 0x00D, 0x188)),
]
