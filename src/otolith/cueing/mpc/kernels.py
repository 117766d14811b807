"""Everything in the MPC's problem that changes from step to step, written in one compiled call.

Notation: x (nx,) is the motion of all degrees of freedom (`otolith.cueing.mpc.motion`); there are N steps, M
blocks of steps, and C channels (`otolith.cueing.mpc.objective`). The force felt through a tilt θ, under an
outer tilt φ, is

    f = a + g cos φ sin θ,

where φ is the pitch if sway-roll is cued with surge-pitch, and zero otherwise. It is linearised about the
motion (x̄, θ̄, φ̄) to which the previous plan leads. A physical channel takes value and slope, f ≈ D x +
const. A sensed channel keeps the slope of small tilts, g θ, so that the organs stay linear. The remainder Δ =
g (cos φ sin θ − θ) is evaluated along the plan, and what the organ senses of it is added. This is a
Gauss-Newton step with the exact value and a fixed slope.
"""

from typing import Final, NamedTuple

import numpy as np

from otolith.core.arrays import Bools, Ints, Mat, Vec
from otolith.core.frames import GRAVITY
from otolith.core.jit import kernel
from otolith.core.methods import INTEGER, MATRIX, NUMBER, Method, Role
from otolith.cueing.mpc.motion import Axes, predict
from otolith.qp.engines import StageMemory

# linearise(data, X (N, nx), wanted (N, C), output, error, varying, lower, upper): into an engine's memory
LINEARISE: Final = Role(INTEGER, (MATRIX,) * 7)
# misjudged(data, X (N, nx), output, error, varying, lower, upper): see `misjudged`
MISJUDGED: Final = Role(NUMBER, (MATRIX,) * 6)
_linearise_body = LINEARISE.call
_misjudged_by_body = MISJUDGED.call
_NO_DIRECTION: Final = 1e-9  # [m] nearer to the centre than this, the circle has no direction


class Felt(NamedTuple):
    """What the kernels need to know of the channels; all arrays but `row` have one entry per channel."""

    row: Mat  # (C, nx) what is felt, linear: g θ for the gravity of a tilt
    root: Vec  # square root of the weight of the squared error
    sensed: Bools  # whether an organ is part of the prediction
    tilt: Ints  # state of x that gives gravity, -1 if there is none
    outer: Ints  # state of x whose cosine reduces that gravity, -1 if there is none
    of_tilt: Ints  # index of the slope by the tilt among the values of D, for physical channels
    of_outer: Ints  # index of the slope by the outer tilt
    linear: bool  # whether sin θ is replaced by θ throughout the prediction
    column: Ints  # which of a predictor's six columns holds what is wanted …
    sign: Vec  # … and its sign


class Organs(NamedTuple):
    """The organs of all sensed channels, one after the other (no,), in the simulator and in the car."""

    first: Ints  # (C + 1,) first state of each channel; a physical channel has none
    A: Mat  # (no, no)
    B: Vec  # (no,) coefficients of an input that is held over a period
    B0: Vec  # (no,) coefficients of an input that is linear over it: of its first value …
    B1: Vec  # (no,) … and of its last
    C: Vec  # (no,)
    D: Vec  # (C,)
    here: Vec  # (no,) states in the simulator
    there: Vec  # (no,) in the car
    felt_here: Vec  # (C,) what was felt last in the simulator
    felt_there: Vec  # (C,) and in the car


class Given(NamedTuple):
    """What the kernels need to know of a problem; only `X` and the organs' states change."""

    axes: Axes
    hold: Mat  # (nu, 6) as `otolith.cueing.mpc.motion.held`
    felt: Felt
    organs: Organs
    ends: Ints  # (M,) last step of every block
    of: Ints  # (w,) state on whose size the washout weight depends
    washout: Mat  # (w, 5) its coefficients w₁ … w₄ and scale
    control_weight: Vec  # (nu,) R
    circle: Vec  # (3,) weights of velocity, position and acceleration in the quantity that the circle limits
    in_circle: Ints  # (2, 3) those states of surge and sway
    circled: bool  # whether there is a circle
    X: Mat  # (N, nx) memory for the prediction
    body: Method  # linearises the whole body instead of channel by channel (`otolith.cueing.mpc.body`) …
    judge: Method  # … and tells what that misjudges


@kernel
def want(felt: Felt, coming: Mat, late: float, wanted: Mat) -> None:
    """Write what every channel should feel (N, C), from the predictor's rows `coming` (N + ⌈late⌉, 6).

    The rows are interpolated linearly, and start `late` periods after the first.
    """
    first = int(late)
    share = late - first
    for c in range(wanted.shape[1]):
        j, sign = felt.column[c], felt.sign[c]
        for k in range(wanted.shape[0]):
            value = coming[first + k, j]
            if share > 0.0:
                value = (1.0 - share) * value + share * coming[first + k + 1, j]
            wanted[k, c] = sign * value


@kernel
def linearise_force(given: Given, c: int, wanted: Mat, D: Mat, error: Mat) -> None:
    """Write slopes D (N, values) and errors (N, C) of a physical channel's force, less `wanted` (N, C)."""
    felt, X = given.felt, given.X
    root, tilt, outer = felt.root[c], felt.tilt[c], felt.outer[c]
    for k in range(X.shape[0]):
        constant = -wanted[k, c]
        if tilt >= 0 and not felt.linear:
            theta = X[k, tilt]
            sine, cosine = np.sin(theta), np.cos(theta)
            pull = GRAVITY
            if outer >= 0:
                phi = X[k, outer]
                pull = GRAVITY * np.cos(phi)
                slope = -GRAVITY * np.sin(phi) * sine
                constant -= slope * phi
                D[k, felt.of_outer[c]] = root * slope
            constant += pull * (sine - cosine * theta)
            D[k, felt.of_tilt[c]] = root * pull * cosine
        error[k, c] = root * constant


@kernel
def _missing(x: Vec, tilt: int, outer: int) -> float:
    """Return Δ of one tilt in the motion x; 0 without a tilt."""
    if tilt < 0:
        return 0.0
    cosine = np.cos(x[outer]) if outer >= 0 else 1.0
    delta: float = GRAVITY * (cosine * np.sin(x[tilt]) - x[tilt])
    return delta


@kernel
def predict_sensed(given: Given, c: int, wanted: Mat, error: Mat) -> None:
    """Write the errors (N, C) of sensed channel `c`.

    The error is what the organ senses of Δ in the simulator, less what it will sense in the car. Both are
    responses of one linear system, so a single pass from the difference of the states gives it.
    """
    felt, organs, X = given.felt, given.organs, given.X
    low, high = organs.first[c], organs.first[c + 1]
    o, after = -organs.there[low:high], np.empty(high - low)
    for k in range(X.shape[0]):
        delta = 0.0 if felt.linear else _missing(X[k], felt.tilt[c], felt.outer[c])
        value = delta - wanted[k, c]
        total = organs.D[c] * value
        for i in range(high - low):
            after[i] = organs.B[low + i] * value
            for j in range(high - low):
                after[i] += organs.A[low + i, low + j] * o[j]
            total += organs.C[low + i] * after[i]
        for i in range(high - low):
            o[i] = after[i]
        error[k, c] = felt.root[c] * total


@kernel
def _move_on(organs: Organs, c: int, o: Vec, before: float, now: float) -> None:
    """Advance one organ by a period over which the felt value changes linearly from `before` to `now`."""
    low, high = organs.first[c], organs.first[c + 1]
    after = organs.B0[low:high] * before + organs.B1[low:high] * now
    for i in range(high - low):
        for j in range(high - low):
            after[i] += organs.A[low + i, low + j] * o[low + j]
    for i in range(high - low):
        o[low + i] = after[i]


@kernel
def sense(given: Given, x: Vec, wanted: Mat) -> None:
    """Advance all organs by the period that ends now.

    The simulator's organs feel the motion x, those in the car the first row of `wanted` (N, C).
    """
    felt, organs = given.felt, given.organs
    for c in range(len(felt.root)):
        if felt.sensed[c]:
            here = _missing(x, felt.tilt[c], felt.outer[c])
            for i in range(len(x)):
                here += felt.row[c, i] * x[i]
            _move_on(organs, c, organs.here, organs.felt_here[c], here)
            _move_on(organs, c, organs.there, organs.felt_there[c], wanted[0, c])
            organs.felt_here[c], organs.felt_there[c] = here, wanted[0, c]


@kernel
def _limited(given: Given, k: int, p: int) -> float:
    """Return the quantity that the circle limits, at step k, for surge (p = 0) or sway (p = 1)."""
    place = 0.0
    for i in range(3):
        place += given.circle[i] * given.X[k, given.in_circle[p, i]]
    return place


@kernel
def linearise_circle(given: Given, rows: Mat) -> None:
    """Write rows (M, values) of the limit circle about the motion predicted for the blocks' ends.

    The circle limits c = (c_long, c_lat), each the position alone or a combination with velocity and
    acceleration. With n the unit vector towards the predicted c, the line n·c = radius touches the circle.
    The non-zeros of a row are in the order of the states, surge before sway.

    The half-plane n·c ≤ radius contains the whole circle. It also contains points outside the circle: a point
    whose direction differs by φ from the predicted one may leave the circle by at most about radius·φ²/2.
    """
    for k in range(len(given.ends)):
        x, y = _limited(given, given.ends[k], 0), _limited(given, given.ends[k], 1)
        length = np.hypot(x, y)
        near = length <= _NO_DIRECTION
        slot = 0
        for p in range(2):
            direction = 0.0 if near else (x, y)[p] / length
            for i in range(3):
                if given.circle[i] != 0.0:
                    rows[k, slot] = direction * given.circle[i]
                    slot += 1


@kernel
def weigh_washout(given: Given, x: Vec, weights: Mat) -> None:
    """Write the washout weights (N, w) for the present state x, the same at all steps (eq. 4.12).

    The weight is w₁ + w₂ r + w₃ r² + w₄ r⁴ with r = |x_of| / scale.
    """
    for i in range(len(given.of)):
        c = given.washout[i]
        r = abs(x[given.of[i]]) / c[4]
        weights[:, i] = c[0] + c[1] * r + c[2] * r**2 + c[3] * r**4


@kernel
def pull_to(u_ref: Mat, R: Vec, ends: Ints, linear: Mat) -> None:
    """Write the linear terms −R Σ u_ref (M, nu), summed over each block; zero if u_ref has no steps."""
    linear[:] = 0.0
    block = 0
    for k in range(u_ref.shape[0]):
        block += k > ends[block]
        for j in range(u_ref.shape[1]):
            linear[block, j] -= R[j] * u_ref[k, j]


@kernel
def write(given: Given, memory: StageMemory, x: Vec, plan: Mat, wanted: Mat, u_ref: Mat) -> None:
    """Write all of the above about the plan (N, nu) into an engine's memory."""
    for i in range(len(x)):
        memory.start[i] = x[i]
    for i in range(len(given.organs.here)):
        memory.start[len(x) + i] = given.organs.here[i]
    predict(given.axes, given.hold, x, plan, given.X)
    if given.body[0] != 0:
        rows = (memory.varying, memory.lower, memory.upper)
        _linearise_body(given.body, (given.X, wanted, memory.output, memory.error, *rows))
    else:
        for c in range(wanted.shape[1]):
            if given.felt.sensed[c]:
                predict_sensed(given, c, wanted, memory.error)
            else:
                linearise_force(given, c, wanted, memory.output, memory.error)
    if given.circled:
        linearise_circle(given, memory.varying)
    weigh_washout(given, x, memory.state_weight)
    pull_to(u_ref, given.control_weight, given.ends, memory.input_linear)


@kernel
def misjudged(given: Given, memory: StageMemory, x: Vec, plan: Mat) -> float:
    """Return which share of a plan's cost (N, nu) the problem in memory misjudges, of a body."""
    predict(given.axes, given.hold, x, plan, given.X)
    rows = (memory.varying, memory.lower, memory.upper)
    share: float = _misjudged_by_body(given.judge, (given.X, memory.output, memory.error, *rows))
    return share
