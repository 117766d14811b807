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
from otolith.core.jit import kernel


@kernel
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


@kernel
def turned(R: Mat, h: Vec, out: Vec) -> None:
    """Write R h (3,)."""
    for i in range(3):
        out[i] = R[i, 0] * h[0] + R[i, 1] * h[1] + R[i, 2] * h[2]


@kernel
def point_jet(jet: Mat, h: Vec, out: Mat) -> None:
    """Write R h and the R_j h with two derivatives in time into `out` (4, 3 orders, 3)."""
    for which in range(4):
        for order in range(3):
            turned(jet[which, order], h, out[which, order])


@kernel
def felt_slopes(head: Vec, motion: Mat, jet: Mat, force: Vec, slopes: Mat) -> None:
    """Write the specific force (3,) [m/s²] at a head, as `rotation.felt` does, and its slopes (3, 18).

    f = Rᵀ (a + R̈ h + g ẑ) − g ẑ.

    Parameters
    ----------
    head : (3,) [m] h from the reference point, in the platform's frame.
    jet : of this motion, from `rotation_jet`.
    """
    h = np.empty((4, 3, 3))
    point_jet(jet, head, h)
    pull = np.empty(3)
    for i in range(3):
        pull[i] = motion[2, i] + h[0, 2, i] + (GRAVITY if i == 2 else 0.0)
    slopes[:, :] = 0.0
    for i in range(3):
        total = -GRAVITY if i == 2 else 0.0
        for m in range(3):
            total += jet[0, 0, m, i] * pull[m]
            slopes[i, 12 + m] = jet[0, 0, m, i]
        force[i] = total
        for j in range(3):
            by_angle, by_rate, by_growth = 0.0, 0.0, 0.0
            for m in range(3):
                by_angle += jet[1 + j, 0, m, i] * pull[m] + jet[0, 0, m, i] * h[1 + j, 2, m]
                by_rate += 2.0 * jet[0, 0, m, i] * h[1 + j, 1, m]
                by_growth += jet[0, 0, m, i] * h[1 + j, 0, m]
            slopes[i, 3 + j], slopes[i, 9 + j], slopes[i, 15 + j] = by_angle, by_rate, by_growth


@kernel
def rate_slopes(motion: Mat, rate: Vec, slopes: Mat) -> None:
    """Write the rates (3,) [rad/s] about the platform's own axes, Rᵀ ω, and their slopes (3, 18)."""
    cr, sr = math.cos(motion[0, 3]), math.sin(motion[0, 3])
    cp, sp = math.cos(motion[0, 4]), math.sin(motion[0, 4])
    roll, pitch, yaw = motion[1, 3], motion[1, 4], motion[1, 5]
    rate[0] = roll - sp * yaw
    rate[1] = cr * pitch + sr * cp * yaw
    rate[2] = cr * cp * yaw - sr * pitch
    slopes[:, :] = 0.0
    slopes[0, 4], slopes[0, 9], slopes[0, 11] = -cp * yaw, 1.0, -sp
    slopes[1, 3], slopes[1, 4] = rate[2], -sr * sp * yaw
    slopes[1, 10], slopes[1, 11] = cr, sr * cp
    slopes[2, 3], slopes[2, 4] = -rate[1], -cr * sp * yaw
    slopes[2, 10], slopes[2, 11] = -sr, cr * cp
