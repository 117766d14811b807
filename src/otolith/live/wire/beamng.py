"""BeamNG.drive, protocol MotionSim: 88 bytes that begin with "BNG1", sent by the game's motionSim.lua.

Source: the two public versions of motionSim.lua. Both send the negated accelerometer, "gravity not included",
in the vehicle's axes, and the velocity in world axes; the older one sends roll and pitch as negated Euler
angles and yaw as it is, the newer one (it also smooths: set its smoothers to 0) roll and yaw negated. Which
way each angle and axis counts is not documented, so nothing is turned beyond the documented difference of
sign; `learned` finds the rest.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from otolith.core.errors import InputError, one_of
from otolith.live.messages import Telemetry
from otolith.live.wire.attitude import from_angles
from otolith.live.wire.formats import Field, OtherPacket, Packet, turning, vector

_AXES: Final = "right forward up"  # nominal: sway, surge, heave; to be learned
PACKET: Final = Packet(
    name="BeamNG MotionSim packet",
    magic=b"BNG1",
    fields=(
        Field(name="position", type="f32", count=3, unit="m"),
        Field(name="velocity", type="f32", count=3, unit="m/s"),  # in world axes, z up
        Field(name="acceleration", type="f32", count=3, unit="m/s²", axes=_AXES),
        Field(name="up vector", type="f32", count=3, unit="unit"),
        Field(name="roll, pitch, yaw", type="f32", count=3, unit="rad"),
        Field(name="roll, pitch, yaw rate", type="f32", count=3, unit="rad/s"),
        Field(name="roll, pitch, yaw acceleration", type="f32", count=3, unit="rad/s²"),
    ),
)
# Factors that bring both versions to one convention: angles as the older file's Euler angles with yaw
# positive; rates are the vehicle's in both.
SIGNS: Final = {"old": (1.0, 1.0, 1.0), "new": (1.0, -1.0, -1.0)}
_TURN: Final = turning(_AXES)


@dataclass(frozen=True, slots=True)
class BeamNG:
    """BeamNG's MotionSim packet.

    Parameters
    ----------
    signs : "old" or "new": which version of motionSim.lua sends it.
    """

    signs: str = "new"
    name: str = "beamng"

    def __post_init__(self) -> None:
        if self.signs not in SIGNS:
            raise InputError("signs of beamng", repr(self.signs), one_of(SIGNS, self.signs))

    def parse(self, packet: bytes) -> Telemetry:
        """Return the sample that a packet holds; see `source.Source`."""
        if len(packet) in (92, 96) and not packet.startswith(b"BNG"):
            raise OtherPacket(
                "size of BeamNG packet", f"{len(packet)} bytes (OutGauge)", "88 bytes (MotionSim)"
            )
        values = PACKET.decode(packet)
        roll, pitch, yaw = np.array(values["roll, pitch, yaw"]) * SIGNS[self.signs]
        velocity = np.array(values["velocity"])
        return Telemetry(
            acceleration=vector(values, "acceleration", _TURN),
            angular_rate=np.array(values["roll, pitch, yaw rate"]),
            attitude=from_angles(roll, pitch, yaw),
            velocity=velocity,
            position=np.array(values["position"]),
            speed=float(np.linalg.norm(velocity)),
        )
