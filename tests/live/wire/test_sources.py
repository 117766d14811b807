"""Every source against packets packed by hand, against its own words on errors, and against any bytes."""

import dataclasses
import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from otolith.core.arrays import Vec
from otolith.core.errors import InputError
from otolith.live.messages import Flag, Telemetry
from otolith.live.wire.beamng import BeamNG
from otolith.live.wire.f1 import F1
from otolith.live.wire.formats import OtherPacket, WireError
from otolith.live.wire.forza import Forza
from otolith.live.wire.generic import Generic, telemetry_packet
from otolith.live.wire.lfs import OutSim, OutSim2
from tests.live.wire.fuzz import FORMATS, Format, outcomes, sound
from tests.live.wire.golden import GOLDEN, Golden, f1_motion, forza, generic, lfs, lfs2


@pytest.mark.parametrize("golden", GOLDEN, ids=[one.name for one in GOLDEN])
def test_golden_packet_means_what_its_document_says(golden: Golden):
    sample = golden.source.parse(golden.packet)
    for one in dataclasses.fields(Telemetry):
        found, meant = getattr(sample, one.name), golden.means.get(one.name, one.default)
        if meant is None or isinstance(meant, Flag | int):
            assert found == meant, one.name
        else:
            assert np.allclose(found, meant, rtol=1e-6, atol=1e-4 if one.name == "attitude" else 1e-5), (
                one.name
            )


@pytest.mark.parametrize("golden", GOLDEN, ids=[one.name for one in GOLDEN])
def test_every_shorter_and_longer_packet_is_refused(golden: Golden):
    for data in [golden.packet[:n] for n in range(len(golden.packet))] + [golden.packet + b"\0"]:
        if golden.name.startswith(("forza", "lfs")) and len(data) in (64, 68, 232, 311, 324, 331):
            continue  # another variant of the same source
        with pytest.raises(WireError):
            golden.source.parse(data)


def _given(one: Vec | None) -> Vec:
    assert one is not None
    return one


def _parsed_or_refused(golden: Golden, data: bytes) -> None:
    try:
        sample = golden.source.parse(data)
    except WireError as error:
        message = str(error)
    else:
        assert sound(sample)
        return
    assert "must be" in message
    assert "\n" not in message


@pytest.mark.parametrize("one", FORMATS, ids=[one.name for one in FORMATS])
def test_damaged_packets_give_sound_values_or_a_wire_error(one: Format):
    """420,000 over all formats; `benchmarks/fuzz_packets.py` does a million of each."""
    read = 0
    for outcome in outcomes(one, 15_000, seed=7):
        if isinstance(outcome, WireError):
            assert "must be" in str(outcome)
            assert "\n" not in str(outcome)
        else:
            assert sound(outcome)
            read += 1
    assert 1_000 < read < 14_000  # both ends are reached


@settings(max_examples=300, deadline=None)
@given(golden=st.sampled_from(GOLDEN), data=st.binary(max_size=400))
def test_any_bytes_give_a_sound_sample_or_a_wire_error(golden: Golden, data: bytes):
    _parsed_or_refused(golden, data)


@pytest.mark.parametrize("number", [float("nan"), float("inf"), -float("inf"), 3e38])
def test_numbers_that_cannot_be_are_refused_by_name_value_bound_and_unit(number: float):
    data = bytearray(forza(232).packet)
    struct.pack_into("<f", data, 20, number)
    with pytest.raises(WireError, match=r"Acceleration of Forza packet .* is .*, must be within ±10000 m/s²"):
        Forza().parse(bytes(data))


def test_words_of_errors():
    with pytest.raises(
        WireError, match="size of Forza packet is 5 bytes, must be 232 or 311 or 324 or 331 bytes"
    ):
        Forza().parse(b"12345")
    data = bytearray(generic().packet)
    data[60] ^= 1
    with pytest.raises(WireError, match="checksum of generic telemetry packet"):
        Generic().parse(bytes(data))
    with pytest.raises(WireError, match="start of BeamNG MotionSim packet is 42 4e 47 32"):
        BeamNG().parse(b"BNG2" + bytes(84))
    with pytest.raises(WireError, match="own car of F1 packet is 30, must be 0 to 21"):
        F1().parse(f1_motion(2024).packet[:27] + bytes([30, 255]) + f1_motion(2024).packet[29:])
    with pytest.raises(WireError, match="packet format of F1 packet is 2021"):
        F1().parse(struct.pack("<H", 2021) + f1_motion(2024).packet[2:])


def test_sound_packets_without_motion_are_not_damage():
    lap = struct.pack("<H5BQf2I2B", 2025, 25, 1, 0, 1, 2, 1, 1.0, 1, 1, 0, 255)
    with pytest.raises(OtherPacket, match="packet id of F1 packet is 2"):
        F1().parse(lap)
    with pytest.raises(OtherPacket):
        BeamNG().parse(bytes(96))  # OutGauge on the same port


def test_forza_menu_is_a_pause():
    data = bytearray(forza(331).packet)
    struct.pack_into("<i", data, 0, 0)
    assert Forza().parse(bytes(data)).flags == Flag.PAUSED
    struct.pack_into("<i", data, 0, 2)
    with pytest.raises(WireError, match="IsRaceOn"):
        Forza().parse(bytes(data))


def test_left_handed_axes_keep_the_physics_of_a_turn():
    """v × ω decides: centripetal acceleration points to the side to which the car turns, in any axes."""
    sample = Forza().parse(forza(232).packet)
    centripetal = np.cross(_given(sample.angular_rate), _given(sample.velocity))
    assert centripetal[1] * _given(sample.acceleration)[1] > 0.0  # both to the left
    unturned_yaw = -0.5  # what the packet holds
    assert _given(sample.angular_rate)[2] == -unturned_yaw


def test_generic_round_trip():
    sample = Generic().parse(generic().packet)
    assert telemetry_packet(sample) == generic().packet
    without = dataclasses.replace(sample, attitude=None)
    assert Generic().parse(telemetry_packet(without)).attitude is None


def test_lfs_vectors_can_be_the_cars_already():
    turned, kept = OutSim().parse(lfs(False).packet), OutSim(frame="car").parse(lfs(False).packet)
    assert np.allclose(_given(turned.acceleration), [2.0, 4.0, 0.5], atol=1e-6)
    assert np.allclose(_given(kept.acceleration), [-4.0, 2.0, 0.5], atol=1e-6)


@pytest.mark.parametrize("options", [0, 0x004, 0x200 | 0x008])
def test_lfs_options_without_motion_or_unknown_are_refused(options: int):
    with pytest.raises(InputError, match="OutSim Opts of lfs2"):
        OutSim2(options)


def test_a_wrong_mask_of_lfs_is_noticed_by_the_size():
    with pytest.raises(WireError, match="size of OutSimPack2"):
        OutSim2(0x1FF).parse(lfs2(0x00D).packet)


def test_attitude_of_lfs_is_its_rotation():
    """Forward and left of the car, from LFS's words: heading about up, pitch about right, roll."""
    heading, pitch, roll = 0.7, 0.3, -0.2
    packet = bytearray(lfs(False).packet)
    struct.pack_into("<3f", packet, 16, heading, pitch, roll)
    w, x, y, z = _given(OutSim().parse(bytes(packet)).attitude)
    forward = np.array([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)])
    assert np.arctan2(forward[1], forward[0]) == pytest.approx(heading, abs=1e-6)  # anticlockwise from above
    assert np.arcsin(forward[2]) == pytest.approx(pitch, abs=1e-6)  # anticlockwise from the right: nose up
    left_z = 2 * (y * z + w * x)
    assert left_z < 0.0  # roll anticlockwise from the front (Y towards the eye): positive leans right
