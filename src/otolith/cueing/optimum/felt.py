"""What the driver feels at one instant and how it changes with the platform's motion, compiled.

Notation: roll ϕ, pitch θ, yaw ψ with their rates P, Q, Y; A = a + g ẑ; ω and α the angular velocity and
acceleration in the platform's frame; h the head. Then

    f = Rᵀ A − g ẑ + α × h + ω × (ω × h),     r = ω_z                        (`core.rotation.felt_at`)
    ω = (P − Y sin θ, Q cos ϕ + Y cos θ sin ϕ, Y cos θ cos ϕ − Q sin ϕ)
    α_x = Ṗ − Ẏ sin θ − Q Y cos θ,  α_y = m cos ϕ + n sin ϕ,  α_z = n cos ϕ − m sin ϕ
    m = Q̇ + P Y cos θ,  n = Ẏ cos θ − P Q − Q Y sin θ.

Without a head the force is that of the planar models, which the loop records in this case: f = a + g Rᵀ ẑ − g
ẑ. The derivatives were derived by hand. They are checked against complex steps of `definition`, which is
written in the world frame, and that is checked against `felt_at`.
"""

import math

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.copying import copy_to
from otolith.core.frames import GRAVITY
from otolith.core.jit import jit_allocating

PLACE, SPEED, ACCELERATION = range(3)
ROLL, PITCH, YAW = 3, 4, 5
CHANNELS = 4  # force along x, y, z; yaw rate


@jit_allocating
def feel(motion: Mat, head: Vec, felt: Vec, slope: Mat) -> None:
    """Write what is felt (4,), force [m/s²] and yaw rate [rad/s], and its derivatives (4, 6, 3).

    Parameters
    ----------
    motion : (3, 6) place, speed and acceleration of the platform's axes.
    head : (3,) [m], or (0,): the force of the planar models is felt.
    slope : derivatives by channel, axis, and order (place, speed, acceleration).
    """
    sp, cp = math.sin(motion[PLACE, PITCH]), math.cos(motion[PLACE, PITCH])
    sr, cr = math.sin(motion[PLACE, ROLL]), math.cos(motion[PLACE, ROLL])
    slope[:] = 0.0
    for i in range(3):
        felt[i] = motion[ACCELERATION, i]
        slope[i, i, ACCELERATION] = 1.0
    pulled = np.array([-GRAVITY * sp, GRAVITY * cp * sr, GRAVITY * cp * cr])  # Rᵀ A, without a head Rᵀ g ẑ
    if len(head) > 0:
        _turn(motion, pulled, felt, slope)
        _add_lever(motion, head, felt, slope)
    for i in range(3):
        felt[i] += pulled[i]
    felt[2] -= GRAVITY
    slope[0, PITCH, PLACE] -= sr * pulled[1] + cr * pulled[2]
    slope[1, ROLL, PLACE] += pulled[2]
    slope[1, PITCH, PLACE] += sr * pulled[0]
    slope[2, ROLL, PLACE] -= pulled[1]
    slope[2, PITCH, PLACE] += cr * pulled[0]
    Q, Y = motion[SPEED, PITCH], motion[SPEED, YAW]
    felt[3] = Y * cp * cr - Q * sr
    slope[3, ROLL, PLACE], slope[3, PITCH, PLACE] = -Y * cp * sr - Q * cr, -Y * sp * cr
    slope[3, PITCH, SPEED], slope[3, YAW, SPEED] = -sr, cp * cr


@jit_allocating
def _turn(motion: Mat, pulled: Vec, felt: Vec, slope: Mat) -> None:
    """Move the acceleration from `felt` (world frame) into `pulled` (platform's frame)."""
    sp, cp = math.sin(motion[PLACE, PITCH]), math.cos(motion[PLACE, PITCH])
    sr, cr = math.sin(motion[PLACE, ROLL]), math.cos(motion[PLACE, ROLL])
    sy, cy = math.sin(motion[PLACE, YAW]), math.cos(motion[PLACE, YAW])
    x, y = felt[0], felt[1]
    axes = np.array(
        [
            [cy * cp, sy * cp, -sp],
            [cy * sp * sr - sy * cr, sy * sp * sr + cy * cr, cp * sr],
            [cy * sp * cr + sy * sr, sy * sp * cr - cy * sr, cp * cr],
        ]
    )  # of the platform in the world frame, one a row
    for i in range(3):
        for j in range(3):
            pulled[i] += axes[i, j] * felt[j]
            slope[i, j, ACCELERATION] = axes[i, j]
        slope[i, YAW, PLACE] = axes[i, 0] * y - axes[i, 1] * x
    felt[:3] = 0.0


@jit_allocating
def _add_lever(motion: Mat, head: Vec, felt: Vec, slope: Mat) -> None:
    """Add α × h + ω × (ω × h) and its derivatives."""
    w, alpha, changes = np.empty(3), np.empty(3), np.zeros((3, 3, 6))
    _turning(motion, w, alpha, changes)
    at_head, tangential, centripetal = np.empty(3), np.empty(3), np.empty(3)
    _cross(w, head, at_head)
    _cross(w, at_head, centripetal)
    _cross(alpha, head, tangential)
    for i in range(3):
        felt[i] += tangential[i] + centripetal[i]
    part = np.empty(3)
    for axis in range(3):
        for order in range(3):
            of_w, of_alpha = changes[axis, order, :3], changes[axis, order, 3:]
            _cross(of_alpha, head, tangential)
            _cross(of_w, head, part)
            _cross(w, part, centripetal)
            _cross(of_w, at_head, part)
            for i in range(3):
                slope[i, 3 + axis, order] += tangential[i] + centripetal[i] + part[i]


@jit_allocating
def _turning(motion: Mat, w: Vec, alpha: Vec, changes: Mat) -> None:
    """Write ω, α and their derivatives (3, 3, 6) by each turning axis (roll, pitch, yaw) and order."""
    sp, cp = math.sin(motion[PLACE, PITCH]), math.cos(motion[PLACE, PITCH])
    sr, cr = math.sin(motion[PLACE, ROLL]), math.cos(motion[PLACE, ROLL])
    P, Q, Y = motion[SPEED, 3], motion[SPEED, 4], motion[SPEED, 5]
    dQ, dY = motion[ACCELERATION, 4], motion[ACCELERATION, 5]
    m, n = dQ + cp * P * Y, dY * cp - P * Q - sp * Q * Y
    w[0], w[1], w[2] = P - sp * Y, cr * Q + sr * cp * Y, cr * cp * Y - sr * Q
    alpha[0] = motion[ACCELERATION, 3] - sp * dY - cp * Q * Y
    alpha[1], alpha[2] = cr * m + sr * n, cr * n - sr * m
    # Each row holds the changes of ω, then those of α_x, m and n, which become α below.
    of_w = -cp * Y, -sr * sp * Y, -cr * sp * Y
    copy_to(changes[1, PLACE], (*of_w, sp * Q * Y - cp * dY, -sp * P * Y, -sp * dY - cp * Q * Y))
    copy_to(changes[0, SPEED], (1.0, 0.0, 0.0, 0.0, cp * Y, -Q))
    copy_to(changes[1, SPEED], (0.0, cr, -sr, -cp * Y, 0.0, -P - sp * Y))
    copy_to(changes[2, SPEED], (-sp, sr * cp, cr * cp, -cp * Q, cp * P, -sp * Q))
    changes[0, ACCELERATION, 3] = changes[1, ACCELERATION, 4] = 1.0
    changes[2, ACCELERATION, 3], changes[2, ACCELERATION, 5] = -sp, cp
    for axis in range(3):
        for order in range(3):
            of_m, of_n = changes[axis, order, 4], changes[axis, order, 5]
            changes[axis, order, 4], changes[axis, order, 5] = cr * of_m + sr * of_n, cr * of_n - sr * of_m
    copy_to(changes[0, PLACE], (0.0, w[2], -w[1], 0.0, alpha[2], -alpha[1]))  # roll turns both about x


@jit_allocating
def _cross(a: Vec, b: Vec, out: Vec) -> None:
    """Write a × b."""
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]
