"""Whether the loop that a study used is the one that everybody else uses: runs of a sample, made twice.

A study closes its loops by `otolith.loop.simulate`, in one compiled call where algorithm and plant allow it.
The sample is made again by the loop in Python, and compared bit for bit.
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass

from otolith.experiment import differences
from otolith.studies.definition import Study
from otolith.studies.jobs import TRAINING, Job, Problem, closed, do
from otolith.studies.results import State, Trial, best_of, front


@dataclass(frozen=True, kw_only=True)
class Agreement:
    """What was compared, and the fields of runs, or measures, that differed."""

    loops: int
    different: tuple[str, ...]


def agreement(study: Study, problem: Problem, trials: Sequence[Trial]) -> Agreement:
    """Compare the first trial that is done and the best one, each on the shortest reference."""
    done = [trial for trial in trials if trial.state is State.DONE]
    chosen = {trial.number: trial for trial in done[:1]}
    if front(study, trials):
        best = best_of(study, trials)
        chosen[best.number] = best
    shortest = min(range(len(problem.items)), key=lambda k: problem.items[k].scenario.duration)
    different = [
        f"trial {number}, {field}"
        for number, trial in chosen.items()
        for field in _different(study, problem, trial, shortest)
    ]
    return Agreement(loops=len(chosen), different=tuple(different))


def _different(study: Study, problem: Problem, trial: Trial, item: int) -> list[str]:
    job = Job(tuple(trial.settings.items()), item)
    found = differences(closed(problem, job), closed(problem, job, clock=_in_python))
    if study.deterministic and do(problem, job) != getattr(trial, TRAINING)[item]:
        found.append("measures")
    return found


def _in_python() -> float:
    """Measure the time of a decision as ever; being another function, it keeps the loop in Python."""
    return time.thread_time()
