"""The Moog driver against bytes packed by hand, and the emulator against each rule of the interface."""

import math
import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from otolith.core.errors import InputError
from otolith.live.devices.driver import Request
from otolith.live.devices.emulator import WATCHDOG_NS, Envelope, MoogEmulator
from otolith.live.devices.moog import FAULTS, MACHINE_STATES, Moog
from otolith.live.messages import DeviceState, SetPoint, State
from otolith.live.wire.formats import WireError

MS = 1_000_000
PERIOD = 16_666_667  # [ns] of 60 Hz
MIDDLE = -0.2286  # [m] heave at our neutral pose in these tests
DRIVER = Moog(interface="CDS7237", neutral_heave=MIDDLE)
POSE = np.array([0.1, 0.05, 0.02, 0.01, 0.03, -0.04])  # forward, left, up, roll right, nose down, yaw right


def set_point(pose: np.ndarray = POSE) -> SetPoint:
    zero = np.zeros(6)
    return SetPoint(
        sequence=1, time_ns=0, pose=pose, twist=zero, acceleration=zero, state=State.ENGAGED, token=9
    )


def test_golden_command_of_both_orders():
    """Lateral counts to the right, heave down, pitch nose up, yaw right: all of these have the other sign."""
    old = struct.pack(">I7f", 130, 0.01, -0.03, MIDDLE - 0.02, 0.1, 0.04, -0.05, 0.0)
    assert DRIVER.encode(set_point(), Request.MOVE) == old
    newer = Moog(interface="CDS7330", neutral_heave=0.0)
    new = struct.pack(">I7f", 130, 0.01, -0.03, 0.04, 0.1, -0.05, -0.02, 0.0)
    assert newer.encode(set_point(), Request.MOVE) == new


@pytest.mark.parametrize(
    ("request_", "code", "heave"),
    [
        (Request.ENGAGE, 180, 0.0),
        (Request.START, 175, MIDDLE),
    ],
)
def test_engage_and_start_send_exact_zeros(request_: Request, code: int, heave: float):
    assert DRIVER.encode(set_point(), request_) == struct.pack(">I7f", code, 0, 0, heave, 0, 0, 0, 0)


def test_command_words():
    codes = {r: struct.unpack(">I", DRIVER.encode(set_point(), r)[:4])[0] for r in Request}
    assert codes == {
        Request.HOLD: 130,
        Request.START: 175,
        Request.ENGAGE: 180,
        Request.MOVE: 130,
        Request.PARK: 210,
        Request.RESET: 160,
        Request.DISABLE: 220,
    }


def test_golden_reply():
    reply = struct.pack(">3I7f", 0x8202, 0x80, 0x29, 0.01, -0.03, MIDDLE - 0.02, 0.1, 0.04, -0.05, 0.0)
    feedback = DRIVER.decode(reply)
    assert np.allclose(feedback.pose, POSE, atol=1e-7)  # type: ignore[arg-type]
    assert feedback.state is DeviceState.FAULT
    assert feedback.faults == ("emergency stop", "command range", "envelope")


@pytest.mark.parametrize("bit", FAULTS)
def test_each_fault_bit_has_its_name(bit: int):
    reply = struct.pack(">3I7f", bit, 0, 0x28, *[0.0] * 7)
    assert DRIVER.decode(reply).faults == (FAULTS[bit],)


def test_states_and_other_modes():
    for code in range(16):
        found = DRIVER.decode(struct.pack(">3I7f", 0, 0, code | 0x20, *[0.0] * 7))
        assert found.state is MACHINE_STATES.get(code, ("", DeviceState.UNKNOWN))[1]
    assert DRIVER.decode(struct.pack(">3I7f", 0, 0, 0x03, *[0.0] * 7)).faults == ("not in DOF mode",)


@pytest.mark.parametrize(
    ("made", "words"),
    [
        ({"interface": "CDS7238", "neutral_heave": 0.0}, "did you mean CDS7237"),
        (
            {"interface": "CDS7237", "neutral_heave": 0.2},
            "neutral_heave of moog is 0.2 m, must be within -0.4572 to 0 m",
        ),
        ({"interface": "CDS7330", "neutral_heave": math.nan}, "neutral_heave of moog is nan"),
    ],
)
def test_what_the_driver_refuses(made, words: str):
    with pytest.raises(InputError, match=words):
        Moog(**made)


@settings(max_examples=300, deadline=None)
@given(data=st.binary(max_size=80))
def test_any_bytes_give_feedback_or_a_wire_error(data: bytes):
    for packet in (data, (data * 40)[:40]):
        try:
            feedback = DRIVER.decode(packet)
        except WireError as error:
            message = str(error)
        else:
            assert np.isfinite(feedback.pose).all()  # type: ignore[arg-type]
            continue
        assert "must be" in message


class Session:
    """A sender of 60 packets per second to an emulator, in virtual time."""

    def __init__(self) -> None:
        self.base = MoogEmulator()
        self.now = 0

    def send(self, request: Request, pose: np.ndarray | None = None, *, times: int = 1) -> DeviceState:
        for _ in range(times):
            self.now += PERIOD
            neutral = np.zeros(6)
            packet = DRIVER.encode(set_point(neutral if pose is None else pose), request)
            reply = self.base.receive(packet, self.now)
            state = DeviceState.OFF if reply is None else DRIVER.decode(reply).state
        return state

    def raw(self, code: int, *words: float) -> DeviceState:
        self.now += PERIOD
        reply = self.base.receive(struct.pack(">I7f", code, *words, 0.0), self.now)
        return DeviceState.OFF if reply is None else DRIVER.decode(reply).state

    @property
    def pose(self) -> np.ndarray:
        pose = DRIVER.decode(self.base.reply()).pose
        assert pose is not None
        return pose

    def engaged(self) -> "Session":
        assert self.send(Request.START) is DeviceState.STANDBY
        for _ in range(200):
            if self.send(Request.START) is DeviceState.ENGAGED:
                return self
        raise AssertionError("not engaged within 200 packets")

    def fault(self) -> tuple[str, ...]:
        return DRIVER.decode(self.base.reply()).faults


def test_start_rises_to_neutral_moves_parks_and_comes_home():
    session = Session().engaged()
    assert np.allclose(session.pose, 0.0, atol=2e-4)
    for share in np.linspace(0.0, 1.0, 60):
        assert session.send(Request.MOVE, share * 0.5 * POSE) is DeviceState.ENGAGED
    session.send(Request.MOVE, 0.5 * POSE, times=30)
    assert np.allclose(session.pose, 0.5 * POSE, atol=2e-4)
    assert session.send(Request.PARK) is DeviceState.PARKING
    assert session.send(Request.HOLD, times=400) is DeviceState.IDLE
    assert np.allclose(session.base.position, 0.0, atol=2e-4)
    assert session.base.refusals == []


def test_engage_off_zero_is_refused():
    session = Session()
    assert session.raw(180, 0, 0, -0.1, 0, 0, 0) is DeviceState.IDLE
    assert session.raw(180, 1e-9, 0, 0, 0, 0, 0) is DeviceState.IDLE
    assert all("exactly 0" in message for message in session.base.refusals)
    assert len(session.base.refusals) == 2
    assert session.raw(175, 0, 0, -0.46, 0, 0, 0) is DeviceState.IDLE
    assert session.raw(175, 0, 0, 0.01, 0, 0, 0) is DeviceState.IDLE
    assert session.raw(175, 0, 0, -0.4572, 0, 0, 0) is DeviceState.STANDBY


def test_engage_outside_idle_is_refused_and_changes_nothing():
    session = Session().engaged()
    assert session.send(Request.ENGAGE) is DeviceState.ENGAGED
    assert session.base.refusals == ["ENGAGE in engaged is refused: must be sent in idle"]


def test_words_must_be_held_until_engaged():
    session = Session()
    session.send(Request.START)
    session.raw(175, 0, 0, -0.1, 0, 0, 0)
    session.send(Request.MOVE, POSE)
    assert ["held until the base is engaged" in message for message in session.base.refusals] == [True, True]


def test_reset_and_park_only_where_they_are_valid():
    session = Session()
    session.send(Request.RESET)
    session.send(Request.PARK)
    assert session.base.refusals == [
        "RESET in idle is refused: must be sent in fault 2 or inhibited",
        "PARK in idle is refused: must be sent in engaged or standby",
    ]


def test_a_silent_sender_is_a_watchdog_fault_and_the_base_sinks_home():
    session = Session().engaged()
    session.base.tick(session.now + WATCHDOG_NS - MS)
    assert session.fault() == ()
    session.base.tick(session.now + WATCHDOG_NS + 2 * MS)
    assert session.fault() == ("watchdog",)
    session.now += WATCHDOG_NS + 3 * MS
    assert session.send(Request.RESET) is DeviceState.FAULT
    assert "at home" in session.base.refusals[-1]
    session.send(Request.HOLD, times=400)
    assert np.allclose(session.base.position, 0.0, atol=1e-4)
    assert session.send(Request.RESET) is DeviceState.IDLE
    assert session.fault() == ()


def test_a_position_outside_the_range_or_a_jump_is_a_fault():
    session = Session().engaged()
    assert session.send(Request.MOVE, np.array([0.3, 0, 0, 0, 0, 0])) is DeviceState.FAULT
    assert session.fault() == ("command range",)
    session = Session().engaged()
    assert session.send(Request.MOVE, np.array([0.05, 0, 0, 0, 0, 0])) is DeviceState.FAULT
    assert session.fault() == ("envelope",)


def test_a_damaged_packet_is_an_invalid_frame_only_under_power():
    session = Session()
    session.base.receive(b"123", session.now)
    assert session.fault() == ()
    session = Session().engaged()
    session.base.receive(b"123", session.now)
    assert session.fault() == ("invalid frame",)


def test_the_emergency_stop_is_latched_after_its_release():
    session = Session().engaged()
    session.base.press_stop(session.now)
    session.send(Request.HOLD, times=400)
    session.send(Request.RESET)
    assert "emergency stop is released" in session.base.refusals[-1]
    session.base.release_stop()
    assert session.fault() == ("emergency stop",)
    assert session.send(Request.MOVE, POSE) is DeviceState.FAULT
    assert session.send(Request.RESET) is DeviceState.IDLE


def test_disable_ends_communication_until_the_power_is_cycled():
    session = Session().engaged()
    assert session.send(Request.DISABLE) is DeviceState.OFF
    assert session.send(Request.RESET) is DeviceState.OFF
    session.base.cycle_power(session.now)
    assert session.send(Request.HOLD) is DeviceState.IDLE


def test_inhibit_needs_a_reset():
    session = Session()
    assert session.raw(150, *[0.0] * 6) is DeviceState.FAULT
    assert session.fault() == ("inhibited",)
    assert session.send(Request.START) is DeviceState.FAULT
    assert session.send(Request.RESET) is DeviceState.IDLE


@settings(max_examples=60, deadline=None)
@given(
    words=st.lists(
        st.tuples(
            st.sampled_from([0, 130, 130, 130, 140, 150, 160, 170, 175, 180, 210, 220]),
            st.tuples(*[st.sampled_from([0.0, 0.0, -0.0, 0.001, -0.2, 0.3, -0.5])] * 6),
            st.sampled_from([MS, PERIOD, 5 * PERIOD, 20 * PERIOD]),
        ),
        max_size=40,
    )
)
def test_whatever_is_sent_the_base_stays_within_its_envelope(words):
    base, now, limits = MoogEmulator(), 0, Envelope()
    before = base.velocity
    for code, six, wait in words:
        now += wait
        base.receive(struct.pack(">I7f", code, *six, 0.0), now)
        assert np.all(base.position >= limits.low - 1e-3)
        assert np.all(base.position <= limits.high + 1e-3)
        assert np.all(np.abs(base.velocity) <= limits.speed + 1e-9)
        assert np.all(np.abs(base.velocity - before) <= limits.acceleration * (wait * 1e-9 + 1e-3) + 1e-9)
        before = base.velocity
