"""Compiled: one decision of a washout, from what is wanted to a command.

What differs between washouts, their channels of filters, is a method (`otolith.core.methods`) of the role
`CHANNELS`. Notation as in `otolith.cueing.washout.feedforward`.
"""

import math
from collections.abc import Sequence
from typing import Any, Final, NamedTuple, Self

import numpy as np

from otolith.compiled import DECIDED, INVALID, NOTHING, STATUS
from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.frames import GRAVITY, Dof
from otolith.core.jit import kernel
from otolith.core.methods import INTEGER, VECTOR, Method, Role
from otolith.core.rotation import place_of, rotation_of, twist_of
from otolith.safety.law import HUGE
from otolith.safety.stopping import Belief, observe, rest

ASTRAY: Final = 0.05  # share of the reach beyond which a platform is not where it was sent
OFF: Final = 0.5  # share of the largest speed; with a larger error a platform does not follow …
OFTEN: Final = 10  # … if this lasts for so many successive periods
STEEPEST: Final = 0.9  # largest force that a tilt should give, as a share of g
FRESH, STOPPED, MISLED = range(3)  # what `Memory.at` holds

FORCE, ACCELERATION, RATE = 0, 3, 6  # where a demand (9,) holds force (driver), acceleration, rates (world)
VELOCITY, TURNING, TILT, TILT_RATE = 0, 3, 6, 9  # where a motion (12,) holds its parts, three axes each

# channels(data, fresh, demand (9,), motion (12,)): write the motion at the end of the period that starts with
# the demand; `fresh` is 1 where the past is discarded first
CHANNELS: Final = Role(INTEGER, (INTEGER, VECTOR, VECTOR))
_channels = CHANNELS.call


class Pairs(NamedTuple):
    """The axis pairs that are cued; one entry per pair."""

    translation: Ints  # index in x, y, z
    rotation: Ints  # index in roll, pitch, yaw
    sign: Vec  # of the tilt against that rotation

    @classmethod
    def of(cls, pairs: Sequence[Dof]) -> Self:
        """Return the pairs in the form that kernels take."""
        return cls(
            np.array([pair.translation for pair in pairs], dtype=np.int64),
            np.array([pair.rotation - 3 for pair in pairs], dtype=np.int64),
            np.array([pair.sign for pair in pairs], dtype=np.float64),
        )


class Memory(NamedTuple):
    """Everything that a washout reads and remembers."""

    channels: Method
    belief: Belief
    period: float  # [s]
    lag: float  # [s] of the platform
    force: Vec  # (4,) scaling of force, as `scale` takes it
    rate: Vec  # (4,) and of angular rate
    cued: Vec  # (6,) one along the axes that are cued, zero along the others
    tilted: Vec  # (3,) the same of roll, pitch and yaw as tilts
    largest: Vec  # (3,) [rad/s] of a tilt
    change: Vec  # (3,) [rad/s] largest change of a tilt's rate in a period
    catch_up: float  # κ [1/s]
    homing: Vec  # (2,) k₁, k₂
    pose: Vec  # (6,) where the commands have led …
    twist: Vec  # (6,)
    angle: Vec  # (3,) [rad] … of which this is tilt …
    angle_rate: Vec  # (3,) [rad/s]
    home: Vec  # (6,) … and this is on its way back to neutral
    home_rate: Vec  # (6,)
    demand: Vec  # (9,)
    motion: Vec  # (12,)
    at: Ints  # (3,) channels start afresh; platform was stopped; successive periods without following


@kernel
def scale(cubic: Vec, x: float) -> float:
    """Scale and limit one number; `cubic` (4,) is S, c₂, c₃ and x_m of `otolith.cueing.washout.scaling`."""
    r = min(abs(x), cubic[3])
    y: float = ((cubic[2] * r + cubic[1]) * r + cubic[0]) * r
    return y if x > 0.0 else -y


@kernel
def tilt_for(force: float, derivative: float) -> tuple[float, float]:
    """Return the tilt whose gravity gives a force, and its rate: g sin θ = f, ω = ḟ / (g cos θ)."""
    sine = min(STEEPEST, max(-STEEPEST, force / GRAVITY))
    angle = math.asin(sine)
    rate = derivative / (GRAVITY * math.cos(angle)) if abs(sine) < STEEPEST else 0.0
    return angle, rate


@kernel
def coordinate(motion: Vec, pairs: Pairs, low: Vec) -> None:
    """Write the tilts for low-passed forces and their derivatives (2P,), one after the other per pair."""
    for p in range(len(pairs.sign)):
        angle, rate = tilt_for(low[2 * p], low[2 * p + 1])
        motion[TILT + pairs.rotation[p]] = pairs.sign[p] * angle
        motion[TILT_RATE + pairs.rotation[p]] = pairs.sign[p] * rate


@kernel
def follow_tilt(of: Any, rate: Vec) -> None:
    """Add to `rate` (3,) that of the tilt at the end of the period, towards the one that the channels want.

    ω⁺ = clip(ω* + κ (θ* − θ)), all at the end of the period. It is exactly ω* within the limits of rate and
    acceleration.
    """
    half = 0.5 * of.period
    for i in range(3):
        wanted, now = of.motion[TILT_RATE + i], of.angle_rate[i]
        behind = of.motion[TILT + i] - (of.angle[i] + half * (now + wanted))
        after = min(of.largest[i], max(-of.largest[i], wanted + of.catch_up * behind))
        after = min(now + of.change[i], max(now - of.change[i], after))
        of.angle[i] = of.angle[i] + half * (now + after)
        of.angle_rate[i] = after
        rate[i] += after


@kernel
def go_home(of: Any, twist: Vec) -> None:
    """Add to `twist` (6,) the velocity on the way back to neutral at the end of the period."""
    T = of.period
    for i in range(6):
        x, v = of.home[i], of.home_rate[i]
        a = -of.homing[0] * x - of.homing[1] * v
        of.home[i], of.home_rate[i] = x + T * v + 0.5 * T**2 * a, v + T * a
        twist[i] += of.home_rate[i]


@kernel
def start(of: Any, pose: Vec, twist: Vec) -> int:
    """Start from a pose (6,) and its derivative; tilt stays, all else goes home, filters start from rest."""
    of.at[FRESH], of.at[STOPPED], of.at[MISLED] = 1, 0, 0
    for i in range(6):
        of.pose[i], of.twist[i] = pose[i] * of.cued[i], twist[i] * of.cued[i]
        other = 1.0 if i < 3 else 1.0 - of.tilted[i - 3]
        of.home[i], of.home_rate[i] = other * of.pose[i], other * of.twist[i]
        if i >= 3:
            of.angle[i - 3] = of.tilted[i - 3] * of.pose[i]
            of.angle_rate[i - 3] = of.tilted[i - 3] * of.twist[i]
    return 0


@kernel
def _astray(of: Any, motion: Mat) -> bool:
    """Return whether the platform is elsewhere, or has moved otherwise for longer than its lag explains."""
    for row in range(3):
        for i in range(6):
            if not abs(motion[row, i]) <= HUGE:  # a NaN fails every comparison
                return False
    reach, beyond, off = of.belief.reach, False, False
    for i in range(6):
        if of.cued[i] > 0.0:
            away = abs(motion[0, i] - of.pose[i])
            beyond = beyond or away > ASTRAY * (reach.high[i] - reach.low[i])
            leading = motion[1, i] + of.lag * motion[2, i]  # as in `otolith.safety.law`
            off = off or abs(leading - of.twist[i]) > OFF * reach.speed[i]
    of.at[MISLED] = of.at[MISLED] + 1 if off else 0
    return beyond or of.at[MISLED] >= OFTEN


@kernel
def demand(of: Any, now: Vec) -> int:
    """Write the scaled reference (6,) as the platform's pose asks for it."""
    midway, place, R = np.empty(6), np.empty(7), np.empty((3, 3))
    velocity, turning, up = np.zeros(6), np.empty(6), GRAVITY
    for i in range(6):  # where the command, which is held, is right on average
        midway[i] = of.pose[i] + 0.5 * of.period * of.twist[i]
    place_of(midway, place)
    rotation_of(place, R)
    for i in range(3):
        of.demand[FORCE + i] = scale(of.force, now[i])
    for i in range(3):
        acceleration = 0.0
        for j in range(3):
            acceleration += R[i, j] * (of.demand[FORCE + j] + (up if j == 2 else 0.0))
            velocity[3 + i] += R[i, j] * scale(of.rate, now[3 + j])
        of.demand[ACCELERATION + i] = acceleration - (up if i == 2 else 0.0)
    twist_of(midway, velocity, turning)
    for i in range(3):
        of.demand[RATE + i] = turning[3 + i]
    return 0


@kernel
def _move(of: Any, command: Vec) -> None:
    """Write the held accelerations (6,) that lead to the motion which the channels want."""
    T, twist = of.period, np.empty(6)
    for i in range(3):
        twist[i], twist[3 + i] = of.motion[VELOCITY + i], of.motion[TURNING + i]
    follow_tilt(of, twist[3:])
    for i in range(6):
        twist[i] *= of.cued[i]
    go_home(of, twist)
    for i in range(6):
        command[i] = (twist[i] - of.twist[i]) / T
        of.pose[i] = of.pose[i] + 0.5 * T * (of.twist[i] + twist[i])
        of.twist[i] = twist[i]


@kernel
def _stop(of: Any, command: Vec) -> None:
    """Brake by the stopping law, from the pose and twist to which the commands have led."""
    motion = np.zeros((3, 6))
    for i in range(6):
        motion[0, i], motion[1, i] = of.pose[i], of.twist[i]
    observe(of.belief, motion)
    rest(of.belief, command)
    for i in range(6):
        of.pose[i], of.twist[i] = of.belief.believed[0, i], of.belief.believed[1, i]
    of.at[STOPPED] = 1


@kernel
def decide(
    of: Any,
    motion: Mat,
    now: Vec,
    preview: Mat,  # noqa: ARG001 (the role has it)
    age: float,  # noqa: ARG001
    again: int,  # noqa: ARG001
    command: Vec,
    result: Vec,
) -> int:
    """Decide one command; see `otolith.compiled.DECIDE`. Washouts use neither preview nor age."""
    result[:] = 0.0
    if _astray(of, motion):
        start(of, motion[0], motion[1])
    known = True
    for i in range(6):
        known = known and abs(now[i]) <= HUGE  # a NaN fails every comparison
    if not known:
        result[STATUS] = INVALID
        _stop(of, command)
        return NOTHING
    if of.at[STOPPED] == 1:
        start(of, of.pose.copy(), of.twist.copy())
    result[STATUS] = DECIDED
    demand(of, now)
    _channels(of.channels, (of.at[FRESH], of.demand, of.motion))
    of.at[FRESH] = 0
    _move(of, command)
    return NOTHING
