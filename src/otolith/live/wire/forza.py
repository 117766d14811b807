"""Forza Motorsport and Forza Horizon: "data out", of which all variants begin with the same 232 bytes.

Source: Turn 10's documents of the data-out feature. Axes of the car: X right, Y up, Z forward, a left-handed
frame; angular velocity is X pitch, Y yaw, Z roll. Whether gravity is in the acceleration is not documented: a
level rest shows it (`learned`).
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from otolith.live.messages import Flag, Telemetry
from otolith.live.wire.formats import Field, Packet, WireError, turning, vector

_AXES: Final = "right up forward"
_SLED: Final = (
    Field(name="IsRaceOn", type="i32"),
    Field(name="TimestampMS", type="u32", unit="ms"),
    Field(name="engine speeds", type="pad", count=12),
    Field(name="Acceleration", type="f32", count=3, unit="m/s²", axes=_AXES),
    Field(name="Velocity", type="f32", count=3, unit="m/s", axes=_AXES),
    Field(name="AngularVelocity", type="f32", count=3, unit="rad/s", axes=_AXES),
    Field(name="Yaw, Pitch, Roll", type="pad", count=12),  # signs are not documented
    Field(name="wheels and car", type="pad", count=164),
)
# size -> where it comes from; all begin with the same 232 bytes
VARIANTS: Final = {
    232: "Sled",
    311: "Motorsport 7 Dash",
    324: "Horizon 4 to 6",
    331: "Motorsport 2023",
}
PACKETS: Final = {
    size: Packet(name=f"Forza packet ({kind})", fields=_SLED, tail=size - 232)
    for size, kind in VARIANTS.items()
}
_TURN: Final = turning(_AXES)
_TURN_RATE: Final = turning(_AXES, rotation=True)


@dataclass(frozen=True, slots=True)
class Forza:
    """Any variant of Forza's packet: 232, 311, 324 or 331 bytes, told apart by their size."""

    name: str = "forza"

    def parse(self, packet: bytes) -> Telemetry:
        """Return the sample that a packet holds; see `source.Source`."""
        if len(packet) not in PACKETS:
            sizes = " or ".join(map(str, PACKETS))
            raise WireError("size of Forza packet", f"{len(packet)} bytes", f"{sizes} bytes")
        values = PACKETS[len(packet)].decode(packet)
        on = values["IsRaceOn"][0]
        if on not in (0, 1):
            raise WireError("IsRaceOn of Forza packet", on, "0 or 1")
        velocity = vector(values, "Velocity", _TURN)
        return Telemetry(
            sender_ns=round(values["TimestampMS"][0] * 1e9),
            flags=Flag.RUNNING if on else Flag.PAUSED,
            acceleration=vector(values, "Acceleration", _TURN),
            angular_rate=vector(values, "AngularVelocity", _TURN_RATE),
            velocity=velocity,
            speed=float(np.linalg.norm(velocity)),
        )
