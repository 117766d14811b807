"""Judges hints on unseen data: identical QPs are solved from every initial guess, and changes are counted.

The closed loop is recorded once with the structured engine. Every scheme then solves the same problems:

- with the dense engine (`daqp`, which counts its working-set changes as the thesis's solver counts
  iterations), always from the set that was optimal a period before, together with the scheme's hint;
- with the structured engine, each scheme from its own memory, timed as thread CPU time of the whole step:
  write the problem, try the remembered set, make the hint if that is not optimal, solve, certify.

If the recorded set did not change from one period to the next, the previous set is the answer, and no hint is
used. Of these decisions the dense engine solves one in ten, as a check.
"""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Final, TypeVar

import numpy as np

from otolith.core.arrays import Bools, Ints, Mat, Vec
from otolith.core.threads import one_thread
from otolith.cueing.hints.training.recording import Recording
from otolith.cueing.mpc.choose import Chooser
from otolith.cueing.mpc.guess import Hint
from otolith.cueing.mpc.problem import Problem
from otolith.qp import Status
from otolith.qp.engines import CondensedEngine, StageEngine, StageMemory, StructuredEngine
from otolith.qp.stage import StageSolution

OnProgress = Callable[[str], None]
Engine = TypeVar("Engine", bound=StageEngine)
PREVIOUS: Final = "previous"
COLD: Final = "cold"
PASSES: Final = 2  # passes over the timed steps, after one in which the hints alone are timed
EVERY: Final = 10  # the dense engine solves one decision in this many in any case, also from cold


@dataclass(slots=True)
class Tally:
    """The cost of one scheme, decision by decision (n,); NaN where the engine did not run."""

    n: int
    inputs: int
    changes: Vec = field(init=False)  # working-set changes of the dense engine
    solves: Vec = field(init=False)  # number of equality solves of the structured engine
    guess: Vec = field(init=False)  # [s] to make the hint, if it was requested
    step: Vec = field(init=False)  # [s] of the whole step of the structured engine
    hinted: Bools = field(init=False)  # whether the hint was used
    first: Mat = field(init=False)  # (n, 2P) first inputs of the dense engine
    first_structured: Mat = field(init=False)  # (n, 2P) of the structured engine

    def __post_init__(self) -> None:
        for name in ("changes", "solves", "guess", "step"):
            setattr(self, name, np.full(self.n, np.nan))
        self.hinted = np.zeros(self.n, dtype=np.bool_)
        self.first = np.full((self.n, self.inputs), np.nan)
        self.first_structured = np.full((self.n, self.inputs), np.nan)


class Problems:
    """The recorded problems, which are written into an engine's memory one after the other."""

    def __init__(self, problem: Problem, recording: Recording) -> None:
        self.recording, self._problem, self._settings = recording, problem, problem.settings

    def __len__(self) -> int:
        return len(self.recording)

    @property
    def inputs(self) -> int:
        """Return the number of commands of one step."""
        return self._problem.structure.inputs

    def engine(self, make: Callable[..., Engine]) -> Engine:
        """Return a new engine for these problems."""
        settings = self._settings
        engine = make(self._problem.structure, tolerance=settings.tolerance, blocks=settings.blocks)
        self._problem.begin(engine.memory)
        return engine

    def write(self, engine: StageEngine, i: int) -> None:
        """Write problem i into the engine's memory."""
        of = self.recording
        self._problem.write(engine.memory, of.x[i], of.plan[i], of.ahead[i], None)

    def proposer(self, hint: Hint, memory: StageMemory) -> "Proposer":
        """Return a hint in the form that an engine requests, for the problem in the engine's memory."""
        return Proposer(self.recording, hint, memory, Chooser(self._problem.structure, self._settings.blocks))


class Proposer:
    """A hint about problem `i`, made and chosen on request, and the time that it took."""

    def __init__(self, recording: Recording, hint: Hint, memory: StageMemory, chooser: Chooser) -> None:
        self._of, self._hint, self._memory, self._chooser = recording, hint, memory, chooser
        self.timed, self.i, self.seconds = True, 0, np.nan  # NaN if not requested or not timed

    def about(self, i: int) -> None:
        """Continue with problem `i`."""
        self.i, self.seconds = i, np.nan
        if self._of.begins[i]:
            self._hint.reset()

    def __call__(self) -> Ints | None:
        """Return the best set of the hint."""
        if not self.timed:
            return self._best()
        started = time.thread_time()
        best = self._best()
        self.seconds = time.thread_time() - started
        return best

    def _best(self) -> Ints | None:
        sets = self._hint.sets(self._of.x[self.i], self._of.wanted[self.i], self._of.plan[self.i])
        return None if sets is None else self._chooser.best(self._memory, sets)


def compare(
    problem: Problem,
    recording: Recording,
    hints: Mapping[str, Hint],
    progress: OnProgress = lambda _: None,
) -> dict[str, Tally]:
    """Return the tallies of `cold`, `previous` and every hint."""
    problems = Problems(problem, recording)
    tallies = {name: Tally(len(problems), problems.inputs) for name in (COLD, PREVIOUS, *hints)}
    with one_thread():
        _count(problems, hints, tallies, progress)
        for name in tallies:
            progress(f"{name}: structured engine, timed")
            _time(problems, name, hints.get(name), tallies[name])
    return tallies


def _count(
    problems: Problems, hints: Mapping[str, Hint], tallies: Mapping[str, Tally], progress: OnProgress
) -> None:
    """Solve with the dense engine from every initial guess."""
    engine, of = problems.engine(CondensedEngine), problems.recording
    proposers = {name: problems.proposer(hint, engine.memory) for name, hint in hints.items()}
    nothing = np.zeros(of.sets.shape[1:], dtype=np.int64)
    for i in range(len(problems)):
        start = nothing if of.begins[i] else of.sets[i - 1].astype(np.int64)
        for proposer in proposers.values():
            proposer.about(i)
        if i % EVERY == 0 or not np.array_equal(of.sets[i], start):
            problems.write(engine, i)
            solution = engine.run(start)
            _note(tallies[PREVIOUS], i, solution)
            for name, proposer in proposers.items():
                _note(tallies[name], i, engine.run(start, proposer) if solution.changes > 0 else solution)
        else:
            for name in (PREVIOUS, *hints):
                tallies[name].changes[i] = 0.0
        if i % EVERY == 0:
            _note(tallies[COLD], i, engine.run(nothing))
            progress(f"dense engine: {100 * i / len(problems):.0f} %")


def _note(tally: Tally, i: int, solution: StageSolution) -> None:
    tally.changes[i], tally.first[i], tally.hinted[i] = solution.changes, solution.U[0], solution.hinted


def _time(problems: Problems, name: str, hint: Hint | None, tally: Tally) -> None:
    """Solve with the structured engine, each scheme from its own memory; the fastest pass counts.

    Reading the clock takes as long as a small part of a hint, so a step is not timed while its hint is.
    """
    engine, clock = problems.engine(StructuredEngine), time.thread_time
    proposer = None if hint is None else problems.proposer(hint, engine.memory)
    nothing = np.zeros(problems.recording.sets.shape[1:], dtype=np.int64) if name == COLD else None
    for number in range(PASSES + 1):
        if proposer is not None:
            proposer.timed = number == 0
        for i in range(len(problems)):
            if problems.recording.begins[i]:
                engine.reset()
            if proposer is not None:
                proposer.about(i)
            started = clock()
            problems.write(engine, i)
            solution = engine.run(nothing, proposer)
            if number > 0:
                tally.step[i] = np.fmin(tally.step[i], clock() - started)
            elif proposer is not None:
                tally.guess[i] = proposer.seconds
            tally.solves[i] = solution.factorisations
            solved = solution.status is Status.OPTIMAL
            tally.first_structured[i] = solution.U[0] if solved else np.nan


def account(tallies: Mapping[str, Tally], recording: Recording) -> dict[str, Any]:
    """Return plain figures of every scheme, with its savings relative to `previous` [%]."""
    base = tallies[PREVIOUS]
    return {name: _of_scheme(tally, base, recording) for name, tally in tallies.items()}


def _of_scheme(tally: Tally, base: Tally, recording: Recording) -> dict[str, Any]:
    changes, of_base = _spread(tally.changes), _spread(base.changes)
    gaps = [np.abs(first - recording.first) for first in (tally.first, tally.first_structured)]
    micro = 1e6 * tally.step
    return {
        "changes": changes,
        "changes_saved_percent": {
            key: 100.0 * (1.0 - changes[key] / of_base[key])
            for key in ("mean", "p99", "max")
            if of_base[key] > 0.0
        },
        "hit_rate": float(np.nanmean(tally.changes == 0)),
        "hint_taken": float(np.mean(tally.hinted)),
        "hint_asked": float(np.mean(np.isfinite(tally.guess))),
        "equality_solves": _spread(tally.solves),
        "guess_us": _spread(1e6 * tally.guess),
        "step_us": _spread(micro) | {"worst_percent_mean": _worst_percent(micro)},
        "first_input_gap": max(float(np.nanmax(gap[recording.solved])) for gap in gaps),
    }


def _spread(values: Vec) -> dict[str, float]:
    """Return mean, median, 99th percentile and maximum of the finite values."""
    asked = values[np.isfinite(values)]
    if not len(asked):
        return dict.fromkeys(("mean", "median", "p99", "max"), 0.0)
    return {
        "mean": float(np.mean(asked)),
        "median": float(np.median(asked)),
        "p99": float(np.percentile(asked, 99)),
        "max": float(np.max(asked)),
    }


def _worst_percent(values: Vec) -> float:
    """Return the mean of the largest hundredth."""
    ranked = np.sort(values)
    return float(np.mean(ranked[-max(1, len(ranked) // 100) :]))
