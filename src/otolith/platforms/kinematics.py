"""Kinematics of six legs, compiled: lengths of a pose, their derivatives, and the pose of six lengths.

Notation: place (p, q), velocity (v, ω), acceleration (a, α) of the motion reference point as in
`otolith.core.rotation`. Leg i runs from the base joint b_i (world, from the neutral reference point) to the
platform joint p + r_i, r_i = R a_i: l_i = p + r_i − b_i, length L_i = |l_i|, direction n_i = l_i/L_i. L̇ = J
(v, ω) with rows J_i = (n_i, r_i × n_i); L̈ = J (a, α) + J̇ (v, ω) (Merlet, Parallel Robots, 2006, chapters 3
and 5). J̇ follows from ṅ = (l̇ − n L̇)/L and ṙ = ω × r.
"""

import math

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.jit import kernel
from otolith.core.rotation import acceleration_of, place_of, rotation_of, turn, velocity_of

SINGULAR = 1e-9  # smallest pivot [-] of a regular Jacobian; good poses have 0.1


@kernel
def inverse(place: Vec, joints: Mat, anchors: Mat, lengths: Vec, J: Mat, arms: Mat) -> None:
    """Write lengths (6,), Jacobian (6, 6) and arms r_i (6, 3) of a place (7,)."""
    R = np.empty((3, 3))
    rotation_of(place, R)
    for i in range(6):
        ax, ay, az = joints[i, 0], joints[i, 1], joints[i, 2]
        rx = R[0, 0] * ax + R[0, 1] * ay + R[0, 2] * az
        ry = R[1, 0] * ax + R[1, 1] * ay + R[1, 2] * az
        rz = R[2, 0] * ax + R[2, 1] * ay + R[2, 2] * az
        x, y, z = place[0] + rx - anchors[i, 0], place[1] + ry - anchors[i, 1], place[2] + rz - anchors[i, 2]
        L = math.sqrt(x * x + y * y + z * z)
        x, y, z = x / L, y / L, z / L
        lengths[i] = L
        arms[i, 0], arms[i, 1], arms[i, 2] = rx, ry, rz
        J[i, 0], J[i, 1], J[i, 2] = x, y, z
        J[i, 3], J[i, 4], J[i, 5] = ry * z - rz * y, rz * x - rx * z, rx * y - ry * x


@kernel
def jacobian_rate(velocity: Vec, lengths: Vec, J: Mat, arms: Mat, speeds: Vec, rate: Mat) -> None:
    """Write leg speeds L̇ (6,) and J̇ (6, 6), given the results of `inverse`."""
    vx, vy, vz = velocity[0], velocity[1], velocity[2]
    wx, wy, wz = velocity[3], velocity[4], velocity[5]
    for i in range(6):
        rx, ry, rz = arms[i, 0], arms[i, 1], arms[i, 2]
        nx, ny, nz = J[i, 0], J[i, 1], J[i, 2]
        sx, sy, sz = wy * rz - wz * ry, wz * rx - wx * rz, wx * ry - wy * rx  # ṙ = ω × r
        along = nx * (vx + sx) + ny * (vy + sy) + nz * (vz + sz)
        dx, dy, dz = (
            (vx + sx - nx * along) / lengths[i],
            (vy + sy - ny * along) / lengths[i],
            (vz + sz - nz * along) / lengths[i],
        )  # ṅ
        speeds[i] = along
        rate[i, 0], rate[i, 1], rate[i, 2] = dx, dy, dz
        rate[i, 3] = sy * nz - sz * ny + ry * dz - rz * dy
        rate[i, 4] = sz * nx - sx * nz + rz * dx - rx * dz
        rate[i, 5] = sx * ny - sy * nx + rx * dy - ry * dx


@kernel
def leg_motion(pose: Vec, twist: Vec, acceleration: Vec, joints: Mat, anchors: Mat, motion: Mat) -> None:
    """Write lengths, speeds and accelerations of the legs (3, 6) [m, m/s, m/s²] of a pose in motion."""
    place, velocity, moving = np.empty(7), np.empty(6), np.empty(6)
    J, rate, arms = np.empty((6, 6)), np.empty((6, 6)), np.empty((6, 3))
    place_of(pose, place)
    velocity_of(pose, twist, velocity)
    acceleration_of(pose, twist, acceleration, moving)
    inverse(place, joints, anchors, motion[0], J, arms)
    jacobian_rate(velocity, motion[0], J, arms, motion[1], rate)
    for i in range(6):
        total = 0.0
        for j in range(6):
            total += J[i, j] * moving[j] + rate[i, j] * velocity[j]
        motion[2, i] = total


@kernel
def lengths_along(poses: Mat, joints: Mat, anchors: Mat, lengths: Mat) -> None:
    """Write leg lengths (n, 6) [m] of poses (n, 6)."""
    place, J, arms = np.empty(7), np.empty((6, 6)), np.empty((6, 3))
    for k in range(len(poses)):
        place_of(poses[k], place)
        inverse(place, joints, anchors, lengths[k], J, arms)


@kernel
def solve(M: Mat, r: Vec) -> bool:
    """Solve M x = r in place with partial pivoting; return False if M is singular or not finite."""
    n = len(r)
    for c in range(n):
        p = c
        for i in range(c + 1, n):
            if abs(M[i, c]) > abs(M[p, c]):
                p = i
        if not abs(M[p, c]) > SINGULAR:  # a NaN fails every comparison
            return False
        if p != c:
            for j in range(c, n):
                M[c, j], M[p, j] = M[p, j], M[c, j]
            r[c], r[p] = r[p], r[c]
        inverse_pivot = 1.0 / M[c, c]
        for i in range(c + 1, n):
            factor = M[i, c] * inverse_pivot
            for j in range(c + 1, n):
                M[i, j] -= factor * M[c, j]
            r[i] -= factor * r[c]
    for c in range(n - 1, -1, -1):
        for j in range(c + 1, n):
            r[c] -= M[c, j] * r[j]
        r[c] /= M[c, c]
    return True


@kernel
def forward(wanted: Vec, joints: Mat, anchors: Mat, place: Vec, tolerance: float, most: int) -> int:
    """Solve L(place) = wanted by Newton's method, from the guess in `place`, which becomes the solution.

    Returns
    -------
    The number of iterations; −1 if the Jacobian became singular, −2 if `most` iterations did not suffice.
    """
    lengths, J, arms, step = np.empty(6), np.empty((6, 6)), np.empty((6, 3)), np.empty(6)
    for iteration in range(most):
        inverse(place, joints, anchors, lengths, J, arms)
        close = True
        for i in range(6):
            step[i] = wanted[i] - lengths[i]
            close = close and abs(step[i]) <= tolerance  # a NaN fails every comparison
        if close:
            return iteration
        if not solve(J, step):
            return -1
        for i in range(3):
            place[i] += step[i]
        turn(place, step[3], step[4], step[5])
    return -2
