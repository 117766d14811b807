"""Live for Speed: OutSim (64 bytes, 68 with an ID) and OutSimPack2, whose parts a bit mask chooses.

Source: InSim.txt and OutSimPack.txt, which come with the game. World axes: at heading zero X points right,
Y forward, Z up; heading, pitch and roll count anticlockwise seen from above, from the right, and from the
front. Gravity is not included. Acceleration, velocity and angular velocity are projected on the car by the
attitude; one public reader takes them for the car's axes already, which `frame="car"` does and a circle
decides.
"""

from dataclasses import dataclass, field
from typing import Final

import numpy as np

from otolith.core.errors import InputError, one_of
from otolith.live.messages import Telemetry
from otolith.live.wire.attitude import from_angles, matrix
from otolith.live.wire.formats import Field, Packet, Values, WireError, turning, vector

_AXES: Final = "right forward up"
FRAMES: Final = ("world", "car")
_MAIN: Final = (
    Field(name="AngVel", type="f32", count=3, unit="rad/s", axes=_AXES),
    Field(name="Heading", type="f32", unit="rad"),
    Field(name="Pitch", type="f32", unit="rad"),
    Field(name="Roll", type="f32", unit="rad"),
    Field(name="Accel", type="f32", count=3, unit="m/s²", axes=_AXES),
    Field(name="Vel", type="f32", count=3, unit="m/s", axes=_AXES),
    Field(name="Pos", type="i32", count=3, unit="m/65536", axes=_AXES),
)
_TIME: Final = Field(name="Time", type="u32", unit="ms")
_ID: Final = Field(name="ID", type="i32")
PACKETS: Final = {
    64: Packet(name="OutSim packet", fields=(_TIME, *_MAIN)),
    68: Packet(name="OutSim packet with ID", fields=(_TIME, *_MAIN, _ID)),
}
# bit of OutSim Opts -> the part of OutSimPack2 that it adds, in this order
PARTS: Final[dict[int, tuple[Field, ...]]] = {
    0x001: (Field(name="header", type="u8", count=4),),
    0x002: (_ID,),
    0x004: (_TIME,),
    0x008: _MAIN,
    0x010: (Field(name="inputs", type="pad", count=20),),
    0x020: (Field(name="drive", type="pad", count=12),),
    0x040: (Field(name="distance", type="pad", count=8),),
    0x080: (Field(name="wheels", type="pad", count=160),),
    0x100: (Field(name="steering torque", type="pad", count=8),),
}
MAIN: Final = 0x008
_TURN: Final = turning(_AXES)


@dataclass(frozen=True, slots=True)
class OutSim:
    """LFS's OutSim packet of 64 or 68 bytes.

    Parameters
    ----------
    frame : "world" as InSim.txt says, or "car" if a circle shows that the vectors are in the car's axes.
    """

    frame: str = "world"
    name: str = "lfs"

    def __post_init__(self) -> None:
        _check_frame(self.frame)

    def parse(self, packet: bytes) -> Telemetry:
        """Return the sample that a packet holds; see `source.Source`."""
        if len(packet) not in PACKETS:
            raise WireError("size of OutSim packet", f"{len(packet)} bytes", "64 bytes, or 68 with an ID")
        return _telemetry(PACKETS[len(packet)].decode(packet), self.frame)


@dataclass(frozen=True, slots=True)
class OutSim2:
    """LFS's OutSimPack2 with the parts that OutSim Opts in the game's cfg.txt chooses.

    Parameters
    ----------
    options : the bit mask of OutSim Opts; it is not in the packet, so the user states it.
    frame : as of `OutSim`.
    """

    options: int
    frame: str = "world"
    name: str = "lfs2"
    packet: Packet = field(init=False)

    def __post_init__(self) -> None:
        _check_frame(self.frame)
        if not self.options & MAIN or self.options & ~sum(PARTS):
            bits = ", ".join(f"{bit:#x}" for bit in PARTS)
            bound = f"a sum of the bits {bits} with {MAIN:#x}, which holds motion"
            raise InputError("OutSim Opts of lfs2", f"{self.options:#x}", bound)
        fields = [one for bit, part in PARTS.items() if self.options & bit for one in part]
        has_header = bool(self.options & 0x001)
        made = Packet(
            name=f"OutSimPack2 ({self.options:#x})",
            magic=b"LFST" if has_header else b"",
            fields=tuple(fields[1:] if has_header else fields),
        )
        object.__setattr__(self, "packet", made)

    def parse(self, packet: bytes) -> Telemetry:
        """Return the sample that a packet holds; see `source.Source`."""
        return _telemetry(self.packet.decode(packet), self.frame)


def _check_frame(frame: str) -> None:
    if frame not in FRAMES:
        raise InputError("frame of lfs", repr(frame), one_of(FRAMES, frame))


def _telemetry(values: Values, frame: str) -> Telemetry:
    attitude = from_angles(values["Roll"][0], -values["Pitch"][0], values["Heading"][0])
    to_car = matrix(attitude).T if frame == "world" else np.eye(3)
    velocity = vector(values, "Vel", _TURN)
    return Telemetry(
        sender_ns=round(values["Time"][0] * 1e9) if "Time" in values else None,
        acceleration=to_car @ vector(values, "Accel", _TURN),
        angular_rate=to_car @ vector(values, "AngVel", _TURN),
        attitude=attitude,
        velocity=to_car @ velocity,
        position=vector(values, "Pos", _TURN),
        speed=float(np.linalg.norm(velocity)),
        source_id=int(values["ID"][0]) if "ID" in values else 0,
    )
