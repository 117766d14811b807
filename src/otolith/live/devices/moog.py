"""Moog motion bases over Ethernet in DOF mode: 32 bytes out, 40 bytes back, big endian, 60 packets per
second.

Source for the 6DOF2000E (interface definition CDS7237): the public C++ header of E. Loewenthal's MCIS
(2018, BSD licence), from which codes, bits and the order of the words are taken, and public excerpts of the
definition for the rules of each command. Directions, also from public excerpts: surge forward, lateral to
the right, heave downwards, roll to the right, pitch nose up, yaw to the right, in metres and radians.

**Two orders.** The newer definition CDS7330 has the words in another order (roll, pitch, yaw, surge, sway,
heave). A device that follows the one and is sent the other moves along wrong axes, so the user has to name
the document, and the axis test before the first engagement is mandatory. Of CDS7330 only the order is
public; that size, codes and states are as in CDS7237 is not verified.
"""

import math
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from otolith.core.arrays import Vec
from otolith.core.errors import InputError, one_of
from otolith.core.frames import AXES
from otolith.live.devices.driver import Request
from otolith.live.devices.reach import Sent, check_span
from otolith.live.messages import DeviceState, Feedback, SetPoint
from otolith.live.wire.formats import Field, Packet, Values

RATE_HZ: Final = 60.0
# command words of CDS7237
DISABLE, PARK, LOW_LIMITS_ON, LOW_LIMITS_OFF = 220, 210, 200, 190
ENGAGE, START, LENGTH_MODE, DOF_MODE = 180, 175, 172, 170
RESET, INHIBIT, MDA_MODE, NEW_POSITION = 160, 150, 140, 130
COMMANDS: Final = {
    Request.HOLD: NEW_POSITION,
    Request.START: START,
    Request.ENGAGE: ENGAGE,
    Request.MOVE: NEW_POSITION,
    Request.PARK: PARK,
    Request.RESET: RESET,
    Request.DISABLE: DISABLE,
}
# bit of the latched fault word -> name
FAULTS: Final = {
    0x8000: "emergency stop",
    0x4000: "snubber",
    0x2000: "actuator runaway",
    0x1000: "battery",
    0x0800: "low idle rate",
    0x0400: "motor thermal",
    0x0200: "command range",
    0x0100: "invalid frame",
    0x0080: "watchdog",
    0x0040: "limit switch",
    0x0020: "drive bus",
    0x0010: "amplifier",
    0x0008: "communication",
    0x0004: "homing",
    0x0002: "envelope",
    0x0001: "torque monitor",
}
# code in the four low bits of the machine state -> (name, what it is in the words that all devices share)
MACHINE_STATES: Final = {
    0x0: ("power up", DeviceState.OFF),
    0x1: ("idle", DeviceState.IDLE),
    0x2: ("standby", DeviceState.STANDBY),
    0x3: ("engaged", DeviceState.ENGAGED),
    0x7: ("parking", DeviceState.PARKING),
    0x8: ("fault 1", DeviceState.FAULT),
    0x9: ("fault 2", DeviceState.FAULT),
    0xA: ("fault 3", DeviceState.FAULT),
    0xB: ("disabled", DeviceState.OFF),
    0xC: ("inhibited", DeviceState.FAULT),
}
STATE_MASK: Final = 0x0F
MODE_MASK, DOF_BITS = 0x60, 0x20
# interface document -> order of the six words
ORDERS: Final = {
    "CDS7237": ("roll", "pitch", "heave", "surge", "yaw", "lateral"),
    "CDS7330": ("roll", "pitch", "yaw", "surge", "lateral", "heave"),
}
# word -> (place in our six-vectors, sign): Moog's y points right and z down
WORDS: Final = {
    "surge": (0, 1.0),
    "lateral": (1, -1.0),
    "heave": (2, -1.0),
    "roll": (3, 1.0),
    "pitch": (4, -1.0),
    "yaw": (5, -1.0),
}
LONGEST_START: Final = -0.4572  # [m] highest heave from which START may begin; 0 is the lowest
# Ends of each word alone [m, rad], in the order of `WORDS`: public figures for a base with CDS7330, apart
# from heave, which CDS7237 counts from home
LOWEST: Final = (-0.241, -0.259, LONGEST_START, *np.deg2rad([-21.0, -22.0, -22.0]).tolist())
HIGHEST: Final = (0.259, 0.259, 0.0, *np.deg2rad([21.0, 22.0, 22.0]).tolist())
_REMEDY: Final = (
    "narrow the limits of the session, or state reach = 'platform' of the device if its base goes as far as"
    " the platform's file says"
)


def _words(interface: str) -> tuple[Field, ...]:
    units = {word: "m" if place < 3 else "rad" for word, (place, _) in WORDS.items()}
    return tuple(Field(name=word, type="f32", unit=units[word]) for word in ORDERS[interface])


COMMAND_PACKETS: Final = {
    interface: Packet(
        name=f"Moog {interface} command",
        order=">",
        fields=(Field(name="command", type="u32"), *_words(interface)),
        tail=4,
    )
    for interface in ORDERS
}
REPLY_PACKETS: Final = {
    interface: Packet(
        name=f"Moog {interface} reply",
        order=">",
        fields=(
            *(Field(name=name, type="u32") for name in ("faults", "discrete", "machine state")),
            *_words(interface),
        ),
        tail=4,
    )
    for interface in ORDERS
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Moog:
    """A Moog base in DOF mode.

    Parameters
    ----------
    interface : the interface definition that the base follows, "CDS7237" or "CDS7330".
    neutral_heave : [m] the base's own heave, positive downwards, at our neutral pose; for CDS7237 within 0
        (at home) to -0.4572. No public document says where the middle of the travel is: measure it.
    reach : how far the base goes: as "public" figures of a small one say, or as the "platform"'s file does.
    """

    interface: str
    neutral_heave: float
    reach: Literal["public", "platform"] = "public"
    rate_hz: float = RATE_HZ
    on_silence: Literal["holds", "parks", "falls"] = "parks"
    reports: bool = True

    def __post_init__(self) -> None:
        if self.interface not in ORDERS:
            raise InputError("interface of moog", repr(self.interface), one_of(ORDERS, self.interface))
        if self.interface == "CDS7237" and not LONGEST_START <= self.neutral_heave <= 0.0:
            bound = f"within {LONGEST_START:g} to 0 m, as START allows"
            raise InputError("neutral_heave of moog", f"{self.neutral_heave:g} m", bound)
        if not np.isfinite(self.neutral_heave):
            raise InputError("neutral_heave of moog", self.neutral_heave, "a finite number of metres")

    @property
    def name(self) -> str:
        """Return the device's name and the document that it follows."""
        return f"moog {self.interface}"

    def check_reach(self, sent: Sent) -> None:
        """Refuse a platform that may be sent beyond the words of the base; see `driver.Driver`.

        Of CDS7330 it is not public where heave begins.
        """
        if self.reach == "platform":
            return
        for number, (word, (place, sign)) in enumerate(WORDS.items()):
            if word == "heave" and self.interface != "CDS7237":
                continue
            shift = self.neutral_heave if word == "heave" else 0.0
            low, high = sorted(sign * (end - shift) + 0.0 for end in (LOWEST[number], HIGHEST[number]))
            size, unit = (1.0, "m") if place < 3 else (180.0 / math.pi, "deg")
            needs = size * float(sent.low[place]), size * float(sent.high[place])
            check_span(f"{AXES[place]} of {self.name}", (size * low, size * high), needs, unit, _REMEDY)

    def encode(self, set_point: SetPoint, request: Request) -> bytes:
        """Return the packet for a set-point; see `driver.Driver`.

        ENGAGE sends all words exactly zero, START all but heave, as the base demands until it is engaged.
        """
        pose = set_point.pose if request not in (Request.ENGAGE, Request.START) else np.zeros(6)
        if not np.isfinite(pose).all():
            raise InputError(f"pose for {self.name}", pose.tolist(), "finite")
        words = {word: (sign * float(pose[place]) + 0.0,) for word, (place, sign) in WORDS.items()}
        lift = 0.0 if request is Request.ENGAGE else self.neutral_heave
        words["heave"] = (words["heave"][0] + lift,)
        return COMMAND_PACKETS[self.interface].encode({"command": (COMMANDS[request],), **words})

    def decode(self, packet: bytes) -> Feedback:
        """Return what the base reports; see `driver.Driver`. Fault bits are reported by name."""
        values = REPLY_PACKETS[self.interface].decode(packet)
        word, machine = int(values["faults"][0]), int(values["machine state"][0])
        _, state = MACHINE_STATES.get(machine & STATE_MASK, ("", DeviceState.UNKNOWN))
        faults = [name for bit, name in FAULTS.items() if word & bit]
        if machine & STATE_MASK == 0xC:
            faults.append("inhibited")
        if machine & MODE_MASK != DOF_BITS:
            faults.append("not in DOF mode")
        return Feedback(pose=self._pose(values), state=state, faults=tuple(faults))

    def _pose(self, values: Values) -> Vec:
        pose = np.empty(6)
        for word, (place, sign) in WORDS.items():
            stated = values[word][0] - (self.neutral_heave if word == "heave" else 0.0)
            pose[place] = sign * stated + 0.0  # adding zero makes -0.0 a plain zero
        return pose
