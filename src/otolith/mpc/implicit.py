"""The implicit half: one Gauss-Newton step of the thesis's online MPC per period (section 4.1.2).

The problem is `otolith.mpc.formulation`'s. The dynamics are linear and discretised exactly; only the
felt force (and, in 4 DOF, the limit circle) is linearised, about the previous plan, not shifted. One
such step per period is the real-time iteration (Diehl, Bock & Schlöder, 2005); more of them converge to
the optimum of the nonlinear problem, which tells what one step costs.

With `blocks` the inputs are held over several steps, and a horizon three times as long costs no more.
Plans are in steps of one period all the same.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import partial
from typing import Final

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.errors import InputError, one_of
from otolith.core.frames import AxisPair
from otolith.interfaces import Command, Outcome, PlatformState, Reference
from otolith.mpc.formulation import Formulation, Setting
from otolith.mpc.hint.along import Along
from otolith.mpc.hint.choose import Chooser
from otolith.mpc.hybrid import Guess, Hint, NoGuess
from otolith.mpc.model import (
    ROT,
    TRAN,
    BrakingRows,
    planar_state,
    plausible,
)
from otolith.mpc.washout import PRESETS, WashoutWeight
from otolith.platforms import Platform
from otolith.qp import Status
from otolith.qp.blocked import Lengths
from otolith.qp.engines import StageEngine, StructuredEngine
from otolith.qp.stage import StageProblem, StageSolution
from otolith.stopping import Stopping

HORIZON: Final = 50  # the thesis's N
LEAST_LAG: Final = 1e-4  # [s] of the model, for a platform that has none
BLOCKS: Final = (1, 1, 2, 7, 12, 20, 28, 36, 43)  # 1.5 s in nine inputs
_CONVERGED = 1e-9  # largest change of a control between Gauss-Newton steps that ends them


class Entry(StrEnum):
    """How a guess enters the implicit MPC."""

    REFERENCE = "reference"  # eq. 3.1 as printed: u_ref of the cost; it changes the optimum
    PRIMAL = "primal"  # the plan that is linearised about: it changes the way, hardly the answer
    WORKING_SET = "working-set"  # the rows at their bounds along it: it changes the way, never the answer


def parse_entry(name: str) -> Entry:
    """Read an option's value, or say in one sentence what it may be."""
    try:
        return Entry(name)
    except ValueError:
        raise InputError("guess entry", repr(name), one_of(Entry, name)) from None


@dataclass(frozen=True, slots=True, kw_only=True)
class ImplicitSettings:
    """What the implicit MPC is; the defaults are the thesis's, with adaptive washout."""

    horizon: int = HORIZON  # N
    period: float = 0.01  # [s]
    lag: float | None = None  # [s] between commanded and actual acceleration; None: the platform's file says
    control_weight: float = 1e-3  # R
    washout: tuple[WashoutWeight, ...] = PRESETS["thesis-fit"]
    braking: BrakingRows = BrakingRows.STOPPING
    terminal: bool = False  # the last state must be able to stop; braking rows imply it
    soft: Mapping[str, float] = field(default_factory=dict)  # penalty by row name: {"tilt_rate": 100.0}
    blocks: Lengths = ()  # steps of each block of constant inputs, N in sum; none: every step its own
    firm: int = 2  # first blocks whose rows are hard; those of the others are soft
    later_penalty: float = 1e3  # of the soft ones
    iterations: int = 1  # Gauss-Newton steps per period at most; 1: real-time iteration
    tolerance: float = 1e-6  # largest certificate that counts as solved
    engine: Callable[..., StageEngine] = StructuredEngine

    def __post_init__(self) -> None:
        if self.horizon < 2:
            raise InputError("implicit horizon", self.horizon, "at least 2 steps")
        if self.iterations < 1:
            raise InputError("iterations", self.iterations, "at least 1 per period")
        for name in ("period", "lag", "control_weight", "tolerance"):
            value = getattr(self, name)
            if value is not None and not 0.0 < value < np.inf:
                raise InputError(name, value, "finite and greater than 0")
        for name, penalty in self.soft.items():
            if not 0.0 < penalty < np.inf:
                raise InputError(f"penalty of {name}", penalty, "finite and greater than 0")
        self._check_blocks()

    def _check_blocks(self) -> None:
        if self.blocks and (min(self.blocks) < 1 or sum(self.blocks) != self.horizon):
            given = ",".join(map(str, self.blocks))
            raise InputError("blocks", given, f"of at least 1 step each, {self.horizon} in sum")
        if self.firm < 1:
            raise InputError("firm blocks", self.firm, "at least 1, for the next node")
        if not self.later_penalty > 0.0:
            raise InputError("later penalty", self.later_penalty, "greater than 0")

    def lag_on(self, platform: Platform) -> float:
        """Lag T [s] of the model on a platform; the model has one, if only a tenth of a millisecond."""
        return max(platform.actuators.lag_s, LEAST_LAG) if self.lag is None else self.lag

    def formulation(self, platform: Platform, pairs: Sequence[AxisPair]) -> Formulation:
        """The stage problem of these settings on a platform."""
        setting = Setting(
            horizon=self.horizon,
            period=self.period,
            lag=self.lag_on(platform),
            control_weight=self.control_weight,
            washout=self.washout,
            braking=self.braking,
            terminal=self.terminal,
            soft=self.soft,
            blocks=self.blocks,
            firm=self.firm,
            later_penalty=self.later_penalty,
        )
        return Formulation(platform, pairs, setting)


class Implicit:
    """Cueing by certified QPs, with or without a guess: the thesis's four models, in 2 and 4 DOF."""

    def __init__(
        self,
        platform: Platform,
        pairs: Sequence[AxisPair],
        *,
        settings: ImplicitSettings,
        guess: Guess,
        entry: Entry = Entry.REFERENCE,
        hint: Hint | None = None,
    ) -> None:
        self.settings = settings
        self.formulation = settings.formulation(platform, pairs)
        self.engine = settings.engine(
            self.formulation.problem, tolerance=settings.tolerance, blocks=settings.blocks
        )
        self.formulation.begin(self.engine.memory)
        self._pairs, self._guess, self._entry = tuple(pairs), guess, entry
        self._axes = [pair.translation for pair in self._pairs]
        self._hint, self._missed = hint, False
        if entry is Entry.WORKING_SET and guess.active:
            self._guess, self._hint = NoGuess(), Along(guess, self.formulation, self.engine.memory)
        self._chooser = Chooser(self.problem, settings.blocks)
        self._plan = np.zeros((settings.horizon, 2 * len(pairs)))
        self._stopping = Stopping(
            platform,
            pairs,
            circle=self.formulation.radius,
            lag=settings.lag_on(platform),
            period=settings.period,
        )
        self._compile()

    def _compile(self) -> None:
        """Solve one harmless problem, so that no decision ever waits for a compiler."""
        still = np.zeros(6 * len(self._pairs))
        nothing = np.zeros((self.settings.horizon, len(self._pairs)))
        self.formulation.write(self.engine.memory, still, self._plan, nothing, None)
        self.engine.run()
        self.engine.reset()
        if self._hint is not None:
            self._hint.sets(still, nothing[0], self._plan)
            self._hint.reset()

    @property
    def period(self) -> float:
        """Time between two decisions [s]."""
        return self.settings.period

    @property
    def soft(self) -> frozenset[str]:
        """Limits that may be passed at a price."""
        return self.formulation.soft

    @property
    def problem(self) -> StageProblem:
        """Structure of the problems that are solved."""
        return self.formulation.problem

    def reset(self, state: PlatformState) -> None:
        """Forget plan, working set, guess and hint."""
        self._plan[:] = 0.0
        self._stopping.reset(state)
        self.engine.reset()
        self._guess.reset()
        if self._hint is not None:
            self._hint.reset()

    def step(self, state: PlatformState, reference: Reference) -> Command:
        """Decide by one certified QP; where there is no such decision, stop, and say why."""
        wanted = self._wanted(reference)
        if not (self._stopping.observe(state) and plausible(wanted)):
            return self._stop(Outcome(status=Status.INVALID, residual=np.inf))
        x = np.concatenate([planar_state(state, pair) for pair in self._pairs])
        guessed = self._guess.controls(x, wanted[0], self._plan)
        self._missed = guessed is None and self._guess.active
        solution = self._solve(x, wanted, guessed)
        outcome = Outcome(
            status=solution.status,
            changes=solution.changes,
            residual=solution.residual,
            guess_missed=self._missed,
        )
        if solution.status is not Status.OPTIMAL:
            return self._stop(outcome)
        plan = self.formulation.of_steps(solution.U)
        in_axes = self._in_axes(plan)
        if self.formulation.stopping and not self._stopping.allows(in_axes[0]):
            return self._stop(replace(outcome, status=Status.UNCERTIFIED))
        self._plan = plan
        return self._stopping.decided(in_axes, outcome)

    def _stop(self, outcome: Outcome) -> Command:
        """Brake to rest; the next decision starts from there, with no plan to go on with."""
        self._plan = np.zeros_like(self._plan)
        return self._stopping.rest(outcome)

    def _in_axes(self, plan: Mat) -> Mat:
        """(N, 6) accelerations of the platform from the pairs' inputs (N, 2P)."""
        in_axes = np.zeros((len(plan), 6))
        for p, pair in enumerate(self._pairs):
            in_axes[:, pair.translation] = plan[:, 2 * p + TRAN]
            in_axes[:, pair.rotation] = pair.sign * plan[:, 2 * p + ROT]
        return in_axes

    def _solve(self, x: Vec, wanted: Mat, guessed: Mat | None) -> StageSolution:
        """Gauss-Newton steps, the first with the hint, until the plan stands still or they are used up."""
        about = guessed if guessed is not None and self._entry is Entry.PRIMAL else self._plan
        u_ref = guessed if self._entry is Entry.REFERENCE else None
        hint = None if self._hint is None else partial(self._best_set, self._hint, x, wanted[0])
        changes = 0
        for _ in range(self.settings.iterations):
            self.formulation.write(self.engine.memory, x, np.ascontiguousarray(about), wanted, u_ref)
            solution = self.engine.run(hint=hint)
            changes, hint = changes + solution.changes, None
            plan = self.formulation.of_steps(solution.U)
            if solution.status is not Status.OPTIMAL or np.max(np.abs(plan - about)) < _CONVERGED:
                break
            about = plan
        return solution if changes == solution.changes else replace(solution, changes=changes)

    def _best_set(self, hint: Hint, x: Vec, wanted: Vec) -> Ints | None:
        """What the hint proposes for the problem in memory."""
        sets = hint.sets(x, wanted, self._plan)
        self._missed = self._missed or sets is None
        return None if sets is None else self._chooser.best(self.engine.memory, sets)

    def _wanted(self, reference: Reference) -> Mat:
        """(N, P) forces over the horizon: previewed where a preview is given, held from its end on."""
        known, N = reference.preview, self.settings.horizon
        if known is None:
            return np.tile(reference.specific_force[self._axes], (N, 1))
        stages = np.minimum(np.arange(N), len(known) - 1)
        wanted: Mat = known[stages][:, self._axes]
        return wanted
