"""What every driver of a motion platform does: it turns set-points into packets and packets into feedback."""

from dataclasses import replace
from enum import StrEnum
from typing import Literal, Protocol

import numpy as np

from otolith.live.devices.reach import Sent
from otolith.live.messages import Feedback, SetPoint


class Request(StrEnum):
    """What the session asks of a device, beside the pose: one request per packet."""

    HOLD = "hold"  # keep the connection alive; nothing moves
    START = "start"  # apply power and rise to the neutral pose, where the device does so itself
    ENGAGE = "engage"  # apply power at the device's own zero
    MOVE = "move"  # follow the pose of the set-point
    PARK = "park"  # go to the park pose by the device's own means, and remove power
    RESET = "reset"  # leave a fault
    DISABLE = "disable"  # end communication; most devices then need a power cycle


class Driver(Protocol):
    """The bytes of one kind of device. A driver is immutable and pure: who owns the socket calls it."""

    @property
    def name(self) -> str:
        """Return the device's name, and the interface document that the driver follows."""

    @property
    def rate_hz(self) -> float:
        """Return how many packets per second the device expects."""

    @property
    def on_silence(self) -> Literal["holds", "parks", "falls"]:
        """Return what the device does if packets stop; one that falls must be brought to rest first."""

    @property
    def reports(self) -> bool:
        """Return whether the device answers; one that does not is driven in open loop."""

    def check_reach(self, sent: Sent) -> None:
        """Refuse a device that cannot go wherever the platform may be sent.

        Raises
        ------
        InputError : one of its axes spans less.
        """

    def encode(self, set_point: SetPoint, request: Request) -> bytes:
        """Return the packet for a set-point; empty where nothing is to be sent.

        Raises
        ------
        InputError : the pose is outside what the packet can express.
        """

    def decode(self, packet: bytes) -> Feedback:
        """Return what the device reports.

        Raises
        ------
        WireError : the bytes are no packet of this device.
        """


def judged(feedback: Feedback, token: int) -> Feedback:
    """Return what a device reports with what is wrong about it among its faults.

    That is a pose that is no number, which is left out, and the token of another session.
    """
    wrong = feedback.faults
    if feedback.token not in (None, token):
        wrong += (f"it follows another session, of token {feedback.token}",)
    if feedback.pose is None or bool(np.isfinite(feedback.pose).all()):
        return feedback if wrong is feedback.faults else replace(feedback, faults=wrong)
    return replace(feedback, faults=(*wrong, "its measured pose is no number"), pose=None)
