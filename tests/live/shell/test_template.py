"""A device that only reads frames, driven by real processes: what it is sent, from its park pose and back."""

import contextlib
import os
import signal
import threading
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from otolith.live.devices.template import Template
from otolith.live.messages import State, Word
from otolith.live.session import session_of
from otolith.live.settings import settings_from_toml
from otolith.live.shell.datagrams import opened, receive
from otolith.live.shell.supervise import Live, only_session
from otolith.live.shell.virtual import free_port
from tests.live.shell.rig import Rig, until

TEXT = """
platform = "davsi-4dof"
cueing = "classical"
tuning = "davsi"
dofs = "surge-pitch,sway-roll"
[input]
source = "generic"
listen = "127.0.0.1:{telemetry}"
[device]
kind = "template"
address = "127.0.0.1:{device}"
on_silence = "holds"
[device.template]
frame = "<255><Axis1a><Axis2a><Axis3a>"
axes = [
    {{ follows = "surge", low = -0.3, high = 0.3 }},
    {{ follows = "heave", low = -0.2, high = 0.2 }},
    {{ follows = "leg1", low = 1.297, high = 1.937 }},
]
bits = 16
start = "on"
stop = "off"
park_heave_m = -0.1
"""


@dataclass
class Desk:
    """The device: it keeps the frames that it was sent, and the texts between them."""

    device: int
    driver: Template
    frames: list[tuple[int, ...]] = field(default_factory=list)
    texts: list[bytes] = field(default_factory=list)
    over: threading.Event = field(default_factory=threading.Event)

    def read(self, packet: bytes, _: int) -> None:
        if packet.startswith(b"\xff"):
            self.frames.append(self.driver.read(packet))
        elif self.texts[-1:] != [packet]:
            self.texts.append(packet)

    def be(self) -> None:
        with opened(self.device) as listening:
            while not self.over.is_set():
                receive(listening, self.read, seconds=0.2)

    def values(self, axis: int) -> np.ndarray:
        """Return what the frames so far ask of one axis [m]."""
        return np.array([self.driver.axes[axis].value(codes[axis], 16) for codes in self.frames.copy()])


@contextlib.contextmanager
def listening(desk: Desk) -> Iterator[None]:
    thread = threading.Thread(target=desk.be, daemon=True)
    thread.start()
    try:
        yield
    finally:
        desk.over.set()
        thread.join()


def test_a_device_without_replies_is_driven_from_its_park_pose_and_back_also_without_a_controller() -> None:
    told: list[str] = []
    with Rig() as rig:  # for its driver
        text = TEXT.format(telemetry=rig.telemetry, device=free_port())
        session = session_of(settings_from_toml(text, "desk.toml"), None, source="desk.toml", named={})
        driver = session.driver
        assert isinstance(driver, Template)
        desk = Desk(session.device[1], driver)
        with listening(desk), only_session(session.device) as lock:
            live = Live(session, told.append, lock=lock)
            try:
                live.start()
                live.say(Word.ARM)
                until(lambda: live.look() is State.READY, "ready")
                live.say(Word.REARM, Word.ENGAGE)
                until(lambda: live.look() is State.ENGAGED, "engaged")
                until(lambda: bool(np.abs(desk.values(0)).max() > 5e-3), "it is cued")
                os.kill(live._children["controller"].pid, signal.SIGKILL)
                until(lambda: live.look() is State.READY, "returned")
            finally:
                live.end()
    code = 0.4 / 65535  # [m] of heave
    surge, heave, leg = (desk.values(axis) for axis in range(3))
    assert desk.texts == [b"on", b"off"]
    assert abs(heave[0] + 0.1) <= code
    assert abs(heave[-1] + 0.1) <= code
    assert abs(surge[-1]) < 1e-4
    assert np.abs(np.diff(heave)).max() < 5e-3  # no jump, also where a busy machine has skipped some ticks
    bottom = session.platform.six_legs().lengths(np.array([0.0, 0.0, -0.1, 0.0, 0.0, 0.0]))[0]
    assert abs(leg[-1] - bottom) < 1e-4
    assert "parked: commanded to park; the device reports nothing" in told
