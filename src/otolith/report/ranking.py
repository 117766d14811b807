"""Who did best: a measure, an order within each scenario, and one over all of them.

The rule. Within a scenario, algorithms that kept every hard limit come before those that passed one; a limit
that is soft for one of them is held against none. Among equals the better measure decides; equal measures
share a rank. Over several scenarios the mean rank decides, then whether every hard limit was kept in all of
them, then the mean of the measure relative to the scenario's best. There are no weights to argue about.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from otolith.core.errors import InputError, one_of
from otolith.core.frames import PAIRS
from otolith.metrics import MEASURES, Better, Column, Measure
from otolith.metrics.measure import Summary, in_degrees

ByCueing = Mapping[str, Summary]  # the summaries of one scenario
_EQUAL: Final = 1e-9  # measures closer than this, relative to them, are equal


@dataclass(frozen=True, slots=True)
class Criterion:
    """What runs are ranked by: one number of a measure."""

    measure: Measure
    column: Column

    @property
    def words(self) -> str:
        """What the number is called."""
        return self.column.words

    @property
    def unit(self) -> str:
        """Unit in which pages show the number: what turns, in degrees."""
        return in_degrees(self.column.unit)

    @property
    def label(self) -> str:
        """Words and unit."""
        return f"{self.words} [{self.unit}]" if self.unit else self.words

    @property
    def better(self) -> Better:
        """Which way it is better."""
        return self.measure.better

    def of(self, summary: Summary) -> float:
        """The number of a run, SI; NaN where its summary does not hold it."""
        value = self.column.number(summary.get(self.measure.name))
        return math.nan if value is None else float(value)

    def shown(self, number: float) -> float:
        """A number that `of` gives, in `unit`."""
        return float(self.column.in_degrees(number))


def criterion(name: str, head: str) -> Criterion:
    """The number that the measure `name` shows in the column `head` of a comparison."""
    measure = MEASURES[name]
    return Criterion(measure, next(column for column in measure.columns if column.head == head))


def criteria(dofs: Sequence[str] | None = None) -> dict[str, Criterion]:
    """What runs can be ranked by, by the name on the command line, where these degrees of freedom are cued.

    Without `dofs`, what runs of any degrees of freedom can be ranked by.
    """
    return {
        column.by: Criterion(measure, column)
        for measure in MEASURES.values()
        for column in measure.columns
        if column.by and (dofs is None or measure.defined(dofs))
    }


def criterion_named(name: str, dofs: Sequence[str] = PAIRS) -> Criterion:
    """Look one of `criteria` up, or say in one sentence which there are for these degrees of freedom."""
    known = criteria(dofs)
    if name not in known:
        where = "" if name not in criteria() else f" where {','.join(dofs)} is cued"
        raise InputError("--by", repr(name), one_of(known, name) + where)
    return known[name]


@dataclass(frozen=True, slots=True, kw_only=True)
class Standing:
    """One algorithm's place."""

    cueing: str
    ranks: tuple[int, ...]  # one per scenario, 1 is best
    values: tuple[float, ...]  # of the measure
    broken: tuple[int, ...]  # controller nodes beyond a hard limit

    @property
    def mean_rank(self) -> float:
        """Over the scenarios."""
        return sum(self.ranks) / len(self.ranks)

    @property
    def wins(self) -> int:
        """Scenarios in which nobody was better."""
        return self.ranks.count(1)

    def as_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "cueing": self.cueing,
            "mean_rank": self.mean_rank,
            "wins": self.wins,
            "ranks": list(self.ranks),
            "values": list(self.values),
            "limit_violations": list(self.broken),
        }


def standings(scenarios: Mapping[str, ByCueing], by: Criterion) -> list[Standing]:
    """All algorithms, best first; every scenario has the same ones.

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
    """Nodes at which each passed a hard limit; a limit that is soft for one of them is held against none."""
    limits = [one.get("limits", {}) for one in summaries]
    soft = {name for of_one in limits for name, limit in of_one.items() if limit["soft"]}
    forgiven = [
        sum(limit["nodes_beyond"] for name, limit in of_one.items() if name in soft and not limit["soft"])
        for of_one in limits
    ]
    return [int(one.get("violations") or 0) - free for one, free in zip(summaries, forgiven, strict=True)]


def _ranks(values: Sequence[float], broken: Sequence[int], better: Better) -> list[int]:
    """1 for the best; equal ones share a rank, and as many of the next ranks are left out."""
    sign = -1.0 if better is Better.HIGHER else 1.0
    keys = [(count > 0, sign * value) for value, count in zip(values, broken, strict=True)]
    return [1 + sum(_before(other, key) for other in keys) for key in keys]


def _before(one: tuple[bool, float], other: tuple[bool, float]) -> bool:
    if one[0] != other[0]:
        return other[0]
    return one[1] < other[1] - _EQUAL * abs(other[1])


def _relative(values: Sequence[float], best: Sequence[float], better: Better) -> float:
    """How far the values are from the best ones, as a sum of ratios that are at least 1."""
    pairs = zip(values, best, strict=True)
    if better is Better.HIGHER:
        return sum(
            math.inf if value <= 0.0 < most else most / value if most > 0.0 else 1.0 for value, most in pairs
        )
    return sum(value / least if least > 0.0 else 1.0 for value, least in pairs)
