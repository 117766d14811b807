"""Captured packets: what is written comes back, whole records survive a kill, damage is found."""

import json
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from otolith.core.errors import CorruptFile, InputError
from otolith.live.records import record
from otolith.live.wire.capture import (
    Packet,
    is_capture,
    packet_record,
    read_capture,
    session_record,
)
from otolith.live.wire.sources import SOURCES, source_named
from tests.live.wire.golden import CUSTOM_XML, GOLDEN, WRC_JSON

PACKETS = [Packet(10**18 + n, one.packet) for n, one in enumerate(GOLDEN)]
DATA = session_record("forza") + b"".join(map(packet_record, PACKETS))


def test_there_and_back():
    assert is_capture(DATA)
    found = read_capture(DATA, "f.otc")
    assert (found.source, list(found.packets), found.cut) == ("forza", PACKETS, False)


@given(at=st.integers(len(session_record("forza")), len(DATA) - 1))
def test_a_file_that_ends_too_soon_gives_its_whole_records(at: int):
    found = read_capture(DATA[:at], "f.otc")
    assert list(found.packets) == PACKETS[: len(found.packets)]
    whole = len(session_record("forza")) + sum(len(packet_record(one)) for one in found.packets)
    assert found.cut == (at != whole)


@given(at=st.integers(0, len(DATA) - 1), bit=st.integers(0, 7))
def test_a_changed_bit_is_found(at: int, bit: int):
    """It is reported, or the file ends too soon where a length was changed; never another packet."""
    data = bytearray(DATA)
    data[at] ^= 1 << bit
    try:
        found = read_capture(bytes(data), "f.otc")
    except CorruptFile:
        return
    assert found.cut
    assert list(found.packets) == PACKETS[: len(found.packets)]


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"t,ax\n1,2\n",
        record(2, bytes(20)),
        record(1, b"no json"),
        record(1, json.dumps({"format": "otolith-capture", "version": 2}).encode()),
    ],
)
def test_other_files_are_refused(data: bytes):
    with pytest.raises(CorruptFile, match=r"f\.otc"):
        read_capture(data, "f.otc")


def test_a_length_that_cannot_be_is_refused_without_reading_on():
    with pytest.raises(
        CorruptFile,
        match=r"damaged at byte \d+, in a record of telemetry: .* 4,294,967,295 byt",
    ):
        read_capture(session_record("forza") + struct.pack("<IIB", 2**32 - 1, 0, 2) + bytes(50), "f.otc")


def test_every_source_has_its_name():
    texts = {"p.xml": CUSTOM_XML, "w.json": WRC_JSON}
    rest = {"codemasters-custom": ":p.xml", "wrc": ":w.json", "lfs2": ":1ff"}
    for name in SOURCES:
        assert source_named(name + rest.get(name, ""), texts.__getitem__).name == name


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("forzza", "source is 'forzza', must be one of .*did you mean forza"),
        ("forza:x", "source forza is followed by 'x', must be alone"),
        ("wrc", "source wrc is alone, must be followed by a colon and the game's JSON file"),
        ("beamng:older", "signs of beamng is 'older', must be one of old, new"),
        ("lfs2:xyz", "OutSim Opts of lfs2 is 'xyz', must be a hexadecimal number"),
        ("lfs:axes", "frame of lfs is 'axes', must be one of world, car"),
    ],
)
def test_names_that_are_refused(text: str, words: str):
    with pytest.raises(InputError, match=words):
        source_named(text, str)
