"""A device that reports nothing: the whole way in open loop, and what of it is sent."""

import re
import socket
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from otolith.core.errors import InputError
from otolith.live.core.device import ASSUMED, Device, assumed
from otolith.live.core.gate import Gate
from otolith.live.devices.driver import Request
from otolith.live.devices.template import Axis, Template
from otolith.live.messages import DeviceState, Rung, SetPoint, State, Word
from otolith.live.output import Output, OutputInbox
from otolith.live.settings import settings_from_toml
from otolith.live.shell.datagrams import opened
from otolith.live.shell.processes import _Line
from otolith.platforms.template import template
from tests.live.conftest import PARK

MS = 1_000_000
DESK = Template(
    name="desk",
    frame="<255><Axis1a>",
    axes=(Axis(follows="heave", low=-0.2, high=0.2),),
    bits=16,
    on_silence="holds",
    start="on",
    stop="off",
)


def told_to(
    output: Output, *words: Word, until: State, from_ms: int
) -> tuple[int, list[tuple[Request, SetPoint]]]:
    """Let a word work until a state is reached; return the time [ms] and what was sent."""
    sent, now = [], from_ms
    while output.session.state is not until:
        out = output.tick(now * MS, OutputInbox(words=words if now == from_ms else ()))
        assert out.set_point is not None
        sent.append((out.request, out.set_point))
        now += 1
        assert now < from_ms + 30_000, f"{until} was not reached; it is {output.session.state}"
    return now, sent


def test_a_device_that_reports_nothing_is_driven_from_and_to_its_declared_park_pose(
    gate: Gate, travel: Gate
) -> None:
    output = Output(gate, travel, Device.at(PARK, rate_hz=1000.0, on_silence="holds", reports=False))
    now, up = told_to(output, Word.ARM, until=State.READY, from_ms=0)
    requests = [request for request, _ in up]
    first = requests.index(Request.MOVE)
    assert set(requests[:first]) <= {Request.HOLD, Request.ENGAGE}
    assert first == pytest.approx(ASSUMED / MS, abs=5)
    np.testing.assert_allclose(up[first][1].pose, PARK, atol=1e-6)
    heave = np.array([set_point.pose[2] for _, set_point in up[first:]])
    assert (np.diff(heave) >= -1e-12).all()
    assert np.diff(heave).max() < 0.21e-3  # 0.2 m/s: the drive is not jumped
    assert abs(heave[-1]) < 1e-9
    now, down = told_to(output, Word.PARK, until=State.PARKED, from_ms=now)
    parks = [request for request, _ in down].count(Request.PARK)
    assert parks == pytest.approx(ASSUMED / MS, abs=5)
    np.testing.assert_allclose(down[-1][1].pose, PARK, atol=1e-6)
    assert output.session.events[-1].reason == "commanded to park; the device reports nothing"


def test_what_is_assumed_follows_the_state() -> None:
    assert assumed(State.IDLE, 10**12, None) is DeviceState.IDLE
    assert assumed(State.ENGAGING, 0, None) is DeviceState.IDLE
    assert assumed(State.ENGAGING, ASSUMED + 1, None) is DeviceState.ENGAGED
    assert assumed(State.READY, 0, None) is DeviceState.ENGAGED
    assert assumed(State.PARKING, 10**12, None) is DeviceState.ENGAGED
    assert assumed(State.PARKING, 10**12, ASSUMED + 1) is DeviceState.IDLE
    assert assumed(State.FAULT, 10**12, None) is DeviceState.IDLE


def point(heave: float) -> SetPoint:
    pose = np.array([0, 0, heave, 0, 0, 0])
    return SetPoint(
        sequence=0, time_ns=0, pose=pose, twist=0 * pose, acceleration=0 * pose, state=State.READY, token=0
    )


def test_nothing_is_sent_where_the_driver_has_nothing_to_say_and_no_code_is_a_fault() -> None:
    with opened(0) as device, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
        line.connect(device.getsockname())
        to_device = _Line(line, DESK)
        for request in (Request.HOLD, Request.RESET, Request.ENGAGE, Request.MOVE, Request.PARK):
            to_device.send(point(0.0), request)
        assert [device.recv(99) for _ in range(3)] == [b"on", b"\xff\x80\x00", b"off"]
        assert to_device.reaction.rung is Rung.NONE
        to_device.send(point(0.25), Request.MOVE)
        assert to_device.reaction.rung is Rung.FAULT
        assert "heave for the template is 0.25 m" in to_device.reaction.reason
        with pytest.raises(TimeoutError):
            device.recv(99)


TEXT = """
platform = "davsi-4dof"
[input]
source = "forza"
listen = "127.0.0.1:5300"
[device]
kind = "template"
address = "127.0.0.1:9910"
on_silence = "holds"
[device.template]
frame = "<255><Axis1a><Axis2a>"
axes = [{ follows = "surge", low = -0.2, high = 0.2 }, { follows = "leg1", low = 1.2, high = 2.0 }]
bits = 16
start = "on"
stop = "off"
park_heave_m = -0.1
"""


def test_a_session_file_describes_a_controller_of_cranks(tmp_path: Path) -> None:
    """Six angles in hundredths of a degree or so: 12 bits over ±60 deg, as text."""
    from otolith.live.session import session_of

    rig = tmp_path / "rig.toml"
    rig.write_text(template("cranks"))
    sixty = np.radians(60.0)
    axes = ", ".join(
        f'{{ follows = "crank{n}", low = {-sixty - 1e-9}, high = {sixty + 1e-9} }}' for n in range(1, 7)
    )
    text = TEXT.replace('"davsi-4dof"', f'"{rig}"').replace("bits = 16", 'bits = 12\nform = "decimal"')
    text = re.sub(r"axes = .*", f"axes = [{axes}]", text).replace("-0.1", "-0.03")
    frame = ",".join(f"<Axis{n}a>" for n in range(1, 7)) + "X"
    text = text.replace('"<255><Axis1a><Axis2a>"', f'"{frame}"')
    session = session_of(settings_from_toml(text, "s.toml"), None, source="s.toml", named={})
    pose = np.array([0.02, -0.01, 0.03, 0.01, -0.02, 0.03])
    packet = session.driver.encode(replace(point(0.0), pose=pose), Request.MOVE)
    hexapod = session.platform.six_legs()
    angles = hexapod.angles(hexapod.lengths(pose))
    assert packet == (",".join(f"{round((a / sixty + 1.0) / 2.0 * 4095)}" for a in angles) + "X").encode()
    with pytest.raises(InputError, match=r"axis of template is leg1, must be one of crank1 to crank6"):
        session_of(
            settings_from_toml(text.replace("crank1", "leg1"), "s.toml"), None, source="s.toml", named={}
        ).driver.encode(point(0.0), Request.MOVE)


def test_a_session_file_describes_a_template() -> None:
    from otolith.live.session import session_of

    session = session_of(settings_from_toml(TEXT, "s.toml"), None, source="s.toml", named={})
    assert session.driver.reports is False
    assert session.park == (0.0, 0.0, -0.1, 0.0, 0.0, 0.0)
    packet = session.driver.encode(point(0.0), Request.MOVE)
    length = session.platform.six_legs().lengths(np.zeros(6))[0]
    code = round((length - 1.2) / 0.8 * 65535)
    assert packet == b"\xff" + (32768).to_bytes(2, "big") + code.to_bytes(2, "big")
    with pytest.raises(InputError, match="template"):
        settings_from_toml(TEXT.replace('kind = "template"', 'kind = "generic"'), "s.toml")
