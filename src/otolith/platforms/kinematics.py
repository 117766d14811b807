"""Kinematics of six actuators, compiled: coordinates of a pose, their derivatives, and the pose of these.

A linear leg extends: its coordinate is its length. A crank turns: a rod of fixed length joins its tip to the
platform, and its coordinate is the arc that the tip has travelled from the zero angle, radius times angle. So
both have coordinates in metres, and everything after this module treats them alike.

Notation: place (p, q), velocity (v, ω), acceleration (a, α) of the motion reference point as in
`otolith.core.rotation`. Leg i runs from b_i (world, from the neutral reference point), a base joint or a
crank's tip, to the platform joint p + r_i, r_i = R a_i: l_i = p + r_i − b_i, length L_i = |l_i|, direction
n_i = l_i/L_i. For linear legs L̇ = n·(v + ω × r) (Merlet, Parallel Robots, 2006, chapters 3 and 5) and

    L̈ = n·(a + α × r) + (|l̇|² − L̇²)/L + n·(ω × (ω × r)).

A crank of radius ρ about the shaft o has its tip at b = o + ρ e(φ), e = z cos φ + y sin φ with unit vectors z
(zero angle) and y (a quarter turn later); t = e′ is the tip's direction of motion. |l| = d, the rod, means

    w·e(φ) = k = (|w|² + ρ² − d²)/(2ρ),  w = p + r − o,   so   φ = β ± arccos(k/h),

with (h, β) the polar coordinates of w in the plane of the crank. The two signs are the two branches: in one,
growing angles push the rod (n·t > 0), in the other they pull it. There is no solution if |k| > h, where the
rod does not reach; results are then NaN. With s = ρφ, differentiating l·l = d² twice gives (n·t) ṡ = n·(v + ω
× r) and

    (n·t) s̈ = n·(a + α × r) + |l̇|²/d + n·(ω × (ω × r)) + (n·e) ṡ²/ρ.

Checked by tests/platforms/test_cranks.py against finite differences and a numerically closed loop.
"""

import math
from typing import NamedTuple

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.jit import kernel
from otolith.core.rotation import acceleration_of, place_of, rotation_of, turn, velocity_of

SINGULAR = 1e-9  # smallest pivot [-] of a regular Jacobian; good poses have 0.1


class Actuators(NamedTuple):
    """The geometry of six linear legs or six cranks, as kernels take it; linear legs have a radius of 0."""

    # (4, 6, 3) in one array, as every array of an argument costs time at each call: joints [m] on the
    # platform, from the reference point, in its frame; base joints or shafts [m], from the neutral reference
    # point, in world; directions of the cranks at angle 0, in world; and a quarter of a turn later
    places: Mat
    radius: float  # ρ [m] of the cranks; 0 for linear legs
    rod: float  # d [m] from a crank's tip to the platform
    push: float  # the branch: +1 if growing angles push the rods, −1 if they pull


@kernel
def tip(of: Actuators, i: int, s: float, at: Vec) -> None:
    """Write the lower end (3,) [m] of leg i, given its coordinate s: its base joint, or its crank's tip."""
    for k in range(3):
        at[k] = of.places[1, i, k]
    if of.radius > 0.0:
        c, q = of.radius * math.cos(s / of.radius), of.radius * math.sin(s / of.radius)
        for k in range(3):
            at[k] += c * of.places[2, i, k] + q * of.places[3, i, k]


@kernel
def arc(of: Actuators, i: int, x: float, y: float, z: float) -> float:
    """Return the coordinate of crank i for a platform joint at (x, y, z) from its shaft; NaN out of reach."""
    along = x * of.places[2, i, 0] + y * of.places[2, i, 1] + z * of.places[2, i, 2]
    across = x * of.places[3, i, 0] + y * of.places[3, i, 1] + z * of.places[3, i, 2]
    h, R, d = math.sqrt(along * along + across * across), of.radius, of.rod
    k = (x * x + y * y + z * z + R * R - d * d) / (2.0 * R)
    if not abs(k) <= h:
        return math.nan
    angle = math.atan2(across, along) - of.push * math.acos(k / h)
    if angle > math.pi:
        angle -= 2.0 * math.pi
    elif angle <= -math.pi:
        angle += 2.0 * math.pi
    return R * angle


@kernel
def _rods(place: Vec, joints: Mat, ends: Mat, lengths: Vec, J: Mat, arms: Mat) -> None:
    """Write lengths (6,), Jacobian (6, 6) and arms r_i (6, 3) of a place (7,), from lower ends (6, 3)."""
    R = np.empty((3, 3))
    rotation_of(place, R)
    for i in range(6):
        ax, ay, az = joints[i, 0], joints[i, 1], joints[i, 2]
        rx = R[0, 0] * ax + R[0, 1] * ay + R[0, 2] * az
        ry = R[1, 0] * ax + R[1, 1] * ay + R[1, 2] * az
        rz = R[2, 0] * ax + R[2, 1] * ay + R[2, 2] * az
        x, y, z = place[0] + rx - ends[i, 0], place[1] + ry - ends[i, 1], place[2] + rz - ends[i, 2]
        L = math.sqrt(x * x + y * y + z * z)
        x, y, z = x / L, y / L, z / L
        lengths[i] = L
        arms[i, 0], arms[i, 1], arms[i, 2] = rx, ry, rz
        J[i, 0], J[i, 1], J[i, 2] = x, y, z
        J[i, 3], J[i, 4], J[i, 5] = ry * z - rz * y, rz * x - rx * z, rx * y - ry * x


@kernel
def inverse(place: Vec, of: Actuators, s: Vec, J: Mat, arms: Mat) -> None:
    """Write coordinates (6,) [m], Jacobian (6, 6) and arms r_i (6, 3) of a place (7,).

    Where a crank's rod does not reach, its coordinate and its row of the Jacobian are NaN.
    """
    _rods(place, of.places[0], of.places[1], s, J, arms)
    if of.radius == 0.0:
        return
    for i in range(6):
        x, y, z = s[i] * J[i, 0], s[i] * J[i, 1], s[i] * J[i, 2]  # w
        s[i] = arc(of, i, x, y, z)
        c, q = math.cos(s[i] / of.radius), math.sin(s[i] / of.radius)
        e = (
            c * of.places[2, i, 0] + q * of.places[3, i, 0],
            c * of.places[2, i, 1] + q * of.places[3, i, 1],
            c * of.places[2, i, 2] + q * of.places[3, i, 2],
        )
        t = (
            c * of.places[3, i, 0] - q * of.places[2, i, 0],
            c * of.places[3, i, 1] - q * of.places[2, i, 1],
            c * of.places[3, i, 2] - q * of.places[2, i, 2],
        )
        x, y, z = x - of.radius * e[0], y - of.radius * e[1], z - of.radius * e[2]  # l
        push = x * t[0] + y * t[1] + z * t[2]  # d n·t
        x, y, z = x / push, y / push, z / push
        rx, ry, rz = arms[i, 0], arms[i, 1], arms[i, 2]
        J[i, 0], J[i, 1], J[i, 2] = x, y, z
        J[i, 3], J[i, 4], J[i, 5] = ry * z - rz * y, rz * x - rx * z, rx * y - ry * x


@kernel
def rates(velocity: Vec, s: Vec, J: Mat, arms: Mat, of: Actuators, moving: Mat) -> None:
    """Write ṡ and the part of s̈ that is due to the velocity alone (2, 6), given the results of `inverse`."""
    vx, vy, vz = velocity[0], velocity[1], velocity[2]
    wx, wy, wz = velocity[3], velocity[4], velocity[5]
    for i in range(6):
        rx, ry, rz = arms[i, 0], arms[i, 1], arms[i, 2]
        gx, gy, gz = J[i, 0], J[i, 1], J[i, 2]  # n, or n/(n·t)
        dx, dy, dz = wy * rz - wz * ry, wz * rx - wx * rz, wx * ry - wy * rx  # ṙ = ω × r
        turning = gx * (wy * dz - wz * dy) + gy * (wz * dx - wx * dz) + gz * (wx * dy - wy * dx)
        dx, dy, dz = vx + dx, vy + dy, vz + dz
        speed = gx * dx + gy * dy + gz * dz
        moving[0, i] = speed
        if of.radius == 0.0:
            moving[1, i] = turning + (dx * dx + dy * dy + dz * dz - speed * speed) / s[i]
            continue
        c, q = math.cos(s[i] / of.radius), math.sin(s[i] / of.radius)
        ex, ey, ez = (
            c * of.places[2, i, 0] + q * of.places[3, i, 0],
            c * of.places[2, i, 1] + q * of.places[3, i, 1],
            c * of.places[2, i, 2] + q * of.places[3, i, 2],
        )
        dx -= speed * (c * of.places[3, i, 0] - q * of.places[2, i, 0])  # l̇
        dy -= speed * (c * of.places[3, i, 1] - q * of.places[2, i, 1])
        dz -= speed * (c * of.places[3, i, 2] - q * of.places[2, i, 2])
        leverage = of.push * math.sqrt(gx * gx + gy * gy + gz * gz)  # 1/(n·t)
        moving[1, i] = (
            turning
            + (dx * dx + dy * dy + dz * dz) * leverage / of.rod
            + (gx * ex + gy * ey + gz * ez) * speed * speed / of.radius
        )


@kernel
def leg_motion(pose: Vec, twist: Vec, acceleration: Vec, of: Actuators, motion: Mat) -> None:
    """Write coordinates, speeds and accelerations (3, 6) [m, m/s, m/s²] of the actuators of a moving pose."""
    place, velocity, driven = np.empty(7), np.empty(6), np.empty(6)
    J, arms = np.empty((6, 6)), np.empty((6, 3))
    place_of(pose, place)
    velocity_of(pose, twist, velocity)
    acceleration_of(pose, twist, acceleration, driven)
    inverse(place, of, motion[0], J, arms)
    rates(velocity, motion[0], J, arms, of, motion[1:])
    for i in range(6):
        for j in range(6):
            motion[2, i] += J[i, j] * driven[j]


@kernel
def lengths_along(poses: Mat, of: Actuators, lengths: Mat) -> None:
    """Write coordinates (n, 6) [m] of poses (n, 6)."""
    place, J, arms = np.empty(7), np.empty((6, 6)), np.empty((6, 3))
    for k in range(len(poses)):
        place_of(poses[k], place)
        inverse(place, of, lengths[k], J, arms)


@kernel
def jacobians_along(poses: Mat, of: Actuators, jacobians: Mat) -> None:
    """Write Jacobians (n, 6, 6) of poses (n, 6)."""
    place, s, arms = np.empty(7), np.empty(6), np.empty((6, 3))
    for k in range(len(poses)):
        place_of(poses[k], place)
        inverse(place, of, s, jacobians[k], arms)


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
def forward(wanted: Vec, of: Actuators, place: Vec, tolerance: float, most: int) -> int:
    """Find the place with these coordinates by Newton's method, from the guess in `place`, which it replaces.

    The lower ends of the legs are known, so the equations are those of leg lengths also where cranks move
    them.

    Returns
    -------
    The number of iterations; −1 if the Jacobian became singular, −2 if `most` iterations did not suffice.
    """
    lengths, J, arms, step = np.empty(6), np.empty((6, 6)), np.empty((6, 3)), np.empty(6)
    ends = np.empty((6, 3))
    for i in range(6):
        tip(of, i, wanted[i], ends[i])
    for iteration in range(most):
        _rods(place, of.places[0], ends, lengths, J, arms)
        close = True
        for i in range(6):
            step[i] = (wanted[i] if of.radius == 0.0 else of.rod) - lengths[i]
            close = close and abs(step[i]) <= tolerance  # a NaN fails every comparison
        if close:
            return iteration
        if not solve(J, step):
            return -1
        for i in range(3):
            place[i] += step[i]
        turn(place, step[3], step[4], step[5])
    return -2
