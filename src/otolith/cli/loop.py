"""The part that `run` and `compare` share: check all options, then close the loop."""

import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

from rich.console import Console

from otolith import files, registry
from otolith.cli.options import RunOptions
from otolith.cli.output import described_bar, progress_bar, progress_line, warn, working
from otolith.core.errors import InputError
from otolith.core.jobs import Workers
from otolith.cueing.design import Design
from otolith.cueing.hints.stored import Refused
from otolith.experiment import Experiment
from otolith.interfaces import Cueing
from otolith.loop import ClosedLoop, Keeper, Run
from otolith.safety.supervisor import Intervention
from otolith.scenarios import Scenario
from otolith.scenarios.catalog import has_literal

_REPORTED: Final = 5  # number of a supervisor's interventions that are reported individually


@dataclass(frozen=True, kw_only=True)
class Prepared:
    """All choices, already checked: none of them is refused once the loop is closed."""

    design: Design
    scenarios: tuple[Scenario, ...]
    experiments: tuple[Mapping[str, Experiment], ...]  # of each scenario, by algorithm
    # Settings to record in the runs of each scenario, by algorithm
    settings: tuple[Mapping[str, Mapping[str, Any]], ...]
    plants: Mapping[str, str]  # the plant of each cueing algorithm, by the algorithm's name


def prepare(
    each: Sequence[RunOptions], names: Sequence[str], tuning: str | None, console: Console
) -> Prepared:
    """Check every scenario and algorithm that was chosen.

    Raises
    ------
    OtolithError : a choice is invalid or would have no effect. No time has been spent on simulation yet.
    """
    first = each[0]
    makers = {name: registry.cueing_named(name) for name in names}
    plants = {name: first.plant or maker.plant for name, maker in makers.items()}
    for plant in plants.values():
        registry.lookup(registry.PLANTS, "--plant", plant)
    registry.check_options(names, first.given)
    _check_literal(each)
    design = first.design()
    if tuning is not None:
        design = replace(design, washout=files.read_tuning(tuning))
    if isinstance(design.hint, Refused):
        warn(console, f"hint refused, running without it: {design.hint.reason}")
    note = functools.partial(warn, console)
    experiments = tuple({name: choices.experiment(name, design) for name in names} for choices in each)
    return Prepared(
        design=design,
        scenarios=tuple(choices.wanted().along(design, note=note) for choices in each),
        experiments=experiments,
        settings=tuple({name: one.record() for name, one in of_one.items()} for of_one in experiments),
        plants=plants,
    )


def _check_literal(each: Sequence[RunOptions]) -> None:
    """Refuse --literal if it makes no difference to any scenario."""
    names = [choices.scenario for choices in each if choices.literal and choices.scenario is not None]
    if names and not any(has_literal(name) for name in names):
        bound = "left out, or used with a step whose end is left open"
        raise InputError("--literal", f"given, but {' and '.join(names)} would ignore it", bound)


def simulate_one(prepared: Prepared, console: Console, name: str, keep: Keeper) -> Run:
    """Return the run of one algorithm on the first scenario, as it was kept."""
    made = Algorithms(prepared, console)
    with progress_bar(console, f"{name} on {prepared.scenarios[0].name}") as progress:
        run = closed_loop(made.prepared, 0, name, made[name], keep=keep).complete(progress)
    report_interventions(run.interventions, console)
    return run


class Algorithms:
    """The algorithms of one or several runs, each made once in every process that needs it.

    In this process they are made at once, which compiles what is missing and finds the laws that they share.
    """

    def __init__(self, prepared: Prepared, console: Console) -> None:
        self.tell: Callable[[Cued, float], None] = _tell_nobody  # how far a run is, if it is made here
        self._made: dict[str, Cueing] = {}
        design = replace(
            prepared.design, progress=lambda now: report(progress_line(now, after=text))
        )  # all algorithms share one design, and with it the laws that are enumerated on first use
        for name in prepared.plants:
            text = f"preparing {name}; kernels are compiled on first use (10 to 30 s), then cached"
            with working(console, text) as report:
                self._made[name] = cueing_of(prepared, name, design)
        laws = design.laws if "laws" in vars(design) else prepared.design.stored_laws
        self.prepared = replace(prepared, design=replace(prepared.design, stored_laws=laws))

    def __getitem__(self, name: str) -> Cueing:
        if name not in self._made:
            self._made[name] = cueing_of(self.prepared, name, self.prepared.design)
        return self._made[name]

    def __getstate__(self) -> dict[str, Any]:
        """Leave out what another process makes for itself."""
        return {"prepared": self.prepared, "_made": {}, "tell": _tell_nobody}


@dataclass(frozen=True)
class Cued:
    """One run to make: an algorithm on scenario k, kept in a file."""

    k: int
    name: str
    path: Path


def simulate_all(
    prepared: Prepared, console: Console, runs: Sequence[Cued], *, jobs: int
) -> list[dict[str, Any]]:
    """Make runs in files, in several processes if asked; return the key figures of each, in their order."""
    made = Algorithms(prepared, console)
    shares = dict.fromkeys(runs, 0.0)  # how far each run is
    lengths = {run: prepared.scenarios[run.k].duration for run in runs}

    def note(run: Cued, share: float) -> None:
        shares[run] = share
        done = sum(lengths[one] * shares[one] for one in runs) / sum(lengths.values())
        progress(f"{run.name} on {prepared.scenarios[run.k].name}", done)

    made.tell = note
    with described_bar(console, "cueing") as progress, Workers(jobs, made) as workers:
        return workers.each(_summary, runs, lambda run: note(run, 1.0))


def _summary(made: Algorithms, run: Cued) -> dict[str, Any]:
    """Make a run, and return its key figures."""
    from otolith import metrics

    with files.run_file(run.path) as keep:
        loop = closed_loop(made.prepared, run.k, run.name, made[run.name], keep=keep)
        return metrics.summarise(loop.complete(lambda share: made.tell(run, share)))


def _tell_nobody(_: "Cued", __: float) -> None:
    """Report no progress, as other processes do."""


def cueing_of(prepared: Prepared, name: str, design: Design) -> Cueing:
    """Make one of the algorithms, for the plant that it will move."""
    plant = registry.make_plant(prepared.plants[name], design.platform)
    return registry.make_cueing(name, design, dead_time=plant.dead_time)


def closed_loop(
    prepared: Prepared, k: int, name: str, cueing: Cueing, *, keep: Keeper | None = None
) -> ClosedLoop:
    """Return the loop of an algorithm and its plant on scenario k, at its start."""
    design, plant = prepared.design, prepared.plants[name]
    return ClosedLoop(
        cueing,
        registry.make_plant(plant, design.platform),
        prepared.scenarios[k],
        platform=design.platform,
        dofs=tuple(dof.name for dof in design.dofs),
        names=(name, plant),
        settings=dict(prepared.settings[k][name]),
        preview=design.preview,
        keep=keep,
    )


def report_interventions(found: Sequence[Intervention], console: Console) -> None:
    """Report the longest interventions in order of time, and the number of the others."""
    longest = sorted(found, key=lambda one: one.start - one.end)[:_REPORTED]
    for intervention in sorted(longest, key=lambda one: one.start):
        warn(console, f"supervisor, {intervention}")
    if len(found) > _REPORTED:
        warn(console, f"supervisor, {len(found) - _REPORTED} shorter interventions besides")
