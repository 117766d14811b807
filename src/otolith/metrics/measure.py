"""What a key figure is: one entry, from which summaries, tables, rankings, gauges and pages are made.

The entries themselves stand in `otolith.metrics.catalogue`.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import TYPE_CHECKING, Any, Final

from otolith.core.frames import DOFS

if TYPE_CHECKING:
    from otolith.loop import Run

Summary = Mapping[str, Any]  # key figures of one run by name, plain JSON values
EVERY_DOF: Final = tuple(DOFS)
FORCES: Final = tuple(name for name, dof in DOFS.items() if not dof.feels_rate)
RATES: Final = tuple(name for name, dof in DOFS.items() if dof.feels_rate)
_TURNING: Final = frozenset({"roll", "pitch", "yaw"})


class Better(StrEnum):
    """Which way a figure is better; neutral where neither way is."""

    LOWER = "smaller"
    HIGHER = "greater"
    NEUTRAL = "neither"

    def of_all(self, values: Sequence[float]) -> float:
        """The best of some numbers; the smallest where neither way is better."""
        return max(values) if self is Better.HIGHER else min(values)


class Topic(StrEnum):
    """What a figure is about. The table of a comparison shows its columns in this order."""

    FELT = "what the driver feels"
    PLATFORM = "what the platform did"
    DECISION = "what the decisions took and came to"
    SOLVER = "what the solver did"  # shown as a dash for an algorithm that solves no problem


@dataclass(frozen=True, slots=True)
class Column:
    """One number of a measure's value: a column in the table of a comparison, and what runs are ranked by."""

    head: str  # heading of the column, without the unit; with "", the table does not show it
    of: Callable[[Any], Any] = lambda value: value  # the measure's value -> the number
    words: str = ""  # what the number is called in rankings and diagrams; the measure's own unless given
    unit: str | None = None  # SI; the measure's own unless given
    by: str = ""  # its name for `otolith compare --by`; without one, runs are not ranked by it
    says: str = ""  # sentence below its diagram of all algorithms and scenarios; none is drawn without one
    against: bool = False  # a column follows with its change against a baseline [%]

    @property
    def heading(self) -> str:
        """Head with the unit in which pages show it."""
        return f"{self.head} [{in_degrees(self.unit)}]" if self.unit else self.head

    def number(self, value: Any) -> Any:
        """The number of a measure's value, SI; None where the value is None or has no entries."""
        return None if value is None or value == {} else self.of(value)

    def in_degrees(self, number: Any) -> Any:
        """The number in the unit of `heading`; None stays None."""
        return math.degrees(number) if number is not None and "rad" in (self.unit or "") else number


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading:
    """A value on its scale."""

    value: str  # with its unit
    share: float  # of the scale's length, from its left end; beyond 1 it is off the scale
    words: str  # what the value is


@dataclass(frozen=True, slots=True, kw_only=True)
class Scale:
    """What gives a value meaning to a reader: a scale from a fact to a fact."""

    title: str
    ends: tuple[str, str]  # what the left and the right end of the scale mean
    read: Callable[[Summary], Reading | None]  # None where the summary does not hold what it takes


@dataclass(frozen=True, slots=True, kw_only=True)
class Measure:
    """One key figure of a run: what it is called, how it is computed, and how a reader is shown it.

    A value is a plain JSON value in SI units: a number, or a mapping of numbers by degree of freedom, by
    axis, or by the names in `parts`; None where it is not defined.
    """

    name: str  # its key in a summary
    words: str
    unit: str  # SI, "" where it has none; of several kinds of axes "m, rad"
    of: Callable[["Run"], Any] | None  # None where only a comparison defines it
    better: Better = Better.NEUTRAL
    topic: Topic = Topic.FELT
    needs: tuple[str, ...] = EVERY_DOF  # it is defined where at least one of these was cued
    optional: bool = False  # where it is not defined, summaries leave it out instead of None or no entries
    columns: tuple[Column, ...] = ()
    line: Callable[[Any], str] | None = None  # how the printed line of a run states the value
    scale: Scale | None = None
    parts: Mapping[str, tuple[str, str]] = field(default_factory=dict)  # key inside it -> words and unit
    listed: bool = True  # stands in the list of all figures; False where a page has a table of its own
    section: str  # heading of docs/metrics.md below which it is defined

    def __post_init__(self) -> None:
        filled = (
            replace(one, words=one.words or self.words, unit=self.unit if one.unit is None else one.unit)
            for one in self.columns
        )
        object.__setattr__(self, "columns", tuple(filled))
        if self.better is Better.NEUTRAL and any(one.by for one in self.columns):
            raise ValueError(f"{self.name}: what runs are ranked by needs a better way, lower or higher")

    @property
    def turns(self) -> bool:
        """Return whether some of its values are angles, or rates of them."""
        return "rad" in self.unit

    def defined(self, dofs: Sequence[str]) -> bool:
        """Return whether it is defined for a run that cued these degrees of freedom."""
        return bool(set(self.needs) & set(dofs))

    def shown(self, value: Any) -> Any:
        """The value with what turns in degrees, as in the diagrams."""
        if not self.turns or value is None:
            return value
        if isinstance(value, Mapping):
            return {axis: math.degrees(v) if axis in _TURNING else v for axis, v in value.items()}
        return math.degrees(value)


def in_degrees(unit: str | None) -> str:
    """The unit in which pages show what a summary keeps in `unit`."""
    return (unit or "").replace("rad", "deg")


def root_sum_square(values: Mapping[str, float]) -> float:
    """√Σ v²: errors along several axes as one."""
    return math.sqrt(sum(value**2 for value in values.values()))
