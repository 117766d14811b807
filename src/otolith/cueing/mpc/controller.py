"""The MPC controller: one certified Gauss-Newton step of its problem per period (section 4.1.2).

The problem is that of `otolith.cueing.mpc.problem`. The dynamics are linear and discretised exactly. Only
what is felt (and, in 4 DOF, the limit circle) is linearised, about the previous plan, without a shift; with
legs (`otolith.cueing.mpc.body`) about that plan shifted by a period. One such step per period is the
real-time iteration (Diehl, Bock & Schlöder, 2005). More steps converge to the optimum of the nonlinear
problem, which shows what the single step costs.

With `blocks` the inputs are held over several steps, and a horizon three times as long costs no more. Plans
are still given in steps of one period.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from otolith.compiled import DECIDE, SOLVERS, outcome_of
from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.errors import InputError
from otolith.core.frames import Dof
from otolith.core.methods import NO_METHOD, Bound
from otolith.cueing.mpc import decide as requests
from otolith.cueing.mpc.body import Body
from otolith.cueing.mpc.choose import Chooser
from otolith.cueing.mpc.decide import Program, decide, planned
from otolith.cueing.mpc.guess import Guess, Hint, NoGuess
from otolith.cueing.mpc.guess_as_hint import GuessAsHint
from otolith.cueing.mpc.problem import FIRM_REACHED, Problem, Washout
from otolith.cueing.mpc.settings import Entry, MpcSettings
from otolith.cueing.prediction.simple import Hold, now, previewed
from otolith.interfaces import Command, PlatformState, Predictor, Reference
from otolith.platforms import Platform
from otolith.qp.blocked_engine import BlockedEngine
from otolith.qp.engines import NO_ENTRANCE, StructuredEngine
from otolith.qp.problem import Status
from otolith.qp.stage import StageSolution
from otolith.qp.structured.generate import CODES
from otolith.safety.stopping import Stopping

_CALLED: Final = (StructuredEngine, BlockedEngine)  # engines that kernels can call
_WORDS: Final = np.array([SOLVERS.index(code.lower()) for code in CODES])


class Mpc:
    """Cueing by certified QPs over any degrees of freedom, with or without a guess.

    Parameters
    ----------
    guess : guesses the controls, from offline knowledge or from the previous plan; `entry` states how the
        guess enters.
    hint : proposes working sets; it is used only if the remembered one is not optimal.
    body : the platform as one body on its legs (`otolith.cueing.mpc.body`).

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
        body: Body | None = None,
    ) -> None:
        self.settings, self.problem = settings, Problem(platform, dofs, settings, body=body)
        self._settled, self._firm = requests.CONVERGED, np.inf
        if body is not None:
            self._settled, self._firm = body.settled, FIRM_REACHED
        self.engine = settings.engine(
            self.problem.structure, tolerance=settings.tolerance, blocks=settings.blocks
        )
        self.problem.begin(self.engine.memory)
        self._guess: Guess = guess or NoGuess()
        self._entry, self._hint = entry, hint
        if entry is Entry.WORKING_SET and self._guess.active:
            self._hint = GuessAsHint(self._guess, self.problem, self.engine.memory)
            self._guess = NoGuess()
        self._chooser = Chooser(self.problem.structure, settings.blocks)
        self._predictor: Predictor = (settings.prediction or Hold()).begin()
        circle = None if self.problem.circle is None else self.problem.circle.radius
        lag, period = settings.lag_on(platform), settings.period
        own, based = ([dof for dof in dofs if dof.is_base is base] for base in (False, True))
        self.carriers = 2 if based else 1  # platform and base that it moves
        self._stopping = Stopping(platform, own, circle=circle, lag=lag, period=period)
        lag = settings.lag_of(platform, based[0]) if based else lag
        self._base = Stopping(platform, based, lag=lag, period=period)
        self.program = self._assemble()
        self._method: Bound = DECIDE.bind(decide, self.program)
        K = self.carriers
        self._motion, self._command, self._result = np.zeros((3 * K, 6)), np.zeros(6 * K), np.zeros(5)
        self._compile()

    def _assemble(self) -> Program:
        """Return everything that the kernel reads and remembers."""
        settings, problem = self.settings, self.problem
        N, M, nu = settings.horizon, len(settings.lengths), len(problem.axes.axis)
        predicts = getattr(self._predictor, "compiled", None)
        # Kernels know the prediction by address only, so its data must live as long as this controller.
        self._prediction: Bound | None = predicts(settings.period) if predicts else None
        return Program(
            given=problem.given,
            memory=self.engine.memory,
            engine=self.engine.entrance if isinstance(self.engine, _CALLED) else NO_ENTRANCE,
            words=_WORDS,
            predict=NO_METHOD if self._prediction is None else self._prediction.method,
            period=settings.period,
            lengths=np.array(settings.lengths),
            belief=self._stopping.belief,
            base=self._base.belief,
            based=self.carriers > 1,
            checked=problem.can_stop,
            guessing=self._guess.active,
            hinting=self._hint is not None,
            rounds=settings.iterations,
            settled=self._settled,
            firm=self._firm,
            x=np.zeros(problem.given.X.shape[1]),
            wanted=problem.wanted(np.zeros((N, 6))),
            **{name: np.zeros((N, nu)) for name in ("plan", "about", "guess")},
            U=np.zeros((M, nu)),
            answer=np.zeros(3),
            certified=np.zeros(2),
            at=np.zeros(6, dtype=np.int64),
        )

    def _compile(self) -> None:
        """Solve one harmless problem, so that no decision ever waits for the compiler."""
        self.step(PlatformState(), _NOTHING)
        p = self.program
        if self._hint is not None:
            self._hint.sets(p.x, p.wanted[0], p.plan)
        self.reset(PlatformState())

    def reweigh(self, washout: Washout) -> None:
        """Use other washout weights from the next decision on; errors are those of `Problem.reweigh`."""
        self.problem.reweigh(washout)
        if not isinstance(washout, Mapping):
            self.settings = replace(self.settings, washout=tuple(washout))

    @property
    def period(self) -> float:
        """Time between two decisions [s]."""
        return self.settings.period

    @property
    def soft(self) -> frozenset[str]:
        """Return the limits that the plan may pass with a penalty."""
        return self.problem.soft

    def reset(self, state: PlatformState) -> None:
        """Forget the plan, the working set, the guess, the hint and what the drivers felt."""
        self.program.plan[:] = 0.0
        self._stopping.reset(state)
        self._base.reset(state.base or PlatformState())
        self._predictor.reset()
        self.problem.reset()
        self.engine.reset()
        self._guess.reset()
        if self._hint is not None:
            self._hint.reset()

    def step(self, state: PlatformState, reference: Reference) -> Command:
        """Decide by one certified QP. Without such a decision, brake, and name the reason in the outcome."""
        motion, result = self._motion, self._result
        state.write(motion)
        wanted, preview, again = now(reference), previewed(reference), 0
        while request := decide(
            self._method.held, motion, wanted, preview, reference.age, again, self._command, result
        ):
            self.answer(request, reference)
            again = 1
        return self._planned(result)

    def _planned(self, result: Vec) -> Command:
        """Return the command of the last decision, with the plan that follows it and ends at rest."""
        command = self._command_of(self._stopping, False, result)
        if self.carriers == 1:
            return command
        return replace(command, base=self._command_of(self._base, True, result))

    def _command_of(self, stopping: Stopping, of_base: bool, result: Vec) -> Command:
        """Return the command of the platform, or of its base."""
        count = planned(self._method.held, of_base, result, stopping.room(len(self.program.plan)))
        return stopping.command(stopping.belief.believed, count, outcome_of(result))

    def compiled(self) -> Bound:
        """Return the method of this controller."""
        return self._method

    def unaided(self) -> None:
        """Let its kernel decide without Python: a problem that the engine gives up has no solution.

        Raises
        ------
        InputError : the kernel asks Python in the ordinary course of a decision.
        """
        p = self.program
        needs = {
            f"the engine {type(self.engine).__name__}": p.engine.solve == 0 and p.engine.own.code == 0,
            f"the prediction {type(self._predictor).__name__}": p.predict.code == 0,
            f"the guess {type(self._guess).__name__}": p.guessing,
            f"the hint {type(self._hint).__name__}, without which the decisions are the same": p.hinting,
        }
        for what, needed in needs.items():
            if needed:
                raise InputError(
                    "an algorithm that decides without Python", f"one that asks for {what}", _ALONE
                )
        p.answer[:] = SOLVERS.index(Status.LIMIT), 0.0, math.inf

    def will_be_felt(self) -> tuple[Ints, Mat]:
        """Return what the last decision's plan makes felt at the ends of the next N periods (N, C).

        The first array (C,) names the predictor's columns to which the channels belong.
        """
        p, felt = self.program, self.problem.given.felt
        return felt.column, felt.sign * self.problem.felt(self.problem.predicted(p.x, p.plan))

    def answer(self, request: int, reference: Reference) -> None:
        """Meet a request of the kernel."""
        match request:
            case requests.AHEAD:
                self._look_ahead(reference)
            case requests.GUESS:
                self._take_guess()
            case requests.HINT if isinstance(self.engine, StructuredEngine):
                self.engine.offer(self._best_set())
            case requests.EXACT if isinstance(self.engine, _CALLED):
                self._pass_on(self.engine.exact())
            case requests.ENGINE:
                first = self._hint is not None and self.program.at[requests.ROUND] == 0
                self._pass_on(self.engine.run(hint=self._best_set if first else None))

    def _look_ahead(self, reference: Reference) -> None:
        """Predict with a predictor that kernels cannot call."""
        dt, N = self.settings.period, self.settings.horizon
        late = reference.age / dt
        coming = self._predictor.ahead(reference, dt, N + math.ceil(late))
        self.problem.wanted(coming, late)

    def _take_guess(self) -> None:
        """Guess the controls and enter the guess as `entry` states."""
        p = self.program
        guessed = self._guess.controls(p.x, p.wanted[0], p.plan)
        if guessed is None:
            p.at[requests.GUESS_MISSED] = 1
        elif self._entry is Entry.PRIMAL:
            p.about[:] = guessed
        elif self._entry is Entry.REFERENCE:
            p.guess[:], p.at[requests.GUESSED] = guessed, 1

    def _best_set(self) -> Ints | None:
        """Return the best working set that the hint proposes for the problem in memory."""
        p = self.program
        sets = None if self._hint is None else self._hint.sets(p.x, p.wanted[0], p.plan)
        p.at[requests.GUESS_MISSED] |= sets is None
        return None if sets is None else self._chooser.best(self.engine.memory, sets)

    def _pass_on(self, solution: StageSolution) -> None:
        """Pass a solution that was found in Python to the kernel."""
        p = self.program
        p.answer[:] = SOLVERS.index(solution.status), solution.changes, solution.residual
        p.U[:] = solution.U
        p.at[requests.RELAXED] = self.problem.relaxed(solution)


_ALONE: Final = "one that asks for nothing, such as implicit or predictive"
_NOTHING: Final = Reference(specific_force=np.zeros(3))
