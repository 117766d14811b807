"""The last instance before the legs: whatever is commanded, the machine stays within its limits.

These are length, speed and acceleration of every leg, the angles of its joints, and poses that the legs hold.
The supervisor stands between set-points and servos and knows no algorithm. Set-points are leg lengths and
speeds. It passes on a path of its own, along which it slows *all* legs in proportion, so that the platform
goes where it was sent, later or less far, and never jumps.

Notation: ℓ, v lengths and speeds passed on; V, A limits of a leg; Δ the period. Accelerations are constant
over a period: v⁺ = v + a Δ, ℓ⁺ = ℓ + Δ (v + v⁺)/2.

Safe set. From v all legs together can stop in n = ⌈max|v|/(A Δ)⌉ periods by v⁺ = v (1 − 1/n), which takes
them to ℓ + v n Δ/2 and requires no more than A from any leg. A state is safe if |v| ≤ V, both ends of that
path lie within the stroke, and every pose on it is proved to hold (`otolith.platforms.holding`). One period
of that braking leads from a safe state to a safe state, because n⁺ ≤ n − 1 and the remaining path is a part
of the path (induction over n). So if every period is either checked to end safely or else brakes, every limit
is kept forever. Checked by test_no_command_whatever_breaks_a_limit and
test_no_command_whatever_reaches_a_singular_pose.
"""

import math
from dataclasses import dataclass
from enum import StrEnum
from typing import Final, NamedTuple

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.copying import copy_to
from otolith.core.errors import InputError
from otolith.core.jit import kernel
from otolith.core.rotation import place_of
from otolith.platforms.hexapod import Hexapod
from otolith.platforms.holding import FLOOR, Ball, Joints, place_ball, way_holds

CATCH_UP: Final = 0.25  # share of a small lag that is recovered in one period
HALVINGS: Final = 20  # bisections of the share of the path towards the target
POSE_HALVINGS: Final = 6  # the same if poses are proved, which costs a thousand times as much
GUARD: Final = 1e-9  # [m] margin to the ends of the stroke, larger than rounding errors
SLACK: Final = 1e-6  # share of a limit; a smaller excess is rounding, not an intervention
APART: Final = 0.25  # [s] longest pause within one intervention
KEPT: Final = 1000  # largest number of interventions that are stored

_FREE, _SPEED, _ACCELERATION, _STROKE, _JOINT, _SINGULAR, _DEAD, _INVALID = range(8)


class Reason(StrEnum):
    """The reason why the supervisor acted."""

    SPEED = "speed"
    ACCELERATION = "acceleration"
    STROKE = "stroke"
    JOINT = "joint angle"
    SINGULAR = "a singular pose"
    DEAD_CENTRE = "the dead centre of a crank"
    INVALID = "a set-point that is no number"

    @property
    def limit(self) -> str:
        """Return what was kept, in words for a table."""
        named = (Reason.SINGULAR, Reason.DEAD_CENTRE, Reason.INVALID)
        return str(self) if self in named else f"the {self} of a leg"


REASONS: Final = (Reason.INVALID, *Reason)  # in the order of the numbers above


@dataclass(frozen=True, slots=True, kw_only=True)
class Intervention:
    """A stretch of time over which the supervisor reduced the motion, for one reason."""

    start: float  # [s]
    end: float  # [s]
    reason: Reason
    leg: int  # 1 … 6, the leg that would have broken its limit first; 0 for a singular pose
    behind: float  # [m] largest distance of a leg from its set-point

    def __str__(self) -> str:
        """Return one sentence."""
        when, late = f"{self.start:.3f} to {self.end:.3f} s", f"up to {1e3 * self.behind:.2f} mm behind"
        match self.reason:
            case Reason.INVALID:
                return f"{when}: braked, for {self.reason}"
            case Reason.SINGULAR | Reason.DEAD_CENTRE:
                return f"{when}: slowed before {self.reason}, {late}"
            case _:
                return f"{when}: slowed for the {self.reason} of leg {self.leg}, {late}"


class Keeps(NamedTuple):
    """The limits, in a form that kernels can read."""

    stroke: tuple[float, float]  # [m] shortest and longest leg
    speed: float  # V [m/s]
    acceleration: float  # A [m/s²]
    joints: Joints
    ball: Ball  # around the lengths that are passed on; moves with them

    @classmethod
    def of(cls, hexapod: Hexapod) -> "Keeps":
        """Return the limits of one hexapod."""
        return cls(hexapod.stroke, hexapod.speed, hexapod.acceleration, Joints.of(hexapod), Ball.empty())


@kernel
def _finite(values: Vec) -> bool:
    """Return whether all six values are finite numbers."""
    wrong = 0
    for i in range(6):
        wrong += not abs(values[i]) < np.inf  # a NaN fails every comparison
    return wrong == 0


@kernel
def _largest(values: Vec) -> int:
    worst = 0
    for i in range(1, len(values)):
        if abs(values[i]) > abs(values[worst]):
            worst = i
    return worst


@kernel
def _periods_to_stop(speeds: Vec, A: float, dt: float) -> float:
    return float(np.ceil(abs(speeds[_largest(speeds)]) / (A * dt) - 1e-9))


@kernel
def _first_outside(lengths: Vec, speeds: Vec, stroke: tuple[float, float], A: float, dt: float) -> int:
    """Return the leg that would leave its stroke now or while all stop together; −1 if none would."""
    low, high = stroke[0] + GUARD, stroke[1] - GUARD
    ahead = 0.5 * dt * _periods_to_stop(speeds, A, dt)
    for i in range(6):
        end = lengths[i] + ahead * speeds[i]
        if not (low <= min(lengths[i], end) and max(lengths[i], end) <= high):
            return i
    return -1


@kernel
def _wanted_speeds(lengths: Vec, to_length: Vec, to_speed: Vec, A: float, dt: float, speeds: Vec) -> None:
    """Write the speeds that follow the set-points and recover the lag, but no faster than can be braked."""
    lag = np.empty(6)
    for i in range(6):
        lag[i] = to_length[i] - lengths[i] - 0.5 * dt * (speeds[i] + to_speed[i])
    largest = abs(lag[_largest(lag)])
    rate = min(CATCH_UP / dt, math.sqrt(A / largest)) if largest > 0.0 else 0.0
    for i in range(6):
        speeds[i] = to_speed[i] + rate * lag[i]


@kernel
def _move(lengths: Vec, before: Vec, after: Vec, dt: float, moved: Vec) -> None:
    """Write the lengths (6,) after a period in which the speeds changed linearly."""
    for i in range(6):
        moved[i] = lengths[i] + 0.5 * dt * (before[i] + after[i])


@kernel
def _shrink(values: Vec, bound: float) -> int:
    """Scale `values` in place so that none exceeds the bound; return the worst leg, −1 for none."""
    worst = _largest(values)
    largest = abs(values[worst])
    if largest > bound:
        values *= bound / largest
    return worst if largest > bound * (1.0 + SLACK) else -1


@kernel
def _braking(speeds: Vec, A: float, dt: float, braked: Vec) -> None:
    """Write the speeds (6,) after a period of braking."""
    n = _periods_to_stop(speeds, A, dt)
    for i in range(6):
        braked[i] = speeds[i] * (1.0 - 1.0 / n) if n > 0 else 0.0


@kernel
def _between(braked: Vec, further: Vec, share: float, aim: Vec) -> None:
    """Write speeds that are a share of what is further than braking."""
    for i in range(6):
        aim[i] = braked[i] + share * further[i]


@kernel
def _stop_short(lengths: Vec, before: Vec, aim: Vec, stroke: tuple[float, float], A: float, dt: float) -> int:
    """Move `aim`, in place, as close to braking as a safe end of the period needs; return the causing leg."""
    moved, braked = np.empty(6), np.empty(6)
    _move(lengths, before, aim, dt, moved)
    leg = _first_outside(moved, aim, stroke, A, dt)
    if leg < 0:
        return leg
    _braking(before, A, dt, braked)
    further, safe, unsafe = aim - braked, 0.0, 1.0
    for _ in range(HALVINGS):
        share = 0.5 * (safe + unsafe)
        _between(braked, further, share, aim)
        _move(lengths, before, aim, dt, moved)
        if _first_outside(moved, aim, stroke, A, dt) < 0:
            safe = share
        else:
            unsafe = share
    _between(braked, further, safe, aim)
    return leg


@kernel
def _holds(lengths: Vec, before: Vec, aim: Vec, keeps: Keeps, dt: float) -> tuple[bool, int]:
    """Return whether the period to the speeds `aim`, and the braking that could follow, hold all the way.

    Returns
    -------
    Whether they hold, and what ends the path if not: see `otolith.platforms.holding.place_ball`.
    """
    moved, rest = np.empty(6), np.empty(6)
    _move(lengths, before, aim, dt, moved)
    ahead = 0.5 * dt * _periods_to_stop(aim, keeps.acceleration, dt)
    for i in range(6):
        rest[i] = moved[i] + ahead * aim[i]
    ball = Ball(keeps.ball.centre.copy(), keeps.ball.place.copy(), keeps.ball.radius.copy())
    held, why = way_holds(lengths, moved, keeps.joints, ball)
    if held:
        held, why = way_holds(moved, rest, keeps.joints, ball)
    return held, why


@kernel
def _stay_held(lengths: Vec, before: Vec, aim: Vec, keeps: Keeps, dt: float) -> tuple[bool, int]:
    """Move `aim`, in place, as close to braking as the poses ahead need; return whether, and why."""
    held, why = _holds(lengths, before, aim, keeps, dt)
    if held:
        return False, -1
    A, moved, braked = keeps.acceleration, np.empty(6), np.empty(6)
    _braking(before, A, dt, braked)
    further, safe, unsafe = aim - braked, 0.0, 1.0
    for _ in range(POSE_HALVINGS):
        share = 0.5 * (safe + unsafe)
        _between(braked, further, share, aim)
        _move(lengths, before, aim, dt, moved)
        inside = _first_outside(moved, aim, keeps.stroke, A, dt) < 0
        if inside and _holds(lengths, before, aim, keeps, dt)[0]:
            safe = share
        else:
            unsafe = share
    _between(braked, further, safe, aim)
    return True, why


@kernel
def _why(ended_by: int) -> tuple[int, int]:
    """Return reason and leg of what `otolith.platforms.holding.place_ball` names."""
    if ended_by < 0:
        return _SINGULAR, -1
    return (_JOINT, ended_by) if ended_by < 6 else (_DEAD, ended_by - 6)


@kernel
def _follow_ball(lengths: Vec, keeps: Keeps) -> None:
    """Move the ball along if the lengths (6,) have left its central half."""
    off = 0.0
    for i in range(6):
        off += (lengths[i] - keeps.ball.centre[i]) ** 2
    if math.sqrt(off) > 0.5 * keeps.ball.radius[0]:
        place_ball(lengths, keeps.joints, keeps.ball)


@kernel
def supervise(
    to_length: Vec, to_speed: Vec, lengths: Vec, speeds: Vec, keeps: Keeps, dt: float
) -> tuple[int, int]:
    """Advance lengths and speeds (6,) in place by dt towards set-points at its end.

    Returns
    -------
    The reason for less motion than requested, an index of `REASONS`, and the leg (0 … 5; −1 for none).
    """
    V, A = keeps.speed, keeps.acceleration
    aim, reason, leg = speeds.copy(), _FREE, -1
    _wanted_speeds(lengths, to_length, to_speed, A, dt, aim)
    if not _finite(aim):
        aim[:] = 0.0
        reason, leg = _INVALID, 0
    leg_of_speed = _shrink(aim, V)
    aim -= speeds
    leg_of_acceleration = _shrink(aim, A * dt)
    aim += speeds
    leg_of_stroke = _stop_short(lengths, speeds, aim, keeps.stroke, A, dt)
    changed, ended_by = _stay_held(lengths, speeds, aim, keeps, dt)
    if reason == _FREE:  # the last change takes precedence
        if changed:
            reason, leg = _why(ended_by)
        elif leg_of_stroke >= 0:
            reason, leg = _STROKE, leg_of_stroke
        elif leg_of_speed >= 0:
            reason, leg = _SPEED, leg_of_speed
        elif leg_of_acceleration >= 0:
            reason, leg = _ACCELERATION, leg_of_acceleration
    _move(lengths, speeds, aim, dt, lengths)
    copy_to(speeds, aim)
    _follow_ball(lengths, keeps)
    return reason, leg


class Log(NamedTuple):
    """The interventions so far, in a form that kernels write."""

    rows: Mat  # (KEPT, 5) start and end [s], reason, leg from 1 on (0: none), how far it stayed behind [m]
    at: Ints  # (2,) periods that have passed, and interventions


@kernel
def record(log: Log, code: int, leg: int, behind: float, dt: float) -> None:
    """Record the result of `supervise` in one period, with how far the farthest leg stayed behind [m]."""
    rows, at = log.rows, log.at
    at[0] += 1
    if code == _FREE:
        return
    now, last = at[0] * dt, at[1] - 1
    late = 0.0 if code == _INVALID else behind
    if last >= 0 and rows[last, 2] == code and now - rows[last, 1] <= APART:
        rows[last, 1], rows[last, 4] = now, max(rows[last, 4], late)
    elif at[1] < len(rows):
        rows[last + 1, 0], rows[last + 1, 1] = now - dt, now
        rows[last + 1, 2], rows[last + 1, 3], rows[last + 1, 4] = code, leg + 1, late
        at[1] += 1


class Supervisor:
    """Keeps one hexapod within its limits, period by period, and records its interventions."""

    def __init__(self, hexapod: Hexapod, *, period: float = 1e-3) -> None:
        self.period = period  # [s]
        self.lengths, self.speeds = np.empty(6), np.zeros(6)  # lengths [m] and speeds [m/s] passed on
        self._hexapod = hexapod
        self.keeps = Keeps.of(hexapod)  # input of `supervise`
        self.log = Log(np.zeros((KEPT, 5)), np.zeros(2, dtype=np.int64))
        self.reset(np.zeros(6), np.zeros(6))

    def reset(self, pose: Vec, twist: Vec) -> None:
        """Start from a pose in motion, and discard the past.

        Raises
        ------
        LegOutsideStroke, LeansTooFar, Singular : the legs cannot make the pose.
        InputError : the motion is so fast, or so close to a singular pose or the end of a joint, that the
            legs cannot stop within their limits.
        """
        self._hexapod.check(pose)
        motion, keeps = self._hexapod.leg_motion(pose, twist, np.zeros(6)), self.keeps
        self.lengths[:], self.speeds[:] = motion.length, motion.speed
        place_of(np.asarray(pose, dtype=np.float64), keeps.ball.place)
        place_ball(self.lengths, keeps.joints, keeps.ball)
        fast, A = float(np.abs(motion.speed).max()), keeps.acceleration
        within = _first_outside(motion.length, motion.speed, keeps.stroke, A, self.period) < 0
        if not (fast <= keeps.speed and within):
            raise InputError(
                "leg speed to start with", f"{fast:.3g} m/s", "one that can stop within the stroke"
            )
        braked = np.empty(6)
        _braking(motion.speed, A, self.period, braked)
        if not (
            keeps.ball.radius[0] >= FLOOR and _holds(self.lengths, self.speeds, braked, keeps, self.period)[0]
        ):
            raise InputError(
                "pose to start with",
                "too near to a singular pose or to the end of a joint",
                "one from which the legs can stop before either",
            )
        self.log.at[:] = 0

    def follow(self, lengths: Vec, speeds: Vec) -> bool:
        """Advance one period towards set-points (6,) at its end; return whether the motion was reduced."""
        code, leg = supervise(lengths, speeds, self.lengths, self.speeds, self.keeps, self.period)
        record(self.log, code, leg, float(np.abs(lengths - self.lengths).max()), self.period)
        return bool(code != _FREE)

    @property
    def interventions(self) -> tuple[Intervention, ...]:
        """Return the interventions since the last reset, at most the first `KEPT`, in order of time."""
        return tuple(
            Intervention(start=start, end=end, reason=REASONS[int(code)], leg=int(leg), behind=behind)
            for start, end, code, leg, behind in self.log.rows[: self.log.at[1]].tolist()
        )
