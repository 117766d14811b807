"""The last hand on the legs: whatever is commanded, lengths, speeds and accelerations stay within limits.

It stands between set-points and servos and knows no algorithm. Set-points are leg lengths and speeds; what
it passes on is a path of its own, along which it slows *all* legs in proportion, so that the platform
goes where it was sent, later or less far, and never jumps.

Notation: ℓ, v lengths and speeds passed on; V, A limits of a leg; Δ the period. Over a period the
accelerations are constant: v⁺ = v + a Δ, ℓ⁺ = ℓ + Δ (v + v⁺)/2.

Safe set. From v all legs together can stop in n = ⌈max|v|/(A Δ)⌉ periods by v⁺ = v (1 − 1/n), which
takes them ℓ + v n Δ/2 and asks no leg for more than A. A state is safe when |v| ≤ V and both ends of that
way lie within the stroke. One period of that braking leads from a safe state to a safe state, for
n⁺ ≤ n − 1 (induction over n). So a period that is checked to end safely, or else brakes, keeps every
limit for ever. Checked by test_no_command_whatever_breaks_a_limit.
"""

import math
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Final

import numpy as np

from otolith.core.arrays import Vec
from otolith.core.errors import InputError
from otolith.core.jit import kernel
from otolith.platforms.hexapod import Hexapod

CATCH_UP: Final = 0.25  # of the lag that is made up for in one period, while the lag is small
HALVINGS: Final = 20  # of the share of the way towards what is wanted
GUARD: Final = 1e-9  # [m] kept from the ends of the stroke, above all rounding
SLACK: Final = 1e-6  # of a limit; less is rounding, not an intervention
APART: Final = 0.25  # [s] between ticks of one intervention at most
KEPT: Final = 1000  # interventions that are remembered

_FREE, _SPEED, _ACCELERATION, _STROKE, _INVALID = range(5)


class Reason(StrEnum):
    """Why the supervisor acted."""

    SPEED = "speed"
    ACCELERATION = "acceleration"
    STROKE = "stroke"
    INVALID = "a set-point that is no number"


_REASONS: Final = (None, Reason.SPEED, Reason.ACCELERATION, Reason.STROKE, Reason.INVALID)


@dataclass(frozen=True, slots=True, kw_only=True)
class Intervention:
    """A stretch of time over which the supervisor gave less than was asked, for one reason."""

    start: float  # [s]
    end: float  # [s]
    reason: Reason
    leg: int  # 1 … 6, the one that would have broken its limit first
    behind: float  # [m] farthest that a leg stayed behind its set-point

    def __str__(self) -> str:
        """One sentence."""
        return (
            f"{self.start:.3f} to {self.end:.3f} s: slowed for the {self.reason} of leg {self.leg}, "
            f"up to {1e3 * self.behind:.2f} mm behind"
            if self.reason is not Reason.INVALID
            else f"{self.start:.3f} to {self.end:.3f} s: braked, for {self.reason}"
        )


@kernel
def _largest(values: Vec) -> int:
    worst = 0
    for i in range(1, len(values)):
        if abs(values[i]) > abs(values[worst]):
            worst = i
    return worst


@kernel
def _periods_to_stop(speeds: Vec, A: float, dt: float) -> float:
    periods: float = math.ceil(abs(speeds[_largest(speeds)]) / (A * dt) - 1e-9)
    return periods


@kernel
def _first_outside(lengths: Vec, speeds: Vec, stroke: tuple[float, float], A: float, dt: float) -> int:
    """The leg that would leave its stroke now or while all stop together; −1 when none does."""
    low, high = stroke[0] + GUARD, stroke[1] - GUARD
    ahead = 0.5 * dt * _periods_to_stop(speeds, A, dt)
    for i in range(6):
        end = lengths[i] + ahead * speeds[i]
        if not (low <= min(lengths[i], end) and max(lengths[i], end) <= high):
            return i
    return -1


@kernel
def _wanted_speeds(lengths: Vec, to_length: Vec, to_speed: Vec, A: float, dt: float, speeds: Vec) -> None:
    """Write the speeds that follow the set-points and make up for the lag, no faster than it can be shed."""
    lag = np.empty(6)
    for i in range(6):
        lag[i] = to_length[i] - lengths[i] - 0.5 * dt * (speeds[i] + to_speed[i])
    largest = abs(lag[_largest(lag)])
    rate = min(CATCH_UP / dt, math.sqrt(A / largest)) if largest > 0.0 else 0.0
    for i in range(6):
        speeds[i] = to_speed[i] + rate * lag[i]


@kernel
def _move(lengths: Vec, before: Vec, after: Vec, dt: float, moved: Vec) -> None:
    """Write the lengths (6,) after a period in which the speeds changed evenly."""
    for i in range(6):
        moved[i] = lengths[i] + 0.5 * dt * (before[i] + after[i])


@kernel
def _shrink(values: Vec, bound: float) -> int:
    """Scale `values` in place until none exceeds the bound; the leg that exceeded it most, −1 for none."""
    worst = _largest(values)
    largest = abs(values[worst])
    if largest > bound:
        values *= bound / largest
    return worst if largest > bound * (1.0 + SLACK) else -1


@kernel
def _stop_short(lengths: Vec, before: Vec, aim: Vec, stroke: tuple[float, float], A: float, dt: float) -> int:
    """Bring `aim`, in place, as near to braking as a safe end of the period needs; the leg that needs it."""
    n = _periods_to_stop(before, A, dt)
    braked = before * (1.0 - 1.0 / n) if n > 0 else np.zeros(6)
    moved = np.empty(6)
    _move(lengths, before, aim, dt, moved)
    leg = _first_outside(moved, aim, stroke, A, dt)
    if leg < 0:
        return leg
    further, safe, unsafe = aim - braked, 0.0, 1.0
    for _ in range(HALVINGS):
        share = 0.5 * (safe + unsafe)
        aim[:] = braked + share * further
        _move(lengths, before, aim, dt, moved)
        if _first_outside(moved, aim, stroke, A, dt) < 0:
            safe = share
        else:
            unsafe = share
    aim[:] = braked + safe * further
    return leg


@kernel
def supervise(
    to_length: Vec,
    to_speed: Vec,
    lengths: Vec,
    speeds: Vec,
    limits: tuple[float, float, float, float],
    dt: float,
) -> tuple[int, int]:
    """Advance lengths and speeds (6,) in place by dt towards set-points at its end.

    Parameters
    ----------
    limits : shortest, longest, V, A.

    Returns
    -------
    Why it gave less than was asked, an index of `_REASONS`, and the leg (0 … 5).
    """
    stroke, V, A = (limits[0], limits[1]), limits[2], limits[3]
    aim, reason, leg = speeds.copy(), _FREE, -1
    _wanted_speeds(lengths, to_length, to_speed, A, dt, aim)
    if not np.all(np.isfinite(aim)):
        aim[:] = 0.0
        reason, leg = _INVALID, 0
    leg_of_speed = _shrink(aim, V)
    aim -= speeds
    leg_of_acceleration = _shrink(aim, A * dt)
    aim += speeds
    leg_of_stroke = _stop_short(lengths, speeds, aim, stroke, A, dt)
    if reason == _FREE:  # the last hand that changed something goes first
        if leg_of_stroke >= 0:
            reason, leg = _STROKE, leg_of_stroke
        elif leg_of_speed >= 0:
            reason, leg = _SPEED, leg_of_speed
        elif leg_of_acceleration >= 0:
            reason, leg = _ACCELERATION, leg_of_acceleration
    _move(lengths, speeds, aim, dt, lengths)
    speeds[:] = aim
    return reason, leg


class Supervisor:
    """Keeps one hexapod's legs within their limits, period by period, and remembers what it did."""

    def __init__(self, hexapod: Hexapod, *, period: float = 1e-3) -> None:
        self.period = period  # [s]
        self.lengths, self.speeds = np.empty(6), np.zeros(6)  # passed on: [m], [m/s]
        self._hexapod = hexapod
        self.limits = (*hexapod.stroke, hexapod.speed, hexapod.acceleration)  # as `supervise` takes them
        self._ticks = 0
        self._kept: list[Intervention] = []
        self.reset(np.zeros(6), np.zeros(6))

    def reset(self, pose: Vec, twist: Vec) -> None:
        """Forget the past and start from a pose in motion.

        Raises
        ------
        LegOutsideStroke, LeansTooFar, Singular : the legs cannot make the pose.
        InputError : so fast that the legs cannot stop within their strokes.
        """
        self._hexapod.check(pose)
        motion = self._hexapod.leg_motion(pose, twist, np.zeros(6))
        V, A = self.limits[2:]
        fast = np.abs(motion.speed).max()
        if not fast <= V or _first_outside(motion.length, motion.speed, self.limits[:2], A, self.period) >= 0:
            raise InputError(
                "leg speed to start with", f"{fast:.3g} m/s", "one that can stop within the stroke"
            )
        self.lengths[:], self.speeds[:] = motion.length, motion.speed
        self._ticks = 0
        self._kept.clear()

    def follow(self, lengths: Vec, speeds: Vec) -> bool:
        """Go one period towards set-points (6,) at its end; whether it gave less than was asked."""
        code, leg = supervise(lengths, speeds, self.lengths, self.speeds, self.limits, self.period)
        return self.account(code, leg, lengths)

    def account(self, code: int, leg: int, wanted: Vec) -> bool:
        """Remember what `supervise` told of a period that wanted lengths (6,) [m]; whether it gave less."""
        self._ticks += 1
        reason = _REASONS[code]
        if reason is not None:
            self._note(reason, leg, wanted)
        return reason is not None

    def _note(self, reason: Reason, leg: int, wanted: Vec) -> None:
        now = self._ticks * self.period
        behind = 0.0 if reason is Reason.INVALID else float(np.abs(wanted - self.lengths).max())
        last = self._kept[-1] if self._kept else None
        if last and last.reason is reason and now - last.end <= APART:
            self._kept[-1] = replace(last, end=now, behind=max(last.behind, behind))
        elif len(self._kept) < KEPT:
            self._kept.append(
                Intervention(start=now - self.period, end=now, reason=reason, leg=leg + 1, behind=behind)
            )

    @property
    def interventions(self) -> tuple[Intervention, ...]:
        """What it did since the last reset, the first `KEPT` of it, in order of time."""
        return tuple(self._kept)
