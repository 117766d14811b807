"""The MPC at work: one certified Gauss-Newton step of its problem per period (section 4.1.2).

The problem is `otolith.cueing.mpc.problem`'s. The dynamics are linear and discretised exactly; only what is
felt (and, in 4 DOF, the limit circle) is linearised, about the previous plan, not shifted. One such step per
period is the real-time iteration (Diehl, Bock & Schlöder, 2005); more of them converge to the optimum of the
nonlinear problem, which shows what one step costs.

With `blocks` the inputs are held over several steps, and a horizon three times as long costs no more.
Plans are in steps of one period all the same.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Final

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.frames import Dof
from otolith.cueing.mpc.choose import Chooser
from otolith.cueing.mpc.guess import Guess, Hint, NoGuess
from otolith.cueing.mpc.guess_as_hint import GuessAsHint
from otolith.cueing.mpc.motion import in_six_axes, model_state
from otolith.cueing.mpc.problem import Problem
from otolith.cueing.mpc.rows import plausible
from otolith.cueing.mpc.settings import Entry, MpcSettings
from otolith.cueing.prediction.simple import Hold, now
from otolith.interfaces import Command, Outcome, PlatformState, Reference, Status
from otolith.platforms import Platform
from otolith.qp.problem import Status as SolverStatus
from otolith.qp.stage import StageSolution
from otolith.safety.stopping import Stopping

_CONVERGED: Final = 1e-9  # largest change of a control between Gauss-Newton steps that ends them


class Mpc:
    """Cueing by certified QPs over any degrees of freedom, with or without a guess.

    Parameters
    ----------
    guess : of the controls, from offline knowledge or the previous plan; `entry` says how it enters.
    hint : of the working set, asked only where the remembered one does not settle.

    Raises
    ------
    InputError : the platform lacks an axis of one of the degrees of freedom.
    """

    def __init__(
        self,
        platform: Platform,
        dofs: Sequence[Dof],
        settings: MpcSettings,
        *,
        guess: Guess | None = None,
        entry: Entry = Entry.REFERENCE,
        hint: Hint | None = None,
    ) -> None:
        self.settings, self.problem = settings, Problem(platform, dofs, settings)
        self.engine = settings.engine(
            self.problem.structure, tolerance=settings.tolerance, blocks=settings.blocks
        )
        self.problem.begin(self.engine.memory)
        self._guess: Guess = guess or NoGuess()
        self._entry, self._hint, self._missed = entry, hint, False
        if entry is Entry.WORKING_SET and self._guess.active:
            self._hint = GuessAsHint(self._guess, self.problem, self.engine.memory)
            self._guess = NoGuess()
        self._chooser = Chooser(self.problem.structure, settings.blocks)
        self._predictor = (settings.prediction or Hold()).begin()
        self._plan = np.zeros((settings.horizon, len(self.problem.axes.axis)))
        self._stopping = Stopping(
            platform,
            dofs,
            circle=None if self.problem.circle is None else self.problem.circle.radius,
            lag=settings.lag_on(platform),
            period=settings.period,
        )
        self._compile()

    def _compile(self) -> None:
        """Solve one harmless problem, so that no decision ever waits for a compiler."""
        still, wanted = model_state(self.problem.axes, PlatformState()), self._wanted(_NOTHING)
        self.problem.sense(still, wanted)
        self.problem.write(self.engine.memory, still, self._plan, wanted, None)
        self.engine.run()
        if self._hint is not None:
            self._hint.sets(still, wanted[0], self._plan)
        self.reset(PlatformState())

    @property
    def period(self) -> float:
        """Time between two decisions [s]."""
        return self.settings.period

    @property
    def soft(self) -> frozenset[str]:
        """Limits that may be passed at a price."""
        return self.problem.soft

    def reset(self, state: PlatformState) -> None:
        """Forget plan, working set, guess, hint and what the drivers felt."""
        self._plan[:] = 0.0
        self._stopping.reset(state)
        self._predictor.reset()
        self.problem.reset()
        self.engine.reset()
        self._guess.reset()
        if self._hint is not None:
            self._hint.reset()

    def step(self, state: PlatformState, reference: Reference) -> Command:
        """Decide by one certified QP; where there is no such decision, stop, and say why."""
        wanted = self._wanted(reference)
        if not (self._stopping.observe(state) and plausible(wanted)):
            return self._stop(Outcome(status=Status.INVALID, residual=np.inf))
        x = model_state(self.problem.axes, state)
        self.problem.sense(x, wanted)
        guessed = self._guess.controls(x, wanted[0], self._plan)
        self._missed = guessed is None and self._guess.active
        solution = self._solve(x, wanted, guessed)
        solved = solution.status is SolverStatus.OPTIMAL
        outcome = Outcome(
            status=Status.DECIDED if solved else Status.FALLBACK,
            solver=solution.status.value,
            changes=solution.changes,
            residual=solution.residual,
            guess_missed=self._missed,
        )
        if not solved:
            return self._stop(outcome)
        plan = self.problem.of_steps(solution.U)
        in_axes = in_six_axes(self.problem.axes, plan)
        if self.problem.can_stop and not self._stopping.allows(in_axes[0]):
            return self._stop(replace(outcome, status=Status.REFUSED))
        self._plan = plan
        return self._stopping.decided(in_axes, outcome)

    def _wanted(self, reference: Reference) -> Mat:
        """(N, C) what to feel in the N periods after the time of the state."""
        dt, N = self.settings.period, self.settings.horizon
        late = reference.age / dt
        ahead = self._predictor.ahead(reference, dt, N + math.ceil(late))
        return self.problem.wanted(_from(late, ahead, now(reference), N))

    def _stop(self, outcome: Outcome) -> Command:
        """Brake to rest; the next decision starts from there, with no plan to go on with."""
        self._plan = np.zeros_like(self._plan)
        return self._stopping.rest(outcome)

    def _solve(self, x: Vec, wanted: Mat, guessed: Mat | None) -> StageSolution:
        """Gauss-Newton steps, the first with the hint, until the plan stands still or they are used up."""
        about = guessed if guessed is not None and self._entry is Entry.PRIMAL else self._plan
        u_ref = guessed if self._entry is Entry.REFERENCE else None
        hint = None if self._hint is None else partial(self._best_set, self._hint, x, wanted[0])
        changes = 0
        for _ in range(self.settings.iterations):
            self.problem.write(self.engine.memory, x, np.ascontiguousarray(about), wanted, u_ref)
            solution = self.engine.run(hint=hint)
            changes, hint = changes + solution.changes, None
            plan = self.problem.of_steps(solution.U)
            if solution.status is not SolverStatus.OPTIMAL or np.max(np.abs(plan - about)) < _CONVERGED:
                break
            about = plan
        return solution if changes == solution.changes else replace(solution, changes=changes)

    def _best_set(self, hint: Hint, x: Vec, wanted: Vec) -> Ints | None:
        """What the hint proposes for the problem in memory."""
        sets = hint.sets(x, wanted, self._plan)
        self._missed = self._missed or sets is None
        return None if sets is None else self._chooser.best(self.engine.memory, sets)


def _from(late: float, ahead: Mat, present: Vec, N: int) -> Mat:
    """N rows of `ahead` (M, 6), which follows `present` (6,), from `late` periods on; straight in between."""
    if late == 0.0:
        return ahead
    known = np.vstack([present, ahead])
    first, share = int(late), late - int(late)
    before, after = known[first + 1 : first + 1 + N], known[first + 2 : first + 2 + N]
    later: Mat = before if share == 0.0 else (1.0 - share) * before + share * after
    return later


_NOTHING: Final = Reference(specific_force=np.zeros(3))
