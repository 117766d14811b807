"""Our own packets of set-points, and the poses that are published for others."""

import struct
import zlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from otolith.live.devices import generic
from otolith.live.devices.driver import Request
from otolith.live.devices.generic import Generic, feedback_packet, read_set_point
from otolith.live.devices.publisher import CRC_EXTRA, Marsh, checksum, pose_packet
from otolith.live.messages import DeviceState, Feedback, SetPoint, State
from otolith.live.wire.formats import WireError

DRIVER = Generic(on_silence="holds")
SIX = np.array([0.5, -0.25, 0.125, 0.0625, -0.5, 0.75])  # exact in f32
SET_POINT = SetPoint(
    sequence=7,
    time_ns=1_234_567_890,
    pose=SIX,
    twist=2 * SIX,
    acceleration=-SIX,
    state=State.ENGAGED,
    token=2**63 + 1,
)


def test_golden_set_point():
    body = b"OTLS" + struct.pack("<HHQIQHH", 1, 128, 2**63 + 1, 7, 1_234_567_890, 4, 3)
    body += struct.pack("<18f", *SIX, *(2 * SIX), *-SIX) + bytes(20)
    assert DRIVER.encode(SET_POINT, Request.MOVE) == body + struct.pack("<I", zlib.crc32(body))


def test_set_point_there_and_back():
    for state in State:
        for request in Request:
            sent = SetPoint(
                sequence=2**32 - 1, time_ns=2**63, pose=SIX, twist=SIX, acceleration=SIX, state=state, token=1
            )
            back, asked = read_set_point(DRIVER.encode(sent, request))
            assert asked is request
            assert (back.state, back.sequence, back.time_ns, back.token) == (state, 2**32 - 1, 2**63, 1)
            assert np.array_equal(back.pose, SIX)


def test_golden_feedback():
    body = b"OTLF" + struct.pack("<HHQIQHH", 1, 128, 5, 9, 77, 3, 0) + struct.pack("<6f", *SIX) + bytes(48)
    body += struct.pack("<I", 0b1001) + bytes(16)
    feedback = DRIVER.decode(body + struct.pack("<I", zlib.crc32(body)))
    assert feedback.state is DeviceState.ENGAGED
    assert feedback.faults == ("emergency stop", "watchdog")
    assert feedback.sequence == 9
    assert np.array_equal(feedback.pose, SIX)  # type: ignore[arg-type]
    assert feedback_packet(feedback, time_ns=77, token=5) == body + struct.pack("<I", zlib.crc32(body))


def test_words_of_the_format_keep_their_places():
    """These places are on the wire: a new word goes to the end."""
    assert generic.STATES[:3] == (State.IDLE, State.CHECKING, State.ENGAGING)
    assert generic.STATES.index(State.FAULT) == 9
    assert generic.REQUESTS.index(Request.DISABLE) == 6
    assert generic.DEVICE_STATES.index(DeviceState.UNKNOWN) == 6


def _sealed(**places: int) -> bytes:
    data = bytearray(feedback_packet(Feedback(pose=SIX), time_ns=0)[:-4])
    for name, value in places.items():
        struct.pack_into("<H" if name == "state" else "<I", data, {"state": 28, "faults": 104}[name], value)
    return bytes(data) + struct.pack("<I", zlib.crc32(bytes(data)))


def test_unknown_words_are_refused():
    with pytest.raises(WireError, match="state of generic feedback packet is 9, must be 0 to 6: off, idle"):
        DRIVER.decode(_sealed(state=9))
    with pytest.raises(WireError, match="faults of generic feedback packet is 0x100"):
        DRIVER.decode(_sealed(faults=0x100))
    with pytest.raises(ValueError, match="needs a measured pose"):
        feedback_packet(Feedback(), time_ns=0)


@settings(max_examples=300, deadline=None)
@given(place=st.integers(0, 127), value=st.integers(0, 255), mend=st.booleans())
def test_any_damage_gives_feedback_or_a_wire_error(place: int, value: int, mend: bool):
    data = bytearray(feedback_packet(Feedback(pose=SIX), time_ns=5))
    data[place] = value
    if mend:
        data[-4:] = struct.pack("<I", zlib.crc32(bytes(data[:-4])))
    try:
        feedback = DRIVER.decode(bytes(data))
    except WireError as error:
        message = str(error)
    else:
        assert np.isfinite(feedback.pose).all()  # type: ignore[arg-type]
        return
    assert "must be" in message


def test_checksum_of_mavlink_has_its_published_check_value():
    assert checksum(b"123456789") == 0x6F91  # CRC-16/MCRF4XX in Williams' catalogue of CRCs


def test_the_extra_byte_is_that_of_two_public_generators():
    assert CRC_EXTRA == 88


def test_marsh_frame_by_hand():
    """y right, z down, nose up, yaw right; the zero bytes at the payload's end are left out."""
    frame = Marsh(system=3, component=4).packet(SET_POINT)
    signs = np.array([1, -1, -1, 1, -1, -1])
    payload = struct.pack("<I18f2B", 1234, *(signs * SIX), *(2 * signs * SIX), *(-signs * SIX), 0, 6)
    head = struct.pack("<5B", 78, 0, 0, 7, 3) + b"\x04" + (52502).to_bytes(3, "little")
    assert frame[:10] == b"\xfd" + head
    assert frame[10:-2] == payload
    assert frame[-2:] == struct.pack("<H", checksum(head + payload + b"\x58"))


def test_a_published_pose_is_our_feedback_packet():
    feedback = DRIVER.decode(pose_packet(SIX, sequence=3, time_ns=4))
    assert np.array_equal(feedback.pose, SIX)  # type: ignore[arg-type]
    assert feedback.sequence == 3
