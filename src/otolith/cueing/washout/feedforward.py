"""What every washout shares: frames, scaling, tilt that nobody notices, motion by held accelerations.

Notation: R from the driver's frame to world, f specific force without the standing 1 g, ẑ up. With the
platform turned by R, the driver feels f exactly when the head accelerates by

    a_world = R (f + g ẑ) − g ẑ,

so what the tilt gives already is not asked of the travel. (Derived here from the definition of f; washouts
of the Reid & Nahon family transform the force alike, but their reports were not at hand.) Angular rates
become derivatives of roll, pitch and yaw.

A filter says how fast each axis should move at the period's end. The command is the held acceleration
that gets it there, so velocities are met exactly at every period's end and travel follows by
integration.
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
from otolith.safety.stopping import HUGE, Stopping

PERIOD: Final = 0.01  # [s]
ASTRAY: Final = 0.05  # of the reach, from which on a platform is not where it was sent
OFF: Final = 0.5  # of the largest speed, by which a platform does not move as commanded …
OFTEN: Final = 10  # … in so many periods on end
STOP: Final = 30  # periods in which the plan of every command comes to rest
STEEPEST: Final = 0.9  # of g: largest force that tilt is asked for
UP: Final = np.array([0.0, 0.0, GRAVITY])


class Task(Protocol):
    """What a washout is made for; `otolith.cueing.design.Design` is one."""

    @property
    def platform(self) -> Platform:
        """Its tilt threshold is all that a washout reads."""

    @property
    def dofs(self) -> tuple[Dof, ...]:
        """Degrees of freedom to be cued."""

    @property
    def tuning(self) -> Tuning:
        """Scaling, filters and weights."""


@dataclass(frozen=True, slots=True)
class Demand:
    """A scaled reference, seen from the platform where it is."""

    force_driver: Vec  # (3,) [m/s²]
    acceleration_world: Vec  # (3,) [m/s²] that would make the driver feel it
    rate_world: Vec  # (3,) [rad/s] of roll, pitch and yaw


@dataclass(frozen=True, slots=True)
class Motion:
    """What the channels want at the period's end; zero along axes that are not cued."""

    velocity: Vec = field(default_factory=lambda: np.zeros(3))  # [m/s] x, y, z
    turning: Vec = field(default_factory=lambda: np.zeros(3))  # [rad/s] roll, pitch, yaw; to be felt
    tilt: Vec = field(default_factory=lambda: np.zeros(3))  # [rad] roll, pitch, –; not to be noticed
    tilt_rate: Vec = field(default_factory=lambda: np.zeros(3))  # [rad/s] its derivative


class Channels(Protocol):
    """The part of a washout that differs: from demand to motion."""

    def reset(self) -> None:
        """Forget the past."""

    def step(self, demand: Demand) -> Motion:
        """Motion at the end of the period that begins with `demand`."""


class Tilting:
    """Follows a tilt at a limited rate, and closes up smoothly after it had to fall behind.

    ω⁺ = clip(ω* + κ (θ* − θ)), with everything at the period's end: exactly ω* while within the limit, and
    while the platform's own angular acceleration allows it.
    """

    def __init__(self, largest: Vec, catch_up: float, period: float, steepest: float | Vec = np.inf) -> None:
        self._largest, self._kappa, self._period = largest, catch_up, period
        self._change = steepest * period * np.ones(3)  # [rad/s] of the rate in a period
        self.reset(np.zeros(3), np.zeros(3))

    def reset(self, angle: Vec, rate: Vec) -> None:
        """Start from a tilt [rad] that turns at a rate [rad/s], (3,) each."""
        self._angle, self._rate = angle, rate

    def step(self, angle: Vec, rate: Vec) -> Vec:
        """Rate (3,) [rad/s] at the period's end towards the wanted angle and rate there."""
        half = 0.5 * self._period
        behind = angle - (self._angle + half * (self._rate + rate))
        after = np.clip(rate + self._kappa * behind, -self._largest, self._largest)
        after = np.clip(after, self._rate - self._change, self._rate + self._change)
        self._angle = self._angle + half * (self._rate + after)
        self._rate = after
        return after


class Homing:
    """Brings a platform that starts elsewhere back to neutral, critically damped, by held accelerations.

    Double integrator x⁺ = x + T v + T²a/2, v⁺ = v + T a with both poles at p = e^(−ωT): a = −k₁ x − k₂ v with
    k₁ = (1 − p)²/T², k₂ = (1 − p)(3 + p)/(2T), by comparing coefficients with (z − p)².
    """

    def __init__(self, omega: float, period: float) -> None:
        p = np.exp(-omega * period)
        self._k1, self._k2 = ((1 - p) / period) ** 2, (1 - p) * (3 + p) / (2 * period)
        self._period = period
        self.reset(np.zeros(6), np.zeros(6))

    def reset(self, pose: Vec, twist: Vec) -> None:
        """Start from here."""
        self._x, self._v = pose, twist

    def step(self) -> Vec:
        """Velocity (6,) at the period's end."""
        a, T = -self._k1 * self._x - self._k2 * self._v, self._period
        self._x, self._v = self._x + T * self._v + 0.5 * T**2 * a, self._v + T * a
        return self._v


class Washout:
    """A washout: channels of filters between a scaled reference and the motion of the platform.

    It decides from the reference alone; set-points are where its commands have led. The platform's state
    enters at `reset`, and where the platform is not where it should be: after decisions that were missed, or
    where its legs gave less than was asked. Then the washout starts again from there.
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
        """Time between two decisions [s]."""
        return self._period

    def reset(self, state: PlatformState) -> None:
        """Start from `state`, from where the platform returns to neutral; filters start from rest.

        Tilt is taken over as it is, and goes on at rates that nobody notices.
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
        """True when the platform is elsewhere, or has moved otherwise for longer than its lag explains."""
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
        midway = self._pose + 0.5 * self._period * self._twist  # where the command, held, is right on average
        place_of(midway, place)
        rotation_of(place, R)
        twist_of(midway, np.concatenate([np.zeros(3), R @ rate]), turning)
        return Demand(force, R @ (force + UP) - UP, turning[3:])

    def _command(self, twist: Vec) -> Command:
        """Accelerations held over the period that lead to `twist` at its end."""
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
    """Scaling of specific force and of angular rate, in SI units."""
    force, rate = tuning.scaling.force, tuning.scaling.rate
    return (
        Cubic(slope=force.slope, largest=force.largest_mps2, limit=force.limit_mps2),
        Cubic(slope=rate.slope, largest=np.radians(rate.largest_degps), limit=np.radians(rate.limit_degps)),
    )


def cued(task: Task) -> Vec:
    """(6,) one along the axes that are cued, zero along the others."""
    used = {i for dof in task.dofs for i in dof.axes}
    return np.array([float(i in used) for i in range(len(AXES))])


def tilt_for(force: Vec, derivative: Vec) -> tuple[Vec, Vec]:
    """Tilts whose gravity gives these forces, and their rates: g sin θ = f, ω = ḟ / (g cos θ)."""
    sine = np.clip(force / GRAVITY, -STEEPEST, STEEPEST)
    angle: Vec = np.arcsin(sine)
    rate: Vec = np.where(np.abs(sine) < STEEPEST, derivative / (GRAVITY * np.cos(angle)), 0.0)
    return angle, rate
