"""The decoder: places, units, turning of axes, and what is refused."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from otolith.live.wire.codemasters import LEGACY
from otolith.live.wire.f1 import FURTHER, HEADER, YEARS
from otolith.live.wire.formats import DIRECTIONS, Field, Packet, WireError, turning
from otolith.live.wire.forza import PACKETS
from otolith.live.wire.generic import FEEDBACK, SET_POINT, TELEMETRY

G = 9.80665
PACKET = Packet(
    name="test packet",
    magic=b"AB",
    order=">",
    fields=(
        Field(name="force", type="f32", count=3, unit="g"),
        Field(name="gap", type="pad", count=3),
        Field(name="speed", type="f32", unit="m/s", scale=3.6),
        Field(name="count", type="u64"),
    ),
    tail=1,
)


def test_sizes_are_those_of_the_documents():
    sizes = [TELEMETRY.size, SET_POINT.size, FEEDBACK.size, LEGACY.size, HEADER.size]
    assert sizes == [96, 128, 128, 264, 29]
    assert [one.size for one in PACKETS.values()] == list(PACKETS)
    assert [layout.size for _, layout, _ in YEARS.values()] == [60, 60, 60, 54]
    assert [one.size for one in FURTHER.values()] == [217, 237, 273, 273]


def test_places_are_those_of_the_documents():
    sled = PACKETS[232]
    assert [sled.offset(n) for n in ("Acceleration", "Velocity", "AngularVelocity")] == [20, 32, 44]
    names = (
        "position_x",
        "velocity_x",
        "left_dir_x",
        "forward_dir_x",
        "gforce_lateral",
        "gforce_longitudinal",
    )
    assert [LEGACY.offset(name) for name in names] == [16, 32, 44, 56, 136, 140]
    assert YEARS[2024][1].offset("force") == YEARS[2026][1].offset("force") == 36
    assert FURTHER[2023].offset("local velocity") == 161
    assert FURTHER[2023].offset("angular velocity") == 173
    with pytest.raises(KeyError):
        LEGACY.offset("no such field")


@given(
    force=st.tuples(*[st.floats(-100.0, 100.0, width=32)] * 3),
    speed=st.floats(-500.0, 500.0, width=32),
    count=st.integers(0, 2**64 - 1),
)
def test_round_trip(force: tuple[float, ...], speed: float, count: int):
    data = PACKET.encode({"force": force, "speed": (speed,), "count": (count,)})
    assert len(data) == 2 + 12 + 3 + 4 + 8 + 1
    back = PACKET.decode(data)
    assert np.allclose(back["force"], force, rtol=1e-6)
    assert back["speed"][0] == pytest.approx(speed, rel=1e-6)
    assert back["count"] == (count,)


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "size of test packet is 0 bytes, must be 30 bytes"),
        (b"BA" + bytes(28), r"start of test packet is 42 41, must be 41 42 \(hexadecimal bytes\)"),
        (b"AB" + b"\x7f\xc0\0\0" + bytes(24), "force of test packet is nan m/s², must be within ±10000 m/s²"),
        (b"AB" + bytes(15) + b"\x7f\x80\0\0" + bytes(9), "speed of test packet is inf m/s, must be within"),
    ],
)
def test_refusals_name_field_value_bound_and_unit(data: bytes, words: str):
    with pytest.raises(WireError, match=words):
        PACKET.decode(data)


@pytest.mark.parametrize(
    "axes", ["right up forward", "left up forward", "right forward up", "forward right down"]
)
def test_turning_of_rates_agrees_with_the_cross_product(axes: str):
    """v = ω × r holds in any axes if ω is turned as a rate, whichever hand the axes follow."""
    generator = np.random.default_rng(3)
    M, rate = turning(axes), turning(axes, rotation=True)
    for _ in range(20):
        omega, r = generator.normal(size=(2, 3))
        assert np.allclose(np.cross(rate @ omega, M @ r), M @ np.cross(omega, r))


def test_turning_reads_each_direction():
    assert np.allclose(turning("back right down") @ np.array([1.0, 2.0, 3.0]), [-1.0, -2.0, -3.0])
    assert set(DIRECTIONS) == {"forward", "back", "left", "right", "up", "down"}


def test_a_field_of_an_unknown_type_or_unit_is_a_programming_error():
    with pytest.raises(ValueError, match="type f16"):
        Field(name="x", type="f16")
    with pytest.raises(ValueError, match="expected 3"):
        PACKET.encode({"force": (1.0,)})
