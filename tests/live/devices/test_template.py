"""Templates: packets packed by hand, and every code value of every template there and back."""

import struct

import numpy as np
import pytest

from otolith.core.errors import InputError
from otolith.live.devices.driver import Request
from otolith.live.devices.reach import Sent
from otolith.live.devices.template import Axis, Template, motion4sim, thanos
from otolith.live.messages import SetPoint, State
from otolith.live.wire.formats import WireError
from otolith.platforms import library

DOFS = ("surge", "sway", "heave", "roll", "pitch", "yaw")


def at(pose: np.ndarray) -> SetPoint:
    zero = np.zeros(6)
    return SetPoint(
        sequence=1, time_ns=0, pose=pose, twist=zero, acceleration=zero, state=State.ENGAGED, token=0
    )


def plain(form: str, bits: int, *, mirrored: bool = False) -> Template:
    low, high = (0.1, -0.1) if mirrored else (-0.1, 0.1)
    return Template(
        name="rig",
        frame="S<Axis1a>,<Axis2a>E<13>",
        axes=(Axis(follows="heave", low=low, high=high), Axis(follows="roll", low=-0.2, high=0.2)),
        bits=bits,
        form=form,
        on_silence="holds",
        start="<255>on",
        stop="off",
    )


def identity(pose: np.ndarray) -> np.ndarray:
    return 0.5 + pose


def test_golden_frames_by_hand():
    up = at(np.array([0.0, 0.0, 0.1, 0.0, 0.0, 0.0]))  # full scale, and the middle
    assert plain("big", 16).encode(up, Request.MOVE) == b"S\xff\xff,\x80\x00E\r"
    assert plain("little", 16).encode(up, Request.MOVE) == b"S\xff\xff,\x00\x80E\r"
    assert plain("decimal", 12).encode(up, Request.MOVE) == b"S4095,2048E\r"
    assert plain("hex", 12).encode(up, Request.MOVE) == b"SFFF,800E\r"
    assert plain("big", 16, mirrored=True).encode(up, Request.MOVE) == b"S\x00\x00,\x80\x00E\r"
    assert plain("big", 16).encode(up, Request.START) == b"\xffon"
    assert plain("big", 16).encode(up, Request.ENGAGE) == b"\xffon"
    assert plain("big", 16).encode(up, Request.HOLD) == b""
    assert plain("big", 16).encode(up, Request.PARK) == b"off"


def test_thanos_and_motion4sim_have_the_sizes_of_their_documents():
    pose = np.array([-0.5, -0.25, 0.0, 0.25, 0.5, 0.0])  # the legs of `identity` are 0 … 1 m
    codes = (0, 16384, 32768, 49151, 65535, 32768)
    driver = thanos((0.0, 1.0), identity)
    assert driver.encode(at(pose), Request.MOVE) == struct.pack(">2B6H4x2B", 255, 255, *codes, 10, 13)
    axes = tuple(Axis(follows=name, low=-1.0, high=1.0) for name in (*DOFS, "heave", "heave"))
    frame = motion4sim(axes).encode(at(np.zeros(6)), Request.MOVE)
    assert frame == b"\xff\xff" + 8 * b"\x80\x00\x00" + b"\n\r"
    assert len(frame) == 28


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize(
    ("form", "bits"), [("big", 16), ("little", 16), ("decimal", 12), ("hex", 10), ("big", 1)]
)
def test_every_code_value_there_and_back(form: str, bits: int, mirrored: bool):
    """-1 mm sent one rig to the bottom of its travel, 0 and -2 mm did not (a bug of another program)."""
    driver, pose = plain(form, bits, mirrored=mirrored), np.zeros(6)
    heave, roll = driver.axes
    for code in range(2**bits):
        pose[2], pose[3] = heave.value(code, bits), roll.value(2**bits - 1 - code, bits)
        codes = driver.codes(pose)
        assert codes == (code, 2**bits - 1 - code)
        assert driver.read(driver.packed(codes)) == codes


def test_codes_of_24_bits_there_and_back():
    axis = Axis(follows="surge", low=-0.3, high=0.5)
    codes = np.r_[0:4096, 2**23 - 2048 : 2**23 + 2048, 2**24 - 4096 : 2**24, 0 : 2**24 : 4099]
    assert all(axis.code(axis.value(int(code), 24), 24) == code for code in codes)


def test_codes_grow_with_the_value_and_are_the_nearest():
    axis = Axis(follows="heave", low=-0.1, high=0.1)
    values = np.linspace(-0.1, 0.1, 2001)
    codes = [axis.code(value, 8) for value in values]
    assert codes == sorted(codes)
    assert all(
        abs(axis.value(c, 8) - v) <= 0.5 * 0.2 / 255 + 1e-12 for c, v in zip(codes, values, strict=True)
    )


def test_order_of_axes_in_the_frame_is_free():
    axes = tuple(Axis(follows=name, low=-1.0, high=1.0) for name in ("surge", "sway"))
    driver = Template(name="rig", frame="<Axis2a><Axis1a>", axes=axes, bits=8, on_silence="holds")
    packet = driver.encode(at(np.array([1.0, -1.0, 0, 0, 0, 0])), Request.MOVE)
    assert packet == b"\x00\xff"
    assert driver.read(packet) == (255, 0)


def test_a_crank_is_no_leg():
    axis = (Axis(follows="crank1", low=-1.0, high=1.0),)
    with pytest.raises(InputError, match="axis of rig is crank1, must be on a platform with cranks"):
        Template(name="rig", frame="<Axis1a>", axes=axis, bits=8, on_silence="holds")
    legs = library.load("davsi").six_legs()
    with pytest.raises(InputError, match="axis of rig is crank1, must be one of leg1 to leg6"):
        Template(name="rig", frame="<Axis1a>", axes=axis, bits=8, on_silence="holds", legs=legs.positions)
    assert axis[0].unit == "rad"


def test_legs_of_a_real_platform():
    legs = library.load("davsi").six_legs()
    driver = thanos(legs.stroke, legs.lengths)
    pose = np.array([0.02, -0.01, 0.03, 0.01, -0.02, 0.03])
    codes = np.array(driver.read(driver.encode(at(pose), Request.MOVE)))
    low, high = legs.stroke
    assert np.allclose(low + (high - low) * codes / 65535, legs.lengths(pose), atol=(high - low) / 65535)


@pytest.mark.parametrize("end", [-1.0, 1.0])
def test_rounding_at_an_end_of_the_range_is_no_excess(end: float):
    pose = np.array([0.0, 0.0, end * 0.1 * (1.0 + 1e-7), 0.0, 0.0, 0.0])
    driver = plain("big", 16)
    assert driver.codes(pose) == driver.codes(np.round(pose, 5))


@pytest.mark.parametrize(
    ("follows", "low", "high", "passes"),
    [
        ("surge", -0.2, 0.2, True),
        ("surge", 0.2, -0.2, True),  # mirrored
        ("surge", -0.2, 0.19, False),
        ("pitch", -0.3, 0.3, False),
        ("leg1", 1.0, 1.5, True),
        ("leg1", 1.1, 1.5, False),
    ],
)
def test_a_device_that_cannot_go_where_the_platform_may_be_sent_is_refused(
    follows: str, low: float, high: float, passes: bool
):
    reach = np.array([0.2, 0.2, 0.1, 0.3, 0.35, 0.4])
    sent = Sent(-reach, reach, stroke=(1.0, 1.5))
    axes = (Axis(follows=follows, low=low, high=high),)
    driver = Template(
        name="rig", frame="<Axis1a>", axes=axes, bits=8, on_silence="holds", legs=lambda pose: pose
    )
    if passes:
        driver.check_reach(sent)
    else:
        with pytest.raises(InputError, match=f"range of <Axis1a> of rig, which follows {follows}, is "):
            driver.check_reach(sent)


@pytest.mark.parametrize("value", [0.1001, -0.11, float("nan"), float("inf")])
def test_what_is_outside_the_range_is_refused_and_never_clamped(value: float):
    pose = np.array([0.0, 0.0, value, 0.0, 0.0, 0.0])
    with pytest.raises(InputError, match=r"heave for the template is .* m, must be within -0.1 to 0.1 m"):
        plain("big", 16).encode(at(pose), Request.MOVE)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"frame": "<Axis1a>"}, r"frame of rig is <Axis1a>, must be each of <Axis1a> to <Axis2a> once"),
        ({"frame": "<Axis1a><Axis1a>"}, "once"),
        ({"frame": "<Axis1a><Axis2a><256>"}, "frame of rig is <256>, must be a byte"),
        ({"frame": "<Axis1a><Axis2a>ä"}, "written in ASCII"),
        ({"start": "<Axis1a>"}, "start of rig is '<Axis1a>', must be without axes"),
        ({"bits": 33}, "bits of rig is 33, must be 1 to 32"),
        ({"form": "bog"}, "did you mean big"),
        (
            {"axes": (Axis(follows="leg1", low=0, high=1), Axis(follows="roll", low=0, high=1))},
            "on a platform with legs",
        ),
    ],
)
def test_a_wrong_template_is_refused(change, words: str):
    right = {"name": "rig", "frame": "<Axis1a><Axis2a>", "bits": 16, "on_silence": "holds"}
    axes = (Axis(follows="surge", low=0, high=1), Axis(follows="roll", low=0, high=1))
    with pytest.raises(InputError, match=words):
        Template(**{"axes": axes, **right, **change})


def test_wrong_axes_requests_and_packets_are_refused():
    with pytest.raises(InputError, match="did you mean surge"):
        Axis(follows="surg", low=0, high=1)
    with pytest.raises(InputError, match="range of surge is 1 to 1"):
        Axis(follows="surge", low=1, high=1)
    with pytest.raises(InputError, match="axes of motion4sim is 0, must be 8"):
        motion4sim(())
    axis = Axis(follows="leg7", low=0, high=1)
    one = Template(name="r", frame="<Axis1a>", axes=(axis,), bits=8, on_silence="holds", legs=identity)
    with pytest.raises(InputError, match="axis of r is leg7, must be one of leg1 to leg6"):
        one.codes(np.zeros(6))
    with pytest.raises(WireError, match="a template describes no replies"):
        plain("big", 16).decode(b"ok")
    with pytest.raises(WireError, match="packet of rig"):
        plain("big", 16).read(b"S123")
