"""The gate: every set-point passes here, whatever decided it, and the platform can stop after each of them.

A set-point is a motion (3, 6): pose, twist and acceleration of the six axes. It passes if all numbers are
finite; pose, twist, acceleration and jerk of every axis are within the platform's limits, and length, speed
and acceleration of every leg, by inverse kinematics; and if the way to rest from it, sampled every 5 ms,
passes the same checks.

Why the limits then hold forever: what has passed last has a way to rest that was checked. If the next
set-point does not pass, the platform follows that way, which is deterministic: the law of
`otolith.safety.law`, asked anew in every period from the motion that has passed. So there is a set-point
that passes in every case. An axis keeps its limits between the samples too: pose p and speed v follow
q = p + T v and w = v + T a without overshoot, all four are checked, and q and w stay within reach by the
proof of `otolith.safety.law.safe`. A leg may be beyond a limit by
what it changes in 2.5 ms; `MARGIN` keeps this room on the way to rest.

Notation: T lag of eq. 4.9; a motion moves by `otolith.safety.law.move`, which is exact, so the jerk of
a commanded acceleration that jumps from one end of its limit U to the other is at most 2 U / T.

Nothing here is imported from controllers, solvers or plants. Checked by tests/live/core/test_gate.py against
another implementation, in plain numpy.
"""

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import Final, NamedTuple

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.frames import AXES, DOFS, Dof
from otolith.core.jit import kernel
from otolith.platforms import Platform
from otolith.platforms.kinematics import leg_motion
from otolith.platforms.platform import Rotation, Translation
from otolith.safety.law import Reach, move, safe, stop, to_rest
from otolith.safety.stopping import reach_of

SAMPLE: Final = 5e-3  # [s] between samples of the way to rest, and of a plan
SLACK: Final = 1e-6  # share of a limit; a smaller excess is rounding
MARGIN: Final = 0.01  # share of a leg's limit that the way to rest keeps free
RESTS: Final = 1e-6  # [SI] commands below this end the way to rest
LONGEST: Final = 1000  # largest number of periods of a way to rest
SPEED: Final = np.array([0.2] * 3 + [0.1] * 3)  # [m/s, rad/s] of moves from and to rest …
PAD: Final = np.array([2e-3] * 3 + [3.5e-3] * 3)  # [m, rad] around a park pose, to brake in
ACCELERATION: Final = np.array([1.0] * 3 + [0.5] * 3)  # … and [m/s², rad/s²]

_FREE, _FINITE, _POSE, _CIRCLE, _TWIST, _ACCELERATION, _JERK, _LENGTH, _SPEED, _STRENGTH, _ENDLESS = range(11)


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
        legs = Refusal.LEG_LENGTH <= self.refusal <= Refusal.LEG_ACCELERATION
        return f"{f'leg {self.index + 1}' if legs else AXES[self.index]} {_WORDS[self.refusal]}"


PASSES: Final = Verdict()


class Bounds(NamedTuple):
    """The limits, in a form that kernels can read; what a platform's file does not give is infinite."""

    low: Vec  # (6,) [m ×3, rad ×3]
    high: Vec  # (6,)
    twist: Vec  # (6,) [m/s ×3, rad/s ×3]
    acceleration: Vec  # (6,) [m/s² ×3, rad/s² ×3]
    jerk: Vec  # (6,) [m/s³ ×3, rad/s³ ×3]
    lag: float  # T [s]
    circle: float  # [m] of surge and sway together
    joints: Mat  # (6, 3) [m], or (0, 3) without legs
    anchors: Mat  # (6, 3) [m]
    stroke: tuple[float, float]  # [m]
    leg_speed: float  # [m/s]
    leg_acceleration: float  # [m/s²]


@kernel
def _axes(motion: Mat, before: Mat, dt: float, b: Bounds) -> tuple[int, int]:
    """Check the axes; without dt the jerk is not checked."""
    for i in range(6):
        p, v, a = motion[0, i], motion[1, i], motion[2, i]
        if not (abs(p) < np.inf and abs(v) < np.inf and abs(a) < np.inf):  # a NaN fails every comparison
            return _FINITE, i
        room, q = SLACK * (b.high[i] - b.low[i]), p + b.lag * v
        if not (b.low[i] - room <= min(p, q) and max(p, q) <= b.high[i] + room):
            return _POSE, i
        if not max(abs(v), abs(v + b.lag * a)) <= b.twist[i] * (1.0 + SLACK):
            return _TWIST, i
        if not abs(a) <= b.acceleration[i] * (1.0 + SLACK):
            return _ACCELERATION, i
        if dt > 0.0 and not abs(a - before[2, i]) <= b.jerk[i] * dt * (1.0 + SLACK) + 1e-9:
            return _JERK, i
    x, y = motion[0, 0], motion[0, 1]
    qx, qy = x + b.lag * motion[1, 0], y + b.lag * motion[1, 1]
    if not max(x * x + y * y, qx * qx + qy * qy) <= (b.circle * (1.0 + SLACK)) ** 2:
        return _CIRCLE, 0
    return _FREE, 0


@kernel
def _legs(motion: Mat, b: Bounds, margin: float) -> tuple[int, int]:
    """Check the legs, of whose limits a share `margin` is kept free."""
    legs = np.empty((3, 6))
    leg_motion(motion[0], motion[1], motion[2], b.joints, b.anchors, legs)
    room = margin * (b.stroke[1] - b.stroke[0])
    for i in range(6):
        if not b.stroke[0] + room <= legs[0, i] <= b.stroke[1] - room:
            return _LENGTH, i
        if not abs(legs[1, i]) <= b.leg_speed * (1.0 - margin):
            return _SPEED, i
        if not abs(legs[2, i]) <= b.leg_acceleration * (1.0 - margin):
            return _STRENGTH, i
    return _FREE, 0


@kernel
def _point(motion: Mat, before: Mat, dt: float, b: Bounds, margin: float) -> tuple[int, int]:
    """Check one motion (3, 6); its jerk since the motion `before`, dt earlier."""
    code, i = _axes(motion, before, dt, b)
    if code == _FREE and len(b.joints) > 0:
        code, i = _legs(motion, b, margin)
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
def _end(motion: Mat, b: Bounds) -> tuple[int, int]:
    """Check where a motion comes to rest whose commands have ended: at q = p + T v, since w is zero."""
    for i in range(6):
        motion[0, i] += b.lag * motion[1, i]
        motion[1, i] = motion[2, i] = 0.0
    return _point(motion, motion, 0.0, b, MARGIN)


@kernel
def _way_to_rest(motion: Mat, b: Bounds, reach: Reach) -> tuple[int, int]:
    """Check the way to rest from `motion`, which advances along it."""
    if not safe(motion, reach):
        return _ENDLESS, 0
    u = np.empty(6)
    for _ in range(LONGEST):
        stop(motion, reach, u)
        largest = 0.0
        for i in range(6):
            largest = max(largest, abs(u[i]))
        if largest <= RESTS:
            return _end(motion, b)
        code, i = _way(motion, u, reach.period, b, reach)
        if code != _FREE:
            return code, i
    return _ENDLESS, 0


@kernel
def judge(motion: Mat, before: Mat, dt: float, b: Bounds, reach: Reach) -> tuple[int, int]:
    """Return what a motion (3, 6), or the way to rest from it, breaks, and where."""
    code, i = _point(motion, before, dt, b, 0.0)
    if code == _FREE:
        code, i = _way_to_rest(motion.copy(), b, reach)
    return code, i


@kernel
def judge_plan(motion: Mat, stages: Mat, period: float, b: Bounds, reach: Reach) -> tuple[int, int]:
    """Return what a plan's commands (K, 6), and then the law's until rest, break on the way from `motion`."""
    ahead = motion.copy()
    for k in range(len(stages)):
        code, i = _way(ahead, stages[k], period, b, reach)
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
        self.bounds = _bounds(platform, lag)
        self.reach = reach_of(platform, dofs_of(platform))._replace(
            circle=math.inf if platform.circle is None else platform.circle, lag=lag, period=period
        )
        if park is not None:
            self.bounds, self.reach = _widened(self.bounds, park), _widened_reach(self.reach, park)
        self._u = np.empty(
            6
        )  # a command to work with: one that can be written to, so that kernels have one form
        rest = np.zeros((3, 6))
        self.judge(rest)  # compiled now, so that no set-point waits for the compiler
        self.plan(rest, np.zeros((1, 6)), period)
        self.advance(rest, np.zeros(6), 1e-3)
        self.brake(rest, np.zeros(6))
        self.rest(rest)
        self.point(rest, rest, 0.0)
        self.move(rest, np.zeros(6), 0.0)

    def judge(self, motion: Mat, before: Mat | None = None, dt: float = 0.0) -> Verdict:
        """Judge a motion (3, 6), and its jerk since the motion `before`, dt [s] earlier, where given."""
        return _verdict(judge(motion, motion if before is None else before, dt, self.bounds, self.reach))

    def point(self, motion: Mat, before: Mat, dt: float) -> Verdict:
        """Judge a motion (3, 6) alone, without the way to rest."""
        return _verdict(_point(motion, before, dt, self.bounds, 0.0))

    def plan(self, motion: Mat, stages: Mat, period: float) -> Verdict:
        """Judge the commands (K, 6) of a plan from `motion`, each held for a period [s], and the way to rest
        after them.
        """
        return _verdict(judge_plan(motion, np.array(stages), period, self.bounds, self.reach))

    def advance(self, motion: Mat, u: Vec, dt: float) -> Verdict:
        """Advance `motion` in place by dt [s] under the commands u (6,) if this passes; else leave it."""
        self._u[:] = u
        return _verdict(advance(motion, self._u, dt, self.bounds, self.reach))

    def rest(self, motion: Mat) -> Mat:
        """Return the commands (K, 6) of the law from `motion` to rest, one for each of its periods."""
        room = np.zeros((LONGEST, 6))
        return room[: max(1, to_rest(motion.copy(), self.reach, 0, room))]

    def brake(self, motion: Mat, u: Vec) -> None:
        """Write the commands u (6,) of the law that leads to rest, to be held for one of its periods."""
        stop(motion, self.reach, u)

    def move(self, motion: Mat, u: Vec, dt: float) -> None:
        """Advance `motion` (3, 6) in place by dt [s] under the commands u (6,), unjudged."""
        self._u[:] = u
        move(motion, self._u, self.reach.lag, dt)


def dofs_of(platform: Platform) -> tuple[Dof, ...]:
    """Return the degrees of freedom for which the platform's file gives all axes and limits."""
    return tuple(
        dof
        for dof in DOFS.values()
        if all(AXES[axis] in platform.axes for axis in dof.axes) and (dof.is_pair or _limited(platform, dof))
    )


def _limited(platform: Platform, dof: Dof) -> bool:
    table = getattr(platform, AXES[dof.axes[0]])
    if isinstance(table, Translation):
        return True
    return table.rate_degps is not None and table.acceleration_degps2 is not None


def _bounds(platform: Platform, lag: float) -> Bounds:
    """Return the machine's limits; axes that nothing moves stay at zero."""
    low, high, twist, acceleration, jerk = np.zeros((5, 6))
    for axis in {axis for dof in dofs_of(platform) for axis in dof.axes}:
        table = getattr(platform, AXES[axis])
        low[axis], high[axis], twist[axis], acceleration[axis] = _of(table)
        jerk[axis] = 2.0 * acceleration[axis] / lag if lag > 0.0 else math.inf
    circle = math.inf if platform.circle is None else platform.circle
    if platform.hexapod is None:
        none = np.empty((0, 3))
        legs = (none, none, (-math.inf, math.inf), math.inf, math.inf)
    else:
        hexapod = platform.six_legs()
        legs = (hexapod.joints, hexapod.anchors, hexapod.stroke, hexapod.speed, hexapod.acceleration)
    return Bounds(low, high, twist, acceleration, jerk, lag, circle, *legs)


def _of(table: Translation | Rotation) -> tuple[float, float, float, float]:
    """Return the ends of an axis, its speed and its acceleration in SI units."""
    if isinstance(table, Translation):
        strongest = max(table.acceleration_mps2, table.command_mps2 or 0.0)
        return *table.position_m, table.velocity_mps, strongest
    low, high = (math.radians(end) for end in table.angle_deg)
    rate = math.inf if table.rate_degps is None else math.radians(table.rate_degps)
    strongest = math.inf if table.acceleration_degps2 is None else math.radians(table.acceleration_degps2)
    return low, high, rate, strongest


def _widened(bounds: Bounds, park: Vec) -> Bounds:
    """Return bounds that contain a pose; an axis that only this pose needs moves gently."""
    new = (park != 0.0) & (bounds.twist == 0.0)
    low, high = _room(bounds.low, bounds.high, park)
    return bounds._replace(
        low=low,
        high=high,
        twist=np.where(new, SPEED, bounds.twist),
        acceleration=np.where(new, ACCELERATION, bounds.acceleration),
        jerk=np.where(new, math.inf, bounds.jerk),
        circle=max(bounds.circle, math.hypot(park[0], park[1]) + PAD[0]),
    )


def _widened_reach(reach: Reach, park: Vec) -> Reach:
    new = (park != 0.0) & (reach.command == 0.0)
    low, high = _room(np.where(new, 0.0, reach.low), np.where(new, 0.0, reach.high), park)
    return reach._replace(
        low=low,
        high=high,
        speed=np.where(new, SPEED, reach.speed),
        command=np.where(new, ACCELERATION, reach.command),
        circle=max(reach.circle, math.hypot(park[0], park[1]) + PAD[0]),
    )


def _room(low: Vec, high: Vec, park: Vec) -> tuple[Vec, Vec]:
    """Return a reach that contains a pose and the neutral one, each with a little room along its axes."""
    pad = np.where(park != 0.0, PAD, 0.0)
    return np.minimum(low, np.minimum(park, 0.0) - pad), np.maximum(high, np.maximum(park, 0.0) + pad)


def _verdict(found: tuple[int, int]) -> Verdict:
    code, index = found
    return PASSES if code == _FREE else Verdict(Refusal(code), index)
