"""Packets damaged at random, and what parsers make of them; `benchmarks/fuzz_packets.py` does more."""

import dataclasses
import struct
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from otolith.live.devices.driver import Request
from otolith.live.devices.generic import Generic, feedback_packet, read_set_point
from otolith.live.devices.moog import ORDERS, Moog
from otolith.live.messages import DeviceState, Feedback, SetPoint, State
from otolith.live.wire.formats import WireError
from tests.live.wire.golden import GOLDEN

SEVERE = np.frombuffer(bytes.fromhex("0001 7f80 80ff ff7f c07f 7f7f"), dtype=np.uint8)  # NaN, infinity, edges
SIX = np.array([0.1, -0.02, 0.03, 0.01, -0.02, 0.03])


@dataclass(frozen=True)
class Format:
    """A format, its parser, and a sound packet of it."""

    name: str
    parse: Callable[[bytes], Any]
    packet: bytes
    sealed: bool = False  # whether its last four bytes are the checksum of the others


def of_devices() -> list[Format]:
    """Replies of devices, and set-points as a device reads them."""
    driver = Generic(on_silence="parks")
    reply = feedback_packet(Feedback(pose=SIX, state=DeviceState.ENGAGED, sequence=7), time_ns=12, token=5)
    point = SetPoint(
        sequence=7, time_ns=12, pose=SIX, twist=SIX, acceleration=-SIX, state=State.ENGAGED, token=5
    )
    moog = struct.pack(">3I7f", 0x8202, 0x80, 0x23, *SIX, 0.0)
    return [
        *(
            Format(f"moog {order}", Moog(interface=order, neutral_heave=-0.2).decode, moog)
            for order in ORDERS
        ),
        Format("generic feedback", driver.decode, reply, sealed=True),
        Format("generic set-point", read_set_point, driver.encode(point, Request.MOVE), sealed=True),
    ]


SOURCES = [Format(one.name, one.source.parse, one.packet, one.name == "generic") for one in GOLDEN]
FORMATS = [*SOURCES, *of_devices()]


def damaged(packet: bytes, generator: np.random.Generator, *, sealed: bool = False) -> bytes:
    """Return a packet with some bytes replaced, and one time in eight of another length.

    One that is sealed gets the right checksum again every other time, so that the checks behind it are met.
    """
    data = np.frombuffer(packet, dtype=np.uint8).copy()
    places = generator.integers(0, len(data), size=generator.integers(0, 9))
    values = (
        generator.integers(0, 256, size=len(places))
        if generator.random() < 0.5
        else SEVERE[places % len(SEVERE)]
    )
    data[places] = values
    changed = data.tobytes()
    if generator.random() < 0.125:
        changed = (2 * changed)[: generator.integers(0, len(data) + 8)]
    if sealed and len(changed) >= 4 and generator.random() < 0.5:
        changed = changed[:-4] + struct.pack("<I", zlib.crc32(changed[:-4]))
    return changed


def outcomes(one: Format, count: int, seed: int) -> Iterator[Any]:
    """Yield what a parser makes of damaged packets: values, or a `WireError`; any other exception ends it."""
    generator = np.random.default_rng(seed)
    for _ in range(count):
        try:
            yield one.parse(damaged(one.packet, generator, sealed=one.sealed))
        except WireError as error:
            yield error


def sound(found: Any) -> bool:
    """Return whether all numbers are finite and an attitude is a unit quaternion."""
    sample = found[0] if isinstance(found, tuple) else found
    values = [getattr(sample, one.name) for one in dataclasses.fields(sample)]
    finite = all(np.isfinite(one).all() for one in values if isinstance(one, np.ndarray | float))
    attitude = getattr(sample, "attitude", None)
    return finite and (attitude is None or bool(abs(np.linalg.norm(attitude) - 1.0) < 1e-6))
