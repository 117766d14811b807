"""Frames in two packets: joined in either order, never across frames."""

import struct

import numpy as np
import pytest

from otolith.live.wire.f1 import F1
from otolith.live.wire.formats import OtherPacket, WireError
from otolith.live.wire.joined import Joined
from tests.live.wire.golden import f1_further, f1_motion

MOTION, FURTHER = f1_motion(2025).packet, f1_further(2025).packet


def of_frame(packet: bytes, number: int) -> bytes:
    data = bytearray(packet)
    struct.pack_into("<I", data, 23, number)  # the overall frame
    return bytes(data)


@pytest.mark.parametrize("order", [(MOTION, FURTHER), (FURTHER, MOTION)])
def test_both_halves_make_one_sample(order: tuple[bytes, bytes]):
    source = Joined(F1())
    for number in (1, 2, 3):
        with pytest.raises(OtherPacket, match=f"frame {number} of f1 is half here"):
            source.parse(of_frame(order[0], number))
        sample = source.parse(of_frame(order[1], number))
        assert sample.sequence == number
        assert np.allclose(sample.acceleration, f1_motion(2025).means["acceleration"])  # type: ignore[arg-type]
        assert np.allclose(sample.angular_rate, [0.25, 0.125, 0.5])  # type: ignore[arg-type]
        assert sample.attitude is not None


def test_a_lost_half_loses_its_frame_only():
    source = Joined(F1())
    for packet, number in ((MOTION, 1), (MOTION, 2), (MOTION, 2), (FURTHER, 3), (MOTION, 4)):
        with pytest.raises(OtherPacket):
            source.parse(of_frame(packet, number))
    assert source.parse(of_frame(FURTHER, 4)).sequence == 4


def test_damage_and_other_packets_pass_through():
    source = Joined(F1())
    with pytest.raises(WireError, match="size of header of F1 packet"):
        source.parse(b"")
    with pytest.raises(OtherPacket):
        source.parse(of_frame(MOTION, 9))
    with pytest.raises(WireError):
        source.parse(MOTION[:-1])
    assert source.parse(of_frame(FURTHER, 9)).sequence == 9
