"""How rotation, felt force and body rates change with a pose, its twist and its acceleration: exact slopes.

Notation is that of `otolith.core.rotation`: a pose is q = (p, φ) with R = Rz(ψ) Ry(θ) Rx(ϕ); v = q̇, a = q̈.
R_j is the derivative of R with respect to the j-th angle. For any function s(q) of the pose alone

    ∂ṡ/∂q = d/dt (∂s/∂q),   ∂ṡ/∂v = ∂s/∂q,
    ∂s̈/∂q = d²/dt² (∂s/∂q),   ∂s̈/∂v = 2 d/dt (∂s/∂q),   ∂s̈/∂a = ∂s/∂q,

so all slopes of s, ṡ and s̈ follow from R and the R_j with their first two derivatives in time along the
motion, the *rotation jet*. A point h fixed to the platform is at p + R h. Slopes have 18 columns: by the
pose, by the twist, by the acceleration. Checked by finite differences in tests/core/test_slopes.py.
"""

import math

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.frames import GRAVITY
from otolith.core.jit import jit_inner, kernel


@jit_inner
def _product(a: Vec, b: Vec, c: Vec, sign: float, out: Mat, i: int, j: int) -> None:
    """Add ± a b c and its first two derivatives, from those of the factors (3,), to entry (i, j) of `out`."""
    out[0, i, j] += sign * a[0] * b[0] * c[0]
    out[1, i, j] += sign * (a[1] * b[0] * c[0] + a[0] * b[1] * c[0] + a[0] * b[0] * c[1])
    out[2, i, j] += sign * (
        a[2] * b[0] * c[0]
        + a[0] * b[2] * c[0]
        + a[0] * b[0] * c[2]
        + 2.0 * (a[1] * b[1] * c[0] + a[1] * b[0] * c[1] + a[0] * b[1] * c[1])
    )


@kernel
def rotation_jet(motion: Mat, jet: Mat) -> None:
    """Write R and R_roll, R_pitch, R_yaw with two derivatives in time into `jet` (4, 3 orders, 3, 3).

    Parameters
    ----------
    motion : (3, 6) pose, twist and acceleration, as everywhere in this module.
    """
    of = np.empty((3, 2, 3, 3))  # angle; it or its derivative; cosine, sine and one; order in time
    for axis in range(3):
        angle, rate, growth = motion[0, 3 + axis], motion[1, 3 + axis], motion[2, 3 + axis]
        c, s = math.cos(angle), math.sin(angle)
        square = rate * rate
        cosine = (c, -s * rate, -c * square - s * growth)
        sine = (s, c * rate, -s * square + c * growth)
        for order in range(3):
            of[axis, 0, 0, order], of[axis, 0, 1, order] = cosine[order], sine[order]
            of[axis, 1, 0, order], of[axis, 1, 1, order] = -sine[order], cosine[order]
            of[axis, 0, 2, order] = 1.0 if order == 0 else 0.0
            of[axis, 1, 2, order] = 0.0
    for which in range(4):
        x, y, z = of[0, int(which == 1)], of[1, int(which == 2)], of[2, int(which == 3)]
        r, R, _r = x[0], x[1], x[2]
        p, P, _p = y[0], y[1], y[2]
        w, W, _w = z[0], z[1], z[2]
        out = jet[which]
        out[:, :, :] = 0.0
        _product(w, p, _r, 1.0, out, 0, 0)
        _product(w, P, R, 1.0, out, 0, 1)
        _product(W, _p, r, -1.0, out, 0, 1)
        _product(w, P, r, 1.0, out, 0, 2)
        _product(W, _p, R, 1.0, out, 0, 2)
        _product(W, p, _r, 1.0, out, 1, 0)
        _product(W, P, R, 1.0, out, 1, 1)
        _product(w, _p, r, 1.0, out, 1, 1)
        _product(W, P, r, 1.0, out, 1, 2)
        _product(w, _p, R, -1.0, out, 1, 2)
        _product(_w, P, _r, -1.0, out, 2, 0)
        _product(_w, p, R, 1.0, out, 2, 1)
        _product(_w, p, r, 1.0, out, 2, 2)


@jit_inner
def turned(R: Mat, h: Vec, out: Vec) -> None:
    """Write R h (3,)."""
    for i in range(3):
        out[i] = R[i, 0] * h[0] + R[i, 1] * h[1] + R[i, 2] * h[2]


@jit_inner
def point_jet(jet: Mat, h: Vec, out: Mat) -> None:
    """Write R h and the R_j h with two derivatives in time into `out` (4, 3 orders, 3)."""
    for which in range(4):
        for order in range(3):
            turned(jet[which, order], h, out[which, order])


@kernel
def felt_slopes(head: Vec, motion: Mat, felt: Vec, slopes: Mat) -> None:
    """Write specific force at a head and rates about the platform's axes, (6,), and their slopes (6, 18).

    With ω = E φ̇ and α the rates about the platform's own axes and their derivatives,

        f = Rᵀ (a + g ẑ) − g ẑ + α × h + ω × (ω × h),   ∂(Rᵀ x)/∂φ_j = Rᵀ x × E_j.

    Parameters
    ----------
    head : (3,) [m] h from the reference point, in the platform's frame.
    """
    cr, sr = math.cos(motion[0, 3]), math.sin(motion[0, 3])
    cp, sp = math.cos(motion[0, 4]), math.sin(motion[0, 4])
    cy, sy = math.cos(motion[0, 5]), math.sin(motion[0, 5])
    slopes[:, :] = 0.0
    slopes[0, 12], slopes[0, 13], slopes[0, 14] = cy * cp, sy * cp, -sp  # Rᵀ
    slopes[1, 12], slopes[1, 13], slopes[1, 14] = cy * sp * sr - sy * cr, sy * sp * sr + cy * cr, cp * sr
    slopes[2, 12], slopes[2, 13], slopes[2, 14] = cy * sp * cr + sy * sr, sy * sp * cr - cy * sr, cp * cr
    _rate_slopes(motion, (cr, sr), (cp, sp), felt, slopes)
    x, y, z = motion[2, 0], motion[2, 1], motion[2, 2] + GRAVITY
    for i in range(3):
        felt[i] = slopes[i, 12] * x + slopes[i, 13] * y + slopes[i, 14] * z
    for j in range(3, 6):
        _cross(felt[0], felt[1], felt[2], slopes[3:, 6 + j], slopes[:3, j])
    felt[2] -= GRAVITY
    if head[0] != 0.0 or head[1] != 0.0 or head[2] != 0.0:
        _add_lever(head, motion, (cr, sr), (cp, sp), felt, slopes)


@jit_inner
def _cross(x: float, y: float, z: float, b: Vec, out: Vec) -> None:
    """Add (x, y, z) × b (3,)."""
    out[0] += y * b[2] - z * b[1]
    out[1] += z * b[0] - x * b[2]
    out[2] += x * b[1] - y * b[0]


@jit_inner
def _rate_slopes(
    motion: Mat, roll: tuple[float, float], pitch: tuple[float, float], felt: Vec, slopes: Mat
) -> None:
    """Write the rates into felt[3:] and their slopes into slopes[3:]; E lies in columns 9 to 11."""
    (cr, sr), (cp, sp), yaw = roll, pitch, motion[1, 5]
    felt[3] = motion[1, 3] - sp * yaw
    felt[4] = cr * motion[1, 4] + sr * cp * yaw
    felt[5] = cr * cp * yaw - sr * motion[1, 4]
    slopes[3, 4], slopes[3, 9], slopes[3, 11] = -cp * yaw, 1.0, -sp
    slopes[4, 3], slopes[4, 4] = felt[5], -sr * sp * yaw
    slopes[4, 10], slopes[4, 11] = cr, sr * cp
    slopes[5, 3], slopes[5, 4] = -felt[4], -cr * sp * yaw
    slopes[5, 10], slopes[5, 11] = -sr, cr * cp


@kernel
def _add_lever(
    h: Vec, motion: Mat, roll: tuple[float, float], pitch: tuple[float, float], felt: Vec, slopes: Mat
) -> None:
    """Add α × h + ω × (ω × h) to the force, and its slopes."""
    (cr, sr), (cp, sp) = roll, pitch
    r, p, y = motion[1, 3], motion[1, 4], motion[1, 5]
    pp, yy = motion[2, 4], motion[2, 5]
    alpha, by = np.empty(3), np.zeros((2, 3, 3))  # ∂α/∂φ_j and ∂α/∂φ̇_j
    alpha[0] = motion[2, 3] - sp * yy - cp * p * y
    alpha[1] = cr * pp + sr * cp * yy + r * felt[5] - sr * sp * p * y
    alpha[2] = cr * cp * yy - sr * pp - r * felt[4] - cr * sp * p * y
    by[0, 0, 1], by[0, 0, 2] = alpha[2], -alpha[1]
    by[0, 1, 0] = sp * p * y - cp * yy
    by[0, 1, 1] = -sr * sp * yy - cr * sp * r * y - sr * cp * p * y
    by[0, 1, 2] = -cr * sp * yy + sr * sp * r * y - cr * cp * p * y
    by[1, 0, 1], by[1, 0, 2] = felt[5], -felt[4]
    by[1, 1, 0], by[1, 1, 1], by[1, 1, 2] = -cp * y, -sr * (r + sp * y), -cr * (r + sp * y)
    by[1, 2, 0], by[1, 2, 1], by[1, 2, 2] = -cp * p, cr * cp * r - sr * sp * p, -sr * cp * r - cr * sp * p
    w, lever, turned_by = felt[3:], np.zeros(3), np.empty(3)  # ω, ω × h, ∂ω × h
    _cross(w[0], w[1], w[2], h, lever)
    _cross(alpha[0], alpha[1], alpha[2], h, felt[:3])
    _cross(w[0], w[1], w[2], lever, felt[:3])
    for order in range(2):
        for j in range(3):
            column = 3 + 6 * order + j
            turn, out = slopes[3:, column], slopes[:3, column]
            turned_by[:] = 0.0
            _cross(turn[0], turn[1], turn[2], h, turned_by)
            _cross(by[order, j, 0], by[order, j, 1], by[order, j, 2], h, out)
            _cross(turn[0], turn[1], turn[2], lever, out)
            _cross(w[0], w[1], w[2], turned_by, out)
    for j in range(3):
        E = slopes[3:, 9 + j]
        _cross(E[0], E[1], E[2], h, slopes[:3, 15 + j])


@kernel
def rate_slopes(motion: Mat, rate: Vec, slopes: Mat) -> None:
    """Write the rates (3,) [rad/s] about the platform's own axes, Rᵀ ω, and their slopes (3, 18)."""
    felt, of_all = np.empty(6), np.zeros((6, 18))
    roll = (math.cos(motion[0, 3]), math.sin(motion[0, 3]))
    pitch = (math.cos(motion[0, 4]), math.sin(motion[0, 4]))
    _rate_slopes(motion, roll, pitch, felt, of_all)
    for i in range(3):
        rate[i] = felt[3 + i]
        for column in range(18):
            slopes[i, column] = of_all[3 + i, column]
