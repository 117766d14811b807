"""From a study's file to what its jobs have in common: platform, algorithm, and references that were read."""

import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from otolith import __version__, files, registry
from otolith.core.errors import InputError
from otolith.core.frames import dofs_named
from otolith.cueing.design import Design
from otolith.cueing.optimum import measure_of, optimum
from otolith.experiment import StoredFile, Wanted
from otolith.metrics import tracking_rmse
from otolith.metrics.axes import by_force
from otolith.metrics.measure import root_sum_square
from otolith.scenarios import Scenario
from otolith.studies.definition import Reference, Study
from otolith.studies.jobs import JUDGING, TRAINING, Item, Problem
from otolith.studies.measures import MEASURES
from otolith.studies.spaces import started


@dataclass(frozen=True, kw_only=True)
class Prepared:
    """A study that is ready to run."""

    study: Study
    folder: Path  # to which the paths in the study are relative
    training: Problem
    judging: Problem
    digest: str  # of all that results depend on, but the software's source

    @property
    def problems(self) -> dict[str, Problem]:
        """Return the problems by the name of their set."""
        return {TRAINING: self.training, JUDGING: self.judging}


def problem_of(study: Study, folder: Path) -> Prepared:
    """Read what a study names.

    Parameters
    ----------
    folder : to which the paths in the study are relative.

    Raises
    ------
    OtolithError : a platform, scenario or drive is refused.
    """
    registry.cueing_named(study.cueing)
    platform = files.read_platform(
        _within(folder, study.platform) if study.platform.endswith(".toml") else study.platform
    )
    design = started(study.cueing, Design(platform=platform, dofs=dofs_named(study.dofs.split(","))))
    if all(dof.feels_rate for dof in design.dofs):
        raise InputError("dofs of a study", study.dofs, "one with a specific force at least")
    for dof in design.dofs:
        platform.limits(dof)  # refuses a degree of freedom that the platform lacks
    plant = study.plant or registry.cueing_named(study.cueing).plant
    registry.make_plant(plant, platform)  # refuses one that does not exist
    read, judged = (
        [_scenario(one, folder, design) for one in references]
        for references in (study.training, study.judging)
    )
    training, judging = (problem(study, design, plant, scenarios) for scenarios in (read, judged))
    logs = [_within(folder, one.log) for one in (*study.training, *study.judging) if one.log is not None]
    content = [
        study.model_dump(mode="json", exclude={"budget": {"trials"}}),
        platform.model_dump(mode="json"),
        [StoredFile.of(Path(log)).sha256 for log in logs],
        __version__,
    ]
    digest = hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
    return Prepared(study=study, folder=folder, training=training, judging=judging, digest=digest)


def problem(study: Study, design: Design, plant: str, scenarios: Sequence[Scenario]) -> Problem:
    """Return what all jobs on these scenarios have in common."""
    measures = tuple(dict.fromkeys(one.measure for one in (*study.objectives, *study.constraints)))
    needs_best = any(MEASURES[name].needs_best for name in measures)
    items = tuple(
        Item(name=one.name, scenario=one, best=_least(design, plant, one) if needs_best else 0.0)
        for one in scenarios
    )
    return Problem(
        cueing=study.cueing,
        design=design,
        plant=plant,
        items=items,
        measures=measures,
        fixed=dict(study.fixed),
        timeout_s=study.budget.timeout_s,
    )


def _least(design: Design, plant: str, scenario: Scenario) -> float:
    """Return the RMSE of the offline optimum along all force axes [m/s²]."""
    best = optimum(design.platform, design.dofs, scenario, plant=measure_of(plant)).run
    return root_sum_square(by_force(best, tracking_rmse(best)))


def _scenario(reference: Reference, folder: Path, design: Design) -> Scenario:
    wanted = Wanted(
        scenario=reference.scenario,
        log=None if reference.log is None else Path(_within(folder, reference.log)),
        lowpass_hz=reference.lowpass_hz,
        causal=reference.causal,
        through=reference.through,
        scale=reference.scale,
    )
    whole = wanted.along(design)
    if reference.from_s == 0.0 and reference.to_s is None:
        return whole
    end = whole.duration if reference.to_s is None else reference.to_s
    if end > whole.duration:
        raise InputError(f"to_s of {whole.name}", f"{end:g} s", f"at most {whole.duration:g} s, its length")
    return whole.part(reference.from_s, end)


def _within(folder: Path, name: str) -> str:
    """Return the path of a file that a study names, relative to its folder."""
    return str(folder / name)
