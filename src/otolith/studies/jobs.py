"""One closed loop as a value: settings and a reference go in, measures come out, nothing else matters."""

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from otolith import registry
from otolith.core.errors import OtolithError
from otolith.cueing.design import Design
from otolith.interfaces import Cueing, Plant
from otolith.loop import Run, simulate
from otolith.scenarios import Scenario
from otolith.studies.measures import MEASURES
from otolith.studies.settings import Settings, applied

Value = float | int | str
TRAINING, JUDGING = "training", "judging"  # sets of items


@dataclass(frozen=True, kw_only=True)
class Item:
    """A reference: what is wanted, and the least possible error on it."""

    name: str
    scenario: Scenario
    best: float = 0.0  # RMSE of the offline optimum [m/s²]; 0 where no measure needs it


@dataclass(frozen=True, kw_only=True)
class Problem:
    """What all jobs of a study have in common; it is sent once to each process."""

    cueing: str
    design: Design
    plant: str
    items: tuple[Item, ...]
    measures: tuple[str, ...]
    fixed: Settings = field(default_factory=dict)
    timeout_s: float | None = None


@dataclass(frozen=True, slots=True)
class Job:
    """One closed loop to make."""

    settings: tuple[tuple[str, Value], ...]  # what is varied, by name
    item: int  # number of the problem's item


@dataclass(frozen=True, slots=True)
class Done:
    """The measures of a job by name, or why there are none."""

    measures: Mapping[str, float] = field(default_factory=dict)
    refused: str = ""


class _TooLong(OtolithError):
    """A job took longer than its time-out."""


def work(problems: Mapping[str, Problem], asked: tuple[str, Job]) -> Done:
    """Do a job of one of the sets of items, given the problems by set."""
    kind, job = asked
    return do(problems[kind], job)


def do(problem: Problem, job: Job) -> Done:
    """Close the loop of one job and measure it; settings that are refused are a result, too."""
    try:
        run = closed(problem, job)
        best = problem.items[job.item].best
        measures = {
            name: float(MEASURES[name].of(run, best if MEASURES[name].needs_best else 0.0))
            for name in problem.measures
        }
    except OtolithError as error:
        return Done(refused=str(error))
    wrong = [name for name, value in measures.items() if not math.isfinite(value)]
    return Done(refused=f"{wrong[0]} is no finite number") if wrong else Done(measures)


def closed(problem: Problem, job: Job, clock: Callable[[], float] = time.thread_time) -> Run:
    """Return the run of a job.

    Parameters
    ----------
    clock : as of `otolith.loop.simulate`; any but the default keeps the loop in Python, and makes everything
        anew.

    Raises
    ------
    OtolithError : a setting is refused, or the job took longer than its time-out.
    """
    began = time.thread_time()
    design, plant, cueing = (_same if clock is time.thread_time else _made)(problem, job.settings)
    return simulate(
        cueing,
        plant,
        problem.items[job.item].scenario,
        platform=design.platform,
        dofs=tuple(dof.name for dof in design.dofs),
        names=(problem.cueing, problem.plant),
        preview=design.preview,
        clock=clock,
        progress=lambda _: _keep_to(problem.timeout_s, began),
    )


def _made(problem: Problem, settings: tuple[tuple[str, Value], ...]) -> tuple[Design, Plant, Cueing]:
    """Return the design of some settings, its plant, and the algorithm."""
    design = applied(problem.design, {**problem.fixed, **dict(settings)})
    plant = registry.make_plant(problem.plant, design.platform)
    return design, plant, registry.make_cueing(problem.cueing, design, dead_time=plant.dead_time)


def _same(problem: Problem, settings: tuple[tuple[str, Value], ...]) -> tuple[Design, Plant, Cueing]:
    """Return what `_made` does: for the same settings as before, what it made then.

    Settings are tried on one reference after another, and making an MPC takes a quarter of the time of a job.
    After a reset, which begins every loop, an algorithm decides as a new one does, bit for bit
    (`otolith.interfaces.Cueing`; `otolith.studies.agreement` checks it). One from outside may not.
    """
    if registry.cueing_named(problem.cueing).outside:
        return _made(problem, settings)
    if not (_last and _last[0] is problem and _last[1] == settings):
        _last[:] = problem, settings, _made(problem, settings)
    found: tuple[Design, Plant, Cueing] = _last[2]
    return found


_last: list[Any] = []  # in a process: a problem, settings, and what was made of them


def _keep_to(timeout_s: float | None, began: float) -> None:
    """Stop a loop that has taken too long; it is asked a hundred times in each."""
    if timeout_s is not None and time.thread_time() - began > timeout_s:
        raise _TooLong(f"it took longer than {timeout_s:g} s")


def as_json(done: Done) -> dict[str, Any]:
    """Return plain values of a result."""
    return {"refused": done.refused} if done.refused else {"measures": dict(done.measures)}
