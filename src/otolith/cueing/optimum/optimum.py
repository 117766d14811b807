"""Katliar's offline problem: the motion within the limits that feels most like the drive.

The whole reference is known, there is no washout, and no travel is reserved for later. So no causal algorithm
can do better, and its error is the measure for theirs. The cost is the mean square of the error of the felt
force that `metrics` reports, at every sample of the plant, and at the driver's head if the platform's file
gives its place. Yaw adds the mean square of the error of its rate, with the weight of the MPCs. Heave is a
problem of its own. A small weight on the commands makes the answer unique. The limits are those of the
platform at the nodes of control (place, speed, acceleration, command, the circle), without braking rows. The
motion model is that of the MPCs, with the exact gravity of every tilt.

Source: M. Katliar, Optimal control of motion simulators (University of Freiburg, 2020).
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from scipy.linalg import block_diag

from otolith.core.arrays import Ints, Mat
from otolith.core.errors import InputError, OtolithError
from otolith.core.frames import SURGE_PITCH, SWAY_ROLL, Dof
from otolith.core.lti import zero_order_hold
from otolith.cueing.mpc.objective import FORCE_WEIGHT, RATE_WEIGHT
from otolith.cueing.optimum import kernels
from otolith.cueing.optimum.definition import Numbers, felt
from otolith.interfaces import Command, Outcome, Plant, PlatformState, Reference, Status
from otolith.loop import EDGE, Run, simulate
from otolith.ocp import Answer, Certificate, Disc, Dynamics, Expansion, certify, solve
from otolith.plant.carried import OnBase
from otolith.plant.ideal import Ideal
from otolith.platforms import Platform
from otolith.scenarios import Scenario

NAME: Final = "optimum"  # of the run
PERIOD: Final = 0.01  # [s]
EFFORT: Final = 1e-5  # weight of u² next to the squared errors of all samples of a period
ACCEPTED: Final = 1e-4  # largest certificate of an answer
NOTICED: Final = 1e-4  # [m/s², rad/s] an error of this size in every sample has a cost that counts as zero
BLOCK: Final = 4_000  # steps whose errors are computed at once, so that an hour fits in memory
_LEAST_LAG: Final = 1e-4  # [s]
_LONGEST: Final = 3600.0  # [s] longest scenario that fits in memory


class NoOptimum(OtolithError):
    """The certificate of the solver's answer is not accepted."""


@dataclass(frozen=True, kw_only=True)
class Optimum:
    """The best motion, recorded as a run, and the proof that it is the best."""

    run: Run
    certificate: Certificate
    iterations: int
    through_lag: Mapping[str, float]  # error [m/s² or rad/s, RMS] by degree of freedom, see `_through_lag`
    weights: Mapping[str, float]  # of the squared errors, by degree of freedom


def optimum(
    platform: Platform,
    dofs: tuple[Dof, ...],
    scenario: Scenario,
    *,
    plant: str = "ideal",
    plant_period: float = 1e-3,
    settings: Mapping[str, Any] | None = None,
) -> Optimum:
    """Solve the offline problem of a scenario and close the loop with its answer on the ideal platform.

    Parameters
    ----------
    plant : "ideal", whose accelerations lag their commands as the platform's file states, or "ideal-no-lag".
    plant_period : [s] between two samples, a whole fraction of 10 ms.
    settings : what the user chose, for the record of the run.

    Raises
    ------
    InputError : the platform lacks an axis, heave is cued with others, the plant is not ideal, the scenario
        lasts over an hour, or its reference is not finite.
    NoOptimum : the certificate of the answer is not accepted.
    """
    check(scenario)
    if plant != measure_of(plant):
        raise InputError("plant of the optimum", plant, "ideal or ideal-no-lag")
    lag = max(platform.actuators.lag_s if plant == "ideal" else 0.0, _LEAST_LAG)
    moved = (*dofs, *platform.bases(dofs))
    lags = [_lag_of(platform, dof, lag) for dof in moved for _ in dof.axes]
    dynamics = _dynamics(platform, moved, lags)
    cost = _Felt.of(scenario, dofs, moved=moved, lags=lags, head=platform.head, plant_period=plant_period)
    answer = solve(dynamics, cost, np.zeros(dynamics.states), len(cost.tracked.wanted))
    certificate = certify(dynamics, cost.costs, answer, nothing=cost.nothing)
    if not certificate.worst <= ACCEPTED:  # so that a NaN is refused, too
        found = f"its certificate is {certificate.worst:.1e}, must be at most {ACCEPTED:g}"
        raise NoOptimum(f"the optimum of {scenario.name} is not certified: {found}")
    own: Plant = Ideal(lag, head=platform.head)
    run = simulate(
        _Replay([axis for dof in moved for axis in dof.axes], answer, certificate.worst),
        own if platform.base is None else OnBase(own, platform),
        scenario,
        platform=platform,
        dofs=tuple(dof.name for dof in dofs),
        names=(NAME, plant),
        settings=settings,
        plant_period=plant_period,
    )
    return Optimum(
        run=run,
        certificate=certificate,
        iterations=answer.iterations,
        through_lag={dof.name: _through_lag(cost, c, dof, lag) for c, dof in enumerate(dofs)},
        weights={dof.name: float(weight) for dof, weight in zip(dofs, cost.tracked.weight, strict=True)},
    )


def measure_of(plant: str) -> str:
    """Return the ideal plant whose optimum measures runs on `plant`; "ideal-no-lag" measures only itself."""
    return "ideal-no-lag" if plant == "ideal-no-lag" else "ideal"


def check(scenario: Scenario) -> None:
    """Refuse what has no optimum here before any time is spent; errors are those of `optimum`."""
    if scenario.duration > _LONGEST:
        raise InputError("duration of the scenario", f"{scenario.duration:g} s", f"at most {_LONGEST:g} s")


@dataclass(frozen=True)
class _Felt:
    """The error of what is felt: the cost of `otolith.ocp`, and its definition for the certificate."""

    tracked: kernels.Tracked

    @classmethod
    def of(
        cls,
        scenario: Scenario,
        dofs: tuple[Dof, ...],
        *,
        moved: tuple[Dof, ...],
        lags: list[float],
        head: tuple[float, float, float] | None,
        plant_period: float,
    ) -> "_Felt":
        """Return the cost of a scenario along degrees of freedom; `head` is that of `Platform.head`.

        Parameters
        ----------
        moved : the degrees of freedom, and what carries them.
        lags : [s] of every axis that is moved.
        """
        samples, N = round(PERIOD / plant_period), round(scenario.duration / PERIOD)
        time = np.arange(1, N * samples + 1, dtype=np.float64) * plant_period - EDGE
        both = np.hstack([scenario.specific_force(time), scenario.angular_rate(time)[:, 2:]])
        channel: Ints = np.array([3 if dof.feels_rate else dof.felt for dof in dofs], dtype=np.int64)
        wanted = np.ascontiguousarray(both[:, channel])
        if not np.isfinite(wanted).all():
            when = time[np.flatnonzero(~np.isfinite(wanted).all(axis=1))[0]]
            raise InputError("the reference", f"no number at {when:.3f} s", "one at all times")
        return cls(
            kernels.Tracked(
                within=np.stack([_within(lag, samples) for lag in lags], axis=1),
                axes=np.array([axis % 6 for dof in moved for axis in dof.axes], dtype=np.int64),
                head=np.array([] if head is None else head, dtype=np.float64),
                channel=channel,
                weight=np.where(channel == 3, RATE_WEIGHT, FORCE_WEIGHT),
                wanted=wanted.reshape(N, samples, len(dofs)),
                effort=EFFORT,
            )
        )

    @property
    def nothing(self) -> float:
        """Return the cost of an error of `NOTICED` in every sample."""
        N, samples, _ = self.tracked.wanted.shape
        return float(0.5 * N * samples * NOTICED**2)

    def expand(self, X: Mat, U: Mat, *, exact: bool = False) -> Expansion:
        """Return the cost of a motion, with its derivatives."""
        nz = X.shape[1] + U.shape[1]
        gradient, hessian = np.empty((len(U), nz)), np.empty((len(U), nz, nz))
        return Expansion(kernels.expand(self.tracked, X, U, gradient, hessian, exact), gradient, hessian)

    def costs(self, X: Numbers, U: Numbers) -> Numbers:
        """Return the cost of every step (N,) by the definitions of the frames, for the certificate alone."""
        squares = np.sum(self.tracked.weight * self.errors(X, U) ** 2, axis=(1, 2))
        total: Numbers = 0.5 * (squares + EFFORT * np.sum(U**2, axis=1))
        return total

    def errors(self, X: Numbers, U: Numbers) -> Numbers:
        """Return felt minus wanted (N, S, C) for the states X (N, nx) before every step and its inputs."""
        parts = [
            self._errors(X[k : k + BLOCK], U[k : k + BLOCK], self.tracked.wanted[k : k + BLOCK])
            for k in range(0, len(U), BLOCK)
        ]
        return np.concatenate(parts)

    def _errors(self, X: Numbers, U: Numbers, wanted: Mat) -> Numbers:
        t = self.tracked
        motion = np.zeros((3, len(U), len(t.within), 6), X.dtype)
        for i, axis in enumerate(t.axes):
            z = np.hstack([X[:, 3 * i : 3 * i + 3], U[:, i : i + 1]])
            motion[..., axis] += np.einsum("jom,km->okj", t.within[:, i], z)
        felt_there = felt(motion[0], motion[1], motion[2], t.head if len(t.head) else None)
        difference: Numbers = felt_there[..., t.channel] - wanted
        return difference


def _through_lag(cost: _Felt, c: int, dof: Dof, lag: float) -> float:
    """Return the RMS error along one degree of freedom that no platform with this lag and period can avoid.

    It is the error of an axis without limits that moves straight along what is felt. Only jumps of the
    reference remain in it. Commands that last a period and reach the acceleration through a lag cannot follow
    them.
    """
    t = cost.tracked
    alone = _Felt(
        t._replace(
            within=t.within[:, list(t.axes).index(dof.axes[0])][:, None].copy(),
            axes=np.array(dof.axes[:1], dtype=np.int64),
            head=np.zeros(0),
            channel=t.channel[c : c + 1],
            weight=t.weight[c : c + 1],
            wanted=np.ascontiguousarray(t.wanted[:, :, c : c + 1]),
        )
    )
    A, B = zero_order_hold(*_axis(lag), PERIOD)
    endless = np.full(4, np.inf)
    answer = solve(
        Dynamics(A=A, B=B, lower=-endless, upper=endless), alone, np.zeros(3), len(alone.tracked.wanted)
    )
    return float(np.sqrt(np.mean(alone.errors(answer.X[:-1], answer.U) ** 2)))


def _lag_of(platform: Platform, dof: Dof, lag: float) -> float:
    """Return the lag [s] of a degree of freedom, given that of the platform."""
    return platform.base.lag_s if dof.is_base and platform.base is not None else lag


def _dynamics(platform: Platform, dofs: tuple[Dof, ...], lags: list[float]) -> Dynamics:
    """Return the dynamics and limits of all axes that are moved, with the lag [s] of each."""
    axes = [axis for dof in dofs for axis in dof.axes]
    A, B = zip(*(zero_order_hold(*_axis(lag), PERIOD) for lag in lags), strict=True)
    lower, upper, of_u = np.empty((len(axes), 3)), np.empty((len(axes), 3)), np.empty(len(axes))
    signs = [sign for dof in dofs for sign in dof.signs]
    limits = [one for dof in dofs for one in platform.limits(dof)]
    for i, (sign, one) in enumerate(zip(signs, limits, strict=True)):
        low, high = one.position if sign > 0.0 else (-one.position[1], -one.position[0])
        lower[i] = low, -one.velocity, -one.acceleration
        upper[i] = high, one.velocity, one.acceleration
        of_u[i] = one.command
    discs: tuple[Disc, ...] = ()
    if platform.circle is not None and {SURGE_PITCH, SWAY_ROLL} <= set(dofs):
        discs = (Disc((3 * axes.index(0), 3 * axes.index(1)), platform.circle),)
    return Dynamics(
        A=block_diag(*A),
        B=block_diag(*B),
        lower=np.concatenate([lower.ravel(), -of_u]),
        upper=np.concatenate([upper.ravel(), of_u]),
        discs=discs,
    )


def _axis(lag: float) -> tuple[Mat, Mat]:
    """Return (A, B) of place, speed and acceleration of one axis that lags its command (eq. 4.9)."""
    return (
        np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0 / lag]]),
        np.array([[0.0], [0.0], [1.0 / lag]]),
    )


def _within(lag: float, samples: int) -> Mat:
    """Return the motion of one axis at a period's samples (S, 3, 4), from its state and command."""
    A, B = _axis(lag)
    step = PERIOD / samples
    return np.stack([np.hstack(zero_order_hold(A, B, step * j)) for j in range(1, samples + 1)])


class _Replay:
    """A cueing algorithm that replays commands found beforehand."""

    period = PERIOD

    def __init__(self, axes: list[int], answer: Answer, residual: float) -> None:
        self._outcome = Outcome(status=Status.DECIDED, residual=residual)
        self.carriers = 1 + (max(axes) >= 6)
        self._commands, self._poses, self._twists = (np.zeros((len(answer.U), 12)) for _ in range(3))
        self._commands[:, axes] = answer.U
        self._poses[:, axes], self._twists[:, axes] = answer.X[1:, ::3], answer.X[1:, 1::3]
        self._k = 0

    def reset(self, state: PlatformState) -> None:  # noqa: ARG002 (the role has it; a replay starts at rest)
        """Start from the beginning."""
        self._k = 0

    def step(self, state: PlatformState, reference: Reference) -> Command:  # noqa: ARG002 (all is known)
        """Return the next command."""
        k, self._k = self._k, self._k + 1
        base = self._command(k, slice(6, 12)) if self.carriers > 1 else None
        return replace(self._command(k, slice(6)), base=base)

    def _command(self, k: int, of: slice) -> Command:
        """Return command k of the platform, or of its base."""
        return Command(
            acceleration=self._commands[k, of],
            pose=self._poses[k, of],
            twist=self._twists[k, of],
            plan=self._commands[k + 1 : k + 2, of],
            outcome=self._outcome,
        )
