"""A study as its TOML file states it, checked before anything runs.

Names of parameters are those of `otolith.studies.settings`, and names of measures those of
`otolith.studies.measures`.
"""

import math
from collections.abc import Mapping
from importlib.resources import files
from typing import Any, Final, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from otolith.core.errors import InputError, one_of
from otolith.platforms.bounds import refuse
from otolith.platforms.validation_messages import sentence, toml_fields
from otolith.studies.measures import AVERAGES, MEASURES
from otolith.studies.settings import check_names

Value = float | int | str
_FOLDER: Final = files("otolith.studies") / "catalog"


class _Table(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)


class Parameter(_Table):
    """One parameter: its scale and its range, or its choices."""

    scale: Literal["linear", "log", "integer", "choice"] = "linear"
    low: float | None = None  # both bounds belong to the range
    high: float | None = None
    step: int = Field(default=1, ge=1)  # of an integer
    of: tuple[float | int | str, ...] = ()  # the choices

    @model_validator(mode="before")
    @classmethod
    def _lists(cls, values: Any) -> Any:
        """Read TOML's arrays as tuples, and its whole numbers as bounds."""
        if isinstance(values, dict):
            values = dict(values)
            if isinstance(values.get("of"), list):
                values["of"] = tuple(values["of"])
        return values

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.scale == "choice":
            if len(set(self.of)) < max(2, len(self.of)):
                raise refuse("at least two choices, each once", field="of", value=list(self.of))
        elif self.of:
            raise refuse('left out, or given with scale = "choice"', field="of", value=list(self.of))
        unread = {"choice": ("low", "high", "step"), "integer": ()}.get(self.scale, ("step",))
        for name in unread:
            value = getattr(self, name)
            if value != Parameter.model_fields[name].default:
                raise refuse(f"left out with a scale that is {self.scale}", field=name, value=value)
        if self.scale != "choice":
            self._check_range()
        return self

    def _check_range(self) -> None:
        if self.low is None or self.high is None:
            raise refuse("given", field="high" if self.high is None else "low", value="missing")
        if not -math.inf < self.low < self.high < math.inf:
            raise refuse(f"finite and more than low, {self.low:g}", field="high", value=self.high)
        if self.scale == "log" and not self.low > 0.0:
            raise refuse("greater than 0 on a logarithmic scale", field="low", value=self.low)
        if self.scale == "integer" and self.low % 1:
            raise refuse("a whole number", field="low", value=self.low)
        if self.scale == "integer" and (self.high - self.low) % self.step:
            raise refuse(f"low plus a multiple of step, {self.step}", field="high", value=self.high)

    def holds(self, value: float | int | str) -> bool:
        """Return whether a value is within the range, or one of the choices."""
        if self.low is None or self.high is None:
            return value in self.of
        return not isinstance(value, str) and self.low <= value <= self.high


class Reference(_Table):
    """A scenario, or a part of a recorded drive, and its treatment, named as the options of `otolith run`."""

    scenario: str | None = None
    log: str | None = None  # path, relative to the study's file
    from_s: float = Field(default=0.0, ge=0.0)
    to_s: float | None = None  # default: the end
    lowpass_hz: float | None = None
    causal: bool = False
    through: str | None = None
    scale: float = 1.0

    @model_validator(mode="after")
    def _check(self) -> Self:
        if (self.scenario is None) == (self.log is None):
            found = "missing" if self.scenario is None else "given next to log"
            raise refuse("given, or log", field="scenario", value=found)
        for name in ("lowpass_hz", "causal"):
            if self.scenario is not None and (value := getattr(self, name)):
                raise refuse("left out, or given with a log", field=name, value=value)
        if self.to_s is not None and not self.to_s > self.from_s:
            raise refuse(f"more than from_s, {self.from_s:g} s", field="to_s", value=self.to_s)
        return self


class Objective(_Table):
    """What is made small: a measure, and how its values over all references become one number."""

    measure: str
    over: str = "mean"

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.measure not in MEASURES:
            raise refuse(one_of(MEASURES, self.measure), field="measure", value=self.measure)
        if self.over not in AVERAGES:
            raise refuse(one_of(AVERAGES, self.over), field="over", value=self.over)
        return self


class Constraint(Objective):
    """A measure that must be at most a bound, on every reference unless `over` says otherwise."""

    over: str = "worst"
    most: float


class Budget(_Table):
    """How many settings are tried, and how they are chosen."""

    trials: int = Field(default=200, ge=1, le=1_000_000)
    sampler: Literal["nsga2", "tpe", "random"] = "nsga2"
    batch: int = Field(default=20, ge=2, le=10_000)  # settings that are chosen before any of them is known
    seed: int = Field(default=1, ge=0, le=2**31 - 1)
    timeout_s: float | None = Field(
        default=None, gt=0.0
    )  # of a job [s of CPU time]; longer ones are rejected
    # A trial that is not among this share [%] of the finished ones, by no objective, ends early; `prune`
    prune_percentile: float | None = Field(default=None, gt=0.0, lt=100.0)
    prune_after: int = Field(default=3, ge=1)  # number of references after which this is judged first


class Study(_Table):
    """A whole study; `parse_study` reads it."""

    name: str = Field(min_length=1, max_length=80)
    description: str = ""
    cueing: str
    platform: str = "thesis"  # a shipped name, or a path relative to the study's file
    plant: str | None = None
    dofs: str = "surge-pitch"
    fixed: Mapping[str, Value] = Field(default_factory=dict)  # settings that are the same in all trials
    parameters: Mapping[str, Parameter]
    start: tuple[Mapping[str, Value], ...] = ()  # settings that are tried first
    training: tuple[Reference, ...]
    judging: tuple[Reference, ...] = ()
    objectives: tuple[Objective, ...]
    constraints: tuple[Constraint, ...] = (
        Constraint(measure="violations", most=0.0),
        Constraint(measure="noticed", most=0.0),
    )
    budget: Budget = Budget()
    presets: Mapping[str, Mapping[str, float]] = Field(
        default_factory=dict
    )  # weights of objectives by preset

    @model_validator(mode="before")
    @classmethod
    def _read(cls, values: Any) -> Any:
        """Read a reference that is a text as a scenario, and TOML's arrays as tuples."""
        values = dict(values)
        for name in ("training", "judging"):
            if isinstance(values.get(name), list):
                values[name] = tuple({"scenario": r} if isinstance(r, str) else r for r in values[name])
        for name in ("start", "objectives", "constraints"):
            if isinstance(values.get(name), list):
                values[name] = tuple(values[name])
        return values

    @model_validator(mode="after")
    def _check(self) -> Self:
        for name in ("parameters", "training", "objectives"):
            if not getattr(self, name):
                raise refuse("given, at least one", field=name, value="none")
        names = [one.measure for one in self.objectives]
        if len(set(names)) < len(names):
            raise refuse("each measure once", field="objectives", value=", ".join(names))
        for number, start in enumerate(self.start):
            if set(start) != set(self.parameters):
                bound = f"one value for each of {', '.join(self.parameters)}"
                raise refuse(bound, field=f"start.{number}", value=", ".join(start) or "empty")
            for one, value in start.items():
                if not self.parameters[one].holds(value):
                    raise refuse("within the parameter's range", field=f"start.{number}.{one}", value=value)
        for preset, weights in self.presets.items():
            for one in weights:
                if one not in names:
                    raise refuse(one_of(names, one), field=f"presets.{preset}", value=one)
                if not 0.0 <= weights[one] < math.inf:
                    raise refuse("finite and at least 0", field=f"presets.{preset}.{one}", value=weights[one])
            if not sum(weights.values()):
                bound = "of a weight greater than 0 at least"
                raise refuse(bound, field=f"presets.{preset}", value="a table of none")
        return self

    @property
    def deterministic(self) -> bool:
        """Return whether results are the same whenever they are made: no measure and no bound is a time."""
        used = (*self.objectives, *self.constraints)
        return self.budget.timeout_s is None and not any(MEASURES[one.measure].timed for one in used)


def studies() -> tuple[str, ...]:
    """Return the names of the shipped studies, sorted."""
    names = (entry.name.removesuffix(".toml") for entry in _FOLDER.iterdir() if entry.name.endswith(".toml"))
    return tuple(sorted(names))


def load_study(name: str) -> Study:
    """Return a shipped study by name.

    Raises
    ------
    InputError : there is none of this name.
    """
    if name not in studies():
        raise InputError("study", repr(name), one_of(studies(), name, otherwise=", or a file (.toml)"))
    return parse_study((_FOLDER / f"{name}.toml").read_text(encoding="utf-8"), f"{name}.toml")


def parse_study(text: str, source: str) -> Study:
    """Read a study from the text of its TOML file.

    Raises
    ------
    InputError : the text is not TOML, or a value is refused; the sentence names the field.
    """
    fields = toml_fields(text, source)
    try:
        study = Study.model_validate(fields)
    except ValidationError as error:
        raise sentence(error, Study, source) from None
    check_names(study.cueing, [*study.fixed, *study.parameters])
    return study
