"""What every driver of a motion platform does: it turns set-points into packets and packets into feedback."""

from enum import StrEnum
from typing import Literal, Protocol

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
