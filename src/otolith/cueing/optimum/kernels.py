"""The tracking error of all plant samples of a run, and its derivatives, in one compiled pass.

Notation: x_k holds place, speed and acceleration (p, v, a) of every axis that moves, axis after axis, in the
platform's own axes and sign; u_k the commands. At sample j of period k each axis is at A_j (p, v, a) + B_j u,
exactly. There the driver feels, with roll ϕ, pitch θ, yaw ψ (`core.frames.specific_force`, `Run.felt_rate`),

    f_x = a_x − g sin θ,   f_y = a_y + g cos θ sin ϕ,   f_z = a_z + g (cos θ cos ϕ − 1),
    r = ψ̇ cos θ cos ϕ − θ̇ sin ϕ.
"""

import math
from typing import NamedTuple

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.frames import GRAVITY
from otolith.core.jit import kernel

PLACE, SPEED, ACCELERATION = range(3)


class Tracked(NamedTuple):
    """Everything constant of the cost."""

    within: Mat  # (S, 3, 4) rows [A_j B_j] of the samples of one period
    axis: Ints  # (6,) which of the axes that move it is; −1: it stands still
    channel: Ints  # (C,) what is tracked: 0, 1, 2 force along x, y, z; 3 the yaw rate
    weight: Vec  # (C,) of its squared error
    wanted: Mat  # (N, S, C)
    effort: float  # weight of u²


@kernel
def place_of_axis(t: Tracked, axis: int, order: int, k: int, j: int, X: Mat, U: Mat) -> float:
    """Place (order 0), speed (1) or acceleration (2) of a platform's axis at sample j of period k."""
    i = t.axis[axis]
    if i < 0:
        return 0.0
    row = t.within[j, order]
    moved: float = (
        row[0] * X[k, 3 * i] + row[1] * X[k, 3 * i + 1] + row[2] * X[k, 3 * i + 2] + row[3] * U[k, i]
    )
    return moved


@kernel
def error_of(t: Tracked, c: int, k: int, j: int, X: Mat, U: Mat, slope: Mat) -> float:
    """Error of channel c at a sample; `slope` (6, 3) gets its derivatives by axis and order."""
    roll, pitch = place_of_axis(t, 3, PLACE, k, j, X, U), place_of_axis(t, 4, PLACE, k, j, X, U)
    cr, sr, cp, sp = math.cos(roll), math.sin(roll), math.cos(pitch), math.sin(pitch)
    channel = t.channel[c]
    slope[:] = 0.0
    if channel == 3:
        pitching, yawing = place_of_axis(t, 4, SPEED, k, j, X, U), place_of_axis(t, 5, SPEED, k, j, X, U)
        slope[3, PLACE] = -yawing * cp * sr - pitching * cr
        slope[4, PLACE] = -yawing * sp * cr
        slope[4, SPEED] = -sr
        slope[5, SPEED] = cp * cr
        turned: float = yawing * cp * cr - pitching * sr - t.wanted[k, j, c]
        return turned
    slope[channel, ACCELERATION] = 1.0
    if channel == 0:
        gravity = -sp
        slope[4, PLACE] = -GRAVITY * cp
    elif channel == 1:
        gravity = cp * sr
        slope[3, PLACE] = GRAVITY * cp * cr
        slope[4, PLACE] = -GRAVITY * sp * sr
    else:
        gravity = cp * cr - 1.0
        slope[3, PLACE] = -GRAVITY * cp * sr
        slope[4, PLACE] = -GRAVITY * sp * cr
    moved = place_of_axis(t, channel, ACCELERATION, k, j, X, U)
    error: float = moved + GRAVITY * gravity - t.wanted[k, j, c]
    return error


@kernel
def value(t: Tracked, X: Mat, U: Mat) -> float:
    """½ Σ weight · error² over all samples and channels, + ½ effort Σ u²."""
    slope, total = np.empty((6, 3)), 0.0
    for k in range(len(U)):
        for j in range(len(t.within)):
            for c in range(len(t.channel)):
                total += t.weight[c] * error_of(t, c, k, j, X, U, slope) ** 2
        for i in range(U.shape[1]):
            total += t.effort * U[k, i] ** 2
    return 0.5 * total


@kernel
def expand(t: Tracked, X: Mat, U: Mat, gradient: Mat, hessian: Mat) -> float:
    """`value`, with its gradient (N, nz) and Gauss-Newton Hessian (N, nz, nz) in (x_k, u_k)."""
    nx, nu = X.shape[1], U.shape[1]
    slope, total = np.empty((6, 3)), 0.0
    row, place = np.empty(nx + nu), np.empty(nx + nu, dtype=np.int64)
    for k in range(len(U)):
        gradient[k], hessian[k] = 0.0, 0.0
        for j in range(len(t.within)):
            for c in range(len(t.channel)):
                error = error_of(t, c, k, j, X, U, slope)
                total += t.weight[c] * error**2
                n = _row(t, slope, t.within[j], nx, row, place)
                for a in range(n):
                    weighted = t.weight[c] * row[a]
                    gradient[k, place[a]] += weighted * error
                    for b in range(n):
                        hessian[k, place[a], place[b]] += weighted * row[b]
        for i in range(nu):
            total += t.effort * U[k, i] ** 2
            gradient[k, nx + i] += t.effort * U[k, i]
            hessian[k, nx + i, nx + i] += t.effort
    return 0.5 * total


@kernel
def _row(t: Tracked, slope: Mat, within: Mat, nx: int, row: Vec, place: Ints) -> int:
    """Derivatives by (x_k, u_k): the non-zero ones and their places; gives how many."""
    n = 0
    for axis in range(6):
        i = t.axis[axis]
        if i < 0 or (slope[axis, 0] == 0.0 and slope[axis, 1] == 0.0 and slope[axis, 2] == 0.0):
            continue
        for m in range(4):
            row[n] = (
                slope[axis, 0] * within[0, m] + slope[axis, 1] * within[1, m] + slope[axis, 2] * within[2, m]
            )
            place[n] = 3 * i + m if m < 3 else nx + i
            n += 1
    return n
