"""Ranking of algorithms by a measure, within each scenario and over all of them.

The rule: within a scenario, algorithms that kept every hard limit come before those that passed one. A limit
that is soft for one algorithm counts against none. Among equals the better measure decides; equal measures
share a rank. Over several scenarios the mean rank decides, then whether every hard limit was kept in all of
them, then the mean of the measure relative to the scenario's best. There are no weights.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from otolith.core.errors import InputError, one_of
from otolith.core.frames import PAIRS
from otolith.metrics import MEASURES, Better, Column, Measure
from otolith.metrics.measure import Summary, in_degrees

ByCueing = Mapping[str, Summary]  # the summaries of one scenario by algorithm
_EQUAL: Final = 1e-9  # measures with a smaller relative difference are equal


@dataclass(frozen=True, slots=True)
class Criterion:
    """The criterion of a ranking: one number of a measure."""

    measure: Measure
    column: Column

    @property
    def words(self) -> str:
        """Return the name of the number in words."""
        return self.column.words

    @property
    def unit(self) -> str:
        """Return the unit in which pages show the number; angles are in degrees."""
        return in_degrees(self.column.unit)

    @property
    def label(self) -> str:
        """Return words and unit."""
        return f"{self.words} [{self.unit}]" if self.unit else self.words

    @property
    def better(self) -> Better:
        """Return which direction is better."""
        return self.measure.better

    def of(self, summary: Summary) -> float:
        """Return the number of a run in SI units; NaN if its summary does not contain it."""
        value = self.column.number(summary.get(self.measure.name))
        return math.nan if value is None else float(value)

    def shown(self, number: float) -> float:
        """Convert a number of `of` to `unit`."""
        return float(self.column.in_degrees(number))


def criterion(name: str, head: str) -> Criterion:
    """Return the number that measure `name` shows in column `head` of a comparison."""
    measure = MEASURES[name]
    return Criterion(measure, next(column for column in measure.columns if column.head == head))


def criteria(dofs: Sequence[str] | None = None) -> dict[str, Criterion]:
    """Return the criteria, by their name on the command line, for these degrees of freedom.

    Without `dofs`, return the criteria for any degrees of freedom.
    """
    return {
        column.by: Criterion(measure, column)
        for measure in MEASURES.values()
        for column in measure.columns
        if column.by and (dofs is None or measure.defined(dofs))
    }


def criterion_named(name: str, dofs: Sequence[str] = PAIRS) -> Criterion:
    """Look up one of `criteria`, or refuse an unknown name with a list of those that exist.

    Raises
    ------
    InputError : no criterion of these degrees of freedom has this name.
    """
    known = criteria(dofs)
    if name not in known:
        where = "" if name not in criteria() else f" where {','.join(dofs)} is cued"
        raise InputError("--by", repr(name), one_of(known, name) + where)
    return known[name]


@dataclass(frozen=True, slots=True, kw_only=True)
class Standing:
    """The place of one algorithm in a ranking."""

    cueing: str
    ranks: tuple[int, ...]  # one per scenario; 1 is best
    values: tuple[float, ...]  # values of the measure, one per scenario
    broken: tuple[int, ...]  # numbers of controller nodes beyond a hard limit, one per scenario

    @property
    def mean_rank(self) -> float:
        """Return the mean rank over the scenarios."""
        return sum(self.ranks) / len(self.ranks)

    @property
    def wins(self) -> int:
        """Return the number of scenarios in which no algorithm was better."""
        return self.ranks.count(1)

    def as_json(self) -> dict[str, Any]:
        """Return plain JSON values."""
        return {
            "cueing": self.cueing,
            "mean_rank": self.mean_rank,
            "wins": self.wins,
            "ranks": list(self.ranks),
            "values": list(self.values),
            "limit_violations": list(self.broken),
        }


def standings(scenarios: Mapping[str, ByCueing], by: Criterion) -> list[Standing]:
    """Rank all algorithms, best first; every scenario must have the same ones.

    Raises
    ------
    ValueError : there is no scenario, or one lacks an algorithm.
    """
    names = list(next(iter(scenarios.values()), {}))
    if not names or any(set(summaries) != set(names) for summaries in scenarios.values()):
        raise ValueError("a ranking needs the same algorithms in every scenario, and at least one")
    values = [[by.of(summaries[name]) for name in names] for summaries in scenarios.values()]
    broken = [_broken([summaries[name] for name in names]) for summaries in scenarios.values()]
    ranks = [_ranks(*of_scenario, by.better) for of_scenario in zip(values, broken, strict=True)]
    found = [
        Standing(
            cueing=name,
            ranks=tuple(row[i] for row in ranks),
            values=tuple(row[i] for row in values),
            broken=tuple(row[i] for row in broken),
        )
        for i, name in enumerate(names)
    ]
    best = [by.better.of_all(row) for row in values]
    return sorted(
        found, key=lambda one: (one.mean_rank, any(one.broken), _relative(one.values, best, by.better))
    )


def _broken(summaries: Sequence[Summary]) -> list[int]:
    """Count the nodes at which each passed a hard limit that is soft for none of them."""
    limits = [one.get("limits", {}) for one in summaries]
    soft = {name for of_one in limits for name, limit in of_one.items() if limit["soft"]}
    forgiven = [
        sum(limit["nodes_beyond"] for name, limit in of_one.items() if name in soft and not limit["soft"])
        for of_one in limits
    ]
    return [int(one.get("violations") or 0) - free for one, free in zip(summaries, forgiven, strict=True)]


def _ranks(values: Sequence[float], broken: Sequence[int], better: Better) -> list[int]:
    """Return the ranks, 1 for the best; equal ones share a rank, and the following ranks are skipped."""
    sign = -1.0 if better is Better.HIGHER else 1.0
    keys = [(count > 0, sign * value) for value, count in zip(values, broken, strict=True)]
    return [1 + sum(_before(other, key) for other in keys) for key in keys]


def _before(one: tuple[bool, float], other: tuple[bool, float]) -> bool:
    if one[0] != other[0]:
        return other[0]
    return one[1] < other[1] - _EQUAL * abs(other[1])


def _relative(values: Sequence[float], best: Sequence[float], better: Better) -> float:
    """Return the sum of ratios, each at least 1, between the values and the best ones."""
    pairs = zip(values, best, strict=True)
    if better is Better.HIGHER:
        return sum(
            math.inf if value <= 0.0 < most else most / value if most > 0.0 else 1.0 for value, most in pairs
        )
    return sum(value / least if least > 0.0 else 1.0 for value, least in pairs)
