"""The result of reproducing a table, figure or study: plain values, ready for JSON and for a page."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any, Final, Literal

from otolith.core.arrays import Vec
from otolith_thesis.verdict import Number, Verdict

Kind = Literal["table", "figure", "study"]
Cell = str | float | int | bool | None
POINTS: Final = 1000  # largest number of points of a curve; more than a page shows


class Bearing(StrEnum):
    """The conclusion of a study about the numbers of a table."""

    ADOPTED = "adopted"  # it decided between readings; the table shows the better one
    EXPLAINS = "explains"  # it explains remaining differences, at least in part
    EXCLUDED = "excluded"  # it does not explain them


@dataclass(frozen=True, slots=True, kw_only=True)
class Claim:
    """A statement of the thesis about its table, and whether our numbers confirm it."""

    text: str
    holds: bool
    figures: str  # the deciding numbers


@dataclass(frozen=True, slots=True, kw_only=True)
class Grid:
    """Further numbers in rows and columns: distributions, other readings, an experiment."""

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Curve:
    """Points joined by a line; if `right`, it belongs to the right-hand axis."""

    label: str
    x: Vec
    y: Vec
    dash: bool = False
    right: bool = False

    def thinned(self) -> dict[str, Any]:
        """Return plain values of at most `POINTS` points."""
        every = max(1, -(-len(self.x) // POINTS))
        x, y = self.x[::every], self.y[::every]
        return {
            "label": self.label,
            "x": [round(float(value), 4) for value in x],
            "y": [float(f"{value:.5g}") for value in y],
            "dash": self.dash,
            "right": self.right,
        }


@dataclass(frozen=True, slots=True, kw_only=True)
class Panel:
    """One diagram: curves over a common axis."""

    title: str
    x_label: str
    y_label: str
    curves: tuple[Curve, ...]
    right_label: str = ""
    log_x: bool = False
    equal: bool = False  # whether both axes have one scale, as on a map

    def as_json(self) -> dict[str, Any]:
        """Return plain JSON values."""
        return {
            "title": self.title,
            "x_label": self.x_label,
            "y_label": self.y_label,
            "right_label": self.right_label,
            "log_x": self.log_x,
            "equal": self.equal,
            "curves": [curve.thinned() for curve in self.curves],
        }


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """One reproduced item of the thesis."""

    name: str  # e.g. "table-5.5"
    kind: Kind
    title: str
    section: str
    text: str = ""  # what was done and what it shows
    numbers: tuple[Number, ...] = ()
    claims: tuple[Claim, ...] = ()
    grids: tuple[Grid, ...] = ()
    panels: tuple[Panel, ...] = ()
    reasons: tuple[str, ...] = ()  # names of the studies that examine why numbers differ
    bears_on: Mapping[str, Bearing] = field(default_factory=dict)  # for a study: its conclusion by table

    @property
    def conclusion_holds(self) -> bool:
        """Return whether every claim holds."""
        return all(claim.holds for claim in self.claims)

    def counts(self) -> dict[str, int]:
        """Count the numbers by verdict."""
        found = Counter(number.verdict for number in self.numbers)
        return {verdict.value: found[verdict] for verdict in Verdict}

    def as_json(self) -> dict[str, Any]:
        """Return plain JSON values; `agree` counts the numbers within 10 %."""
        counts = self.counts()
        return {
            "kind": self.kind,
            "title": self.title,
            "section": self.section,
            "text": self.text,
            "agree": counts[Verdict.AGREES.value] + counts[Verdict.CLOSE.value],
            "total": len(self.numbers),
            "conclusion_holds": self.conclusion_holds,
            "verdicts": counts,
            "numbers": [_number(number) for number in self.numbers],
            "claims": [
                {"text": claim.text, "holds": claim.holds, "figures": claim.figures} for claim in self.claims
            ],
            "grids": [
                {"title": grid.title, "header": list(grid.header), "rows": [list(row) for row in grid.rows]}
                for grid in self.grids
            ],
            "panels": [panel.as_json() for panel in self.panels],
            "reasons": list(self.reasons),
            "bears_on": {table: bearing.value for table, bearing in self.bears_on.items()},
        }


def _number(number: Number) -> dict[str, Any]:
    return {
        "row": number.row,
        "column": number.column,
        "published": number.published,
        "at_least": number.at_least,
        "ours": number.ours,
        "ratio": number.ratio,
        "verdict": number.verdict.value,
    }


def columns_of(numbers: Sequence[Number]) -> list[str]:
    """Return the columns of a table in order."""
    return list(dict.fromkeys(number.column for number in numbers))
