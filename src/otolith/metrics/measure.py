"""The definition of a key figure, from which summaries, tables, rankings, gauges and pages are made.

The entries themselves are in `otolith.metrics.catalogue`.
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
    """The direction in which a figure is better; neutral if neither is."""

    LOWER = "smaller"
    HIGHER = "greater"
    NEUTRAL = "neither"

    def of_all(self, values: Sequence[float]) -> float:
        """Return the best of some numbers; the smallest if neither direction is better."""
        return max(values) if self is Better.HIGHER else min(values)


class Topic(StrEnum):
    """The topic of a figure. The table of a comparison shows its columns in this order."""

    FELT = "what the driver feels"
    PLATFORM = "what the platform did"
    DECISION = "what the decisions took and came to"
    SOLVER = "what the solver did"  # shown as a dash for an algorithm that solves no problem


@dataclass(frozen=True, slots=True)
class Column:
    """One number of a measure's value: a column of a comparison, and a criterion of rankings."""

    head: str  # heading of the column, without the unit; if empty, the table does not show it
    of: Callable[[Any], Any] = lambda value: value  # computes the number from the measure's value
    words: str = ""  # name of the number in rankings and diagrams; by default the measure's
    unit: str | None = None  # SI; by default the measure's
    by: str = ""  # its name for `otolith compare --by`; empty if it is no criterion
    says: str = ""  # sentence below its diagram of all algorithms and scenarios; empty for no diagram
    against: bool = False  # whether a column follows with its change against a baseline [%]

    @property
    def heading(self) -> str:
        """Return the heading with the unit in which pages show the number."""
        return f"{self.head} [{in_degrees(self.unit)}]" if self.unit else self.head

    def number(self, value: Any) -> Any:
        """Return the number of a measure's value in SI units; None if the value is None or empty."""
        return None if value is None or value == {} else self.of(value)

    def in_degrees(self, number: Any) -> Any:
        """Convert the number to the unit of `heading`; None stays None."""
        return math.degrees(number) if number is not None and "rad" in (self.unit or "") else number


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading:
    """A value on its scale."""

    value: str  # with its unit, for readers
    share: float  # position on the scale from its left end; beyond 1 it is off the scale
    words: str  # explanation of the value


@dataclass(frozen=True, slots=True, kw_only=True)
class Scale:
    """A scale whose two ends are facts, which gives a value its meaning."""

    title: str
    ends: tuple[str, str]  # meaning of the left and of the right end
    read: Callable[[Summary], Reading | None]  # None if the summary lacks the figures


@dataclass(frozen=True, slots=True, kw_only=True)
class Measure:
    """One key figure of a run: its name, its computation, and how it is shown to readers.

    A value is a plain JSON value in SI units: a number, or a mapping of numbers by degree of freedom, by
    axis, or by the names in `parts`. It is None where the figure is undefined.
    """

    name: str  # its key in a summary
    words: str
    unit: str  # SI, empty if there is none; "m, rad" for several kinds of axes
    of: Callable[["Run"], Any] | None  # None if only a comparison defines it
    better: Better = Better.NEUTRAL
    topic: Topic = Topic.FELT
    needs: tuple[str, ...] = EVERY_DOF  # defined if at least one of these was cued
    optional: bool = False  # whether summaries leave it out where it is undefined
    columns: tuple[Column, ...] = ()
    line: Callable[[Any], str] | None = None  # text of the value in the printed line of a run
    scale: Scale | None = None
    in_words: Callable[[Summary], str] | None = None  # text on pages, if it replaces the numbers of the value
    # Key inside the value -> words and unit
    parts: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    listed: bool = True  # whether it appears in the list of all figures; False if a page has a separate table
    section: str  # heading of docs/metrics.md under which it is defined

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
        """Return whether some of its values are angles or their rates."""
        return "rad" in self.unit

    def defined(self, dofs: Sequence[str]) -> bool:
        """Return whether it is defined for a run that cued these degrees of freedom."""
        return bool(set(self.needs) & set(dofs))

    def shown(self, value: Any) -> Any:
        """Return the value with angles in degrees, as in the diagrams."""
        if not self.turns or value is None:
            return value
        if isinstance(value, Mapping):
            return {axis: math.degrees(v) if axis in _TURNING else v for axis, v in value.items()}
        return math.degrees(value)


def in_degrees(unit: str | None) -> str:
    """Return the unit in which pages show a value that a summary stores in `unit`."""
    return (unit or "").replace("rad", "deg")


def root_sum_square(values: Mapping[str, float]) -> float:
    """Return √Σ v², the total error along several axes."""
    return math.sqrt(sum(value**2 for value in values.values()))
