"""Rigid-body motion: converts between poses (used at the edges) and quaternions, velocities and lever arms.

Notation: a *pose* is (p, φ), position and roll-pitch-yaw φ = (ϕ θ ψ) with R = Rz(ψ) Ry(θ) Rx(ϕ), where R maps
the platform's frame to world; *twist* and *acceleration* are its derivatives. A *place* is (p, q) with the
unit quaternion q = (w x y z) of R; its *velocity* is (v, ω) with the derivative (a, α), all in world. ω =
E(φ) φ̇, where the columns of E are the axes about which roll, pitch and yaw turn; α = E φ̈ + Ė φ̇.
Derivation: Diebel, Representing Attitude (2006), sequence 3-2-1. E is singular at a pitch of 90 deg, which no
platform reaches; quaternions have no singularity. Checked by finite differences and by round trips.

All functions write their result into an array argument, since they are called from compiled code. They copy
element by element: numba compiles the error message of a slice's assignment with it, which takes seconds.
"""

import math

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.frames import GRAVITY
from otolith.core.jit import kernel


@kernel
def place_of(pose: Vec, place: Vec) -> None:
    """Write the place (7,) that corresponds to a pose (6,)."""
    for i in range(3):
        place[i] = pose[i]
    cr, sr = math.cos(0.5 * pose[3]), math.sin(0.5 * pose[3])
    cp, sp = math.cos(0.5 * pose[4]), math.sin(0.5 * pose[4])
    cy, sy = math.cos(0.5 * pose[5]), math.sin(0.5 * pose[5])
    place[3] = cy * cp * cr + sy * sp * sr
    place[4] = cy * cp * sr - sy * sp * cr
    place[5] = cy * sp * cr + sy * cp * sr
    place[6] = sy * cp * cr - cy * sp * sr


@kernel
def pose_of(place: Vec, pose: Vec) -> None:
    """Write the pose (6,) that corresponds to a place (7,); the pitch must be within ±90 deg."""
    for i in range(3):
        pose[i] = place[i]
    w, x, y, z = place[3], place[4], place[5], place[6]
    pose[3] = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pose[4] = math.asin(min(1.0, max(-1.0, 2.0 * (w * y - z * x))))
    pose[5] = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


@kernel
def rotation_of(place: Vec, R: Mat) -> None:
    """Write the rotation matrix (3, 3) of a place, from the platform's frame to world."""
    w, x, y, z = place[3], place[4], place[5], place[6]
    R[0, 0], R[0, 1], R[0, 2] = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)
    R[1, 0], R[1, 1], R[1, 2] = 2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)
    R[2, 0], R[2, 1], R[2, 2] = 2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)


@kernel
def turn(place: Vec, x: float, y: float, z: float) -> None:
    """Rotate a place by the rotation vector (x, y, z) [rad] given in world; the place is overwritten."""
    angle = math.sqrt(x * x + y * y + z * z)
    c = math.cos(0.5 * angle)
    s = math.sin(0.5 * angle) / angle if angle > 1e-9 else 0.5
    dx, dy, dz = s * x, s * y, s * z
    q0, q1, q2, q3 = place[3], place[4], place[5], place[6]
    w = c * q0 - dx * q1 - dy * q2 - dz * q3
    i = c * q1 + dx * q0 + dy * q3 - dz * q2
    j = c * q2 - dx * q3 + dy * q0 + dz * q1
    k = c * q3 + dx * q2 - dy * q1 + dz * q0
    length = math.sqrt(w * w + i * i + j * j + k * k)
    place[3], place[4], place[5], place[6] = w / length, i / length, j / length, k / length


@kernel
def velocity_of(pose: Vec, twist: Vec, velocity: Vec) -> None:
    """Write the velocity (v, ω) (6,) that corresponds to the twist (6,) of a pose."""
    cp, sp, cy, sy = math.cos(pose[4]), math.sin(pose[4]), math.cos(pose[5]), math.sin(pose[5])
    for i in range(3):
        velocity[i] = twist[i]
    velocity[3] = cy * cp * twist[3] - sy * twist[4]
    velocity[4] = sy * cp * twist[3] + cy * twist[4]
    velocity[5] = -sp * twist[3] + twist[5]


@kernel
def _turning(pose: Vec, twist: Vec) -> tuple[float, float, float]:
    """Return Ė φ̇, the part of α that does not come from φ̈."""
    cp, sp, cy, sy = math.cos(pose[4]), math.sin(pose[4]), math.cos(pose[5]), math.sin(pose[5])
    roll, pitch, yaw = twist[3], twist[4], twist[5]
    x = (-sy * cp * yaw - cy * sp * pitch) * roll - cy * yaw * pitch
    y = (cy * cp * yaw - sy * sp * pitch) * roll - sy * yaw * pitch
    return x, y, -cp * pitch * roll


@kernel
def acceleration_of(pose: Vec, twist: Vec, acceleration: Vec, out: Vec) -> None:
    """Write (a, α) (6,) that corresponds to the second derivative (6,) of a pose."""
    velocity_of(pose, acceleration, out)
    x, y, z = _turning(pose, twist)
    out[3] += x
    out[4] += y
    out[5] += z


@kernel
def twist_of(pose: Vec, velocity: Vec, twist: Vec) -> None:
    """Write the twist (6,) of a pose that moves with `velocity`; the inverse of `velocity_of`."""
    cp, sp, cy, sy = math.cos(pose[4]), math.sin(pose[4]), math.cos(pose[5]), math.sin(pose[5])
    for i in range(3):
        twist[i] = velocity[i]
    twist[3] = (cy * velocity[3] + sy * velocity[4]) / cp
    twist[4] = -sy * velocity[3] + cy * velocity[4]
    twist[5] = velocity[5] + sp * twist[3]


@kernel
def pose_acceleration_of(pose: Vec, twist: Vec, acceleration: Vec, out: Vec) -> None:
    """Write the second derivative (6,) of a pose from (a, α); the inverse of `acceleration_of`."""
    x, y, z = _turning(pose, twist)
    free = acceleration.copy()
    free[3] -= x
    free[4] -= y
    free[5] -= z
    twist_of(pose, free, out)


@kernel
def felt_at(head: Vec, place: Vec, velocity: Vec, acceleration: Vec, force: Vec) -> None:
    """Write the specific force (3,) [m/s²] at a point fixed to the platform, without the standing 1 g.

    f = Rᵀ (a + α × r + ω × (ω × r) + g ẑ) − g ẑ with r = R head: rotation and lever arm included.

    Parameters
    ----------
    head : (3,) [m] from the reference point, in the platform's frame, which is the driver's.
    place, velocity, acceleration : of the reference point, in world.
    """
    R = np.empty((3, 3))
    rotation_of(place, R)
    rx = R[0, 0] * head[0] + R[0, 1] * head[1] + R[0, 2] * head[2]
    ry = R[1, 0] * head[0] + R[1, 1] * head[1] + R[1, 2] * head[2]
    rz = R[2, 0] * head[0] + R[2, 1] * head[1] + R[2, 2] * head[2]
    wx, wy, wz = velocity[3], velocity[4], velocity[5]
    ax, ay, az = acceleration[3], acceleration[4], acceleration[5]
    along = wx * rx + wy * ry + wz * rz
    speed2 = wx * wx + wy * wy + wz * wz
    x = acceleration[0] + ay * rz - az * ry + wx * along - speed2 * rx
    y = acceleration[1] + az * rx - ax * rz + wy * along - speed2 * ry
    z = acceleration[2] + ax * ry - ay * rx + wz * along - speed2 * rz + GRAVITY
    for i in range(3):
        force[i] = R[0, i] * x + R[1, i] * y + R[2, i] * z
    force[2] -= GRAVITY


@kernel
def felt(head: Vec, pose: Vec, twist: Vec, acceleration: Vec, force: Vec) -> None:
    """Write the specific force (3,) [m/s²] at a head for a pose (6,) and its derivatives, as `felt_at` does.

    It is computed in the platform's frame, f = Rᵀ (a + g ẑ) − g ẑ + ω̇ × h + ω × (ω × h), where the rates ω =
    (p q r) and their derivatives need no yaw: a third of the sines, for a plant that is recorded every
    millisecond.
    """
    cr, sr, cp, sp = math.cos(pose[3]), math.sin(pose[3]), math.cos(pose[4]), math.sin(pose[4])
    cy, sy = math.cos(pose[5]), math.sin(pose[5])
    p = twist[3] - sp * twist[5]
    q = cr * twist[4] + sr * cp * twist[5]
    r = cr * cp * twist[5] - sr * twist[4]
    turning = twist[4] * twist[5]
    dp = acceleration[3] - sp * acceleration[5] - cp * turning
    dq = cr * acceleration[4] + sr * cp * acceleration[5] + twist[3] * r - sr * sp * turning
    dr = cr * cp * acceleration[5] - sr * acceleration[4] - twist[3] * q - cr * sp * turning
    ax, ay, az = acceleration[0], acceleration[1], acceleration[2] + GRAVITY
    forward, left = cy * ax + sy * ay, cy * ay - sy * ax
    down = sp * forward + cp * az
    x, y, z = head[0], head[1], head[2]
    along, speed2 = p * x + q * y + r * z, p * p + q * q + r * r
    force[0] = cp * forward - sp * az + dq * z - dr * y + p * along - speed2 * x
    force[1] = sr * down + cr * left + dr * x - dp * z + q * along - speed2 * y
    force[2] = cr * down - sr * left + dp * y - dq * x + r * along - speed2 * z - GRAVITY


@kernel
def felt_along(head: Vec, pose: Mat, twist: Mat, acceleration: Mat, force: Mat) -> None:
    """Write the specific forces (n, 3) [m/s²] at a head for rows (n, 6) of poses and their derivatives."""
    for k in range(len(pose)):
        felt(head, pose[k], twist[k], acceleration[k], force[k])


@kernel
def rate_along(pose: Mat, twist: Mat, rate: Mat) -> None:
    """Write the angular rates (n, 3) [rad/s] in the platform's frame, Rᵀ ω, as a gyroscope would read
    them.
    """
    for k in range(len(pose)):
        cr, sr = math.cos(pose[k, 3]), math.sin(pose[k, 3])
        cp, sp = math.cos(pose[k, 4]), math.sin(pose[k, 4])
        rate[k, 0] = twist[k, 3] - sp * twist[k, 5]
        rate[k, 1] = cr * twist[k, 4] + sr * cp * twist[k, 5]
        rate[k, 2] = -sr * twist[k, 4] + cr * cp * twist[k, 5]
