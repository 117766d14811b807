"""The planar models of one axis pair, and the rows that keep a platform within its limits.

Notation of the thesis: ω tilt rate, θ tilt, v velocity, s position, a_tran, a_rot accelerations;
f = a_tran + g sin θ. Explicit model (eq. 4.1): x = [ω θ v s], u = [a_rot a_tran]. Implicit model
(eq. 4.9): accelerations are states that lag the commands, x = [ω θ v s a_tran a_rot], u as before.

A *row* is a linear form of the model's states (and, in the explicit model, of its inputs) that must
stay between two bounds at every stage.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Final

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError
from otolith.core.frames import AxisPair
from otolith.interfaces import PlatformState
from otolith.platforms import Braking, PairLimits
from otolith.stopping import HUGE

STATES: Final = ("tilt_rate", "tilt", "velocity", "position", "acceleration", "tilt_acceleration")
TILT_RATE, TILT, VELOCITY, POSITION, ACCELERATION, TILT_ACCELERATION = range(6)
ROT, TRAN = range(2)  # inputs


class BrakingRows(StrEnum):
    """Which rows slow the platform down as it nears its reach."""

    STOPPING = "stopping"  # eq. C.2, and limits on the leading motion: whoever keeps them can stop
    POSITION = "position"  # eq. C.2: s + c_v v T + ½ c_u a T² within the reach, limits at the nodes
    PRINTED = "printed"  # eqs. 4.7 and 4.8 as printed, without the position: for reproduction only
    NONE = "none"


def parse_braking_rows(name: str) -> BrakingRows:
    """Read an option's value, or say in one sentence what it may be."""
    try:
        return BrakingRows(name)
    except ValueError:
        raise InputError("braking", repr(name), "one of " + ", ".join(BrakingRows)) from None


@dataclass(frozen=True, slots=True)
class Row:
    """lower ≤ coefficients · x ≤ upper with x the six states of the implicit model."""

    name: str
    coefficients: Vec  # (6,)
    lower: float
    upper: float


def explicit_dynamics() -> tuple[Mat, Mat]:
    """Continuous (A (4, 4), B (4, 2)) of eq. 4.1: two double integrators."""
    A, B = np.zeros((4, 4)), np.zeros((4, 2))
    A[TILT, TILT_RATE] = A[POSITION, VELOCITY] = 1.0
    B[TILT_RATE, ROT] = B[VELOCITY, TRAN] = 1.0
    return A, B


def implicit_dynamics(lag: float) -> tuple[Mat, Mat]:
    """Continuous (A (6, 6), B (6, 2)) of eq. 4.9: accelerations lag their commands by `lag` [s]."""
    A, B = np.zeros((6, 6)), np.zeros((6, 2))
    A[TILT, TILT_RATE] = A[POSITION, VELOCITY] = 1.0
    A[TILT_RATE, TILT_ACCELERATION] = A[VELOCITY, ACCELERATION] = 1.0
    A[ACCELERATION, ACCELERATION] = A[TILT_ACCELERATION, TILT_ACCELERATION] = -1.0 / lag
    B[ACCELERATION, TRAN] = B[TILT_ACCELERATION, ROT] = 1.0 / lag
    return A, B


def _unit(state: int) -> Vec:
    e = np.zeros(6)
    e[state] = 1.0
    return e


def state_rows(limits: PairLimits) -> list[Row]:
    """Limits on the four states that both models share (eq. 4.3)."""
    return [
        Row("tilt_rate", _unit(TILT_RATE), -limits.tilt_rate, limits.tilt_rate),
        Row("tilt", _unit(TILT), *limits.tilt),
        Row("velocity", _unit(VELOCITY), -limits.velocity, limits.velocity),
        Row("position", _unit(POSITION), *limits.position),
    ]


def acceleration_rows(limits: PairLimits) -> list[Row]:
    """Limits on the accelerations that the platform has, not on those commanded."""
    rows = [Row("acceleration", _unit(ACCELERATION), -limits.acceleration, limits.acceleration)]
    if math.isfinite(limits.tilt_acceleration):
        bound = limits.tilt_acceleration
        rows.append(Row("tilt_acceleration", _unit(TILT_ACCELERATION), -bound, bound))
    return rows


def leading_rows(limits: PairLimits, braking: Braking, *, lag: float, period: float) -> list[Row]:
    """Limits on the leading motion, from which the platform can always stop (`otolith.stopping`).

    With q = s + T v and w = v + T a, T the lag: |v + 2 T a| ≤ v_max and q + τ w within the reach. While both
    hold, v follows v + 2 T a, q follows q + τ w, and s follows q, each through a low-pass; so the limits on
    v and s hold as well, between the nodes too. With T instead of 2 T the speed would run into its limit
    within one period, and a servo that follows not quite would overshoot it. τ is such that full braking
    needs no more than τ |w| (`look_ahead`). The commands' bounds, not above those on the accelerations,
    keep the accelerations.
    """
    turning, moving = look_ahead(limits, braking, period)
    rate, speed = _led(TILT_RATE, TILT_ACCELERATION, lag), _led(VELOCITY, ACCELERATION, lag)
    angle, place = _led(TILT, TILT_RATE, lag), _led(POSITION, VELOCITY, lag)
    late_rate, late_speed = lag * _unit(TILT_ACCELERATION), lag * _unit(ACCELERATION)
    return [
        Row("tilt_rate", rate + late_rate, -limits.tilt_rate, limits.tilt_rate),
        Row("tilt", angle + turning * rate, *limits.tilt),
        Row("velocity", speed + late_speed, -limits.velocity, limits.velocity),
        Row("position", place + moving * speed, *limits.position),
    ]


def _led(state: int, derivative: int, lag: float) -> Vec:
    return _unit(state) + lag * _unit(derivative)


def look_ahead(limits: PairLimits, braking: Braking, period: float) -> tuple[float, float]:
    """Times τ [s] of tilt and travel in `leading_rows`.

    Full braking by periods Δ from the leading speed w takes at most w (Δ/2 + w/(2U)), and w is at most
    v_max, or L/τ when the reach of length L is shorter. τ is at least a tenth of the braking rows' own
    time, far below where they act in normal motion, so that measurement errors cost little command.
    """
    turning = time_to_stop(limits.tilt, limits.tilt_rate, limits.tilt_acceleration, period)
    bound = min(limits.command, limits.acceleration)
    moving = time_to_stop(limits.position, limits.velocity, bound, period)
    return max(turning, 0.1 * braking.c_w * braking.tilt_s), max(
        moving, 0.1 * braking.c_v * braking.position_s
    )


def circle_weights(
    limits: Sequence[PairLimits], braking: Braking, kind: BrakingRows, lag: float, period: float
) -> Vec:
    """Weights (3,) of velocity, position and acceleration in the place that the limit circle holds.

    The position itself, or with `leading_rows` their q + τ w with one τ for all pairs: the way from q
    there is straight, and stays in the circle.
    """
    if kind is not BrakingRows.STOPPING:
        return np.array([0.0, 1.0, 0.0])
    ahead = max(look_ahead(one, braking, period)[1] for one in limits)
    return np.array([lag + ahead, 1.0, ahead * lag])


def time_to_stop(reach: tuple[float, float], speed: float, bound: float, period: float) -> float:
    """Smallest τ with τ ≥ Δ/2 + min(v_max, L/τ)/(2U)."""
    half = 0.5 * period
    room = (reach[1] - reach[0]) / (2.0 * bound)
    return min(half + speed / (2.0 * bound), 0.5 * half + math.sqrt(0.25 * half**2 + room))


def command_bound(limits: PairLimits, kind: BrakingRows) -> float:
    """Bound on the commanded acceleration [m/s²]; beside `leading_rows` it keeps the actual one, too."""
    return min(limits.command, limits.acceleration) if kind is BrakingRows.STOPPING else limits.command


def braking_rows(limits: PairLimits, braking: Braking, kind: BrakingRows) -> list[Row]:
    """Rows that slow the platform down as it nears its reach (eqs. 4.7, 4.8; with position: C.2).

    On its surface the position row is a stable second-order law s → limit, overdamped enough not
    to overshoot when c_v² / c_u ≥ 2, so that whoever satisfies it can stop within the reach.
    """
    if kind is BrakingRows.NONE:
        return []
    own = 0.0 if kind is BrakingRows.PRINTED else 1.0
    T_s, T_tilt = braking.position_s, braking.tilt_s
    translation = own * _unit(POSITION) + braking.c_v * T_s * _unit(VELOCITY)
    translation += 0.5 * braking.c_u * T_s**2 * _unit(ACCELERATION)
    rotation = own * _unit(TILT) + braking.c_w * T_tilt * _unit(TILT_RATE)
    rotation += 0.5 * braking.c_u * T_tilt**2 * _unit(TILT_ACCELERATION)
    return [
        Row("braking_position", translation, *limits.position),
        Row("braking_tilt", rotation, *limits.tilt),
    ]


def terminal_rows(limits: PairLimits) -> list[Row]:
    """Rows on the last state from which the platform can stop within its reach.

    On v = κ (s_max − s) braking asks for κ² (s_max − s) ≤ κ² (s_max − s_min), which the command bound u
    affords for κ² = u / (s_max − s_min): the wedge is invariant. Braking rows imply a narrower one.
    """
    rows = []
    motions = (
        ("position", POSITION, VELOCITY, limits.position, min(limits.command, limits.acceleration)),
        ("tilt", TILT, TILT_RATE, limits.tilt, limits.tilt_acceleration),
    )
    for name, place, speed, (low, high), bound in motions:
        if math.isfinite(bound):
            kappa = math.sqrt(bound / (high - low))
            rows.append(Row(f"terminal_{name}", _unit(place) + _unit(speed) / kappa, low, high))
    return rows


def planar_state(state: PlatformState, pair: AxisPair) -> Vec:
    """The implicit model's x (6,) of one axis pair; its first four entries are the explicit model's."""
    x = np.empty(6)
    x[POSITION], x[TILT] = pair.planar(state.pose)
    x[VELOCITY], x[TILT_RATE] = pair.planar(state.twist)
    x[ACCELERATION], x[TILT_ACCELERATION] = pair.planar(state.acceleration)
    return x


def plausible(values: Mat) -> bool:
    """True when forces are numbers of this world, at most `HUGE` in SI units."""
    return bool(np.abs(values).max(initial=0.0) <= HUGE)  # so written, a NaN is not
