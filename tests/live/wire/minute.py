"""A minute of driving as the experiment asks for, computed: what a driver feels is known exactly."""

import struct
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d

from otolith.core.arrays import Mat, Vec
from otolith.live.messages import Telemetry
from otolith.live.wire.attitude import from_angles

G = 9.80665
DT = 1.0 / 60.0
# seconds, forward acceleration [m/s²], yaw rate [rad/s]
PHASES = (
    (5.0, 0.0, 0.0),
    (6.0, 3.0, 0.0),
    (3.0, -4.0, 0.0),
    (4.0, 2.0, 0.0),
    (17.0, 0.0, 0.4),
    (4.0, 0.0, 0.0),
    (4.5, 0.0, -0.35),
    (4.0, 0.5, 0.0),
    (4.0, -4.0, 0.0),
    (4.0, 0.0, 0.0),
)


# The same in less time; shorter still, and a busy machine that stalls the sender spoils a correlation.
SHORT = (
    (4.0, 0.0, 0.0),
    (3.0, 3.0, 0.0),
    (2.0, -2.5, 0.0),
    (3.0, 3.0, 0.0),
    (2.0, -3.0, 0.0),
    (3.0, 3.0, 0.0),
    (14.0, 0.0, 0.45),
    (2.0, 0.0, 0.0),
    (2.5, 0.0, -0.65),
    (2.0, 0.0, 0.0),
)


@dataclass(frozen=True)
class Driven:
    """What happened, in x forward, y left, z up of the car; the ground is level."""

    t: Vec
    force: Mat  # (n, 3) [m/s²] without the standing 1 g
    rate: Mat  # (n, 3) [rad/s]
    speed: Vec
    heading: Vec  # [rad] to the left


def driven(phases: tuple[tuple[float, float, float], ...] = PHASES) -> Driven:
    ahead = np.concatenate([np.full(round(s / DT), a) for s, a, _ in phases])
    turning = np.concatenate([np.full(round(s / DT), r) for s, _, r in phases])
    ahead, turning = (gaussian_filter1d(one, 0.15 / DT) for one in (ahead, turning))
    speed = np.maximum(np.cumsum(ahead) * DT, 0.0)
    ahead = np.gradient(speed, DT)
    t = np.asarray(np.arange(len(ahead)) * DT, dtype=np.float64)
    bumps = np.where(speed > 1.0, 0.3 * np.sin(7.0 * t), 0.0)
    rate = np.stack(
        [0.01 * np.sin(5.0 * t) * (speed > 1.0), 0.01 * np.cos(4.0 * t) * (speed > 1.0), turning], axis=1
    )
    force = np.stack([ahead, speed * turning, bumps], axis=1)
    return Driven(t, force, rate, speed, np.asarray(np.cumsum(turning) * DT, dtype=np.float64))


def samples(drive: Driven, force: Mat, rate: Mat, *, attitude: bool = False) -> list[tuple[float, Telemetry]]:
    """Return what a source sends that states these vectors (n, 3)."""
    return [
        (
            float(t),
            Telemetry(
                acceleration=f,
                angular_rate=w,
                speed=float(v),
                attitude=from_angles(0.0, 0.0, float(heading)) if attitude else None,
            ),
        )
        for t, f, w, v, heading in zip(drive.t, force, rate, drive.speed, drive.heading, strict=True)
    ]


DRIVE = driven()


def forza_packet(k: int, drive: Driven = DRIVE) -> bytes:
    """Return the packet that Forza sends at instant k: X right, Y up, Z forward, rates by the left hand."""
    f, w, v = drive.force[k], drive.rate[k], drive.speed[k]
    data = bytearray(232)
    struct.pack_into("<iI", data, 0, 1, round(1e3 * drive.t[k]))
    struct.pack_into("<9f", data, 20, -f[1], f[2], f[0], 0.0, 0.0, v, w[1], -w[2], -w[0])
    return bytes(data)


def wrc_packet(k: int, drive: Driven = DRIVE) -> bytes:
    """Return the packet that WRC sends at instant k by `golden.WRC_JSON`: world axes left, up, forward."""
    f, heading = drive.force[k], drive.heading[k]
    forward = np.array([np.sin(heading), 0.0, np.cos(heading)])
    left, up = np.array([np.cos(heading), 0.0, -np.sin(heading)]), np.array([0.0, 1.0, 0.0])
    velocity, acceleration = drive.speed[k] * forward, f[0] * forward + f[1] * left + f[2] * up
    data = struct.pack("<4sQBB9f", b"sesu", k, 1, 3, 0.0, 0.0, 0.0, *velocity, *acceleration)
    return data + struct.pack("<9fdf", *left, *forward, *up, 0.0, drive.t[k])
