"""The best settings of one algorithm for one platform and some drives, and what they cost.

It is a small study: the settings that the algorithm has without tuning are tried first, and TPE chooses the
others. Of those within all limits the one is chosen that has no larger error than the settings to begin with,
if there is one, and of these the least

    J = ln(RMSE / RMS of the wanted force) + μ · (share of the reach, p99),

as `otolith.tuning` does for constant weights. The end of every drive is held out, and has two votes: the
limits have to be kept there too, or the next best settings are taken; and if the error is not less there, by
`GAIN`, than with the settings to begin with, those stay.

A conventional washout does not know the limits. How much of them it uses depends on the drive alone, so a
drive that is a little stronger than those it was tuned on would pass them. Therefore it may use no more than
`1 - MARGIN` of any limit on what it is trained on. What keeps the limits by itself needs no margin.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, Final

import numpy as np

from otolith import registry
from otolith.core.errors import InputError, one_of
from otolith.core.frames import Dof
from otolith.cueing.design import Design
from otolith.scenarios import Scenario
from otolith.studies.definition import Budget, Constraint, Objective, Reference, Study
from otolith.studies.executors import Executor
from otolith.studies.jobs import JUDGING, TRAINING, Done, Job, Problem, do, work
from otolith.studies.problem import problem
from otolith.studies.results import State, Trial, allowed, values
from otolith.studies.search import Progress, Search
from otolith.studies.spaces import SPACES
from otolith.studies.store import Store
from otolith.tuning import check_price

PRICE: Final = 0.5  # μ: all of the reach counts as much as 65 % of error
TRAINED: Final = 0.7  # share of a drive that is trained on
PIECE, PIECES = 60.0, 5  # [s] length of a piece of a drive, and how many are cued of each share at most
QUIET: Final = 0.05  # share of a drive's RMS below which a piece tells nothing about the error
MARGIN: Final = 0.1  # share of every limit that what does not know the limits leaves unused
GAIN: Final = 0.01  # share of the error below which a gain on what was held out may be chance
BATCH: Final = 10
_PASSED: Final = ("violations", "noticed")  # what counts as passing a limit


@dataclass(frozen=True, kw_only=True)
class Tuned:
    """The settings before and after, and how both were judged."""

    study: Study
    design: Design  # with what is not varied
    before: Trial
    after: Trial  # the settings to begin with, if no others are better
    best: Trial  # the best by what was trained on, whether it was taken or not
    trials: tuple[Trial, ...]
    shown: Problem  # what was held out, or else what was trained on

    def measured(self, trial: Trial, kind: str) -> dict[str, float] | None:
        """Return what a trial was measured to cost on one set of references, if that is known."""
        results: Mapping[int, Done] = getattr(trial, kind)
        if not results or any(done.refused for done in results.values()):
            return None
        error, travel = values(self.study, results)
        worst = {name: _worst(results, name) for name in ("peak", *_PASSED)}
        return {"tracking": error, "travel": travel, **worst}

    @property
    def kept(self) -> bool:
        """Return whether the settings to begin with stay."""
        return self.after.number == self.before.number

    @property
    def limited(self) -> bool:
        """Return whether the algorithm keeps the limits by itself, however strong a drive is."""
        return registry.cueing_named(self.study.cueing).limited

    def as_json(self) -> dict[str, Any]:
        """Return plain values."""
        return {
            name: {
                "settings": dict(trial.settings),
                TRAINING: self.measured(trial, TRAINING),
                "held_out": self.measured(trial, JUDGING),
            }
            for name, trial in (("before", self.before), ("after", self.after), ("best_trained", self.best))
        } | {"kept": self.kept, "trials": len(self.trials), "cueing": self.study.cueing}


def pieces(drive: Scenario, dofs: Sequence[Dof]) -> tuple[list[Scenario], list[Scenario]]:
    """Return pieces of a drive for training, and of its held-out end for judging.

    Pieces in which next to nothing is wanted along `dofs` are left out.

    Raises
    ------
    InputError : nothing is wanted where it would be trained, or no specific force is cued.
    """
    border = TRAINED * drive.duration
    axes = [dof.felt for dof in dofs if not dof.feels_rate]
    if not axes:
        raise InputError("--dofs", ",".join(dof.name for dof in dofs), "one with a specific force at least")
    least = QUIET * _wanted(drive, axes)
    trained, held_out = (
        [one for one in _spread(drive, *ends) if _wanted(one, axes) > least]
        for ends in ((0.0, border), (border, drive.duration))
    )
    if not trained:
        bound = f"wanted within the first {border:.0f} s, on which settings are trained"
        raise InputError(f"specific force of {drive.name}", "none", bound)
    return trained, held_out


def _wanted(drive: Scenario, axes: Sequence[int]) -> float:
    """Return the RMS of the wanted force along axes, all together [m/s²]."""
    t = np.linspace(0.0, drive.duration, max(2, round(drive.duration / 0.01)), endpoint=False)
    return float(np.sqrt(np.mean(np.sum(drive.specific_force(t)[:, axes] ** 2, axis=1))))


def _spread(drive: Scenario, begin: float, end: float) -> list[Scenario]:
    """Return at most `PIECES` pieces of equal length, evenly spread over a part of a drive."""
    count = min(PIECES, math.ceil((end - begin) / PIECE))
    length = min(PIECE, (end - begin) / count)
    gap = 0.0 if count == 1 else (end - begin - length) / (count - 1)
    return [drive.part(begin + k * gap, min(begin + k * gap + length, end)) for k in range(count)]


def study_for(cueing: str, design: Design, evaluations: int, references: Sequence[Scenario]) -> Study:
    """Return the study that tunes an algorithm; `design` has the tuning with which a washout begins.

    Raises
    ------
    InputError : the algorithm has nothing that is tuned here, or there are too few evaluations.
    """
    if cueing not in SPACES:
        raise InputError("--cueing", repr(cueing), one_of(SPACES, cueing))
    if evaluations < BATCH:
        raise InputError("--evaluations", evaluations, f"at least {BATCH}")
    parameters, starts = SPACES[cueing](design)
    known = () if registry.cueing_named(cueing).limited else (Constraint(measure="peak", most=1.0 - MARGIN),)
    return Study(
        name=f"tune-{cueing}",
        cueing=cueing,
        platform=design.platform.name,
        dofs=",".join(dof.name for dof in design.dofs),
        parameters=parameters,
        start=starts,
        training=tuple(Reference(scenario=one.name) for one in references),
        objectives=(Objective(measure="tracking"), Objective(measure="travel", over="worst")),
        constraints=(
            Constraint(measure="violations", most=0.0),
            Constraint(measure="noticed", most=0.0),  # replaced by `_no_worse`
            *known,
        ),
        budget=Budget(trials=evaluations, sampler="tpe", batch=BATCH),
    )


def tuned(
    study: Study,
    design: Design,
    plant: str,
    references: Mapping[str, Sequence[Scenario]],
    executor_of: Callable[[Mapping[str, Problem]], Executor],
    *,
    price: float = PRICE,
    progress: Callable[[Progress], None] = lambda _: None,
) -> Tuned:
    """Tune an algorithm.

    Parameters
    ----------
    references : for training and for judging, by the name of the set.
    executor_of : makes what does the jobs, given the problems.
    price : μ.

    Raises
    ------
    InputError : the price is none, the settings to begin with are refused, or no settings that were tried
        keep all limits.
    """
    check_price(price)
    problems = {kind: _measured(study, design, plant, references[kind]) for kind in (TRAINING, JUDGING)}
    study = _no_worse(study, problems[TRAINING])
    counts = {kind: len(one.items) for kind, one in problems.items()}
    store = Store.create("", study.name, len(study.objectives), {})
    with executor_of(problems) as executor:
        search = Search(study, store, counts, executor, do_one=work, progress=progress)
        ranked = by_price(study, search.train(), price)
        search.judge(store.trials(range(1)))
        before = store.trials(range(1))[0]
        best = next(_within_limits(search, store, ranked, before), before)
    if best is before and _passes(before):
        bound = "at least 1: a platform with more reach, a smaller --scale, or more --evaluations"
        done = sum(one.state is State.DONE for one in store.trials())
        raise InputError("settings within all limits", f"0 of {done} tried", bound)
    return Tuned(
        study=study,
        design=design,
        before=before,
        after=best if _better(study, best, before) else before,
        best=best,
        trials=tuple(store.trials()),
        shown=problems[JUDGING if counts[JUDGING] else TRAINING],
    )


def _measured(study: Study, design: Design, plant: str, references: Sequence[Scenario]) -> Problem:
    """Return the problem of a study with what is printed, too: how near the limits were."""
    found = problem(study, design, plant, references)
    return replace(found, measures=tuple(dict.fromkeys((*found.measures, "peak"))))


def _no_worse(study: Study, of: Problem) -> Study:
    """Return the study with the share of noticed tilts bounded by that of the settings to begin with.

    Conventional washouts do not know the rate at which drivers notice a tilt, and the pitch of a car, cued as
    it is, passes it, too. An MPC keeps to it, and so has to go on doing so.
    """
    first = Job(tuple(study.start[0].items()), 0)
    done = {item: do(of, replace(first, item=item)) for item in range(len(of.items))}
    refused = [one.refused for one in done.values() if one.refused]
    if refused:
        raise InputError(
            "the settings to begin with", f"refused ({refused[0]})", "such that a loop can close"
        )
    bounds = {"noticed": _worst(done, "noticed")}
    constraints = tuple(
        one.model_copy(update={"most": bounds.get(one.measure, one.most)}) for one in study.constraints
    )
    return study.model_copy(update={"constraints": constraints})


def by_price(study: Study, trials: Sequence[Trial], price: float) -> list[Trial]:
    """Return the trials within all limits: those first whose error is not larger than the first trial's.

    Of these, and of the others, those with the least J come first.
    """
    known = {one.number: values(study, one.training) for one in trials if allowed(study, one)}
    most = values(study, trials[0].training)[0]

    def rank(number: int) -> tuple[bool, float, int]:
        error, travel = known[number]
        return error > most, math.log(error) + price * travel, number

    return [trials[number] for number in sorted(known, key=rank)]


def _within_limits(search: Search, store: Store, ranked: Sequence[Trial], before: Trial) -> Iterator[Trial]:
    """Yield the trials that keep the limits on what is held out; there, too, tilts are noticed no more."""
    noticed = _worst(before.judging, "noticed")
    for first, last in pairwise(
        (0, 1, *range(1 + BATCH, len(ranked) + BATCH, BATCH))
    ):  # the first mostly does
        some = ranked[first:last]
        search.judge(one for one in some if one.number != before.number)
        judged = store.trials()
        for number in (one.number for one in some):
            found = before if number == before.number else judged[number]
            if not _passes(found) and _worst(found.judging, "noticed") <= noticed:
                yield found


def _passes(trial: Trial) -> bool:
    """Return whether a trial passes a limit of the machine anywhere."""
    return max(_worst(one, "violations") for one in (trial.training, trial.judging)) > 0.0


def _better(study: Study, trial: Trial, before: Trial) -> bool:
    """Return whether a trial, which keeps the limits, is better than the settings to begin with.

    It is if those pass a limit, or if its error is less on what was held out, by `GAIN` at least. If nothing
    was, training, which has ranked them, decides.
    """
    if _passes(before) or not before.judging:
        return True
    return values(study, trial.judging)[0] <= (1.0 - GAIN) * values(study, before.judging)[0]


def _worst(results: Mapping[int, Done], name: str) -> float:
    """Return the largest value of a measure: 0 without any results, infinite if a loop was refused."""
    return max((done.measures.get(name, math.inf) for done in results.values()), default=0.0)
