"""Six legs in motion: their lengths, speeds and accelerations at one pose, and bounds on them along a way.

Linear legs and cranks alike; of a crank, "length" is the arc of its tip, radius times angle.

Notation: leg i runs from the anchor b to p + r, r = R a; l = p + r − b, L = |l|, n = l/L. With ω and α of the
Euler rates (R = Rz Ry Rx), ṙ = ω × r, r̈ = α × r + ω × ṙ, l̇ = ṗ + ṙ:

    L̇ = n·l̇,    L̈ = (l̇·l̇ + l·(p̈ + r̈) − L̇²)/L.

*Cranks.* With w = p + r − b from the shaft, A and B its parts along the crank's directions at angles 0 and 90
deg, and k = (|w|² + ρ² − d²)/(2ρ), a rod of length d reaches the joint where A cos φ + B sin φ = k. So φ is
the angle of (A, B) less ± arccos(k/√(A² + B²)), and with D = B cos φ − A sin φ (the moment of the rod: n·t =
D/d)

    D φ̇ = k̇ − Ȧ cos φ − Ḃ sin φ,
    D φ̈ = k̈ − Ä cos φ − B̈ sin φ + 2 (Ȧ sin φ − Ḃ cos φ) φ̇ + k φ̇².

*Bounds.* Let poses stay within c ± d by axis, speeds within ±V, accelerations within ±A. Every Euler angle
turns r about a unit vector, so with ρ = |a| and S(x) the sum of the magnitudes of the three angles of x, the
first derivative of l in the direction x is at most |x|ₗ = |x_translation| + ρ S(x), and the second derivative
of r in the directions x and y at most ρ S(x) S(y). The second derivative of L in x and y is
(l_x·l_y − (n·l_x)(n·l_y))/L + n·r_xy, therefore at most

    B(x, y) = |x|ₗ |y|ₗ / L₀ + ρ S(x) S(y),    L₀ = L(c) − |d|ₗ ≤ L,

and by Taylor's theorem around c, with J the derivative of L there:

    |L − L(c)| ≤ |J| d + ½ B(d, d),   |L̇| ≤ |J| V + B(d, V),   |L̈| ≤ |J| A + B(d, A) + B(V, V).

They are of linear legs whose joints set no limit; others are judged at every sample.

Written for the gate alone, and checked by tests/live/core/test_legs.py against differences of lengths by
scipy's rotations.
"""

import math
from typing import Final

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.jit import kernel
from otolith.live.core.bounds import Bounds
from otolith.platforms.hexapod import DEAD_CENTRE

HOLDS, LENGTH, SPEED, STRENGTH, LEAN = 0, 7, 8, 9, 11
_THREE: Final = 3


@kernel
def _turning(pose: Vec, R: Mat, axes: Mat) -> None:
    """Write the rotation (3, 3) of a pose, and the axes (3, 3), as rows, about which its angles turn."""
    cr, sr, cp, sp = math.cos(pose[3]), math.sin(pose[3]), math.cos(pose[4]), math.sin(pose[4])
    cy, sy = math.cos(pose[5]), math.sin(pose[5])
    R[0, 0], R[0, 1], R[0, 2] = cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr
    R[1, 0], R[1, 1], R[1, 2] = sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr
    R[2, 0], R[2, 1], R[2, 2] = -sp, cp * sr, cp * cr
    axes[0, 0], axes[0, 1], axes[0, 2] = cy * cp, sy * cp, -sp
    axes[1, 0], axes[1, 1], axes[1, 2] = -sy, cy, 0.0
    axes[2, 0], axes[2, 1], axes[2, 2] = 0.0, 0.0, 1.0


@kernel
def legs_at(motion: Mat, b: Bounds, margin: float, R: Mat, axes: Mat) -> tuple[int, int]:
    """Return which limit of a leg a motion (3, 6) passes, and the leg; HOLDS if none.

    Parameters
    ----------
    margin : share of every limit that is kept free.
    R, axes : (3, 3) to work with.
    """
    _turning(motion[0], R, axes)
    p, v, a = motion[0], motion[1], motion[2]
    dr, dp, dy = v[3], v[4], v[5]
    e, f = axes[0], axes[1]
    wx, wy, wz = dr * e[0] + dp * f[0], dr * e[1] + dp * f[1], dr * e[2] + dy
    # the axis of roll turns with yaw and pitch, that of pitch with yaw
    gx, gy, gz = dp * f[0], dp * f[1], dy
    ax = a[3] * e[0] + a[4] * f[0] + dr * (gy * e[2] - gz * e[1]) - dp * dy * f[1]
    ay = a[3] * e[1] + a[4] * f[1] + dr * (gz * e[0] - gx * e[2]) + dp * dy * f[0]
    az = a[3] * e[2] + a[5] + dr * (gx * e[1] - gy * e[0])
    low, high = b.stroke
    room, limited = margin * (high - low), min(b.lean[0], b.lean[1]) < math.pi
    for i in range(6):
        jx, jy, jz = b.joints[i, 0], b.joints[i, 1], b.joints[i, 2]
        rx = R[0, 0] * jx + R[0, 1] * jy + R[0, 2] * jz
        ry = R[1, 0] * jx + R[1, 1] * jy + R[1, 2] * jz
        rz = R[2, 0] * jx + R[2, 1] * jy + R[2, 2] * jz
        x, y, z = p[0] + rx - b.anchors[i, 0], p[1] + ry - b.anchors[i, 1], p[2] + rz - b.anchors[i, 2]
        sx, sy, sz = wy * rz - wz * ry, wz * rx - wx * rz, wx * ry - wy * rx
        vx, vy, vz = v[0] + sx, v[1] + sy, v[2] + sz
        tx = a[0] + ay * rz - az * ry + wy * sz - wz * sy
        ty = a[1] + az * rx - ax * rz + wz * sx - wx * sz
        tz = a[2] + ax * ry - ay * rx + wx * sy - wy * sx
        if b.radius > 0.0:
            length, speed, strength = _crank_at((x, y, z), (vx, vy, vz), (tx, ty, tz), b, i)
        else:
            length = math.sqrt(x * x + y * y + z * z)
            speed = (x * vx + y * vy + z * vz) / length
            strength = (vx * vx + vy * vy + vz * vz + x * tx + y * ty + z * tz - speed * speed) / length
        if not low + room <= length <= high - room:
            return LENGTH, i
        if not abs(speed) <= b.leg_speed * (1.0 - margin):
            return SPEED, i
        if not abs(strength) <= b.leg_acceleration * (1.0 - margin):
            return STRENGTH, i
        if limited and not _leans((x, y, z), length, R, b, i, 1.0 - margin):
            return LEAN, i
    return HOLDS, 0


@kernel
def _crank_at(
    w: tuple[float, float, float],
    v: tuple[float, float, float],
    a: tuple[float, float, float],
    b: Bounds,
    i: int,
) -> tuple[float, float, float]:
    """Return arc, speed and acceleration of crank i, given the motion of its platform joint from its shaft.

    All are NaN where the rod does not reach, or only near the crank's dead centre.
    """
    A, B, dA, dB, ddA, ddB, k, dk, ddk = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, b.radius**2 - b.rod**2, 0.0, 0.0
    for j in range(_THREE):
        zero, quarter = b.frames[0, i, j], b.frames[1, i, j]
        A, dA, ddA = A + zero * w[j], dA + zero * v[j], ddA + zero * a[j]
        B, dB, ddB = B + quarter * w[j], dB + quarter * v[j], ddB + quarter * a[j]
        k, dk, ddk = k + w[j] * w[j], dk + 2.0 * w[j] * v[j], ddk + 2.0 * (v[j] * v[j] + w[j] * a[j])
    double = 2.0 * b.radius
    k, dk, ddk, h = k / double, dk / double, ddk / double, math.sqrt(A * A + B * B)
    if not abs(k) < h:
        return math.nan, math.nan, math.nan
    D = b.push * math.sqrt(h * h - k * k)
    if not b.push * D > DEAD_CENTRE * b.rod:
        return math.nan, math.nan, math.nan
    phi = math.atan2(B, A) - b.push * math.acos(k / h)
    phi -= 2.0 * math.pi * round(phi / (2.0 * math.pi))
    c, s = math.cos(phi), math.sin(phi)
    rate = (dk - dA * c - dB * s) / D
    growth = (ddk - ddA * c - ddB * s + 2.0 * (dA * s - dB * c) * rate + k * rate * rate) / D
    return b.radius * phi, b.radius * rate, b.radius * growth


@kernel
def _leans(w: tuple[float, float, float], length: float, R: Mat, b: Bounds, i: int, share: float) -> bool:
    """Return whether leg i leans at most a share of what its joints allow, given its way from its anchor."""
    x, y, z = w
    if b.radius > 0.0:
        c, s = b.radius * math.cos(length / b.radius), b.radius * math.sin(length / b.radius)
        x -= c * b.frames[0, i, 0] + s * b.frames[1, i, 0]
        y -= c * b.frames[0, i, 1] + s * b.frames[1, i, 1]
        z -= c * b.frames[0, i, 2] + s * b.frames[1, i, 2]
    far = math.sqrt(x * x + y * y + z * z)
    lower, upper = b.frames[2, i], b.frames[3, i]
    along = (x * lower[0] + y * lower[1] + z * lower[2]) / far
    if b.lean[0] < math.pi:
        angle = math.acos(min(1.0, max(-1.0, along)))
        if b.radius > 0.0:
            angle = abs(0.5 * math.pi - angle)  # from the crank's plane
        if not angle <= b.lean[0] * share:
            return False
    if b.lean[1] < math.pi:
        turned = 0.0
        for row in range(_THREE):
            part = R[row, 0] * upper[0] + R[row, 1] * upper[1] + R[row, 2] * upper[2]
            turned += part * (x if row == 0 else y if row == 1 else z)
        if not math.acos(min(1.0, max(-1.0, turned / far))) <= b.lean[1] * share:
            return False
    return True


@kernel
def _size(x: Vec) -> tuple[float, float]:
    """Return the length of a six-vector's translation, and the sum of the magnitudes of its angles."""
    return math.sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]), abs(x[3]) + abs(x[4]) + abs(x[5])


@kernel
def legs_hold(centre: Vec, spread: Mat, b: Bounds, margin: float, R: Mat, axes: Mat) -> bool:
    """Return whether all legs keep their limits, by bounds, on a whole way; False proves nothing.

    Parameters
    ----------
    centre : (6,) of the poses.
    spread : (3, 6) largest distances of the poses from the centre, largest speeds, largest accelerations.
    margin : share of every limit that is kept free.
    R, axes : (3, 3) to work with.
    """
    if b.radius > 0.0 or min(b.lean[0], b.lean[1]) < math.pi:
        return False
    _turning(centre, R, axes)
    d, V, A = spread[0], spread[1], spread[2]
    (dt, ds), (Vt, Vs), (At, As) = _size(d), _size(V), _size(A)
    low, high = b.stroke
    room = margin * (high - low)
    for i in range(6):
        jx, jy, jz = b.joints[i, 0], b.joints[i, 1], b.joints[i, 2]
        rx = R[0, 0] * jx + R[0, 1] * jy + R[0, 2] * jz
        ry = R[1, 0] * jx + R[1, 1] * jy + R[1, 2] * jz
        rz = R[2, 0] * jx + R[2, 1] * jy + R[2, 2] * jz
        x, y, z = (
            centre[0] + rx - b.anchors[i, 0],
            centre[1] + ry - b.anchors[i, 1],
            centre[2] + rz - b.anchors[i, 2],
        )
        length = math.sqrt(x * x + y * y + z * z)
        n = (x / length, y / length, z / length)
        mx, my, mz = ry * n[2] - rz * n[1], rz * n[0] - rx * n[2], rx * n[1] - ry * n[0]  # r × n
        change, speed, strength = 0.0, 0.0, 0.0
        for j in range(_THREE):
            linear = abs(n[j])
            turning = abs(axes[j, 0] * mx + axes[j, 1] * my + axes[j, 2] * mz)
            change += linear * d[j] + turning * d[3 + j]
            speed += linear * V[j] + turning * V[3 + j]
            strength += linear * A[j] + turning * A[3 + j]
        rho = math.sqrt(jx * jx + jy * jy + jz * jz)
        dl, Vl, Al = dt + rho * ds, Vt + rho * Vs, At + rho * As
        least = length - dl
        if not least > 0.0:
            return False
        change += 0.5 * (dl * dl / least + rho * ds * ds)
        speed += dl * Vl / least + rho * ds * Vs
        strength += dl * Al / least + rho * ds * As + Vl * Vl / least + rho * Vs * Vs
        if not (low + room <= length - change and length + change <= high - room):
            return False
        if not (speed <= b.leg_speed * (1.0 - margin) and strength <= b.leg_acceleration * (1.0 - margin)):
            return False
    return True


def work() -> tuple[Mat, Mat]:
    """Return what the kernels of this module work with."""
    return np.empty((3, 3)), np.empty((3, 3))
