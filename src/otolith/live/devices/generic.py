"""Our own set-point and feedback packets, for devices whose maker or builder can read them.

`otolith.live.wire.generic` describes the bytes. Words are sent as their place in `STATES`, `REQUESTS` and
`DEVICE_STATES`, so that these tuples are part of the format: they only ever grow at the end.
"""

from dataclasses import dataclass
from typing import Final, Literal, TypeVar

import numpy as np

from otolith.core.arrays import Vec
from otolith.live.devices.driver import Request
from otolith.live.devices.reach import Sent
from otolith.live.messages import DeviceState, Feedback, SetPoint, State
from otolith.live.wire.formats import Number, Values, WireError
from otolith.live.wire.generic import FEEDBACK, SET_POINT, seal, unseal

W = TypeVar("W", State, Request, DeviceState)

STATES: Final = tuple(State)
REQUESTS: Final = tuple(Request)
DEVICE_STATES: Final = tuple(DeviceState)
# bit of the fault word, from 0 -> its name
FAULTS: Final = (
    "emergency stop",
    "outside envelope",
    "command out of range",
    "watchdog",
    "drive",
    "limit switch",
    "communication",
    "another session's token",
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Generic:
    """A device that reads our own packets.

    Parameters
    ----------
    on_silence : what it does when packets stop; whoever builds it has to say.
    rate_hz : how many packets per second it wants.
    """

    on_silence: Literal["holds", "parks", "falls"]
    rate_hz: float = 1000.0
    name: str = "generic"
    reports: bool = True

    def check_reach(self, sent: Sent) -> None:
        """Accept every reach: who builds such a device reads the platform's file."""

    def encode(self, set_point: SetPoint, request: Request) -> bytes:
        """Return the packet for a set-point; see `driver.Driver`."""
        values: dict[str, tuple[Number, ...]] = {
            "token": (set_point.token,),
            "sequence": (set_point.sequence & 0xFFFFFFFF,),
            "time": (set_point.time_ns,),
            "state": (STATES.index(set_point.state),),
            "request": (REQUESTS.index(request),),
        }
        for kind in ("pose", "twist", "acceleration"):
            values |= _halves(kind, getattr(set_point, kind))
        return seal(SET_POINT, values)

    def decode(self, packet: bytes) -> Feedback:
        """Return what the device reports; see `driver.Driver`."""
        values = unseal(FEEDBACK, packet)
        word = int(values["faults"][0])
        if word >> len(FAULTS):
            bound = f"a combination of the bits {(1 << len(FAULTS)) - 1:#x}"
            raise WireError(f"faults of {FEEDBACK.name}", f"{word:#x}", bound)
        return Feedback(
            pose=_joined("pose", values),
            state=_word(DEVICE_STATES, values, "state", FEEDBACK.name),
            faults=tuple(name for bit, name in enumerate(FAULTS) if word >> bit & 1),
            sequence=int(values["sequence"][0]),
            token=int(values["token"][0]) or None,
        )


def read_set_point(packet: bytes) -> tuple[SetPoint, Request]:
    """Return what a set-point packet says: the device's side of `Generic.encode`.

    Raises
    ------
    WireError : the bytes are no such packet.
    """
    values = unseal(SET_POINT, packet)
    set_point = SetPoint(
        sequence=int(values["sequence"][0]),
        time_ns=int(values["time"][0]),
        pose=_joined("pose", values),
        twist=_joined("twist", values),
        acceleration=_joined("acceleration", values),
        state=_word(STATES, values, "state", SET_POINT.name),
        token=int(values["token"][0]),
    )
    return set_point, _word(REQUESTS, values, "request", SET_POINT.name)


def feedback_packet(feedback: Feedback, *, time_ns: int, token: int = 0) -> bytes:
    """Return the packet in which a device reports: the device's side of `Generic.decode`.

    Raises
    ------
    ValueError : the feedback has no pose, or names a fault that is not one of `FAULTS`.
    """
    if feedback.pose is None:
        raise ValueError("a generic feedback packet needs a measured pose")
    values: dict[str, tuple[Number, ...]] = {
        "token": (token,),
        "sequence": ((feedback.sequence or 0) & 0xFFFFFFFF,),
        "time": (time_ns,),
        "state": (DEVICE_STATES.index(feedback.state),),
        "faults": (sum(1 << FAULTS.index(name) for name in set(feedback.faults)),),
    }
    return seal(FEEDBACK, {**values, **_halves("pose", feedback.pose)})


def _halves(kind: str, six: Vec) -> dict[str, tuple[Number, ...]]:
    return {f"{kind} translation": tuple(six[:3].tolist()), f"{kind} rotation": tuple(six[3:].tolist())}


def _joined(kind: str, values: Values) -> Vec:
    return np.array([*values[f"{kind} translation"], *values[f"{kind} rotation"]])


def _word(words: tuple[W, ...], values: Values, name: str, source: str) -> W:
    """Return the word at the place that a packet names."""
    place = int(values[name][0])
    if place >= len(words):
        raise WireError(f"{name} of {source}", place, f"0 to {len(words) - 1}: {', '.join(map(str, words))}")
    return words[place]
