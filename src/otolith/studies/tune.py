"""The best settings of one algorithm for one platform and one drive, and what they cost.

It is a small study: the settings that the algorithm has without tuning are tried first, and TPE chooses the
others. Of those that keep all limits and that no other beats in tracking and travel, the one with the least

    J = ln(RMSE / RMS of the wanted force) + μ · (share of the reach, p99)

is chosen, as `otolith.tuning` does for constant weights. Limits of the machine are kept, and the tilt is
noticed no more often than with the settings to begin with. The end of a drive is held out, to judge before
and after on what was not trained on.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

from otolith import registry
from otolith.core.errors import InputError, one_of
from otolith.core.frames import AXES, Dof
from otolith.cueing.design import Design
from otolith.cueing.washout.tuning import Classical, Optimal, load_tuning, tunings
from otolith.platforms.axes import Translation
from otolith.scenarios import Scenario
from otolith.studies.definition import Budget, Constraint, Objective, Parameter, Reference, Study
from otolith.studies.executors import Executor
from otolith.studies.jobs import JUDGING, TRAINING, Done, Job, Problem, do, work
from otolith.studies.problem import problem
from otolith.studies.results import State, Trial, front, values
from otolith.studies.search import Progress, Search
from otolith.studies.settings import Settings
from otolith.studies.store import Store

PRICE: Final = 0.5  # μ: all of the reach counts as much as 65 % of error
TRAINED: Final = 0.7  # share of a drive that is trained on
PIECE, PIECES = 60.0, 5  # [s] length of a piece of a drive, and how many are cued of each share at most
BATCH: Final = 10
_REACH: Final = 0.5  # [m] of the platform for which the tuning is made that others begin with


@dataclass(frozen=True, kw_only=True)
class Tuned:
    """The settings before and after, and how both were judged."""

    study: Study
    design: Design  # with what is not varied
    before: Trial
    after: Trial
    trials: tuple[Trial, ...]
    shown: Problem  # what was held out, or else what was trained on

    def measured(self, trial: Trial, kind: str) -> dict[str, float] | None:
        """Return what a trial was measured to cost on one set of references, if that is known."""
        results: Mapping[int, Done] = getattr(trial, kind)
        if not results or any(done.refused for done in results.values()):
            return None
        error, travel = values(self.study, results)
        passed, noticed = (
            max(done.measures[name] for done in results.values()) for name in ("violations", "noticed")
        )
        return {"tracking": error, "travel": travel, "violations": passed, "noticed": noticed}

    def as_json(self) -> dict[str, Any]:
        """Return plain values."""
        return {
            name: {
                "settings": dict(trial.settings),
                TRAINING: self.measured(trial, TRAINING),
                "held_out": self.measured(trial, JUDGING),
            }
            for name, trial in (("before", self.before), ("after", self.after))
        } | {"trials": len(self.trials), "cueing": self.study.cueing}


def pieces(drive: Scenario) -> tuple[list[Scenario], list[Scenario]]:
    """Return pieces of a drive for training, and of its held-out end for judging."""
    border = TRAINED * drive.duration
    return _spread(drive, 0.0, border), _spread(drive, border, drive.duration)


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
    if cueing not in _SPACES:
        raise InputError("--cueing", repr(cueing), one_of(_SPACES, cueing))
    if evaluations < BATCH:
        raise InputError("--evaluations", evaluations, f"at least {BATCH}")
    parameters, starts = _SPACES[cueing](design)
    return Study(
        name=f"tune-{cueing}",
        cueing=cueing,
        platform=design.platform.name,
        dofs=",".join(dof.name for dof in design.dofs),
        parameters=parameters,
        start=starts,
        training=tuple(Reference(scenario=one.name) for one in references),
        objectives=(Objective(measure="tracking"), Objective(measure="travel", over="worst")),
        budget=Budget(trials=evaluations, sampler="tpe", batch=BATCH),
    )


def started(cueing: str, design: Design) -> Design:
    """Return the design with the tuning with which a washout begins, if it has none of its own.

    It is the platform's, or that of the thesis's platform with the travel's frequencies fitted to the reach.
    """
    if "tuning" not in registry.cueing_named(cueing).reads or design.washout is not None:
        return design
    if design.platform.name in tunings():
        return replace(design, washout=load_tuning(design.platform.name))
    known = load_tuning("thesis")
    fields = known.of(Classical).model_dump()
    for name in ("surge", "sway", "heave"):
        limits = getattr(design.platform, name)
        if isinstance(limits, Translation):
            faster = math.sqrt(_REACH / min(-limits.position_m[0], limits.position_m[1]))
            fields[name]["natural_radps"] = min(20.0, fields[name]["natural_radps"] * faster)
    own = {"name": design.platform.name, "description": "", "classical": Classical(**fields)}
    return replace(design, washout=known.model_copy(update=own))


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
    InputError : no settings that were tried keep all limits.
    """
    problems = {kind: problem(study, design, plant, references[kind]) for kind in (TRAINING, JUDGING)}
    study = _no_worse(study, problems[TRAINING])
    counts = {kind: len(one.items) for kind, one in problems.items()}
    store = Store.create("", study.name, len(study.objectives), {})
    with executor_of(problems) as executor:
        search = Search(study, store, counts, executor, do_one=work, progress=progress)
        trials = search.train()
        best = cheapest(study, trials, price)
        search.judge({0: trials[0], best.number: best}.values())
    trials = store.trials()
    return Tuned(
        study=study,
        design=design,
        before=trials[0],
        after=trials[best.number],
        trials=tuple(trials),
        shown=problems[JUDGING if counts[JUDGING] else TRAINING],
    )


def _no_worse(study: Study, of: Problem) -> Study:
    """Return the study with the share of noticed tilts bounded by that of the settings to begin with.

    Conventional washouts do not know the rate at which drivers notice a tilt, and the pitch of a car, cued as
    it is, passes it, too. An MPC keeps to it, and so has to go on doing so.
    """
    first = Job(tuple(study.start[0].items()), 0)
    done = [do(of, replace(first, item=item)) for item in range(len(of.items))]
    shares = [one.measures["noticed"] for one in done if not one.refused]
    bound = Constraint(measure="noticed", most=max(shares, default=0.0))
    return study.model_copy(update={"constraints": (Constraint(measure="violations", most=0.0), bound)})


def cheapest(study: Study, trials: Sequence[Trial], price: float) -> Trial:
    """Return the trial of the front with the least J.

    Raises
    ------
    InputError : no trial keeps all limits.
    """
    found = front(study, trials)
    if not found:
        done = sum(one.state is State.DONE for one in trials)
        bound = "at least 1: a platform with more reach, a smaller --scale, or more --evaluations"
        raise InputError("settings within all limits", f"0 of {done} tried", bound)

    def J(trial: Trial) -> float:
        error, travel = values(study, trial.training)
        return math.log(error) + price * travel

    return min(found, key=lambda one: (J(one), one.number))


Space = tuple[dict[str, Parameter], tuple[Settings, ...]]  # and what is tried first


def _log(low: float, high: float) -> Parameter:
    return Parameter(scale="log", low=low, high=high)


def _classical(design: Design) -> Space:
    """Return six parameters for one travelling axis, and three more for each other one."""
    tuning = design.tuning
    table = tuning.of(Classical)
    space: dict[str, Parameter] = {"tuning.scaling.force.slope": Parameter(low=0.1, high=1.0)}
    if any(dof.is_pair for dof in design.dofs):
        space["tuning.classical.tilt.natural_radps"] = _log(0.2, 10.0)
        space["tuning.classical.tilt.damping"] = Parameter(low=0.5, high=1.5)
    for axis in _travelling(design.dofs):
        space[f"tuning.classical.{axis}.natural_radps"] = _log(0.5, 20.0)
        space[f"tuning.classical.{axis}.damping"] = Parameter(low=0.5, high=2.0)
        space[f"tuning.classical.{axis}.washout_radps"] = _log(0.05, 3.0)
    known = {"scaling": tuning.scaling.model_dump(), "classical": table.model_dump()}
    start = {name: _inside(space[name], _at(known, name)) for name in space}
    return space, (start, _cautious(space, start))


def _cautious(space: Mapping[str, Parameter], start: Mapping[str, float]) -> Settings:
    """Return settings that keep the limits of most rigs on hard drives, where those to begin with do not.

    Without any such settings the search would have to find the small part of the space by chance.
    """
    values = {"slope": 0.3, "natural_radps": 0.3, "damping": 1.0, "washout_radps": 1.0}
    own = {name: values[name.rpartition(".")[2]] for name in space}
    faster = {
        name: 2.0 * start[name] for name in space if name.endswith("natural_radps") and ".tilt." not in name
    }
    return {name: _inside(space[name], value) for name, value in (own | faster).items()}


def _optimal(design: Design) -> Space:
    """Return the weights of the optimal washout relative to that of the sensed force, and the scaling."""
    tuning = design.tuning
    known = {"scaling": tuning.scaling.model_dump(), "optimal": tuning.of(Optimal).model_dump()}
    space: dict[str, Parameter] = {"tuning.scaling.force.slope": Parameter(low=0.1, high=1.0)}
    for name in ("integral", "position", "velocity", "acceleration", "rate"):
        value = known["optimal"][name]
        space[f"tuning.optimal.{name}"] = _log(value / 30.0, 30.0 * value)
    return space, ({name: _inside(space[name], _at(known, name)) for name in space},)


def _predictive(design: Design) -> Space:
    """Return liveliness, and the times of the adaptive prediction unless another one is chosen."""
    space = {"liveliness": Parameter(low=0.0, high=1.0)}
    start: dict[str, float | int | str] = {"liveliness": design.liveliness}
    if design.mpc.prediction is None:
        from otolith.cueing.prediction.adaptive import Adaptive

        for name in ("near", "far", "slope"):
            value = getattr(Adaptive(), name)
            space[f"prediction.{name}"] = _log(value / 4.0, 4.0 * value)
            start[f"prediction.{name}"] = value
    return space, (start,)


def _implicit(design: Design) -> Space:  # noqa: ARG001 (as all of them)
    """Return constant washout weights, beginning with the preset `constant-fit`."""
    space = {"weight.velocity": _log(1e-3, 1e2), "weight.position": _log(1e-4, 1e2)}
    return space, ({"weight.velocity": 0.411, "weight.position": 0.0131},)


_SPACES: Final[Mapping[str, Callable[[Design], Space]]] = {
    "predictive": _predictive,
    "implicit": _implicit,
    "hybrid-all": _implicit,
    "classical": _classical,
    "optimal": _optimal,
}
TUNED: Final = tuple(_SPACES)


def _travelling(dofs: Sequence[Dof]) -> list[str]:
    return [AXES[i] for dof in dofs for i in dof.axes if i < len(AXES) // 2]


def _at(tables: Mapping[str, Any], name: str) -> float:
    """Return a value of a tuning by the name of its setting."""
    value: Any = tables
    for part in name.split(".")[1:]:
        value = value[part]
    return float(value)


def _inside(parameter: Parameter, value: float) -> float:
    low, high = parameter.low, parameter.high
    return value if low is None or high is None else min(max(value, low), high)
