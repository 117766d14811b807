"""Closed loops of chapter 5 as jobs: one scenario, one cueing model, one reading of the thesis."""

import functools
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from pydantic import BaseModel

from otolith.core.arrays import Ints, Vec
from otolith.core.frames import DOFS, Dof, specific_force
from otolith.cueing.design import Design
from otolith.cueing.mpc.controller import Mpc
from otolith.cueing.mpc.explicit_problem import ExplicitSettings
from otolith.cueing.mpc.guess import FromExplicit, Guess, HeldPlan, NoGuess
from otolith.cueing.mpc.rows import BrakingRows
from otolith.cueing.mpc.settings import Entry, MpcSettings
from otolith.cueing.mpc.washout_weights import PRESETS, WashoutWeight
from otolith.interfaces import Cueing, Status
from otolith.loop import Run, simulate
from otolith.metrics import distribution, excesses, false_cues, tracking_rmse, travel_rms
from otolith.platforms import Platform, load
from otolith.qp.engines import StageEngine
from otolith.qp.stage import StageProblem
from otolith.registry import CUEING, FOUR_MODELS, PLANTS
from otolith.scenarios import Scenario, scenario
from otolith_thesis.counting_engine import COUNTED, clock_of, engine_named
from otolith_thesis.parametric import ParametricEngine
from otolith_thesis.solver_variants import (
    ACADO,
    QPOASES,
    Damped,
    QpOasesEngine,
    Start,
    StartedEngine,
    TerminalWeight,
)

MODELS: Final = FOUR_MODELS
TWO_DOF: Final = ("surge-pitch",)
FOUR_DOF: Final = ("surge-pitch", "sway-roll")
_SECONDS: Final = {
    ("explicit", 1): 0.3,
    ("explicit", 2): 0.3,
    (COUNTED, 1): 0.6,
    (COUNTED, 2): 2.5,
    ("dense", 1): 1.1,
    ("dense", 2): 4.5,
    ("structured", 1): 0.3,
    ("structured", 2): 0.4,
    (QPOASES, 1): 9.0,
    (ACADO, 1): 2.5,
    (ACADO, 2): 11.0,
}  # duration [s] per ten seconds of scenario
# The laws that give the guesses, by number of axis pairs: sections 4.1.1 and 4.2.1.
EXPLICIT: Final = {
    1: ExplicitSettings(),
    2: ExplicitSettings(horizon=2, period=0.25, block_from=None),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Loop:
    """One closed loop on the thesis's platform."""

    scenario: str
    cueing: str = "implicit"
    dofs: tuple[str, ...] = TWO_DOF
    washout: tuple[WashoutWeight, ...] = PRESETS["thesis-fit"]
    solver: str = COUNTED  # or "structured" if only the motion matters
    entry: Entry = Entry.REFERENCE
    braking: BrakingRows = BrakingRows.POSITION
    literal: bool = False  # whether steps last from 1 s to 4 s, as printed
    circle: float | None = None  # [m] replaces the platform's limit circle
    braking_times: tuple[float, float] | None = None  # T of travel and of tilt [s], replaces the platform's
    explicit: ExplicitSettings | None = None  # replaces the law that gives the thesis's guesses
    on: str = "thesis"  # platform
    terminal: float = 1.0  # weight of the last stage's cost, relative to the other stages
    damping: float = 0.0  # λ of ACADO's regularisation (Table D.1)
    start: Start = Start.PREVIOUS

    @property
    def label(self) -> str:
        """Return the text for the progress line."""
        return f"{self.cueing} on {self.scenario}, {2 * len(self.dofs)} DOF"

    @property
    def cost(self) -> float:
        """Return the approximate duration [s]."""
        kind = "explicit" if self.cueing == "explicit" else self.solver
        return _SECONDS[kind, len(self.dofs)] * self.reference.duration / 10.0

    @property
    def pairs(self) -> tuple[Dof, ...]:
        """Return the axis pairs that are cued."""
        return tuple(DOFS[name] for name in self.dofs)

    @property
    def reference(self) -> Scenario:
        """Return the scenario along every cued axis."""
        along = [scenario(self.scenario, literal=self.literal, axis=pair.along) for pair in self.pairs]
        return functools.reduce(Scenario.combined_with, along)

    @property
    def platform(self) -> Platform:
        """Return the platform, with another limit circle or braking law if one is given."""
        platform = load(self.on)
        changed: dict[str, BaseModel] = {}
        if self.circle is not None:
            changed["workspace"] = platform.workspace.model_copy(update={"circle_m": self.circle})
        if self.braking_times is not None:
            travel, tilt = self.braking_times
            times = {"position_s": travel, "tilt_s": tilt}
            changed["braking"] = platform.braking.model_copy(update=times)
        return platform.model_copy(update=changed)

    @property
    def engine(self) -> Callable[..., StageEngine]:
        """Return the factory of the implicit MPC's solver."""

        def weighted(problem: StageProblem, **options: Any) -> StageEngine:
            return TerminalWeight(self._engine(problem, **options), self.terminal)

        return self._engine if self.terminal == 1.0 else weighted

    @property
    def _engine(self) -> Callable[..., StageEngine]:
        """Return the factory of the solver itself."""

        def started(problem: StageProblem, **options: Any) -> StageEngine:
            return StartedEngine(problem, start=self.start, **options)

        if self.solver == QPOASES:
            return QpOasesEngine
        if self.solver == ACADO:
            return ParametricEngine
        if self.start is not Start.PREVIOUS:
            return started
        return engine_named(self.solver)

    def controller(self) -> Cueing:
        """Return the cueing algorithm of this loop."""
        design = _design(replace(self, scenario="", cueing=""))
        if self.damping != 0.0:
            return _damped(self, design)
        cueing: Cueing = CUEING[self.cueing].load()(design)
        return cueing

    def run(self) -> "Closed":
        """Simulate the closed loop."""
        return close_with(self, self.controller())


@dataclass(frozen=True, slots=True, kw_only=True)
class Motion:
    """The motion of one axis pair, at the controller's nodes."""

    time: Vec  # (m,) [s]
    wanted: Vec  # [m/s²]
    felt: Vec  # [m/s²]
    translation: Vec  # [m/s²] part from acceleration
    tilt_part: Vec  # [m/s²] part from tilt
    tilt_deg: Vec
    tilt_rate_deg: Vec  # [deg/s]
    position: Vec  # [m]
    velocity: Vec  # [m/s]


@dataclass(frozen=True, slots=True, kw_only=True)
class Closed:
    """The result of a closed loop."""

    rmse: dict[str, float]  # [m/s²] by axis pair
    decided: dict[str, float]  # [m/s²] RMSE at the decisions only, by axis pair
    travel: dict[str, float]  # [m] RMS of the displacement by axis pair
    changes: Ints  # (m,) working-set changes of each step
    step_us: dict[str, float]  # distribution of the time of a step [µs]
    unsolved: int  # number of steps without a certified answer
    missed: int  # number of guesses that were not available
    cues: dict[str, int]  # number of false cues (`otolith.metrics.false_cues`) by kind
    excess: dict[str, float]  # largest excess over each limit at any sample, by quantity [SI]
    motion: dict[str, Motion]  # by axis pair

    def spread(self) -> dict[str, float]:
        """Return the distribution of the working-set changes."""
        return distribution(self.changes)


def close_with(loop: Loop, cueing: Cueing) -> Closed:
    """Simulate the closed loop with a given cueing algorithm."""
    plant = PLANTS[CUEING[loop.cueing].plant].load()(loop.platform)
    run = simulate(
        cueing,
        plant,
        loop.reference,
        platform=loop.platform,
        dofs=loop.dofs,
        clock=clock_of(cueing),
    )
    return closed(loop, run)


def _damped(loop: Loop, design: Design) -> Mpc:
    guesses: dict[str, Callable[[], Guess]] = {
        "implicit": NoGuess,
        "implicit-trajectory": HeldPlan,
        "hybrid-first": lambda: FromExplicit(design.laws_at_work(), first_only=True),
        "hybrid-all": lambda: FromExplicit(design.laws_at_work(), first_only=False),
    }
    weight = design.mpc.control_weight
    settings = replace(design.mpc, control_weight=weight + loop.damping)
    guess = Damped(guesses[loop.cueing](), weight, loop.damping)
    return Mpc(design.platform, design.dofs, settings, guess=guess, entry=design.entry)


@functools.lru_cache(maxsize=4)
def _design(loop: Loop) -> Design:
    """Return one design for all scenarios and models of a reading, so that its laws are enumerated once."""
    return Design(
        platform=loop.platform,
        dofs=loop.pairs,
        explicit=loop.explicit or EXPLICIT[len(loop.dofs)],
        mpc=MpcSettings(washout=loop.washout, braking=loop.braking, engine=loop.engine),
        entry=loop.entry,
    )


def closed(loop: Loop, run: Run) -> Closed:
    """Return the figures of a run that tables and diagrams need."""
    rmse, travel = tracking_rmse(run), travel_rms(run)
    return Closed(
        rmse={pair.name: float(rmse[pair.translation]) for pair in loop.pairs},
        decided={pair.name: rmse_at_decisions(run, pair) for pair in loop.pairs},
        travel={pair.name: float(travel[pair.translation]) for pair in loop.pairs},
        changes=run.changes,
        step_us=distribution(run.step_time, 1e6),
        unsolved=sum(status != Status.DECIDED for status in run.status),
        missed=int(np.count_nonzero(run.guess_missed)),
        cues=dict(Counter(cue.kind for cue in false_cues(run))),
        excess={one.quantity: one.between_nodes for one in excesses(run)},
        motion={pair.name: _motion(run, pair) for pair in loop.pairs},
    )


def rmse_at_decisions(run: Run, pair: Dof) -> float:
    """Return the RMSE [m/s²] at the decisions only, one plant step after each.

    On a plant without lag this is the error of the explicit model's own output y_k = a_k + g tilt_k (4.1).
    """
    error = (run.felt_force - run.reference_force)[:: round(run.period / run.plant_period), pair.translation]
    return float(np.sqrt(np.mean(error**2)))


def _motion(run: Run, pair: Dof) -> Motion:
    s, th = pair.translation, pair.rotation
    at = run.at_decisions
    tilt_part = at(specific_force(np.zeros((len(run.time), 3)), run.pose[:, 3:])[:, s])
    return Motion(
        time=at(run.time),
        wanted=at(run.reference_force[:, s]),
        felt=at(run.felt_force[:, s]),
        translation=at(run.felt_force[:, s]) - tilt_part,
        tilt_part=tilt_part,
        tilt_deg=np.rad2deg(pair.sign * at(run.pose[:, th])),
        tilt_rate_deg=np.rad2deg(pair.sign * at(run.twist[:, th])),
        position=at(run.pose[:, s]),
        velocity=at(run.twist[:, s]),
    )
