"""Devices of the virtual world: an ideal one, and the software Moog base behind its packets."""

from dataclasses import dataclass, field
from typing import Final, Protocol

import numpy as np

from otolith.core.arrays import Vec
from otolith.live.devices.driver import Request
from otolith.live.devices.emulator import Envelope, MoogEmulator
from otolith.live.devices.moog import FAULTS, Moog
from otolith.live.messages import DeviceState, Feedback, SetPoint

MS: Final = 1_000_000  # [ns]


@dataclass(slots=True)
class IdealDevice:
    """A platform that follows, with a state machine of its own and a watchdog.

    Parameters
    ----------
    park : (6,) [m, rad]. lag : [s] with which it follows. engages : [s] that it takes to engage.
    """

    park: Vec
    lag: float = 0.02
    engages: float = 0.3
    watchdog_ns: int = 50 * MS
    state: DeviceState = DeviceState.IDLE
    faults: tuple[str, ...] = ()
    shown: DeviceState | None = None  # what it reports instead of its state: a fault
    offset: Vec = field(default_factory=lambda: np.zeros(6))  # of what it measures: a fault
    share: Vec = field(default_factory=lambda: np.ones(6))  # of the way that it goes: a fault
    refuses: bool = False  # to engage: a fault
    token: int | None = None  # of another session that it follows: a fault
    mute: bool = False  # sends no replies: a fault
    pose: Vec = field(default_factory=lambda: np.zeros(6))
    _target: Vec = field(default_factory=lambda: np.zeros(6))
    _heard_ns: int = -1
    _moved_ns: int = 0
    _since_ns: int = 0

    def __post_init__(self) -> None:
        self.pose, self._target = self.park.copy(), self.park.copy()

    def receive(self, now_ns: int, set_point: SetPoint, request: Request) -> None:
        """Take in a packet."""
        self._heard_ns = now_ns
        match request:
            case Request.ENGAGE if self.state is DeviceState.IDLE and not self.refuses:
                self._go(now_ns, DeviceState.STANDBY)
            case Request.MOVE if self.state is DeviceState.ENGAGED:
                self._target = self.park + self.share * (set_point.pose - self.park)
            case Request.PARK if self.state in {DeviceState.ENGAGED, DeviceState.STANDBY}:
                self._go(now_ns, DeviceState.PARKING)
            case Request.RESET if self.state is DeviceState.FAULT:
                self.faults = ()
                self._go(now_ns, DeviceState.PARKING)

    def step(self, now_ns: int) -> None:
        """Move until now."""
        dt, self._moved_ns = 1e-9 * (now_ns - self._moved_ns), now_ns
        powered = self.state in {DeviceState.ENGAGED, DeviceState.STANDBY}
        if powered and now_ns - self._heard_ns > self.watchdog_ns:
            self.fail(now_ns, "watchdog")
        if self.state is DeviceState.STANDBY and 1e-9 * (now_ns - self._since_ns) >= self.engages:
            self._target = self.pose.copy()
            self._go(now_ns, DeviceState.ENGAGED)
        if self.state is DeviceState.ENGAGED:
            self.pose = self.pose + (1.0 - np.exp(-dt / self.lag)) * (self._target - self.pose)
        elif self.state in {DeviceState.PARKING, DeviceState.FAULT}:
            self.pose = self.pose + (1.0 - np.exp(-dt / 0.5)) * (self.park - self.pose)
            if self.state is DeviceState.PARKING and float(np.abs(self.pose - self.park).max()) < 1e-3:
                self._go(now_ns, DeviceState.IDLE)

    def feedback(self) -> Feedback | None:
        """Return what it reports."""
        if self.mute:
            return None
        pose, state = self.pose + self.offset, self.shown or self.state
        return Feedback(pose=pose, state=state, faults=self.faults, token=self.token)

    def fail(self, now_ns: int, *faults: str) -> None:
        """Fail: power goes, and the platform sinks to where it rests."""
        self.faults = faults
        self._go(now_ns, DeviceState.FAULT)

    def _go(self, now_ns: int, state: DeviceState) -> None:
        self.state, self._since_ns = state, now_ns


class MoogDevice:
    """The software Moog base as a device of this world, through the bytes of its packets.

    Parameters
    ----------
    neutral_heave : as of `otolith.live.devices.moog.Moog`.
    envelope : as of `otolith.live.devices.emulator.MoogEmulator`.
    """

    def __init__(self, neutral_heave: float = -0.2, envelope: Envelope | None = None) -> None:
        self.driver = Moog(interface="CDS7237", neutral_heave=neutral_heave)
        self.base = MoogEmulator(envelope=envelope)
        self.park = np.array([0.0, 0.0, neutral_heave, 0.0, 0.0, 0.0])  # at home

    def receive(self, now_ns: int, set_point: SetPoint, request: Request) -> None:
        """Take in a packet."""
        self.base.receive(self.driver.encode(set_point, request), now_ns)

    def step(self, now_ns: int) -> None:
        """Move until now."""
        self.base.tick(now_ns)

    def feedback(self) -> Feedback:
        """Return what it reports."""
        return self.driver.decode(self.base.reply())

    @property
    def pose(self) -> Vec:
        """Return the pose (6,) in our axes."""
        measured = self.feedback().pose
        return np.zeros(6) if measured is None else measured

    @property
    def state(self) -> DeviceState:
        """Return its state in the words that all devices share."""
        return self.feedback().state

    @property
    def faults(self) -> tuple[str, ...]:
        """Return its latched faults."""
        return self.base.fault_names

    def fail(self, now_ns: int, *faults: str) -> None:
        """Latch faults by name."""
        for bit, name in FAULTS.items():
            if name in faults:
                self.base.inject(bit, now_ns)


class Machine(Protocol):
    """What this world asks of a device."""

    def receive(self, now_ns: int, set_point: SetPoint, request: Request) -> None:
        """Take in a packet."""

    def step(self, now_ns: int) -> None:
        """Move until now."""

    def feedback(self) -> Feedback | None:
        """Return what it reports; None if nothing."""

    def fail(self, now_ns: int, *faults: str) -> None:
        """Fail with faults of its own."""

    @property
    def pose(self) -> Vec:
        """Return the pose (6,) in our axes."""

    @property
    def state(self) -> DeviceState:
        """Return its state."""

    @property
    def faults(self) -> tuple[str, ...]:
        """Return its faults."""
