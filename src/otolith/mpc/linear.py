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
from typing import Any, Final

import numpy as np

from otolith.core.lti import StateSpace
from otolith.interfaces import Command, Cueing, Outcome, PlatformState, Reference
from otolith.mpc.design import Design, explicit_limits
from otolith.mpc.model import BrakingRows, circle_weights, plausible
from otolith.mpc.parts import PartSettings, command_of, pair_part, single_part
from otolith.mpc.perceiving import Perceiving, PerceivingSettings
from otolith.mpc.several import Beside
from otolith.mpc.washout import constant
from otolith.perception import Vestibular
from otolith.qp import Status
from otolith.qp.stage import StageSolution
from otolith.stopping import Stopping

FORCE_WEIGHT: Final = 1.0  # of the squared error of sensed force [(m/s²)⁻²]
RATE_WEIGHT: Final = 0.1  # of that of sensed rate, where it comes of tilting and is unwanted [(rad/s)⁻²]
YAW_WEIGHT: Final = 100.0  # of that of a wanted rate: (10 m/s)², the force on a car that turns so at 36 km/h
PHYSICAL: Final = StateSpace.gain(np.eye(1))  # an organ that passes on what there is
LINEAR_WASHOUT: Final = {"position": 5.0, "velocity": 5.0}  # constant, in the manner of Table 5.3


class Sensed:
    """Cueing by one certified QP over some parts of the platform."""

    def __init__(self, problem: Perceiving, stopping: Stopping, design: Design) -> None:
        implicit = design.implicit
        self._period, self.problem, self._stopping = implicit.period, problem, stopping
        self.engine = implicit.engine(problem.problem, tolerance=implicit.tolerance, blocks=implicit.blocks)
        problem.begin(self.engine.memory)
        self.reset(PlatformState())
        self.step(PlatformState(), Reference(specific_force=np.zeros(3)))  # no decision waits for a compiler
        self.reset(PlatformState())

    @property
    def period(self) -> float:
        """Time between two decisions [s]."""
        return self._period

    def reset(self, state: PlatformState) -> None:
        """Forget plan and working set; the driver has been at rest for long."""
        self._plan = np.zeros((self.problem.settings.horizon, self.problem.inputs))
        self._stopping.reset(state)
        self.problem.reset()
        self.engine.reset()

    def step(self, state: PlatformState, reference: Reference) -> Command:
        """Decide by one certified QP; where there is no such decision, stop, and say why."""
        told = [reference.specific_force, reference.angular_rate]
        told += [] if reference.preview is None else [reference.preview.ravel()]
        if not (self._stopping.observe(state) and plausible(np.concatenate(told))):
            return self._stop(Outcome(status=Status.INVALID, residual=np.inf))
        x = np.concatenate([part.read(state) for part in self.problem.parts])
        self.problem.write(self.engine.memory, x, reference, self._plan)
        solution: StageSolution = self.engine.run()
        outcome = Outcome(status=solution.status, changes=solution.changes, residual=solution.residual)
        if solution.status is not Status.OPTIMAL:
            return self._stop(outcome)
        plan = self.problem.of_steps(solution)
        command = command_of(self.problem.parts, self.problem.of_parts(plan))
        if not self._stopping.allows(command[0]):
            return self._stop(replace(outcome, status=Status.UNCERTIFIED))
        self._plan = plan
        return self._stopping.decided(command, outcome)

    def _stop(self, outcome: Outcome) -> Command:
        """Brake to rest; the next decision starts from there, with no plan to go on with."""
        self._plan = np.zeros_like(self._plan)
        return self._stopping.rest(outcome)


def _settings(design: Design) -> tuple[PartSettings, PerceivingSettings]:
    implicit = design.implicit
    parts = PartSettings(
        lag=implicit.lag_on(design.platform),
        braking=implicit.braking,
        terminal=implicit.terminal,
        force_weight=FORCE_WEIGHT,
        rate_weight=RATE_WEIGHT,
        senses=Vestibular(),
        period=implicit.period,
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
        circle_weights=circle_weights(
            [design.platform.pair_limits(pair) for pair in design.pairs],
            design.platform.braking,
            implicit.braking,
            implicit.lag_on(design.platform),
            implicit.period,
        )
        if design.pairs
        else np.zeros(3),
    )
    return parts, problem


def linear_mpc(design: Design) -> Cueing:
    """Up to four linear problems, each on its own; of a limit circle each pair gets a side of its square."""
    of_parts, of_problem = _settings(design)
    of_parts = replace(of_parts, braking=BrakingRows.STOPPING, eased=False)
    of_problem = replace(of_problem, washout=constant(LINEAR_WASHOUT), exact_gravity=False, circle=None)
    cueing = []
    for limits, pair in zip(explicit_limits(design.platform, design.pairs), design.pairs, strict=True):
        part = pair_part(design.platform, limits, pair, of_parts)
        stopping = _stopping(design, pairs=(pair,), limits=(limits,))
        cueing.append(Sensed(Perceiving([part], of_problem), stopping, design))
    return _one(cueing + _alone(design, of_parts, of_problem))


def implicit_sensed(design: Design) -> Cueing:
    """All pairs in one problem; heave and yaw, which nothing couples to them, in their own."""
    of_parts, of_problem = _settings(design)
    pairs = [
        pair_part(design.platform, design.platform.pair_limits(pair), pair, of_parts) for pair in design.pairs
    ]
    cueing = []
    if pairs:
        stopping = _stopping(design, pairs=design.pairs, circle=of_problem.circle)
        cueing = [Sensed(Perceiving(pairs, of_problem), stopping, design)]
    return _one(cueing + _alone(design, of_parts, of_problem))


def single_axes(design: Design) -> Cueing:
    """Heave and yaw of a design, each its own problem, tracked as they are and not as they are sensed."""
    of_parts, of_problem = _settings(design)
    physical = replace(of_parts, senses=Vestibular(otolith=PHYSICAL, canal=PHYSICAL))
    return _one(_alone(design, physical, of_problem))


def _alone(design: Design, parts: PartSettings, problem: PerceivingSettings) -> list[Sensed]:
    """Heave and yaw, as far as the design has them."""
    parts, problem = replace(parts, rate_weight=YAW_WEIGHT), replace(problem, circle=None)
    cueing = []
    for axis in design.singles:
        part = single_part(design.platform.axis_limits(axis), axis, parts)
        cueing.append(Sensed(Perceiving([part], problem), _stopping(design, singles=(axis,)), design))
    return cueing


def _stopping(design: Design, **of_axes: Any) -> Stopping:
    """The fallback of some of the design's axes."""
    implicit, pairs = design.implicit, of_axes.pop("pairs", ())
    return Stopping(
        design.platform, pairs, lag=implicit.lag_on(design.platform), period=implicit.period, **of_axes
    )


def _one(cueing: Sequence[Sensed]) -> Cueing:
    return cueing[0] if len(cueing) == 1 else Beside(cueing)
