"""The tracking error of all plant samples of a run, and its derivatives, in one compiled pass.

Notation: x_k holds place, speed and acceleration (p, v, a) of every axis that moves, axis after axis, in the
platform's own axes and signs; u_k holds the commands. At sample j of period k each axis is exactly at A_j (p,
v, a) + B_j u. An axis of a base adds to the axis of the platform that it carries. What the driver feels there
is given by `felt.feel`.
"""

from typing import NamedTuple

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.jit import jit_allocating, jit_entry
from otolith.cueing.optimum.felt import ACCELERATION, CHANNELS, PLACE, ROLL, SPEED, feel

NUDGE = 1e-6  # [rad, rad/s] between two slopes


class Tracked(NamedTuple):
    """The constants of the cost."""

    within: Mat  # (S, axes, 3, 4) rows [A_j B_j] of the samples of one period, for every axis
    axes: Ints  # (axes,) of the platform, in the order of the states; that which an axis of the base carries
    head: Vec  # (3,) [m] where force is sensed, or (0,): the planar models' force is felt
    channel: Ints  # (C,) what is tracked: 0, 1, 2 force along x, y, z; 3 the yaw rate
    weight: Vec  # (C,) of its squared error
    wanted: Mat  # (N, S, C)
    effort: float  # weight of u²


@jit_entry
def expand(t: Tracked, X: Mat, U: Mat, gradient: Mat, hessian: Mat, exact: bool) -> float:
    """Return ½ Σ weight · error² over all samples and channels + ½ effort Σ u²; write its derivatives.

    Parameters
    ----------
    gradient, hessian : (N, nz) and (N, nz, nz) in (x_k, u_k), overwritten.
    exact : whether the Hessian contains error · ∂²felt, which may make it indefinite; else Gauss-Newton's.
    """
    nx, nu = X.shape[1], U.shape[1]
    motion, felt, slope = np.zeros((3, 6)), np.empty(CHANNELS), np.empty((CHANNELS, 6, 3))
    row, total, pull = np.empty(nx + nu), 0.0, np.zeros(CHANNELS)
    for k in range(len(U)):
        gradient[k], hessian[k] = 0.0, 0.0
        for j in range(len(t.within)):
            _move(t, t.within[j], X[k], U[k], motion)
            feel(motion, t.head, felt, slope)
            for c in range(len(t.channel)):
                error = felt[t.channel[c]] - t.wanted[k, j, c]
                pull[t.channel[c]] = t.weight[c] * error
                total += t.weight[c] * error**2
                _derivatives(t, t.within[j], slope[t.channel[c]], row)
                _add(t.weight[c], error, row, gradient[k], hessian[k])
            if exact:
                _bend(t, t.within[j], motion, pull, slope, hessian[k])
        for i in range(nu):
            total += t.effort * U[k, i] ** 2
            gradient[k, nx + i] += t.effort * U[k, i]
            hessian[k, nx + i, nx + i] += t.effort
    return 0.5 * total


@jit_allocating
def _move(t: Tracked, within: Mat, x: Vec, u: Vec, motion: Mat) -> None:
    """Write place, speed and acceleration (3, 6) of the axes at one sample."""
    motion[:] = 0.0
    for i in range(len(t.axes)):
        for order in range(3):
            row = within[i, order]
            motion[order, t.axes[i]] += (
                row[0] * x[3 * i] + row[1] * x[3 * i + 1] + row[2] * x[3 * i + 2] + row[3] * u[i]
            )


@jit_allocating
def _derivatives(t: Tracked, within: Mat, slope: Mat, row: Vec) -> None:
    """Write the derivatives (nz,) of a channel by (x_k, u_k)."""
    nx = 3 * len(t.axes)
    for i in range(len(t.axes)):
        of = slope[t.axes[i]]
        for m in range(4):
            place = 3 * i + m if m < 3 else nx + i
            row[place] = of[0] * within[i, 0, m] + of[1] * within[i, 1, m] + of[2] * within[i, 2, m]


@jit_allocating
def _add(weight: float, error: float, row: Vec, gradient: Vec, hessian: Mat) -> None:
    """Add the gradient and Hessian of ½ weight · error²; `row` holds the derivatives of the error."""
    for a in range(len(row)):
        weighted = weight * row[a]
        if weighted != 0.0:
            gradient[a] += weighted * error
            for b in range(len(row)):
                hessian[a, b] += weighted * row[b]


@jit_allocating
def _bend(t: Tracked, within: Mat, motion: Mat, pull: Vec, slope: Mat, hessian: Mat) -> None:
    """Add Σ pull · ∂²felt of one sample; what is felt bends with the places and speeds of turning axes only.

    The second derivatives are differences of the first: their error, 10⁻⁶ of them, changes the step a little
    and the answer not at all.
    """
    felt, beside = np.empty(CHANNELS), np.empty((CHANNELS, 6, 3))
    nx = 3 * len(t.axes)
    for i in range(len(t.axes)):
        if t.axes[i] < ROLL:
            continue
        for order in (PLACE, SPEED):
            motion[order, t.axes[i]] += NUDGE
            feel(motion, t.head, felt, beside)
            motion[order, t.axes[i]] -= NUDGE
            for j in range(len(t.axes)):
                for other in range(3):
                    turning = t.axes[j] >= ROLL and other != ACCELERATION
                    if turning and (other, j) < (order, i):
                        continue  # that pair was added the other way round
                    bent = 0.0
                    for c in range(CHANNELS):
                        bent += pull[c] * (beside[c, t.axes[j], other] - slope[c, t.axes[j], other])
                    bent /= NUDGE
                    if bent == 0.0:
                        continue
                    for m in range(4):
                        a = 3 * i + m if m < 3 else nx + i
                        for n in range(4):
                            b = 3 * j + n if n < 3 else nx + j
                            value = bent * within[i, order, m] * within[j, other, n]
                            hessian[a, b] += value
                            if (other, j) != (order, i):
                                hessian[b, a] += value
