"""A software Moog base: it moves in virtual time, and refuses what the base refuses.

Rules of the interface definition CDS7237 (`moog` names the source): ENGAGE only in idle, with all words
exactly zero and held until the base is engaged; START alike, with heave within 0 to -0.4572 m; PARK only in
engaged or standby; RESET only in a fault or when inhibited; DISABLE ends communication until the power is
cycled; DOF mode and INHIBIT only in idle and power up. What no public document states, and is therefore
ours: a command that is refused is noted and has no effect, except that a position outside the range, or one
that jumps faster than the base can move, is a fault; the watchdog waits six packets; the base rises and
sinks at 0.1 m/s; in a fault it brakes and sinks home.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final, Self

import numpy as np

from otolith.core.arrays import Vec, freeze
from otolith.core.errors import InputError, one_of
from otolith.live.core.bounds import bounds_of
from otolith.live.devices import moog
from otolith.live.devices.moog import COMMAND_PACKETS, ORDERS, REPLY_PACKETS
from otolith.live.wire.formats import WireError
from otolith.platforms import Platform

STEP_NS: Final = 1_000_000  # [ns] of virtual time between two steps of the motion
WATCHDOG_NS: Final = 100_000_000  # [ns] six packets at 60 Hz
LIFT: Final = 0.1  # [m/s] at which the base rises to its start and sinks home
HOME_WITHIN: Final = 1e-4  # [m and rad] within which the base is at home, or at its start
POWER_UP, IDLE, STANDBY, ENGAGED, PARKING = 0x0, 0x1, 0x2, 0x3, 0x7
FAULT_2, DISABLED, INHIBITED = 0x9, 0xB, 0xC
ESTOP, INVALID, RANGE, WATCHDOG, ENVELOPE = 0x8000, 0x0100, 0x0200, 0x0080, 0x0002
_WORDS: Final = tuple(moog.WORDS)  # surge, lateral, heave, roll, pitch, yaw


@dataclass(frozen=True, slots=True, kw_only=True)
class Envelope:
    """What the base can do, in its own words: surge, lateral, heave [m], roll, pitch, yaw [rad].

    The defaults are public figures; see `moog.LOWEST`.
    """

    low: Vec = field(default_factory=lambda: np.array(moog.LOWEST))
    high: Vec = field(default_factory=lambda: np.array(moog.HIGHEST))
    speed: Vec = field(default_factory=lambda: np.array([0.5, 0.5, 0.3, *np.deg2rad([30, 30, 40])]))
    acceleration: Vec = field(default_factory=lambda: np.array([5.9, 5.9, 4.9, *np.deg2rad([500, 500, 400])]))

    def __post_init__(self) -> None:
        freeze(self, low=(6,), high=(6,), speed=(6,), acceleration=(6,))

    @classmethod
    def holding(cls, platform: Platform, neutral_heave: float) -> Self:
        """Return the default, as much larger as a platform needs that is rehearsed on it.

        Parameters
        ----------
        neutral_heave : as of `moog.Moog`.
        """
        least, bounds = cls(), bounds_of(platform, platform.actuators.lag_s)
        signs = np.array([sign for _, sign in moog.WORDS.values()])
        shift = np.where(np.array(_WORDS) == "heave", neutral_heave, 0.0)
        ends = signs * np.array([bounds.low - HOME_WITHIN, bounds.high + HOME_WITHIN]) + shift
        moving = (bounds.twist, bounds.acceleration)
        speed, acceleration = (np.where(np.isfinite(of), of, 0.0) for of in moving)
        return cls(
            low=np.minimum(least.low, ends.min(axis=0)),
            high=np.maximum(least.high, ends.max(axis=0)),
            speed=np.maximum(least.speed, speed),
            acceleration=np.maximum(least.acceleration, acceleration),
        )


class MoogEmulator:
    """A Moog base that is at home, powered, in DOF mode.

    Parameters
    ----------
    interface : as of `moog.Moog`.
    envelope : what the base can do.
    """

    def __init__(self, interface: str = "CDS7237", envelope: Envelope | None = None) -> None:
        if interface not in ORDERS:
            raise InputError("interface of the emulator", repr(interface), one_of(ORDERS, interface))
        self.interface = interface
        self.envelope = envelope or Envelope()
        self.refusals: list[str] = []  # sentences: what was refused, and why
        self._power_up(0)

    def _power_up(self, now_ns: int) -> None:
        self.state, self.faults = IDLE, 0
        self.pressed = False  # the emergency stop
        self.position, self.velocity = np.zeros(6), np.zeros(6)  # in the words of `Envelope`
        self.target, self._start = np.zeros(6), np.zeros(6)
        self._now, self._last_packet = now_ns, now_ns
        self._target_since = now_ns  # [ns] when the target last changed

    def cycle_power(self, now_ns: int) -> None:
        """Switch the base off and on: it is at home and idle, whatever it was."""
        self._power_up(now_ns)

    def press_stop(self, now_ns: int) -> None:
        """Press the emergency stop; it stays pressed until `release_stop`, which does not start anything."""
        self.tick(now_ns)
        self.pressed = True
        self._fail(ESTOP)

    def release_stop(self) -> None:
        """Release the emergency stop. The fault stays latched."""
        self.pressed = False

    def inject(self, bit: int, now_ns: int) -> None:
        """Latch one of the fault bits of `moog.FAULTS`."""
        self.tick(now_ns)
        self._fail(bit)

    @property
    def fault_names(self) -> tuple[str, ...]:
        """Return the latched faults by name."""
        return tuple(name for bit, name in moog.FAULTS.items() if self.faults & bit)

    def receive(self, packet: bytes, now_ns: int) -> bytes | None:
        """Take in a command and return the base's reply; None once it is disabled.

        A packet that is no command is an invalid frame: a fault while the base is powered.
        """
        self.tick(now_ns)
        if self.state == DISABLED:
            return None
        try:
            values = COMMAND_PACKETS[self.interface].decode(packet)
        except WireError as error:
            self.refusals.append(str(error))
            if self.state in (STANDBY, ENGAGED):
                self._fail(INVALID)
            return self.reply()
        self._last_packet = now_ns
        words = np.array([values[word][0] for word in _WORDS])
        self._obey(int(values["command"][0]), words)
        return self.reply()

    def tick(self, now_ns: int) -> None:
        """Move on to a time [ns]; times before the last one change nothing."""
        while self._now + STEP_NS <= now_ns:
            self._now += STEP_NS
            if self.state in (STANDBY, ENGAGED) and self._now - self._last_packet > WATCHDOG_NS:
                self._fail(WATCHDOG)
            self._move(STEP_NS * 1e-9)

    def reply(self) -> bytes:
        """Return the packet in which the base reports itself."""
        words: Mapping[str, tuple[float, ...]] = dict(
            zip(_WORDS, self.position[:, None].tolist(), strict=True)
        )
        values = {"faults": (self.faults,), "machine state": (self.state | moog.DOF_BITS,), **words}
        return REPLY_PACKETS[self.interface].encode(values)

    def _obey(self, command: int, words: Vec) -> None:
        match command:
            case moog.ENGAGE | moog.START:
                self._engage(command, words)
            case moog.NEW_POSITION:
                self._follow(words)
            case moog.PARK if self._allowed("PARK", ENGAGED, STANDBY):
                self.state = PARKING
            case moog.RESET if self._allowed("RESET", FAULT_2, INHIBITED):
                self._reset()
            case moog.INHIBIT if self._allowed("INHIBIT", IDLE, POWER_UP):
                self.state = INHIBITED
            case moog.DISABLE:
                self.state = DISABLED
            case moog.DOF_MODE:
                self._allowed("DOF MODE", IDLE, POWER_UP)
            case moog.PARK | moog.RESET | moog.INHIBIT:
                pass  # refused above
            case _:
                self._refuse(f"command {command}", "a command of DOF mode")

    def _engage(self, command: int, words: Vec) -> None:
        """Begin to rise. The same words must come until the base is engaged."""
        name = "START" if command == moog.START else "ENGAGE"
        if (
            self.state == ENGAGED
            and np.array_equal(words, self._start)
            and np.array_equal(words, self.target)
        ):
            return  # sent before the reply that says "engaged" has arrived
        if self.state == STANDBY:
            if not np.array_equal(words, self._start):
                self._refuse(f"{name} with changed words in standby", "held until the base is engaged")
            return
        if not self._allowed(name, IDLE):
            return
        lift, others = float(words[2]), np.delete(words, 2)
        right = moog.LONGEST_START <= lift <= 0.0 if name == "START" else lift == 0.0
        if np.any(others != 0.0) or not right:
            bound = f"0, heave within {moog.LONGEST_START:g} to 0 m" if name == "START" else "exactly 0"
            self._refuse(f"{name} with {np.round(words, 6).tolist()}", bound)
            return
        self.state, self._start, self.target = STANDBY, words, words

    def _follow(self, words: Vec) -> None:
        """Take a position as the target while engaged; in other states it only keeps the connection alive."""
        if self.state == STANDBY and not np.allclose(words, self._start, rtol=0.0, atol=HOME_WITHIN):
            self._refuse("NEW POSITION in standby", "the start position, held until the base is engaged")
        if self.state != ENGAGED:
            return
        if np.any(words < self.envelope.low) or np.any(words > self.envelope.high):
            self._fail(RANGE)
            return
        time = (
            1e-9 * (self._now - self._target_since) + 1.0 / moog.RATE_HZ
        )  # a packet may come one period late
        if np.any(np.abs(words - self.target) > self.envelope.speed * time):
            self._fail(ENVELOPE)
            return
        self.target, self._target_since = words, self._now

    def _reset(self) -> None:
        if self.pressed:
            self._refuse("RESET", "sent after the emergency stop is released")
            return
        if np.any(np.abs(self.position) > HOME_WITHIN):
            self._refuse("RESET", "sent when the base is at home")
            return
        self.state, self.faults = IDLE, 0

    def _allowed(self, name: str, *states: int) -> bool:
        if self.state in states:
            return True
        names = " or ".join(moog.MACHINE_STATES[state][0] for state in states)
        self._refuse(f"{name} in {moog.MACHINE_STATES[self.state][0]}", f"sent in {names}")
        return False

    def _refuse(self, what: str, bound: str) -> None:
        self.refusals.append(f"{what} is refused: must be {bound}")

    def _fail(self, bit: int) -> None:
        """Latch a fault; the base brakes and sinks home."""
        self.faults |= bit
        if self.state != DISABLED:
            self.state = FAULT_2

    def _move(self, dt: float) -> None:
        """Follow the target within speed and acceleration, and change state on arrival."""
        limit = self.envelope.speed
        if self.state in (PARKING, FAULT_2, DISABLED):
            self.target = np.zeros(6)
        if self.state != ENGAGED:
            limit = limit * (LIFT / limit[2])
        gap = self.target - self.position
        stopping = np.sqrt(2.0 * self.envelope.acceleration * np.abs(gap))
        wanted = np.sign(gap) * np.minimum.reduce([limit, stopping, np.abs(gap) / dt])
        step = self.envelope.acceleration * dt
        self.velocity = self.velocity + np.clip(wanted - self.velocity, -step, step)
        self.position = self.position + self.velocity * dt
        arrived = bool(np.all(np.abs(self.target - self.position) < HOME_WITHIN))
        if arrived and self.state == STANDBY:
            self.state, self._target_since = ENGAGED, self._now
        elif arrived and self.state == PARKING:
            self.state = IDLE
