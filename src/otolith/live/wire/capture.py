"""Captured packets in a file: append only, one record after the other, each with its length and checksum.

A record is u32 length of the payload, u32 CRC-32 of kind and payload, u8 kind, payload; little endian. The
first record of a capture says in JSON what was captured; those of kind `TELEMETRY` hold a packet as it
came, after the time of its arrival.
"""

import json
import struct
import zlib
from collections.abc import Iterator, Sequence
from typing import Final, NamedTuple

from otolith.core.errors import CorruptFile

SESSION, TELEMETRY = 1, 2  # kinds of records
FORMAT: Final = "otolith-capture"
VERSION: Final = 1
LONGEST: Final = 65_535  # longest payload of a UDP packet [bytes]
_HEAD: Final = struct.Struct("<IIB")
_TIME: Final = struct.Struct("<Q")


class Packet(NamedTuple):
    """A packet and when it came."""

    time_ns: int  # [ns] of the receiver's monotonic clock
    data: bytes


class Capture(NamedTuple):
    """What a file of captured packets holds."""

    source: str  # as a user names it on the command line
    packets: Sequence[Packet]
    cut: bool  # whether the last record is incomplete, as when the recorder was killed


def record(kind: int, payload: bytes) -> bytes:
    """Return a record, ready to be appended to a file."""
    return _HEAD.pack(len(payload), zlib.crc32(bytes([kind]) + payload), kind) + payload


def session_record(source: str) -> bytes:
    """Return the first record of a capture."""
    return record(SESSION, json.dumps({"format": FORMAT, "version": VERSION, "source": source}).encode())


def packet_record(packet: Packet) -> bytes:
    """Return the record of a packet."""
    return record(TELEMETRY, _TIME.pack(packet.time_ns) + packet.data)


def is_capture(data: bytes) -> bool:
    """Return whether a file begins as a capture does."""
    return len(data) > _HEAD.size and data[8] == SESSION and FORMAT.encode() in data[: _HEAD.size + 200]


def read_capture(data: bytes, source: str) -> Capture:
    """Return the packets of a capture.

    Parameters
    ----------
    source : the file's name, for errors.

    Raises
    ------
    CorruptFile : a checksum is wrong, a record is impossible, or the first one is not that of a capture.
    """
    found, cut = list(_records(data, source)), False
    if found and found[-1] is None:
        cut = True
    complete = [one for one in found if one is not None]
    if not complete or complete[0][0] != SESSION:
        raise CorruptFile(f"{source} does not begin as a capture of packets")
    said = _said(complete[0][1], source)
    packets = [
        Packet(_TIME.unpack_from(payload)[0], payload[_TIME.size :])
        for kind, payload in complete
        if kind == TELEMETRY and len(payload) >= _TIME.size
    ]
    return Capture(said, packets, cut)


def _records(data: bytes, source: str) -> Iterator[tuple[int, bytes] | None]:
    """Yield kind and payload of each record, and None for one that is cut off at the end."""
    place = 0
    while place < len(data):
        if len(data) - place < _HEAD.size:
            yield None
            return
        length, checksum, kind = _HEAD.unpack_from(data, place)
        if length > LONGEST + _TIME.size:
            raise CorruptFile(f"{source} is damaged at byte {place}: a record of {length:,} bytes")
        payload = data[place + _HEAD.size : place + _HEAD.size + length]
        if len(payload) < length:
            yield None
            return
        if zlib.crc32(bytes([kind]) + payload) != checksum:
            raise CorruptFile(f"{source} is damaged at byte {place}: the checksum of its record is wrong")
        yield kind, payload
        place += _HEAD.size + length


def _said(payload: bytes, source: str) -> str:
    try:
        said = json.loads(payload)
    except ValueError:
        said = None
    if not isinstance(said, dict) or said.get("format") != FORMAT or said.get("version") != VERSION:
        raise CorruptFile(f"{source} is no capture of packets of version {VERSION}")
    return str(said.get("source", ""))
