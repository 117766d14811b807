"""Who did best: a measure, an order within each scenario, and one over all of them.

The rule. Within a scenario, algorithms that kept every hard limit come before those that passed one; a limit
that is soft for one of them is held against none. Among equals the smaller measure is better; equal measures
share a rank. Over several scenarios the mean rank decides, then whether every hard limit was kept in all of
them, then the mean of the measure relative to the scenario's best. There are no weights to argue about.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from otolith.core.errors import InputError, one_of
from otolith.core.frames import DOFS, PAIRS

Summary = Mapping[str, Any]
ByCueing = Mapping[str, Summary]  # the summaries of one scenario
MISLEADING: Final = ("inverted", "unwanted", "missing")  # kinds of false cues; a scaled one does not mislead
_FORCE: Final = tuple(name for name, dof in DOFS.items() if not dof.feels_rate)
_RATE: Final = tuple(name for name, dof in DOFS.items() if dof.feels_rate)
_EQUAL: Final = 1e-9  # measures closer than this, relative to them, are equal


@dataclass(frozen=True, slots=True)
class Measure:
    """What is ranked by: smaller is better."""

    words: str
    unit: str
    of: Callable[[Summary], float]
    needs: tuple[str, ...] = ()  # degrees of freedom, of which one must be cued for it to be defined


def tracking(summary: Summary) -> float:
    """RMSE of the felt specific force over all axes [m/s²]; NaN where none was cued."""
    value = summary.get("rmse")
    return math.nan if value is None else float(value)


def misleading(summary: Summary) -> float:
    """Time with inverted, unwanted or missing cues over all axes [s]."""
    kinds = summary.get("false_cues", {}).values()
    return float(sum(of_axis[kind]["duration_s"] for of_axis in kinds for kind in MISLEADING))


def perceived(summary: Summary) -> float:
    """RMSE of the sensed specific force over all axes [m/s²]."""
    return math.sqrt(sum(value**2 for value in summary.get("perceived_rmse", {}).values()))


def turning(summary: Summary) -> float:
    """RMSE of the wanted angular rate over all axes cued for it [rad/s]."""
    return math.sqrt(sum(value**2 for value in summary.get("rate_rmse", {}).values()))


def largest_use(summary: Summary) -> float:
    """Largest share of the reach used along any axis; above 1 the platform would have hit its end."""
    return max((use["largest"] for use in summary.get("workspace", {}).values()), default=0.0)


MEASURES: Final = {
    "rmse": Measure("Tracking error (RMSE)", "m/s²", tracking, _FORCE),
    "perceived": Measure("Perceived error (RMSE)", "m/s²", perceived, _FORCE),
    "false-cues": Measure("Time with misleading cues", "s", misleading, _FORCE),
    "rate": Measure("Yaw rate error (RMSE)", "rad/s", turning, _RATE),
}


def measures_for(dofs: Sequence[str]) -> dict[str, Measure]:
    """Those of `MEASURES` that are defined where these degrees of freedom are cued."""
    return {name: measure for name, measure in MEASURES.items() if set(measure.needs) & set(dofs)}


def measure_named(name: str, dofs: Sequence[str] = PAIRS) -> Measure:
    """Look one of `MEASURES` up, or say in one sentence which there are for these degrees of freedom."""
    known = measures_for(dofs)
    if name not in known:
        where = "" if name not in MEASURES else f" where {','.join(dofs)} is cued"
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


def standings(scenarios: Mapping[str, ByCueing], measure: Measure) -> list[Standing]:
    """All algorithms, best first; every scenario has the same ones.

    Raises
    ------
    ValueError : there is no scenario, or one lacks an algorithm.
    """
    names = list(next(iter(scenarios.values()), {}))
    if not names or any(set(summaries) != set(names) for summaries in scenarios.values()):
        raise ValueError("a ranking needs the same algorithms in every scenario, and at least one")
    values = [[measure.of(summaries[name]) for name in names] for summaries in scenarios.values()]
    broken = [_broken([summaries[name] for name in names]) for summaries in scenarios.values()]
    ranks = [_ranks(*of_scenario) for of_scenario in zip(values, broken, strict=True)]
    found = [
        Standing(
            cueing=name,
            ranks=tuple(row[i] for row in ranks),
            values=tuple(row[i] for row in values),
            broken=tuple(row[i] for row in broken),
        )
        for i, name in enumerate(names)
    ]
    best = [min(row) for row in values]
    return sorted(found, key=lambda one: (one.mean_rank, any(one.broken), _relative(one.values, best)))


def _broken(summaries: Sequence[Summary]) -> list[int]:
    """Nodes at which each passed a hard limit; a limit that is soft for one of them is held against none."""
    limits = [one.get("limits", {}) for one in summaries]
    soft = {name for of_one in limits for name, limit in of_one.items() if limit["soft"]}
    forgiven = [
        sum(limit["nodes_beyond"] for name, limit in of_one.items() if name in soft and not limit["soft"])
        for of_one in limits
    ]
    return [int(one.get("violations") or 0) - free for one, free in zip(summaries, forgiven, strict=True)]


def _ranks(values: Sequence[float], broken: Sequence[int]) -> list[int]:
    keys = [(count > 0, value) for value, count in zip(values, broken, strict=True)]
    return [1 + sum(_better(other, key) for other in keys) for key in keys]


def _better(one: tuple[bool, float], other: tuple[bool, float]) -> bool:
    if one[0] != other[0]:
        return other[0]
    return one[1] < other[1] - _EQUAL * abs(other[1])


def _relative(values: Sequence[float], best: Sequence[float]) -> float:
    return sum(value / least if least > 0.0 else 1.0 for value, least in zip(values, best, strict=True))
