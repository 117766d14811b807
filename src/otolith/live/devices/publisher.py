"""The platform's pose for others, such as a headset's motion compensation: our own packet, or a MAVLink
frame.

MARSH's MAVLink message MOTION_PLATFORM_STATE (52502 since 2025-05-16) is a state report: y points right, z
down, pitch is positive nose up and yaw to the right. The frame is written by hand after the MAVLink 2
specification, from the message's list of fields in the dialect's XML. That MARSH's own tools accept it has
not been tried; the message is marked there as work in progress.
"""

import struct
from dataclasses import dataclass
from typing import Final

import numpy as np

from otolith.core.arrays import Vec
from otolith.live.devices.generic import feedback_packet
from otolith.live.messages import DeviceState, Feedback, SetPoint, State

MESSAGE: Final = "MOTION_PLATFORM_STATE"
MESSAGE_ID: Final = 52502
# fields in the order of the wire: MAVLink sends the larger ones first, else as the XML lists them
FIELDS: Final = (
    ("uint32_t", "time_boot_ms"),
    *(
        ("float", f"{kind}{axis}")
        for kind in ("", "vel_", "acc_")
        for axis in ("x", "y", "z", "roll", "pitch", "yaw")
    ),
    ("uint8_t", "health"),
    ("uint8_t", "mode"),
)
PAYLOAD: Final = struct.Struct("<I18f2B")
SIGNS: Final = np.array([1.0, -1.0, -1.0, 1.0, -1.0, -1.0])  # ours to y right, z down, nose up
# MOTION_PLATFORM_MODE: off, settled, neutral, stopped anywhere, in motion
OFF, SETTLED, NEUTRAL, FROZEN, ENGAGED = 2, 3, 4, 5, 6
MODES: Final = {
    State.IDLE: OFF,
    State.CHECKING: OFF,
    State.ENGAGING: ENGAGED,
    State.READY: NEUTRAL,
    State.ENGAGED: ENGAGED,
    State.HOLDING: ENGAGED,
    State.RETURNING: ENGAGED,
    State.PARKING: ENGAGED,
    State.PARKED: SETTLED,
    State.FAULT: FROZEN,
}
HEALTH_OK, HEALTH_CRITICAL = 0, 2  # MOTION_PLATFORM_HEALTH: ok, warning, critical


def checksum(data: bytes, crc: int = 0xFFFF) -> int:
    """Return MAVLink's checksum, CRC-16/MCRF4XX: polynomial 0x1021 reflected, begun with all bits set."""
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ 0x8408 if crc & 1 else crc >> 1
    return crc


def crc_extra() -> int:
    """Return the byte that stands for the message's fields, computed as MAVLink prescribes."""
    text = f"{MESSAGE} " + "".join(f"{kind} {name} " for kind, name in FIELDS)
    crc = checksum(text.encode())
    return crc & 0xFF ^ crc >> 8


CRC_EXTRA: Final = crc_extra()


@dataclass(frozen=True, slots=True, kw_only=True)
class Marsh:
    """Writes MOTION_PLATFORM_STATE frames.

    Parameters
    ----------
    system, component : MAVLink ids of this platform in its network.
    """

    system: int = 1
    component: int = 1

    def packet(self, set_point: SetPoint) -> bytes:
        """Return the frame that reports the state which a set-point commands."""
        motion = np.concatenate(
            [SIGNS * getattr(set_point, kind) for kind in ("pose", "twist", "acceleration")]
        )
        health = HEALTH_CRITICAL if set_point.state is State.FAULT else HEALTH_OK
        time_ms = set_point.time_ns // 1_000_000 & 0xFFFFFFFF
        payload = PAYLOAD.pack(time_ms, *(motion + 0.0), health, MODES[set_point.state])
        payload = payload.rstrip(b"\0") or b"\0"  # MAVLink 2 leaves out zeros at the end
        head = struct.pack("<5B", len(payload), 0, 0, set_point.sequence & 0xFF, self.system)
        head += struct.pack("<B", self.component) + MESSAGE_ID.to_bytes(3, "little")
        crc = checksum(head + payload + bytes([CRC_EXTRA]))
        return b"\xfd" + head + payload + struct.pack("<H", crc)


def pose_packet(pose: Vec, *, sequence: int, time_ns: int) -> bytes:
    """Return our own packet with a pose (6,) [m, rad], which is that of a device's feedback."""
    feedback = Feedback(pose=pose, state=DeviceState.ENGAGED, sequence=sequence)
    return feedback_packet(feedback, time_ns=time_ns)
