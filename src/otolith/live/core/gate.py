"""The gate: every set-point passes here, whatever decided it, and the platform can stop after each of them.

A set-point is a motion (3, 6): pose, twist and acceleration of the six axes. It passes if all numbers are
finite; pose, twist, acceleration and jerk of every axis are within the platform's limits, and length (or
crank angle), speed and acceleration of every leg and the angles of its joints, by inverse kinematics; and if
the way to rest from it, sampled every 5 ms, passes the same checks.

Why the limits then hold forever: what has passed last has a way to rest that was checked. If the next
set-point does not pass, the platform follows that way, which is deterministic: the law of
`otolith.safety.law`, asked anew in every period from the motion that has passed. So there is a set-point
that passes in every case. An axis keeps its limits between the samples too: pose p and speed v follow
q = p + T v and w = v + T a without overshoot, all four are checked, and q and w stay within reach by the
proof of `otolith.safety.law.safe`. A leg may be beyond a limit by
what it changes in 2.5 ms; `MARGIN` keeps this room on the way to rest.

On the way to rest, and during some periods of a plan at a time, axes are judged by what the samples span, and
legs by bounds over that span (`otolith.live.core.legs`); where these prove nothing, every sample is judged.

Notation: T lag of eq. 4.9; a motion moves by `otolith.safety.law.move`, which is exact, so the jerk of
a commanded acceleration that jumps from one end of its limit U to the other is at most 2 U / T.

Nothing here is imported from controllers, solvers or plants. Checked by tests/live/core/test_gate.py against
another implementation, in plain numpy.
"""

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import Final

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.copying import copy_to
from otolith.core.frames import AXES
from otolith.core.jit import kernel
from otolith.live.core.bounds import Bounds, bounds_of, dofs_of, widened, widened_reach
from otolith.live.core.legs import legs_at, legs_hold
from otolith.platforms import Platform
from otolith.safety.law import Reach, decay, move, move_by, none_above, safe, stop_by, to_rest
from otolith.safety.stopping import reach_of

SAMPLE: Final = 5e-3  # [s] between samples of the way to rest, and of a plan
SLACK: Final = 1e-6  # share of a limit; a smaller excess is rounding
MARGIN: Final = 0.01  # share of a leg's limit that the way to rest keeps free
RESTS: Final = 1e-6  # [SI] commands below this end the way to rest
LONGEST: Final = 1000  # largest number of periods of a way to rest
TOGETHER: Final = 16  # periods of a plan that are judged by one span

_FREE, _FINITE, _POSE, _CIRCLE, _TWIST, _ACCELERATION, _JERK = range(7)
_LENGTH, _SPEED, _STRENGTH, _ENDLESS, _LEAN = range(7, 12)


class Refusal(IntEnum):
    """What a set-point breaks; the first that is found."""

    NOTHING = _FREE
    NOT_FINITE = _FINITE
    POSE = _POSE
    CIRCLE = _CIRCLE
    TWIST = _TWIST
    ACCELERATION = _ACCELERATION
    JERK = _JERK
    LEG_LENGTH = _LENGTH
    LEG_SPEED = _SPEED
    LEG_ACCELERATION = _STRENGTH
    CANNOT_STOP = _ENDLESS
    LEG_LEAN = _LEAN


_WORDS: Final = {
    Refusal.NOT_FINITE: "is no number",
    Refusal.POSE: "leaves its reach",
    Refusal.CIRCLE: "leaves the circle of surge and sway",
    Refusal.TWIST: "is too fast",
    Refusal.ACCELERATION: "accelerates too much",
    Refusal.JERK: "jerks",
    Refusal.LEG_LENGTH: "leaves its stroke",
    Refusal.LEG_SPEED: "is too fast",
    Refusal.LEG_ACCELERATION: "accelerates too much",
    Refusal.LEG_LEAN: "leans too far",
}


@dataclass(frozen=True, slots=True)
class Verdict:
    """Whether a set-point passes; if not, why, and at which axis or leg."""

    refusal: Refusal = Refusal.NOTHING
    index: int = 0  # of the axis or leg, from 0

    @property
    def passes(self) -> bool:
        """True if nothing is broken."""
        return self.refusal is Refusal.NOTHING

    def __str__(self) -> str:
        """Return it in words."""
        if self.passes:
            return "passes"
        if self.refusal is Refusal.CANNOT_STOP:
            return "could not stop within reach"
        legs = self.refusal >= Refusal.LEG_LENGTH
        return f"{f'leg {self.index + 1}' if legs else AXES[self.index]} {_WORDS[self.refusal]}"


PASSES: Final = Verdict()


@kernel
def _widen(span: Mat, motion: Mat, lag: float) -> None:
    """Let a span (5, 6) contain a motion (3, 6).

    Its rows are the lowest and highest pose, the largest speed and acceleration, each with its leading value
    q = p + T v or w = v + T a, and the square of the largest distance of surge and sway from the middle.
    """
    for i in range(6):
        p, v, a = motion[0, i], motion[1, i], motion[2, i]
        q, w = p + lag * v, v + lag * a
        span[0, i], span[1, i] = min(span[0, i], min(p, q)), max(span[1, i], max(p, q))
        span[2, i] = max(span[2, i], max(abs(v), abs(w)))
        span[3, i] = max(span[3, i], abs(a))
    x, y = motion[0, 0], motion[0, 1]
    qx, qy = x + lag * motion[1, 0], y + lag * motion[1, 1]
    span[4, 0] = max(span[4, 0], max(x * x + y * y, qx * qx + qy * qy))


@kernel
def _narrow(span: Mat) -> None:
    """Let a span contain nothing."""
    for i in range(6):
        span[0, i], span[1, i] = np.inf, -np.inf
        span[2, i] = span[3, i] = span[4, i] = 0.0


@kernel
def _within(span: Mat, b: Bounds) -> tuple[int, int]:
    """Check that a span is within the limits of the axes."""
    for i in range(6):
        room = SLACK * (b.high[i] - b.low[i])
        if not (b.low[i] - room <= span[0, i] and span[1, i] <= b.high[i] + room):
            return _POSE, i
        if not span[2, i] <= b.twist[i] * (1.0 + SLACK):
            return _TWIST, i
        if not span[3, i] <= b.acceleration[i] * (1.0 + SLACK):
            return _ACCELERATION, i
    if not span[4, 0] <= (b.circle * (1.0 + SLACK)) ** 2:
        return _CIRCLE, 0
    return _FREE, 0


@kernel
def _finite(motion: Mat) -> int:
    """Return the first axis of which a number is none; −1 if all are finite."""
    for i in range(6):
        for row in range(3):
            if not abs(motion[row, i]) < np.inf:  # a NaN fails every comparison
                return i
    return -1


@kernel
def _axes(motion: Mat, before: Mat, dt: float, b: Bounds) -> tuple[int, int]:
    """Check the axes of one motion; without dt the jerk is not checked."""
    i = _finite(motion)
    if i >= 0:
        return _FINITE, i
    for i in range(6):
        if dt > 0.0 and not abs(motion[2, i] - before[2, i]) <= b.jerk[i] * dt * (1.0 + SLACK) + 1e-9:
            return _JERK, i
    span = np.empty((5, 6))
    _narrow(span)
    _widen(span, motion, b.lag)
    return _within(span, b)


@kernel
def _point(motion: Mat, before: Mat, dt: float, b: Bounds, margin: float) -> tuple[int, int]:
    """Check one motion (3, 6); its jerk since the motion `before`, dt earlier."""
    code, i = _axes(motion, before, dt, b)
    if code == _FREE and len(b.joints) > 0:
        code, i = legs_at(motion, b, margin, np.empty((3, 3)), np.empty((3, 3)))
    return code, i


@kernel
def _way(motion: Mat, u: Vec, duration: float, b: Bounds, reach: Reach) -> tuple[int, int]:
    """Advance `motion` under held commands, in samples of about `SAMPLE`, and check each of them."""
    n = max(1, round(duration / SAMPLE))
    for _ in range(n):
        move(motion, u, reach.lag, duration / n)
        code, i = _point(motion, motion, 0.0, b, MARGIN)
        if code != _FREE:
            return code, i
    return _FREE, 0


@kernel
def _end(motion: Mat, b: Bounds) -> None:
    """Let a motion come to rest whose commands have ended: at q = p + T v, since w is zero."""
    for i in range(6):
        motion[0, i] += b.lag * motion[1, i]
        motion[1, i] = motion[2, i] = 0.0


@kernel
def _legs_within(span: Mat, b: Bounds) -> bool:
    """Return whether all legs keep their limits wherever in a span; False proves nothing."""
    if len(b.joints) == 0:
        return True
    centre, spread = np.empty(6), np.empty((3, 6))
    for k in range(6):
        centre[k], spread[0, k] = 0.5 * (span[1, k] + span[0, k]), 0.5 * (span[1, k] - span[0, k])
        spread[1, k], spread[2, k] = span[2, k], span[3, k]
    return legs_hold(centre, spread, b, MARGIN, np.empty((3, 3)), np.empty((3, 3)))


@kernel
def _way_of_axes(motion: Mat, b: Bounds, reach: Reach, span: Mat) -> tuple[int, int]:
    """Check the axes at every sample of the way to rest from `motion`, which advances along it.

    `span` becomes that of the way. All limits of axes but the circle are intervals, so it is enough to
    compare the span with them; a number that is none stays one until the end.
    """
    u, q, w = np.empty(6), np.empty(6), np.empty(6)
    n = max(1, round(reach.period / SAMPLE))
    rho = decay(reach.lag, reach.period / n)
    _narrow(span)
    for _ in range(LONGEST):
        stop_by(motion, reach, u, q, w)
        if none_above(u, RESTS):
            _end(motion, b)
            _widen(span, motion, b.lag)
            i = _finite(motion)
            if i >= 0:
                return _FINITE, i
            return _within(span, b)
        for _ in range(n):
            move_by(motion, u, reach.lag, reach.period / n, rho)
            _widen(span, motion, b.lag)
    return _ENDLESS, 0


@kernel
def _way_of_legs(motion: Mat, b: Bounds, reach: Reach) -> tuple[int, int]:
    """Check the legs at every sample of the way to rest from `motion`, which advances along it."""
    u, q, w, R, axes = np.empty(6), np.empty(6), np.empty(6), np.empty((3, 3)), np.empty((3, 3))
    n = max(1, round(reach.period / SAMPLE))
    rho = decay(reach.lag, reach.period / n)
    for _ in range(LONGEST):
        stop_by(motion, reach, u, q, w)
        if none_above(u, RESTS):
            _end(motion, b)
            return legs_at(motion, b, MARGIN, R, axes)
        for _ in range(n):
            move_by(motion, u, reach.lag, reach.period / n, rho)
            code, i = legs_at(motion, b, MARGIN, R, axes)
            if code != _FREE:
                return code, i
    return _ENDLESS, 0


@kernel
def _way_to_rest(motion: Mat, b: Bounds, reach: Reach) -> tuple[int, int]:
    """Check the way to rest from `motion`: axes at every sample; legs by bounds, or else at every sample."""
    if not safe(motion, reach):
        return _ENDLESS, 0
    span = np.empty((5, 6))
    code, i = _way_of_axes(motion.copy(), b, reach, span)
    if code != _FREE or _legs_within(span, b):
        return code, i
    return _way_of_legs(motion.copy(), b, reach)


@kernel
def _holds(motion: Mat, stages: Mat, period: float, b: Bounds, reach: Reach) -> bool:
    """Advance `motion` by stages of a plan; return whether their span proves them right."""
    n = max(1, round(period / SAMPLE))
    dt = period / n
    rho = decay(reach.lag, dt)
    span = np.empty((5, 6))
    _narrow(span)
    for k in range(len(stages)):
        for _ in range(n):
            move_by(motion, stages[k], reach.lag, dt, rho)
            _widen(span, motion, b.lag)
    return _finite(motion) < 0 and _within(span, b)[0] == _FREE and _legs_within(span, b)


@kernel
def judge(motion: Mat, before: Mat, dt: float, b: Bounds, reach: Reach) -> tuple[int, int]:
    """Return what a motion (3, 6), or the way to rest from it, breaks, and where."""
    code, i = _point(motion, before, dt, b, 0.0)
    if code == _FREE:
        code, i = _way_to_rest(motion, b, reach)
    return code, i


@kernel
def judge_plan(motion: Mat, stages: Mat, period: float, b: Bounds, reach: Reach) -> tuple[int, int]:
    """Return what a plan's commands (K, 6), and then the law's until rest, break on the way from `motion`."""
    ahead = motion.copy()
    for first in range(0, len(stages), TOGETHER):
        some = stages[first : first + TOGETHER]
        begin = ahead.copy()
        if not _holds(ahead, some, period, b, reach):
            for row in range(3):
                copy_to(ahead[row], begin[row])
            for k in range(len(some)):
                code, i = _way(ahead, some[k], period, b, reach)
                if code != _FREE:
                    return code, i
    return _way_to_rest(ahead, b, reach)


@kernel
def advance(motion: Mat, u: Vec, dt: float, b: Bounds, reach: Reach) -> tuple[int, int]:
    """Advance `motion` (3, 6) in place by dt under the commands u (6,), only if the result passes."""
    ahead = motion.copy()
    move(ahead, u, reach.lag, dt)
    code, i = judge(ahead, motion, dt, b, reach)
    if code == _FREE:
        for row in range(3):
            for j in range(6):
                motion[row, j] = ahead[row, j]
    return code, i


class Gate:
    """Checks the set-points of one platform, and knows the way to rest from each that passed.

    Parameters
    ----------
    lag : T [s] of the model by which set-points move.
    period : [s] of the law that leads to rest.
    park : (6,) [m, rad] a pose that the reach is widened to contain; for moves from and to where the platform
        rests without power.
    """

    def __init__(self, platform: Platform, *, lag: float, period: float, park: Vec | None = None) -> None:
        self.bounds = bounds_of(platform, lag)
        self.reach = reach_of(platform, dofs_of(platform))._replace(
            circle=math.inf if platform.circle is None else platform.circle, lag=lag, period=period
        )
        if park is not None:
            self.bounds, self.reach = widened(self.bounds, park), widened_reach(self.reach, park)
        self._u = np.empty(6)  # a command to work with
        rest = np.zeros((3, 6))
        self.judge(rest)  # compiled now, so that no set-point waits for the compiler
        self.plan(rest, np.zeros((1, 6)), period)
        self.rest(rest)
        self.point(rest, rest, 0.0)
        self.move(rest, np.zeros(6), 0.0)

    def judge(self, motion: Mat, before: Mat | None = None, dt: float = 0.0) -> Verdict:
        """Judge a motion (3, 6), and its jerk since the motion `before`, dt [s] earlier, where given."""
        return verdict_of(judge(motion, motion if before is None else before, dt, self.bounds, self.reach))

    def point(self, motion: Mat, before: Mat, dt: float) -> Verdict:
        """Judge a motion (3, 6) alone, without the way to rest."""
        return verdict_of(_point(motion, before, dt, self.bounds, 0.0))

    def plan(self, motion: Mat, stages: Mat, period: float) -> Verdict:
        """Judge the commands (K, 6) of a plan from `motion`, each held for a period [s], and the way to rest
        after them.
        """
        return verdict_of(judge_plan(motion, np.array(stages), period, self.bounds, self.reach))

    def rest(self, motion: Mat) -> Mat:
        """Return the commands (K, 6) of the law from `motion` to rest, one for each of its periods."""
        room = np.zeros((LONGEST, 6))
        return room[: max(1, to_rest(motion.copy(), self.reach, 0, room))]

    def move(self, motion: Mat, u: Vec, dt: float) -> None:
        """Advance `motion` (3, 6) in place by dt [s] under the commands u (6,), unjudged."""
        move(motion, self.writable(u), self.reach.lag, dt)

    def writable(self, u: Vec) -> Vec:
        """Return commands (6,) in an array that may be written to, so that kernels have one form."""
        self._u[:] = u
        return self._u


def verdict_of(found: tuple[int, int]) -> Verdict:
    """Return the verdict that a kernel has found."""
    code, index = found
    return PASSES if code == _FREE else Verdict(Refusal(code), index)
