"""Our own packets: telemetry that comes in (96 bytes), set-points that go out and feedback (128 bytes each).

All are little endian and end in the CRC-32 (as zlib computes it) of all bytes before it.
"""

import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from otolith.live.messages import Flag, Telemetry
from otolith.live.wire.attitude import unit_quaternion
from otolith.live.wire.formats import Field, Number, Packet, Values, WireError

VERSION: Final = 1
_HEAD: Final = (Field(name="version", type="u16"), Field(name="size", type="u16"))
_SIX: Final = tuple(
    Field(name=f"{what} {kind}", type="f32", count=3, unit=unit)
    for what, kind, unit in (
        ("pose", "translation", "m"),
        ("pose", "rotation", "rad"),
        ("twist", "translation", "m/s"),
        ("twist", "rotation", "rad/s"),
        ("acceleration", "translation", "m/s²"),
        ("acceleration", "rotation", "rad/s²"),
    )
)
TELEMETRY: Final = Packet(
    name="generic telemetry packet",
    magic=b"OTLM",
    fields=(
        *_HEAD,
        Field(name="sequence", type="u32"),
        Field(name="time", type="u64", unit="ns"),
        Field(name="flags", type="u32"),
        Field(name="source", type="u32"),
        Field(name="specific force", type="f32", count=3, unit="m/s²", axes="forward left up"),
        Field(name="angular rate", type="f32", count=3, unit="rad/s", axes="forward left up"),
        Field(name="attitude", type="f32", count=4, unit="unit"),
        Field(name="velocity", type="f32", count=3, unit="m/s", axes="forward left up"),
        Field(name="reserve", type="pad", count=12),
        Field(name="checksum", type="u32"),
    ),
)
SET_POINT: Final = Packet(
    name="generic set-point packet",
    magic=b"OTLS",
    fields=(
        *_HEAD,
        Field(name="token", type="u64"),
        Field(name="sequence", type="u32"),
        Field(name="time", type="u64", unit="ns"),
        Field(name="state", type="u16"),
        Field(name="request", type="u16"),
        *_SIX,
        Field(name="reserve", type="pad", count=20),
        Field(name="checksum", type="u32"),
    ),
)
FEEDBACK: Final = Packet(
    name="generic feedback packet",
    magic=b"OTLF",
    fields=(
        *_HEAD,
        Field(name="token", type="u64"),
        Field(name="sequence", type="u32"),
        Field(name="time", type="u64", unit="ns"),
        Field(name="state", type="u16"),
        Field(name="request", type="u16"),
        *_SIX,
        Field(name="faults", type="u32"),
        Field(name="reserve", type="pad", count=16),
        Field(name="checksum", type="u32"),
    ),
)


def seal(packet: Packet, values: Mapping[str, tuple[Number, ...]]) -> bytes:
    """Return a packet with its version, size and checksum filled in."""
    body = packet.encode({**values, "version": (VERSION,), "size": (packet.size,)})[:-4]
    return body + zlib.crc32(body).to_bytes(4, "little")


def unseal(packet: Packet, data: bytes) -> Values:
    """Return the numbers of a packet whose version, size and checksum are right.

    Raises
    ------
    WireError : one of them is wrong, or a number is not finite or not possible.
    """
    if len(data) == packet.size and data.startswith(packet.magic):
        stated, found = int.from_bytes(data[-4:], "little"), zlib.crc32(data[:-4])
        if stated != found:
            raise WireError(
                f"checksum of {packet.name}", f"{stated:08x}", f"{found:08x}, the CRC-32 of its bytes"
            )
    values = packet.decode(data)
    for name, right in (("version", VERSION), ("size", packet.size)):
        if values[name][0] != right:
            raise WireError(f"{name} of {packet.name}", values[name][0], f"{right}")
    return values


@dataclass(frozen=True, slots=True)
class Generic:
    """Our own telemetry packet: specific force without the standing 1 g, x forward, y left, z up."""

    name: str = "generic"

    def parse(self, packet: bytes) -> Telemetry:
        """Return the sample that a packet holds; see `source.Source`."""
        values = unseal(TELEMETRY, packet)
        flags = int(values["flags"][0])
        known = int(Flag.RUNNING | Flag.PAUSED | Flag.REPLAY | Flag.TELEPORTED)
        if flags & ~known:
            raise WireError(
                f"flags of {TELEMETRY.name}", f"{flags:#x}", f"a combination of the bits {known:#x}"
            )
        velocity = np.array(values["velocity"])
        return Telemetry(
            sequence=int(values["sequence"][0]),
            sender_ns=int(values["time"][0]),
            flags=Flag(flags),
            acceleration=np.array(values["specific force"]),
            angular_rate=np.array(values["angular rate"]),
            attitude=unit_quaternion(values["attitude"], TELEMETRY.name),
            velocity=velocity,
            speed=float(np.linalg.norm(velocity)),
            source_id=int(values["source"][0]),
        )


def telemetry_packet(telemetry: Telemetry) -> bytes:
    """Return the generic packet of a sample; what the sample lacks is sent as zero."""
    values: dict[str, tuple[Number, ...]] = {
        "sequence": (telemetry.sequence or 0,),
        "time": (telemetry.sender_ns or 0,),
        "flags": (int(telemetry.flags or 0),),
        "source": (telemetry.source_id,),
    }
    vectors = {
        "specific force": telemetry.acceleration,
        "angular rate": telemetry.angular_rate,
        "attitude": telemetry.attitude,
        "velocity": telemetry.velocity,
    }
    values |= {name: tuple(one.tolist()) for name, one in vectors.items() if one is not None}
    return seal(TELEMETRY, values)
