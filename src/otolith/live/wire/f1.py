"""F1 23 to 26: the motion packet (id 0) of all cars, and the packet of further motion (id 13) of one's
own.

Source: EA's UDP specifications, and for the format of 2026 the sizes of the PyPI package f1-packets. Each
packet begins with a header of 29 bytes that says which car is one's own. The motion packet holds forward
and right directions (int16 / 32767) and forces in the car's axes, in g, as f32 until 2025 and as int16 /
1000 since; the packet of further motion holds velocity and angular velocity. Which way each axis counts,
and whether the vertical force holds gravity, is not documented: `learned` finds it. The two packets of one
frame give two samples, with the same `sequence` (the frame's number); each holds what its packet does.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from otolith.core.arrays import Vec
from otolith.live.messages import Telemetry
from otolith.live.wire.attitude import axes_of, quaternion
from otolith.live.wire.formats import Field, OtherPacket, Packet, Values, WireError, turning, vector

MOTION, MOTION_EX = 0, 13
HEADER: Final = Packet(
    name="header of F1 packet",
    fields=(
        Field(name="packet format", type="u16"),
        Field(name="game year and versions", type="pad", count=4),
        Field(name="packet id", type="u8"),
        Field(name="session", type="u64"),
        Field(name="session time", type="f32", unit="s"),
        Field(name="frame", type="u32"),
        Field(name="overall frame", type="u32"),
        Field(name="own car", type="u8"),
        Field(name="second car", type="pad"),
    ),
)
_WORLD: Final = "left up forward"  # nominal: the game's world has y up
_CAR: Final = "right forward up"  # order of the forces: lateral, longitudinal, vertical
_FIRST: Final = (
    Field(name="position", type="f32", count=3, unit="m", axes=_WORLD),
    Field(name="velocity", type="f32", count=3, unit="m/s", axes=_WORLD),
    Field(name="forward direction", type="i16", count=3, unit="unit/32767", axes=_WORLD),
    Field(name="right direction", type="i16", count=3, unit="unit/32767", axes=_WORLD),
)
_LAST: Final = (Field(name="yaw, pitch, roll", type="f32", count=3, unit="rad"),)
_FORCE: Final = Field(name="force", type="f32", count=3, unit="g", axes=_CAR)
_FORCE_2026: Final = Field(name="force", type="i16", count=3, unit="g/1000", axes=_CAR)
# packet format -> (number of cars, one car of the motion packet, size of the packet of further motion)
YEARS: Final = {
    2023: (22, Packet(name="car of F1 23 motion packet", fields=(*_FIRST, _FORCE, *_LAST)), 217),
    2024: (22, Packet(name="car of F1 24 motion packet", fields=(*_FIRST, _FORCE, *_LAST)), 237),
    2025: (22, Packet(name="car of F1 25 motion packet", fields=(*_FIRST, _FORCE, *_LAST)), 273),
    2026: (24, Packet(name="car of F1 26 motion packet", fields=(*_FIRST, _FORCE_2026, *_LAST)), 273),
}
_EX_AXES: Final = "left up forward"
FURTHER: Final = {
    year: Packet(
        name=f"F1 {year % 100} packet of further motion",
        fields=(
            Field(name="header and wheels", type="pad", count=161),
            Field(name="local velocity", type="f32", count=3, unit="m/s", axes=_EX_AXES),
            Field(name="angular velocity", type="f32", count=3, unit="rad/s", axes=_EX_AXES),
            Field(name="angular acceleration", type="f32", count=3, unit="rad/s²", axes=_EX_AXES),
        ),
        tail=size - 197,
    )
    for year, (_, _, size) in YEARS.items()
}
_TURN_WORLD: Final = turning(_WORLD)
_TURN_CAR: Final = turning(_CAR)
_TURN_EX: Final = turning(_EX_AXES)


@dataclass(frozen=True, slots=True)
class F1:
    """The packets of F1 23, 24, 25 and 26, told apart by the header's packet format."""

    name: str = "f1"

    def parse(self, packet: bytes) -> Telemetry:
        """Return the sample that a packet holds; see `source.Source`."""
        header = HEADER.decode(packet[: HEADER.size])
        year, kind = int(header["packet format"][0]), int(header["packet id"][0])
        if year not in YEARS:
            formats = " or ".join(map(str, YEARS))
            raise WireError(
                "packet format of F1 packet", year, f"{formats} (UDP format in the game's settings)"
            )
        if kind == MOTION:
            return _motion(packet, header, year)
        if kind == MOTION_EX:
            return _further(packet, header, year)
        raise OtherPacket("packet id of F1 packet", kind, f"{MOTION} or {MOTION_EX}, which hold motion")


def _motion(packet: bytes, header: Values, year: int) -> Telemetry:
    cars, layout, _ = YEARS[year]
    size, own = HEADER.size + cars * layout.size, int(header["own car"][0])
    if len(packet) != size:
        raise WireError(f"size of F1 {year % 100} motion packet", f"{len(packet)} bytes", f"{size} bytes")
    if own >= cars:
        raise WireError("own car of F1 packet", own, f"0 to {cars - 1}, a place in the motion packet")
    begin = HEADER.size + own * layout.size
    values = layout.decode(packet[begin : begin + layout.size])
    axes = axes_of(
        vector(values, "forward direction", _TURN_WORLD),
        -vector(values, "right direction", _TURN_WORLD),
        layout.name,
    )
    velocity = vector(values, "velocity", _TURN_WORLD)
    return Telemetry(
        sequence=int(header["overall frame"][0]),
        sender_ns=_time(header),
        acceleration=vector(values, "force", _TURN_CAR),
        attitude=quaternion(axes),
        velocity=axes.T @ velocity,
        position=vector(values, "position", _TURN_WORLD),
        speed=_length(velocity),
        source_id=own,
    )


def _further(packet: bytes, header: Values, year: int) -> Telemetry:
    values = FURTHER[year].decode(packet)
    velocity = vector(values, "local velocity", _TURN_EX)
    return Telemetry(
        sequence=int(header["overall frame"][0]),
        sender_ns=_time(header),
        angular_rate=vector(values, "angular velocity", _TURN_EX),
        velocity=velocity,
        speed=_length(velocity),
        source_id=int(header["own car"][0]),
    )


def _time(header: Values) -> int:
    return round(header["session time"][0] * 1e9)


def _length(velocity: Vec) -> float:
    return float(np.linalg.norm(velocity))
