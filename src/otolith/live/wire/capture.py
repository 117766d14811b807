"""Captured packets in a file of records (`otolith.live.records`).

The first record of a capture says in JSON what was captured; those of kind `TELEMETRY` hold a packet as it
came, after the time of its arrival. The log of a session is a capture, too, with records of other kinds
between.
"""

import json
import struct
from collections.abc import Sequence
from typing import Final, NamedTuple

from otolith.core.errors import CorruptFile
from otolith.live.records import HEAD, Records, record

SESSION, TELEMETRY = 1, 2  # kinds of records
FORMAT, LOG = "otolith-capture", "otolith-log"
VERSION: Final = 1
MOST: Final = 1 << 20  # longest payload of a record [bytes]
KINDS: Final = {SESSION: "of the session", TELEMETRY: "of telemetry"}
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


def session_record(source: str) -> bytes:
    """Return the first record of a capture."""
    return record(SESSION, json.dumps({"format": FORMAT, "version": VERSION, "source": source}).encode())


def packet_record(packet: Packet) -> bytes:
    """Return the record of a packet."""
    return record(TELEMETRY, _TIME.pack(packet.time_ns) + packet.data)


def is_capture(data: bytes) -> bool:
    """Return whether a file begins as a capture does."""
    begin = data[: HEAD.size + 200]
    return (
        len(data) > HEAD.size and data[8] == SESSION and any(name.encode() in begin for name in (FORMAT, LOG))
    )


def read_capture(data: bytes, source: str) -> Capture:
    """Return the packets of a capture.

    Parameters
    ----------
    source : the file's name, for errors.

    Raises
    ------
    CorruptFile : a checksum is wrong, a record is impossible, or the first one is not that of a capture.
    """
    records = Records(data, source, KINDS, most=MOST)
    found = [(one.kind, one.payload) for one in records if one.kind in KINDS]
    if not found or found[0][0] != SESSION:
        raise CorruptFile(f"{source} does not begin as a capture of packets")
    said = _said(found[0][1], source)
    packets = [
        Packet(_TIME.unpack_from(payload)[0], payload[_TIME.size :])
        for kind, payload in found
        if kind == TELEMETRY and len(payload) >= _TIME.size
    ]
    return Capture(said, packets, records.cut)


def _said(payload: bytes, source: str) -> str:
    try:
        said = json.loads(payload)
    except ValueError:
        said = None
    if (
        not isinstance(said, dict)
        or said.get("format") not in (FORMAT, LOG)
        or said.get("version") != VERSION
    ):
        raise CorruptFile(f"{source} is no capture of packets of version {VERSION}")
    return str(said.get("source", ""))
