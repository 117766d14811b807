"""What trials found: values of the objectives, the front that none of them beats, and presets on it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum

from otolith.core.errors import InputError, one_of
from otolith.studies.definition import Objective, Study
from otolith.studies.jobs import Done
from otolith.studies.measures import AVERAGES
from otolith.studies.settings import Settings


class State(StrEnum):
    """How far a trial is."""

    OPEN = "open"  # some of its jobs are not done
    DONE = "done"
    PRUNED = "pruned"  # it ended early, since it was in the worse part by every objective
    REJECTED = "rejected"  # a setting was refused, or a job took too long


@dataclass(frozen=True, kw_only=True)
class Trial:
    """One set of settings and what became of it."""

    number: int
    settings: Settings  # what is varied
    training: Mapping[int, Done] = field(default_factory=dict)  # by number of the item
    judging: Mapping[int, Done] = field(default_factory=dict)
    state: State = State.OPEN


def average(of: Objective, results: Mapping[int, Done]) -> float:
    """Return one number for the results on all references."""
    return AVERAGES[of.over]([results[k].measures[of.measure] for k in sorted(results)])


def values(study: Study, results: Mapping[int, Done]) -> tuple[float, ...]:
    """Return the value of every objective."""
    return tuple(average(objective, results) for objective in study.objectives)


def excesses(study: Study, results: Mapping[int, Done]) -> dict[str, float]:
    """Return by how much every constraint is passed; at most 0 if it is kept."""
    return {f"{one.measure} {one.over}": average(one, results) - one.most for one in study.constraints}


def allowed(study: Study, trial: Trial) -> bool:
    """Return whether a trial is done and keeps all constraints."""
    return trial.state is State.DONE and max(excesses(study, trial.training).values(), default=0.0) <= 0.0


def front(study: Study, trials: Sequence[Trial]) -> list[Trial]:
    """Return the trials that keep all constraints and that no other beats, by the first objective.

    A trial beats another if it is at least as good in every objective and better in one; of equals, the
    first is kept.
    """
    found: list[tuple[tuple[float, ...], Trial]] = []
    for trial in trials:
        if not allowed(study, trial):
            continue
        new = values(study, trial.training)
        if any(all(a <= b for a, b in zip(old, new, strict=True)) for old, _ in found):
            continue
        found = [(old, one) for old, one in found if not all(a <= b for a, b in zip(new, old, strict=True))]
        found.append((new, trial))
    return [trial for _, trial in sorted(found, key=lambda pair: (pair[0], pair[1].number))]


def best_of(study: Study, trials: Sequence[Trial], weights: Mapping[str, float] | None = None) -> Trial:
    """Return the trial of the front with the least weighted sum of objectives, each scaled to the front.

    Parameters
    ----------
    weights : of the objectives by measure; those that are not named count nothing. By default all count
        alike.

    Raises
    ------
    InputError : no trial keeps all constraints.
    """
    best = front(study, trials)
    if not best:
        done = sum(trial.state is State.DONE for trial in trials)
        raise InputError("trials within all constraints", f"0 of {done} done", "at least 1")
    columns = list(zip(*(values(study, trial.training) for trial in best), strict=True))
    named = [objective.measure for objective in study.objectives]
    given = dict.fromkeys(named, 1.0) if weights is None else weights

    def cost(k: int) -> float:
        scaled: list[float] = [
            given.get(name, 0.0) * (column[k] - min(column)) / ((max(column) - min(column)) or 1.0)
            for name, column in zip(named, columns, strict=True)
        ]
        return sum(scaled)

    return best[min(range(len(best)), key=lambda k: (cost(k), best[k].number))]


def preset_of(study: Study, trials: Sequence[Trial], name: str) -> Trial:
    """Return the trial of a study's preset.

    Raises
    ------
    InputError : there is no such preset, or no trial keeps all constraints.
    """
    if name not in study.presets:
        raise InputError("preset", repr(name), one_of(study.presets, name) if study.presets else "left out")
    return best_of(study, trials, study.presets[name])
