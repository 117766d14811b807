"""The parts that all washouts share: frames, scaling, unnoticed tilt, and motion by held accelerations.

Notation: R from the driver's frame to world, f specific force without the standing 1 g, ẑ up. With the
platform rotated by R, the driver feels exactly f if the head accelerates by

    a_world = R (f + g ẑ) − g ẑ,

so the translation need not produce what the tilt already gives. (This is derived from the definition of f.
Washouts of the Reid & Nahon family transform the force in the same way, but their reports were not
available.) Angular rates become derivatives of roll, pitch and yaw.

A filter states how fast each axis should move at the end of the period. The command is the held acceleration
that leads there, so velocities are exact at the end of every period, and travel follows by integration.
"""

from dataclasses import dataclass, field
from typing import Final, Protocol

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.frames import AXES, GRAVITY, Dof, pairs_of
from otolith.core.rotation import place_of, rotation_of, twist_of
from otolith.cueing.washout.scaling import Cubic
from otolith.cueing.washout.tuning import Tuning
from otolith.interfaces import Command, Outcome, PlatformState, Reference, Status
from otolith.platforms import Platform
from otolith.safety.law import HUGE
from otolith.safety.stopping import Stopping

PERIOD: Final = 0.01  # [s]
ASTRAY: Final = 0.05  # share of the reach from which a platform is not where it was sent
OFF: Final = 0.5  # share of the largest speed by which a platform deviates from its commands …
OFTEN: Final = 10  # … in this many consecutive periods
STOP: Final = 30  # number of periods in which the plan of every command comes to rest
STEEPEST: Final = 0.9  # largest force from tilt, as a share of g
UP: Final = np.array([0.0, 0.0, GRAVITY])


class Task(Protocol):
    """The description of a washout's task; `otolith.cueing.design.Design` is one."""

    @property
    def platform(self) -> Platform:
        """Return the platform; a washout reads only its limits of tilt."""

    @property
    def dofs(self) -> tuple[Dof, ...]:
        """Return the degrees of freedom to be cued."""

    @property
    def tuning(self) -> Tuning:
        """Return scaling, filters and weights."""


@dataclass(frozen=True, slots=True)
class Demand:
    """A scaled reference, seen from the platform at its present pose."""

    force_driver: Vec  # (3,) [m/s²]
    acceleration_world: Vec  # (3,) [m/s²] acceleration with which the driver would feel it
    rate_world: Vec  # (3,) [rad/s] rates of roll, pitch and yaw


@dataclass(frozen=True, slots=True)
class Motion:
    """The output of the channels at the end of the period; zero along axes that are not cued."""

    velocity: Vec = field(default_factory=lambda: np.zeros(3))  # [m/s] x, y, z
    turning: Vec = field(default_factory=lambda: np.zeros(3))  # [rad/s] roll, pitch, yaw; should be felt
    tilt: Vec = field(default_factory=lambda: np.zeros(3))  # [rad] roll, pitch, –; should not be noticed
    tilt_rate: Vec = field(default_factory=lambda: np.zeros(3))  # [rad/s] derivative of the tilt


class Channels(Protocol):
    """The part of a washout that differs: from demand to motion."""

    def reset(self) -> None:
        """Discard the past."""

    def step(self, demand: Demand) -> Motion:
        """Return the motion at the end of the period that starts with `demand`."""


class Tilting:
    """Follows a tilt at a limited rate, and catches up smoothly after it fell behind.

    ω⁺ = clip(ω* + κ (θ* − θ)), all at the end of the period. It is exactly ω* within the limits of rate and
    acceleration.
    """

    def __init__(self, largest: Vec, catch_up: float, period: float, steepest: float | Vec = np.inf) -> None:
        self._largest, self._kappa, self._period = largest, catch_up, period
        self._change = steepest * period * np.ones(3)  # [rad/s] largest change of the rate in a period
        self.reset(np.zeros(3), np.zeros(3))

    def reset(self, angle: Vec, rate: Vec) -> None:
        """Start from a tilt [rad] and its rate [rad/s], (3,) each."""
        self._angle, self._rate = angle, rate

    def step(self, angle: Vec, rate: Vec) -> Vec:
        """Return the rate (3,) [rad/s] at the end of the period, towards the wanted angle and rate there."""
        half = 0.5 * self._period
        behind = angle - (self._angle + half * (self._rate + rate))
        after = np.clip(rate + self._kappa * behind, -self._largest, self._largest)
        after = np.clip(after, self._rate - self._change, self._rate + self._change)
        self._angle = self._angle + half * (self._rate + after)
        self._rate = after
        return after


class Homing:
    """Returns a platform that starts elsewhere to neutral, critically damped, by held accelerations.

    The double integrator x⁺ = x + T v + T²a/2, v⁺ = v + T a has both poles at p = e^(−ωT) with a = −k₁ x − k₂
    v, k₁ = (1 − p)²/T², k₂ = (1 − p)(3 + p)/(2T), by comparing coefficients with (z − p)².
    """

    def __init__(self, omega: float, period: float) -> None:
        p = np.exp(-omega * period)
        self._k1, self._k2 = ((1 - p) / period) ** 2, (1 - p) * (3 + p) / (2 * period)
        self._period = period
        self.reset(np.zeros(6), np.zeros(6))

    def reset(self, pose: Vec, twist: Vec) -> None:
        """Start from this pose and twist."""
        self._x, self._v = pose, twist

    def step(self) -> Vec:
        """Return the velocity (6,) at the end of the period."""
        a, T = -self._k1 * self._x - self._k2 * self._v, self._period
        self._x, self._v = self._x + T * self._v + 0.5 * T**2 * a, self._v + T * a
        return self._v


class Washout:
    """A washout: channels of filters between a scaled reference and the motion of the platform.

    It decides from the reference alone, and its set-points are where its commands have led. The platform's
    state is used at `reset`, and if the platform is not where it should be: after missed decisions, or if the
    legs gave less than requested. Then the washout starts again from there.
    """

    def __init__(self, task: Task, channels: Channels, *, period: float = PERIOD) -> None:
        tuning = task.tuning
        self._channels, self._period = channels, period
        self._force, self._rate = scaling(tuning)
        self._cued = cued(task)
        limits, steepest = np.full(3, np.inf), np.full(3, np.inf)
        for pair in pairs_of(task.dofs):
            _, tilt = task.platform.limits(pair)
            limits[pair.rotation - 3] = tilt.velocity
            steepest[pair.rotation - 3] = tilt.acceleration
        self._tilted = np.isfinite(limits).astype(np.float64)  # (3,) roll, pitch, yaw
        self._tilting = Tilting(limits, tuning.catch_up_radps, period, steepest)
        self._lag = task.platform.actuators.lag_s
        self._homing = Homing(tuning.home_radps, period)
        self._stopping = Stopping(task.platform, task.dofs, lag=0.0, period=period)
        self.reset(PlatformState())

    @property
    def period(self) -> float:
        """Return the time between two decisions [s]."""
        return self._period

    def reset(self, state: PlatformState) -> None:
        """Start from `state`, from which the platform returns to neutral; filters start at rest.

        A tilt is kept, and continues at rates that are not noticed.
        """
        self._stopped, self._off = False, 0
        self._pose, self._twist = state.pose * self._cued, state.twist * self._cued
        others = 1.0 - np.concatenate([np.zeros(3), self._tilted])
        self._homing.reset(others * self._pose, others * self._twist)
        self._tilting.reset(self._tilted * self._pose[3:], self._tilted * self._twist[3:])
        self._channels.reset()

    def step(self, state: PlatformState, reference: Reference) -> Command:
        """Decide one command; while there is no reference, come to rest, then start again from there."""
        if self._astray(state):
            self.reset(state)
        given = np.concatenate([reference.specific_force, reference.angular_rate])
        if not np.all(np.abs(given) <= HUGE):  # a NaN fails every comparison
            return self._stop()
        if self._stopped:
            self.reset(PlatformState(pose=self._pose, twist=self._twist))
        demand = self._demand(given)
        motion = self._channels.step(demand)
        rotation = motion.turning + self._tilting.step(motion.tilt, motion.tilt_rate)
        twist = self._cued * np.concatenate([motion.velocity, rotation]) + self._homing.step()
        return self._command(twist)

    def _astray(self, state: PlatformState) -> bool:
        """Return whether the platform is elsewhere, or deviates for longer than its lag explains."""
        if not np.abs([state.pose, state.twist, state.acceleration]).max() <= HUGE:
            return False
        reach, cued = self._stopping.reach, self._cued > 0.0
        beyond = np.abs(state.pose - self._pose) > ASTRAY * (reach.high - reach.low)
        leading = state.twist + self._lag * state.acceleration  # as in `otolith.safety.stopping`
        off = np.abs(leading - self._twist) > OFF * reach.speed
        self._off = self._off + 1 if (off & cued).any() else 0
        return bool((beyond & cued).any()) or self._off >= OFTEN

    def _stop(self) -> Command:
        self._stopping.observe(PlatformState(pose=self._pose, twist=self._twist))
        command = self._stopping.rest(Outcome(status=Status.INVALID))
        self._pose, self._twist, self._stopped = command.pose, command.twist, True
        return command

    def _demand(self, given: Vec) -> Demand:
        force, rate = self._force(given[:3]), self._rate(given[3:])
        place, R, turning = np.empty(7), np.empty((3, 3)), np.empty(6)
        midway = self._pose + 0.5 * self._period * self._twist  # where the held command is right on average
        place_of(midway, place)
        rotation_of(place, R)
        twist_of(midway, np.concatenate([np.zeros(3), R @ rate]), turning)
        return Demand(force, R @ (force + UP) - UP, turning[3:])

    def _command(self, twist: Vec) -> Command:
        """Return the accelerations held over the period that lead to `twist` at its end."""
        T = self._period
        acceleration = (twist - self._twist) / T
        self._pose = self._pose + 0.5 * T * (self._twist + twist)
        self._twist = twist
        rest: Mat = np.tile(-twist / (STOP * T), (STOP, 1))
        return Command(
            acceleration=acceleration,
            pose=self._pose,
            twist=twist,
            plan=rest,
            outcome=Outcome(status=Status.DECIDED),
        )


def scaling(tuning: Tuning) -> tuple[Cubic, Cubic]:
    """Return the scaling of specific force and of angular rate, in SI units."""
    force, rate = tuning.scaling.force, tuning.scaling.rate
    return (
        Cubic(slope=force.slope, largest=force.largest_mps2, limit=force.limit_mps2),
        Cubic(slope=rate.slope, largest=np.radians(rate.largest_degps), limit=np.radians(rate.limit_degps)),
    )


def cued(task: Task) -> Vec:
    """Return one along the axes that are cued and zero along the others (6,)."""
    used = {i for dof in task.dofs for i in dof.axes}
    return np.array([float(i in used) for i in range(len(AXES))])


def tilt_for(force: Vec, derivative: Vec) -> tuple[Vec, Vec]:
    """Return tilts whose gravity gives these forces, and their rates: g sin θ = f, ω = ḟ / (g cos θ)."""
    sine = np.clip(force / GRAVITY, -STEEPEST, STEEPEST)
    angle: Vec = np.arcsin(sine)
    rate: Vec = np.where(np.abs(sine) < STEEPEST, derivative / (GRAVITY * np.cos(angle)), 0.0)
    return angle, rate
