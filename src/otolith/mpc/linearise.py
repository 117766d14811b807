"""Kernels that fill in what changes from step to step: output rows, errors, the limit circle.

Notation: P axis pairs; x = (x_1 … x_P) with x_p = [ω θ v s a_tran a_rot]; A (6, 6), B (6, 2) of one pair,
the same for all; u_p = [a_rot a_tran]. Felt force of pair p, with q the pair whose tilt it lies under:

    f_p = a_p + g cos θ_q sin θ_p      (q exists for sway-roll beside surge-pitch; else the cosine is 1)

linearised about (x̄, ū) as f_p ≈ D x + const. The values of D are stored row by row in the order of the
states, [θ_q] θ_p a_p, which needs q < p.
"""

from typing import Final

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.frames import GRAVITY
from otolith.core.jit import kernel

TILT, POSITION, ACCELERATION = 1, 3, 4  # as in otolith.mpc.model, whose test checks it
_NO_DIRECTION: Final = 1e-9  # [m] closer than this to the centre, the circle has no direction


@kernel
def predict(A: Mat, B: Mat, x0: Vec, plan: Mat, X: Mat) -> None:
    """States x_1 … x_N into X (N, 6P) under the inputs `plan` (N, 2P)."""
    for k in range(X.shape[0]):
        for p in range(plan.shape[1] // 2):
            for i in range(6):
                total = B[i, 0] * plan[k, 2 * p] + B[i, 1] * plan[k, 2 * p + 1]
                for j in range(6):
                    before = x0[6 * p + j] if k == 0 else X[k - 1, 6 * p + j]
                    total += A[i, j] * before
                X[k, 6 * p + i] = total


@kernel
def linearise_force(X: Mat, under: Ints, wanted: Mat, D: Mat, error: Mat) -> None:
    """Output rows D (N, values) and errors (N, P) of f − wanted about the states X (N, 6P).

    Parameters
    ----------
    under : (P,) index of the pair q whose tilt pair p lies under, −1 where there is none.
    wanted : (N, P) forces [m/s²].
    """
    for k in range(X.shape[0]):
        slot = 0
        for p in range(len(under)):
            tilt, q = X[k, 6 * p + TILT], under[p]
            outer = X[k, 6 * q + TILT] if q >= 0 else 0.0
            constant = GRAVITY * np.cos(outer) * np.sin(tilt) - wanted[k, p]
            if q >= 0:
                D[k, slot] = -GRAVITY * np.sin(outer) * np.sin(tilt)
                constant -= D[k, slot] * outer
                slot += 1
            D[k, slot] = GRAVITY * np.cos(outer) * np.cos(tilt)
            constant -= D[k, slot] * tilt
            D[k, slot + 1] = 1.0
            slot += 2
            error[k, p] = constant


@kernel
def linearise_circle(X: Mat, ends: Ints, directions: Mat) -> None:
    """Unit directions n (M, 2) of the positions predicted for the steps `ends` (M,).

    With them, n·(s_long, s_lat) ≤ radius touches the circle.

    The half-plane through the circle's point nearest to the prediction contains the whole circle, and
    cuts off what lies beyond it in that direction; a position that turns by φ from its prediction may
    leave the circle by radius·φ²/2 at most.
    """
    for k in range(len(ends)):
        x, y = X[ends[k], POSITION], X[ends[k], 6 + POSITION]
        length = np.hypot(x, y)
        near = length <= _NO_DIRECTION
        directions[k, 0] = 0.0 if near else x / length
        directions[k, 1] = 0.0 if near else y / length


@kernel
def polynomial_weights(x: Vec, of: Ints, coefficients: Mat, scale: Vec, weights: Vec) -> None:
    """Washout weights (w,) at state x: w₁ + w₂ r + w₃ r² + w₄ r⁴ with r = |x_of| / scale (eq. 4.12)."""
    for i in range(len(of)):
        r = abs(x[of[i]]) / scale[i]
        c = coefficients[i]
        weights[i] = c[0] + c[1] * r + c[2] * r**2 + c[3] * r**4


@kernel
def prepare(
    A: Mat,
    B: Mat,
    x0: Vec,
    plan: Mat,
    under: Ints,
    wanted: Mat,
    X: Mat,
    D: Mat,
    error: Mat,
    ends: Ints,
    circle: Mat,
) -> None:
    """Everything above about the plan, in one call; `circle` has no columns where there is no circle."""
    predict(A, B, x0, plan, X)
    linearise_force(X, under, wanted, D, error)
    if circle.shape[1] == 2:
        linearise_circle(X, ends, circle)
