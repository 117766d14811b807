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

from typing import Final, Protocol

import numpy as np

from otolith.compiled import DECIDE, DECIDED, STATUS, outcome_of
from otolith.core.arrays import Vec
from otolith.core.frames import AXES, Dof, pairs_of
from otolith.core.methods import Bound
from otolith.cueing.prediction.simple import NO_PREVIEW, now
from otolith.cueing.washout.kernels import Memory, decide, start
from otolith.cueing.washout.scaling import Cubic
from otolith.cueing.washout.tuning import Tuning
from otolith.interfaces import Command, Outcome, PlatformState, Reference, Status
from otolith.platforms import Platform
from otolith.safety.law import to_rest
from otolith.safety.stopping import Stopping

PERIOD: Final = 0.01  # [s]
STOP: Final = 30  # periods in which the plan of every command comes to rest


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


class Washout:
    """A washout: channels of filters between a scaled reference and the motion of the platform.

    It decides from the reference alone, and its set-points are where its commands have led. The platform's
    state is used at `reset`, and if the platform is not where it should be: after missed decisions, or if the
    legs gave less than requested. Then the washout starts again from there.
    """

    def __init__(self, task: Task, channels: Bound, *, period: float = PERIOD) -> None:
        self._channels, self._period = channels, period
        self._stopping = Stopping(task.platform, task.dofs, lag=0.0, period=period)
        self.memory = _memory(task, channels, period, self._stopping)
        self._method = DECIDE.bind(decide, self.memory)
        self._motion, self._command, self._result = np.zeros((3, 6)), np.zeros(6), np.zeros(5)
        self.reset(PlatformState())

    @property
    def period(self) -> float:
        """Return the time between two decisions [s]."""
        return self._period

    def reset(self, state: PlatformState) -> None:
        """Start from `state` and return to neutral from there; filters start from rest.

        Tilt is kept as it is, and continues at rates that nobody notices.
        """
        start(self._method.held, np.array(state.pose), np.array(state.twist))

    def step(self, state: PlatformState, reference: Reference) -> Command:
        """Decide one command. Without a reference, come to rest, then start again from there."""
        motion, command, result = self._motion, self._command, self._result
        motion[0], motion[1], motion[2] = state.pose, state.twist, state.acceleration
        decide(self._method.held, motion, now(reference), NO_PREVIEW, reference.age, 0, command, result)
        if result[STATUS] != DECIDED:
            return self._stopped(outcome_of(result))
        twist = self.memory.twist.copy()
        return Command(
            acceleration=command.copy(),
            pose=self.memory.pose.copy(),
            twist=twist,
            plan=np.tile(-twist / (STOP * self._period), (STOP, 1)),
            outcome=_DECIDED,
        )

    def compiled(self) -> Bound:
        """Return the method of this washout."""
        return self._method

    def answer(self, request: int, reference: Reference) -> None:
        """Do nothing, since a washout has no requests."""

    def _stopped(self, outcome: Outcome) -> Command:
        """Return the stopping law's command, with its plan."""
        belief, room = self._stopping.belief, self._stopping.room(0)
        count = to_rest(belief.before, belief.reach, 0, room)
        return self._stopping.command(belief.believed, count, outcome)


def _memory(task: Task, channels: Bound, period: float, stopping: Stopping) -> Memory:
    """Return what the kernel of a washout reads and remembers."""
    tuning, (force, rate) = task.tuning, scaling(task.tuning)
    largest, steepest = np.full(3, np.inf), np.full(3, np.inf)
    for pair in pairs_of(task.dofs):
        _, tilt = task.platform.limits(pair)
        largest[pair.rotation - 3] = tilt.velocity
        steepest[pair.rotation - 3] = tilt.acceleration
    return Memory(
        channels=channels.method,
        belief=stopping.belief,
        period=period,
        lag=task.platform.actuators.lag_s,
        force=force.coefficients,
        rate=rate.coefficients,
        cued=cued(task),
        tilted=np.isfinite(largest).astype(np.float64),
        largest=largest,
        change=steepest * period,
        catch_up=tuning.catch_up_radps,
        homing=homing(tuning.home_radps, period),
        **{name: np.zeros(6) for name in ("pose", "twist", "home", "home_rate")},
        **{name: np.zeros(3) for name in ("angle", "angle_rate")},
        demand=np.zeros(9),
        motion=np.zeros(12),
        at=np.zeros(3, dtype=np.int64),
    )


def homing(omega: float, period: float) -> Vec:
    """Return k₁, k₂ (2,) that bring a platform from elsewhere to neutral, critically damped.

    Double integrator x⁺ = x + T v + T²a/2, v⁺ = v + T a with both poles at p = e^(−ωT): a = −k₁ x − k₂ v with
    k₁ = (1 − p)²/T², k₂ = (1 − p)(3 + p)/(2T), by comparing coefficients with (z − p)².
    """
    p = np.exp(-omega * period)
    return np.array([((1 - p) / period) ** 2, (1 - p) * (3 + p) / (2 * period)])


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


_DECIDED: Final = Outcome(status=Status.DECIDED)
