"""MPC of what is sensed: the linear one in decoupled sub-problems, and the implicit one with perception
inside.

`linear-mpc` is of the kind of Beghi, Bruschetta & Maran (2012), with Telban's organs in a linear
prediction and limits on place and speed in the driver's frame, split as Garrett & Best (2013) do into
four problems that do not know of each other: longitudinal, lateral, vertical, yaw. What their papers
leave open is chosen here: horizon, lag and engine are those of the implicit MPC, so that the
difference is the model and not the effort. (The papers themselves were not at hand; the description is
the thesis's, section 2.4.2.)

`implicit-sensed` is the thesis's third recommendation (chapter 8): its implicit MPC, with braking
rows, adaptive washout, the limit circle and all pairs in one problem, but the sensed force and rate
tracked instead of the physical force.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.lti import StateSpace
from otolith.interfaces import Command, Outcome, PlatformState, Reference
from otolith.mpc.design import Design, explicit_limits
from otolith.mpc.model import HUGE, BrakingRows, plausible
from otolith.mpc.parts import Part, PartSettings, command_of, pair_part, single_part
from otolith.mpc.perceiving import Perceiving, PerceivingSettings
from otolith.mpc.washout import constant
from otolith.perception import Vestibular
from otolith.qp import Status
from otolith.qp.stage import StageSolution

FORCE_WEIGHT: Final = 1.0  # of the squared error of sensed force [(m/s²)⁻²]
RATE_WEIGHT: Final = 0.1  # of that of sensed rate, where it comes of tilting and is unwanted [(rad/s)⁻²]
YAW_WEIGHT: Final = 100.0  # of that of a wanted rate: (10 m/s)², the force on a car that turns so at 36 km/h
PHYSICAL: Final = StateSpace.gain(np.eye(1))  # an organ that passes on what there is
LINEAR_WASHOUT: Final = {"position": 5.0, "velocity": 5.0}  # constant, in the manner of Table 5.3
STOPPING: Final = 5.0  # periods in which a platform without a plan is brought to rest
_SEVERITY: Final = (Status.INVALID, Status.INFEASIBLE, Status.UNCERTIFIED, Status.LIMIT, Status.OPTIMAL)


class SensedMpc:
    """Cueing by one or several certified QPs, each with its own parts of the platform."""

    def __init__(self, problems: Sequence[Perceiving], design: Design) -> None:
        self._period = design.implicit.period
        self.problems = tuple(problems)
        self.engines = []
        for problem in self.problems:
            engine = design.implicit.engine(
                problem.problem, tolerance=design.implicit.tolerance, blocks=design.implicit.blocks
            )
            problem.begin(engine.memory)
            self.engines.append(engine)
        self._parts = [part for problem in self.problems for part in problem.parts]
        self.reset(PlatformState())
        self.step(PlatformState(), Reference(specific_force=np.zeros(3)))  # no decision waits for a compiler
        self.reset(PlatformState())

    @property
    def period(self) -> float:
        """Time between two decisions [s]."""
        return self._period

    def reset(self, state: PlatformState) -> None:
        """Forget plans and working sets; the driver has been at rest for long."""
        del state
        self._plans = [np.zeros((p.settings.horizon, p.inputs)) for p in self.problems]
        for problem, engine in zip(self.problems, self.engines, strict=True):
            problem.reset()
            engine.reset()

    def step(self, state: PlatformState, reference: Reference) -> Command:
        """Decide by certified QPs; where one fails, its last plan goes on or its parts are braked."""
        outcomes = []
        for i, problem in enumerate(self.problems):
            x = np.concatenate([part.read(state) for part in problem.parts])
            outcome, self._plans[i] = self._decide(i, x, reference)
            outcomes.append(outcome)
        return self._command(state, outcomes)

    def _decide(self, i: int, x: Vec, reference: Reference) -> tuple[Outcome, Mat]:
        problem, engine, plan = self.problems[i], self.engines[i], self._plans[i]
        told = [reference.specific_force, reference.angular_rate]
        told += [] if reference.preview is None else [reference.preview.ravel()]
        if not (plausible(x) and plausible(np.concatenate(told))):
            return Outcome(status=Status.INVALID, residual=np.inf), self._fallback(problem, x, plan)
        problem.write(engine.memory, x, reference, plan)
        solution: StageSolution = engine.run()
        outcome = Outcome(status=solution.status, changes=solution.changes, residual=solution.residual)
        solved = solution.status is Status.OPTIMAL
        return outcome, problem.of_steps(solution) if solved else self._fallback(problem, x, plan)

    def _fallback(self, problem: Perceiving, x: Vec, plan: Mat) -> Mat:
        """The last certified plan, one step on; where there is none, brake to rest."""
        if plan.any():
            return np.vstack([plan[1:], np.zeros((1, plan.shape[1]))])
        bounded = np.clip(np.nan_to_num(x, nan=0.0, posinf=HUGE, neginf=-HUGE), -HUGE, HUGE)
        braking, at = [], 0
        for part in problem.parts:
            speeds = bounded[at + np.array(part.speeds)]
            braking.append(np.clip(-speeds / (STOPPING * self._period), -part.bounds, part.bounds))
            at += len(part.A)
        return np.tile(np.concatenate(braking), (len(plan), 1))

    def _command(self, state: PlatformState, outcomes: Sequence[Outcome]) -> Command:
        plans = [columns for problem, plan in self._each() for columns in _columns(problem.parts, plan)]
        command = command_of(self._parts, plans)
        pose, twist = np.zeros(6), np.zeros(6)
        for problem, plan in self._each():
            x = np.concatenate([part.read(state) for part in problem.parts])
            x = np.clip(np.nan_to_num(x, nan=0.0, posinf=HUGE, neginf=-HUGE), -HUGE, HUGE)
            after = problem.A[: len(x), : len(x)] @ x + problem.B[: len(x)] @ plan[0]
            at = 0
            for part in problem.parts:
                for axis, sign, speed, place in zip(
                    part.axes, part.signs, part.speeds, part.places, strict=True
                ):
                    pose[axis], twist[axis] = sign * after[at + place], sign * after[at + speed]
                at += len(part.A)
        return Command(
            acceleration=command[0], pose=pose, twist=twist, plan=command[1:], outcome=together(outcomes)
        )

    def _each(self) -> list[tuple[Perceiving, Mat]]:
        return list(zip(self.problems, self._plans, strict=True))


def _columns(parts: Sequence[Part], plan: Mat) -> list[Mat]:
    """The plan's columns of every part."""
    return np.split(plan, np.cumsum([part.B.shape[1] for part in parts])[:-1], axis=1)


def together(outcomes: Sequence[Outcome]) -> Outcome:
    """One outcome of several problems: the worst status and certificate, all changes."""
    return Outcome(
        status=min((one.status for one in outcomes), key=_SEVERITY.index),
        changes=sum(one.changes for one in outcomes),
        residual=max(one.residual for one in outcomes),
        guess_missed=any(one.guess_missed for one in outcomes),
    )


def _settings(design: Design) -> tuple[PartSettings, PerceivingSettings]:
    implicit = design.implicit
    parts = PartSettings(
        lag=implicit.lag,
        braking=implicit.braking,
        terminal=implicit.terminal,
        force_weight=FORCE_WEIGHT,
        rate_weight=RATE_WEIGHT,
        senses=Vestibular(),
    )
    problem = PerceivingSettings(
        horizon=implicit.horizon,
        period=implicit.period,
        control_weight=implicit.control_weight,
        washout=implicit.washout,
        blocks=implicit.blocks,
        firm=implicit.firm,
        later_penalty=implicit.later_penalty,
        exact_gravity=True,
        circle=design.platform.circle if len(design.pairs) == 2 else None,
    )
    return parts, problem


def linear_mpc(design: Design) -> SensedMpc:
    """Up to four linear problems, each on its own; of a limit circle each pair gets a side of its square."""
    of_parts, of_problem = _settings(design)
    of_parts = replace(of_parts, braking=BrakingRows.NONE, terminal=True)
    of_problem = replace(of_problem, washout=constant(LINEAR_WASHOUT), exact_gravity=False, circle=None)
    own = zip(explicit_limits(design.platform, design.pairs), design.pairs, strict=True)
    parts = [pair_part(design.platform, limits, pair, of_parts) for limits, pair in own]
    parts += _alone(design, of_parts)
    return SensedMpc([Perceiving([part], of_problem) for part in parts], design)


def implicit_sensed(design: Design) -> SensedMpc:
    """All pairs in one problem; heave and yaw, which nothing couples to them, in their own."""
    of_parts, of_problem = _settings(design)
    pairs = [
        pair_part(design.platform, design.platform.pair_limits(pair), pair, of_parts) for pair in design.pairs
    ]
    problems = [Perceiving(pairs, of_problem)] if pairs else []
    alone = replace(of_problem, circle=None)
    return SensedMpc([*problems, *(Perceiving([part], alone) for part in _alone(design, of_parts))], design)


def single_axes(design: Design) -> SensedMpc:
    """Heave and yaw of a design, each its own problem, tracked as they are and not as they are sensed."""
    of_parts, of_problem = _settings(design)
    physical = replace(of_parts, senses=Vestibular(otolith=PHYSICAL, canal=PHYSICAL))
    alone = replace(of_problem, circle=None)
    return SensedMpc([Perceiving([part], alone) for part in _alone(design, physical)], design)


def _alone(design: Design, settings: PartSettings) -> list[Part]:
    """Heave and yaw, as far as the design has them."""
    settings = replace(settings, rate_weight=YAW_WEIGHT)
    return [single_part(design.platform.axis_limits(axis), axis, settings) for axis in design.singles]
