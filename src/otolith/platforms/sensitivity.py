"""How the motion of six actuators changes with the motion of the platform, compiled: rows for an optimiser.

An optimiser that keeps coordinate s, speed ṡ and acceleration s̈ of every actuator within limits needs their
derivatives with respect to pose x, twist v and acceleration a (its variables, with Euler angles). Three
blocks suffice, because s depends on x alone: with G = ∂s/∂x, Ġ = ∂ṡ/∂x and K = ∂s̈/∂x,

    δs = G δx,   δṡ = Ġ δx + G δv,   δs̈ = K δx + 2 Ġ δv + G δa.

Notation of `otolith.platforms.kinematics`. A subscript j is the derivative in direction j of the pose, a dot
the derivative along x(t) = x + v t + a t²/2. With P the platform joint, l·l = s² of a linear leg gives in
turn

    s s_j = l·P_j,   s ṡ_j = Ṗ·P_j + l·Ṗ_j − ṡ s_j,   s s̈_j = 2 Ṗ·Ṗ_j + P̈·P_j + l·P̈_j − 2 ṡ ṡ_j − s̈ s_j;

and l·l = d² of a crank, with b_j = t s_j, ḃ_j = t ṡ_j − e ṡ s_j/ρ and so on for its tip b(s),

    (l·t) s_j = l·P_j,   (l·t) ṡ_j = l̇·l_j + l·Ṗ_j + (l·e) ṡ s_j/ρ,
    (l·t) s̈_j = 2 l̇·l̇_j + l̈·l_j + l·P̈_j + (l·e) (2 ṡ ṡ_j + s̈ s_j)/ρ + (l·t) ṡ² s_j/ρ².

An angle turns r about an axis u_j that moves with the angles before it, so r_j = u_j × r, and its time
derivatives follow by the product rule. Checked by tests/platforms/test_sensitivity.py against finite
differences.
"""

import math

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.jit import kernel
from otolith.core.rotation import place_of, rotation_of
from otolith.platforms.kinematics import Actuators, leg_motion, tip


@kernel
def _cross(a: Vec, b: Vec, out: Vec) -> None:
    x, y = a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]
    out[0], out[1] = x, y


@kernel
def _dot(a: Vec, b: Vec) -> float:
    product: float = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return product


@kernel
def _axes(pose: Vec, twist: Vec, acceleration: Vec, u: Mat) -> None:
    """Write the axes of roll, pitch and yaw in world and their first two time derivatives (3, 3, 3).

    Pitch's axis turns with yaw, at the rate Ω = ψ̇ z; roll's turns with both, at Ω = ψ̇ z + θ̇ u_pitch.
    """
    cp, sp, cy, sy = math.cos(pose[4]), math.sin(pose[4]), math.cos(pose[5]), math.sin(pose[5])
    u[:] = 0.0
    u[0, 0, 0], u[0, 0, 1], u[0, 0, 2] = cy * cp, sy * cp, -sp
    u[0, 1, 0], u[0, 1, 1] = -sy, cy
    u[0, 2, 2] = 1.0
    rate, change, swing = np.zeros(3), np.zeros(3), np.empty(3)
    rate[2], change[2] = twist[5], acceleration[5]
    for j in (1, 0):
        if j == 0:
            for k in range(3):
                rate[k] += twist[4] * u[0, 1, k]
                change[k] += acceleration[4] * u[0, 1, k] + twist[4] * u[1, 1, k]
        _cross(rate, u[0, j], u[1, j])
        _cross(change, u[0, j], u[2, j])
        _cross(rate, u[1, j], swing)
        for k in range(3):
            u[2, j, k] += swing[k]


@kernel
def _turned(twist: Vec, acceleration: Vec, u: Mat, r: Mat) -> None:
    """Complete r (3, 3), of which the first row is given, with its first and second time derivatives."""
    w, dw, part = np.zeros(3), np.zeros(3), np.empty(3)
    for j in range(3):
        for k in range(3):
            w[k] += twist[3 + j] * u[0, j, k]
            dw[k] += acceleration[3 + j] * u[0, j, k] + twist[3 + j] * u[1, j, k]
    _cross(w, r[0], r[1])
    _cross(dw, r[0], r[2])
    _cross(w, r[1], part)
    for k in range(3):
        r[2, k] += part[k]


@kernel
def _joint_in(j: int, u: Mat, r: Mat, P: Mat) -> None:
    """Write P_j, Ṗ_j and P̈_j (3, 3) of a platform joint, for direction j of the pose."""
    P[:] = 0.0
    if j < 3:
        P[0, j] = 1.0
        return
    part = np.empty(3)
    for order in range(3):
        for inner in range(order + 1):
            _cross(u[order - inner, j - 3], r[inner], part)
            times = 2.0 if order == 2 and inner == 1 else 1.0
            for k in range(3):
                P[order, k] += times * part[k]


@kernel
def _of_linear(rod: Mat, s: float, ds: float, dds: float, P: Mat, out: Vec) -> None:
    """Write s_j, ṡ_j, s̈_j (3,) of a linear leg, given l, l̇, l̈ (3, 3) and P_j, Ṗ_j, P̈_j (3, 3)."""
    out[0] = _dot(rod[0], P[0]) / s
    out[1] = (_dot(rod[1], P[0]) + _dot(rod[0], P[1]) - ds * out[0]) / s
    out[2] = 2.0 * _dot(rod[1], P[1]) + _dot(rod[2], P[0]) + _dot(rod[0], P[2])
    out[2] = (out[2] - 2.0 * ds * out[1] - dds * out[0]) / s


@kernel
def _of_crank(rod: Mat, e: Vec, t: Vec, radius: float, ds: float, dds: float, P: Mat, out: Vec) -> None:
    """Write s_j, ṡ_j, s̈_j (3,) of a crank, given l, l̇, l̈ of its rod and P_j, Ṗ_j, P̈_j (3, 3)."""
    push, along, d, dd = _dot(rod[0], t), _dot(rod[0], e) / radius, np.empty(3), np.empty(3)
    out[0] = _dot(rod[0], P[0]) / push
    for k in range(3):
        d[k] = P[0, k] - t[k] * out[0]
    out[1] = (_dot(rod[1], d) + _dot(rod[0], P[1]) + along * ds * out[0]) / push
    for k in range(3):
        dd[k] = P[1, k] - t[k] * out[1] + e[k] * ds * out[0] / radius
    out[2] = 2.0 * _dot(rod[1], dd) + _dot(rod[2], d) + _dot(rod[0], P[2])
    out[2] += along * (2.0 * ds * out[1] + dds * out[0])
    out[2] = out[2] / push + ds * ds * out[0] / radius**2


@kernel
def _rod(p: Mat, r: Mat, of: Actuators, i: int, s: Vec, rod: Mat, e: Vec, t: Vec) -> None:
    """Write l, l̇, l̈ (3, 3) of leg i with the motion s (3,), and e and t (3,) of its crank, if it has one."""
    end = np.empty(3)
    tip(of, i, s[0], end)
    for k in range(3):
        rod[0, k] = p[0, k] + r[0, k] - end[k]
        rod[1, k], rod[2, k] = p[1, k] + r[1, k], p[2, k] + r[2, k]
    if of.radius == 0.0:
        return
    c, q = math.cos(s[0] / of.radius), math.sin(s[0] / of.radius)
    for k in range(3):
        e[k] = c * of.zero[i, k] + q * of.quarter[i, k]
        t[k] = c * of.quarter[i, k] - q * of.zero[i, k]
        rod[1, k] -= s[1] * t[k]
        rod[2, k] -= s[2] * t[k] - s[1] * s[1] * e[k] / of.radius


@kernel
def motion_and_derivatives(
    pose: Vec, twist: Vec, acceleration: Vec, of: Actuators, motion: Mat, blocks: Mat
) -> None:
    """Write the motion of the actuators and its derivatives.

    Parameters
    ----------
    pose, twist, acceleration : (6,) of `otolith.interfaces.PlatformState`.
    motion : (3, 6) output: coordinates [m], speeds [m/s] and accelerations [m/s²] of the actuators.
    blocks : (3, 6, 6) output: G, Ġ and K, with a row per actuator and a column per axis of the pose.
    """
    leg_motion(pose, twist, acceleration, of, motion)
    place, R, u = np.empty(7), np.empty((3, 3)), np.empty((3, 3, 3))
    place_of(pose, place)
    rotation_of(place, R)
    _axes(pose, twist, acceleration, u)
    p, r, rod, P = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    e, t, out, s = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for k in range(3):
        p[0, k], p[1, k], p[2, k] = pose[k], twist[k], acceleration[k]
    for i in range(6):
        for k in range(3):
            r[0, k] = _dot(R[k], of.joints[i])
            s[k] = motion[k, i]
        _turned(twist, acceleration, u, r)
        _rod(p, r, of, i, s, rod, e, t)
        for j in range(6):
            _joint_in(j, u, r, P)
            if of.radius == 0.0:
                _of_linear(rod, s[0], s[1], s[2], P, out)
            else:
                _of_crank(rod, e, t, of.radius, s[1], s[2], P, out)
            for order in range(3):
                blocks[order, i, j] = out[order]
