"""Katliar's offline problem: of all motions within the limits, the one that feels most like the drive.

The whole reference is known, there is no washout and nothing is held back for what may come, so no causal
algorithm can do better: its error is the measure of theirs. What is minimised is the mean square of the error
of the felt force that `metrics` reports, at every sample of the plant; yaw adds that of its rate, with the
weight of the MPCs, and heave is a problem of its own. A trace of effort makes the answer unique. The limits
are the platform's own at the nodes of control (place, speed, acceleration, command, the circle), without
braking rows, and the motion model is that of the MPCs, with the exact gravity of every tilt.

Source: M. Katliar, Optimal control of motion simulators (University of Freiburg, 2020).
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from otolith.core.arrays import Ints, Mat
from otolith.core.errors import InputError, OtolithError
from otolith.core.frames import HEAVE, SURGE_PITCH, SWAY_ROLL, Dof, specific_force
from otolith.core.lti import zero_order_hold
from otolith.cueing.mpc.objective import FORCE_WEIGHT, RATE_WEIGHT
from otolith.cueing.optimum import kernels
from otolith.interfaces import Command, Outcome, PlatformState, Reference, Status
from otolith.loop import EDGE, Run, simulate
from otolith.ocp import Answer, Certificate, Disc, Dynamics, Expansion, certify, solve
from otolith.plant.ideal import Ideal
from otolith.platforms import Platform
from otolith.scenarios import Scenario

NAME: Final = "optimum"  # of the run
PERIOD: Final = 0.01  # [s]
EFFORT: Final = 1e-5  # weight of u² next to the squared errors of all samples of a period
ACCEPTED: Final = 1e-4  # largest certificate of an answer
_LEAST_LAG: Final = 1e-4  # [s]
_LONGEST: Final = 3600.0  # [s] that fit in memory


class NoOptimum(OtolithError):
    """The solver gave an answer whose certificate is not accepted."""


@dataclass(frozen=True, kw_only=True)
class Optimum:
    """The best motion, as a run like any other, and the proof that it is."""

    run: Run
    certificate: Certificate
    iterations: int


def optimum(
    platform: Platform, dofs: tuple[Dof, ...], scenario: Scenario, *, plant_period: float = 1e-3
) -> Optimum:
    """Solve the offline problem of a scenario and close the loop with its answer on the ideal platform.

    Parameters
    ----------
    plant_period : [s] between two samples, a whole fraction of 10 ms.

    Raises
    ------
    InputError : the platform lacks an axis, heave is cued with others, or the scenario lasts over an hour.
    NoOptimum : the certificate of the answer is not accepted.
    """
    if scenario.duration > _LONGEST:
        raise InputError("duration of the scenario", f"{scenario.duration:g} s", f"at most {_LONGEST:g} s")
    if HEAVE in dofs and len(dofs) > 1:
        bound = "alone: tilts pull on it to the second order, which the Gauss-Newton steps do not see"
        raise InputError(
            "--dofs of the optimum", ",".join(dof.name for dof in dofs), f"without heave, or heave {bound}"
        )
    task = _Task(platform, dofs, scenario, plant_period)
    answer = solve(task.dynamics, task, np.zeros(task.dynamics.states), len(task.wanted))
    certificate = certify(task.dynamics, task.costs, answer)
    if not certificate.worst <= ACCEPTED:  # so that a NaN is refused, too
        raise NoOptimum(f"the optimum of {scenario.name} is not certified: {certificate}")
    run = simulate(
        _Replay(task, answer, certificate.worst),
        Ideal(task.lag),
        scenario,
        platform=platform,
        dofs=tuple(dof.name for dof in dofs),
        names=(NAME, "ideal"),
        plant_period=plant_period,
    )
    return Optimum(run=run, certificate=certificate, iterations=answer.iterations)


class _Task:
    """The problem of one scenario; it is the cost of `otolith.ocp` itself."""

    def __init__(
        self, platform: Platform, dofs: tuple[Dof, ...], scenario: Scenario, plant_period: float
    ) -> None:
        self.dofs, self.lag = dofs, max(platform.actuators.lag_s, _LEAST_LAG)
        self.axes = [axis for dof in dofs for axis in dof.axes]
        self._samples = round(PERIOD / plant_period)
        self.dynamics = self._dynamics(platform)
        N = round(scenario.duration / PERIOD)
        time = np.arange(1, N * self._samples + 1, dtype=np.float64) * plant_period - EDGE
        force, rate = scenario.specific_force(time), scenario.angular_rate(time)
        both = np.hstack([force, rate[:, 2:]]).reshape(N, self._samples, 4)
        self.channel: Ints = np.array([3 if dof.feels_rate else dof.felt for dof in dofs], dtype=np.int64)
        self.wanted = np.ascontiguousarray(both[:, :, self.channel])
        self.weight = np.where(self.channel == 3, RATE_WEIGHT, FORCE_WEIGHT)

    @cached_property
    def within(self) -> Mat:
        """(S, 3, 4) motion of one axis at the samples of a period, by place, speed, acceleration, command."""
        A, B = _axis(self.lag)
        step = PERIOD / self._samples
        held = [zero_order_hold(A, B, step * j) for j in range(1, self._samples + 1)]
        return np.stack([np.hstack(pair) for pair in held])

    @cached_property
    def tracked(self) -> kernels.Tracked:
        """The constants of the cost, as the kernels take them."""
        where = [self.axes.index(axis) if axis in self.axes else -1 for axis in range(6)]
        return kernels.Tracked(
            self.within, np.array(where, dtype=np.int64), self.channel, self.weight, self.wanted, EFFORT
        )

    def value(self, X: Mat, U: Mat) -> float:
        """The cost of a motion."""
        return kernels.value(self.tracked, X, U)

    def expand(self, X: Mat, U: Mat) -> Expansion:
        """The cost of a motion, with its derivatives."""
        nz = X.shape[1] + U.shape[1]
        gradient, hessian = np.empty((len(U), nz)), np.empty((len(U), nz, nz))
        return Expansion(kernels.expand(self.tracked, X, U, gradient, hessian), gradient, hessian)

    def costs(self, X: NDArray[Any], U: NDArray[Any]) -> NDArray[Any]:
        """The cost of every step (N,), by the definitions of the frames: for the certificate alone."""
        place, speed, acceleration = (np.zeros((len(U), self._samples, 6), X.dtype) for _ in range(3))
        for i, axis in enumerate(self.axes):
            z = np.hstack([X[:, 3 * i : 3 * i + 3], U[:, i : i + 1]])
            moved = np.einsum("jom,km->okj", self.within, z)
            place[:, :, axis], speed[:, :, axis], acceleration[:, :, axis] = moved
        force = specific_force(acceleration[:, :, :3], place[:, :, 3:])
        roll, pitch = place[:, :, 3], place[:, :, 4]
        yawing = speed[:, :, 5] * np.cos(pitch) * np.cos(roll) - speed[:, :, 4] * np.sin(roll)
        felt = np.concatenate([force, yawing[:, :, None]], axis=2)[:, :, self.channel]
        errors = np.sum(self.weight * (felt - self.wanted) ** 2, axis=(1, 2))
        total: NDArray[Any] = 0.5 * (errors + EFFORT * np.sum(U**2, axis=1))
        return total

    def _dynamics(self, platform: Platform) -> Dynamics:
        A, B = zero_order_hold(*_axis(self.lag), PERIOD)
        count = len(self.axes)
        lower, upper, of_u = np.empty((count, 3)), np.empty((count, 3)), np.empty(count)
        signs = [sign for dof in self.dofs for sign in dof.signs]
        limits = [one for dof in self.dofs for one in platform.limits(dof)]
        for i, (sign, one) in enumerate(zip(signs, limits, strict=True)):
            low, high = one.position if sign > 0.0 else (-one.position[1], -one.position[0])
            lower[i], upper[i] = (
                (low, -one.velocity, -one.acceleration),
                (high, one.velocity, one.acceleration),
            )
            of_u[i] = one.command
        discs: tuple[Disc, ...] = ()
        if platform.circle is not None and {SURGE_PITCH, SWAY_ROLL} <= set(self.dofs):
            discs = (Disc((3 * self.axes.index(0), 3 * self.axes.index(1)), platform.circle),)
        return Dynamics(
            A=block_diag(*[A] * count),
            B=block_diag(*[B] * count),
            lower=np.concatenate([lower.ravel(), -of_u]),
            upper=np.concatenate([upper.ravel(), of_u]),
            discs=discs,
        )


def _axis(lag: float) -> tuple[Mat, Mat]:
    """Place, speed and acceleration of one axis that lags its command (eq. 4.9)."""
    return (
        np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0 / lag]]),
        np.array([[0.0], [0.0], [1.0 / lag]]),
    )


class _Replay:
    """Commands that were found beforehand, as a cueing algorithm."""

    period = PERIOD

    def __init__(self, task: _Task, answer: Answer, residual: float) -> None:
        self._outcome = Outcome(status=Status.DECIDED, residual=residual)
        self._commands, self._poses, self._twists = (np.zeros((len(answer.U), 6)) for _ in range(3))
        self._commands[:, task.axes] = answer.U
        self._poses[:, task.axes], self._twists[:, task.axes] = answer.X[1:, ::3], answer.X[1:, 1::3]
        self._k = 0

    def reset(self, state: PlatformState) -> None:  # noqa: ARG002 (the role has it; a replay starts at rest)
        """Start from the beginning."""
        self._k = 0

    def step(self, state: PlatformState, reference: Reference) -> Command:  # noqa: ARG002 (all is known)
        """Return the next command."""
        k, self._k = self._k, self._k + 1
        return Command(
            acceleration=self._commands[k],
            pose=self._poses[k],
            twist=self._twists[k],
            plan=self._commands[k + 1 : k + 2],
            outcome=self._outcome,
        )
