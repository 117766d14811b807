"""Kernels that fill in what changes from step to step: output rows, errors, the limit circle.

Notation: P axis pairs; x = (x_1 … x_P) with x_p = [ω θ v s a_tran a_rot]; A (6, 6), B (6, 2) of one pair,
the same for all; u_p = [a_rot a_tran]. Felt force of pair p, with q the pair whose tilt it lies under:

    f_p = a_p + g cos θ_q sin θ_p      (q exists for sway-roll beside surge-pitch; else the cosine is 1)

linearised about (x̄, ū) as f_p ≈ D x + const. The values of D are stored row by row in the order of the
states, [θ_q] θ_p a_p, which needs q < p.
"""

from typing import Final, NamedTuple

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.frames import GRAVITY
from otolith.core.jit import kernel
from otolith.qp.engines import StageMemory

TILT, VELOCITY, POSITION, ACCELERATION = 1, 2, 3, 4  # as in otolith.mpc.model, whose test checks it
_NO_DIRECTION: Final = 1e-9  # [m] closer than this to the centre, the circle has no direction


class Given(NamedTuple):
    """What the kernels need of a formulation, the same at every step."""

    A: Mat  # (6, 6) of one pair
    B: Mat  # (6, 2)
    under: Ints  # (P,) index of the pair q whose tilt pair p lies under, −1 where there is none
    ends: Ints  # (M,) last step of every block
    of: Ints  # (w,) state whose size the washout weight depends on
    washout: Mat  # (w, 5) its coefficients w₁ … w₄ and scale
    control_weight: Vec  # (2P,) R
    circle: Vec  # (3,) weights of velocity, position and acceleration in the place that the circle limits
    X: Mat  # (N, 6P) room for the prediction


@kernel
def predict(A: Mat, B: Mat, x0: Vec, plan: Mat, X: Mat) -> None:
    """States x_1 … x_N into X (N, 6P) under the inputs `plan` (N, 2P)."""
    for k in range(X.shape[0]):
        before = x0 if k == 0 else X[k - 1]
        for p in range(plan.shape[1] // 2):
            for i in range(6):
                total = B[i, 0] * plan[k, 2 * p] + B[i, 1] * plan[k, 2 * p + 1]
                for j in range(6):
                    total += A[i, j] * before[6 * p + j]
                X[k, 6 * p + i] = total


@kernel
def linearise_force(X: Mat, under: Ints, wanted: Mat, D: Mat, error: Mat) -> None:
    """Output rows D (N, values) and errors (N, P) of f − wanted about the states X (N, 6P).

    Parameters
    ----------
    under : see `Given`.
    wanted : (N, P) forces [m/s²].
    """
    P = len(under)
    sine, cosine = np.empty(P), np.empty(P)
    for k in range(X.shape[0]):
        slot = 0
        for p in range(P):
            tilt, q = X[k, 6 * p + TILT], under[p]
            sine[p], cosine[p] = np.sin(tilt), np.cos(tilt)
            pull = GRAVITY * (cosine[q] if q >= 0 else 1.0)
            constant = pull * (sine[p] - cosine[p] * tilt) - wanted[k, p]
            if q >= 0:
                D[k, slot] = -GRAVITY * sine[q] * sine[p]
                constant -= D[k, slot] * X[k, 6 * q + TILT]
                slot += 1
            D[k, slot] = pull * cosine[p]
            D[k, slot + 1] = 1.0
            slot += 2
            error[k, p] = constant


@kernel
def _limited(X: Mat, k: int, p: int, of: Vec) -> float:
    x = X[k, 6 * p : 6 * p + 6]
    place: float = of[0] * x[VELOCITY] + of[1] * x[POSITION] + of[2] * x[ACCELERATION]
    return place


@kernel
def linearise_circle(X: Mat, of: Vec, ends: Ints, rows: Mat) -> None:
    """Rows (M, values) of the limit circle about the places predicted for the steps `ends` (M,).

    The circle limits c = (c_long, c_lat), per pair the position alone or a combination with velocity and
    acceleration, weights `of` (3,). With n the unit vector towards the predicted c, n·c ≤ radius touches
    the circle. The non-zeros of a row stand in the order of the states, pair by pair.

    The half-plane through the circle's point nearest to the prediction contains the whole circle, and
    cuts off what lies beyond it in that direction; a place that turns by φ from its prediction may
    leave the circle by radius·φ²/2 at most.
    """
    for k in range(len(ends)):
        x, y = _limited(X, ends[k], 0, of), _limited(X, ends[k], 1, of)
        length = np.hypot(x, y)
        near = length <= _NO_DIRECTION
        slot = 0
        for p in range(2):
            direction = 0.0 if near else (x, y)[p] / length
            for i in range(3):
                if of[i] != 0.0:
                    rows[k, slot] = direction * of[i]
                    slot += 1


@kernel
def weigh_washout(x: Vec, of: Ints, washout: Mat, weights: Mat) -> None:
    """Washout weights (N, w), the same at all steps: w₁ + w₂ r + w₃ r² + w₄ r⁴ with r = |x_of| / scale.

    Of the present state x (eq. 4.12); `washout` as in `Given`.
    """
    for i in range(len(of)):
        c = washout[i]
        r = abs(x[of[i]]) / c[4]
        weights[:, i] = c[0] + c[1] * r + c[2] * r**2 + c[3] * r**4


@kernel
def pull_to(u_ref: Mat, R: Vec, ends: Ints, linear: Mat) -> None:
    """Linear terms −R Σ u_ref (M, 2P), the sum over each block's steps; zero where u_ref has no steps."""
    linear[:] = 0.0
    block = 0
    for k in range(u_ref.shape[0]):
        block += k > ends[block]
        for j in range(u_ref.shape[1]):
            linear[block, j] -= R[j] * u_ref[k, j]


@kernel
def write(given: Given, memory: StageMemory, x: Vec, plan: Mat, wanted: Mat, u_ref: Mat) -> None:
    """Everything above about the plan, into an engine's memory, in one call."""
    memory.start[:] = x
    predict(given.A, given.B, x, plan, given.X)
    linearise_force(given.X, given.under, wanted, memory.output, memory.error)
    if memory.varying.shape[1] > 0:
        linearise_circle(given.X, given.circle, given.ends, memory.varying)
    weigh_washout(x, given.of, given.washout, memory.state_weight)
    pull_to(u_ref, given.control_weight, given.ends, memory.input_linear)
