"""What `otolith tune` varies of each algorithm, and the settings that it tries first."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

from otolith import registry
from otolith.core.frames import AXES, Dof
from otolith.cueing.design import Design
from otolith.cueing.washout.tuning import Classical, Optimal, load_tuning, tunings
from otolith.platforms.axes import Translation
from otolith.studies.definition import Parameter
from otolith.studies.settings import Settings

_REACH: Final = 0.5  # [m] of the platform for which the tuning is made that others begin with

Space = tuple[dict[str, Parameter], tuple[Settings, ...]]  # and what is tried first


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


SPACES: Final[Mapping[str, Callable[[Design], Space]]] = {
    "predictive": _predictive,
    "implicit": _implicit,
    "hybrid-all": _implicit,
    "classical": _classical,
    "optimal": _optimal,
}


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
