"""Whether the platform stayed within its limits, judged by its motion and its file alone.

Nothing here is shared with the controllers. This module reads the motion of the plant and the platform file,
so that a controller's wrong model or constraint cannot hide its own violation. It distinguishes two
questions. A limit protects the machine (travel, angle, speed, acceleration) or the driver's comfort (the tilt
rate below which tilting is not noticed). And the algorithm treated it as hard, or as soft, with a penalty for
violating it (`Run.soft`).
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.frames import AXES, DOFS, Dof
from otolith.loop import Run

TOLERANCE: Final = 1e-6  # excess that is ignored, in the SI unit of each quantity
_SERIES: Final = {  # field of a run -> name along an axis, name about an axis, unit after m or deg
    "pose": ("position", "angle", ""),
    "twist": ("velocity", "rate", "/s"),
    "acceleration": ("acceleration", "acceleration", "/s²"),
    "command": ("commanded acceleration", "commanded acceleration", "/s²"),
}
_MOVED: Final = {
    "pose": "position",
    "twist": "velocity",
    "acceleration": "acceleration",
    "command": "command",
}
_TILTED: Final = {
    "pose": "tilt",
    "twist": "tilt_rate",
    "acceleration": "tilt_acceleration",
    "command": "tilt_command",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Excess:
    """How far one quantity exceeded its limit; 0 if it never did."""

    quantity: str  # e.g. "surge-pitch tilt_rate"
    name: str  # in words, e.g. "pitch rate"
    unit: str  # for readers: m, m/s, m/s², deg, deg/s or deg/s²
    limit: tuple[float, float]  # low and high [SI]
    soft: bool  # whether the algorithm may exceed it, with a penalty
    comfort: bool  # whether it protects the driver's comfort, not the machine
    at_nodes: float  # largest excess at the controller's nodes [SI]
    between_nodes: float  # largest excess at any plant sample [SI]
    violations: int  # number of nodes with an excess above TOLERANCE

    def as_json(self) -> dict[str, Any]:
        """Return plain JSON values in `unit`; an excess that is not finite becomes None.

        An excess up to `TOLERANCE` is ignored and becomes 0.
        """
        scale = math.degrees(1.0) if self.unit.startswith("deg") else 1.0
        passed = [value if value > TOLERANCE else 0.0 for value in (self.at_nodes, self.between_nodes)]
        scaled = [scale * value for value in (*self.limit, *passed)]
        low, high, at_nodes, anywhere = (value if math.isfinite(value) else None for value in scaled)
        return {
            "name": self.name,
            "soft": self.soft,
            "comfort": self.comfort,
            "unit": self.unit,
            "low": low,
            "high": high,
            "nodes_beyond": self.violations,
            "excess": at_nodes,
            "excess_between_nodes": anywhere,
        }


def excesses(run: Run) -> list[Excess]:
    """Return one `Excess` per limited quantity of every cued degree of freedom.

    An MPC imposes limits at its nodes only. Between them the motion may exceed a limit by what one period
    allows, which `between_nodes` shows.
    """
    limited = _limited(run)
    worst: list[tuple[float, float, int]] = [(0.0, 0.0, 0)] * len(limited)
    for part in run.parts():
        series = _series(part)
        for k, one in enumerate(limited):
            beyond = _beyond(one.of(series), *one.limit)
            at_nodes = one.at_nodes(part, beyond)
            node, anywhere, violations = worst[k]
            worst[k] = (
                max(node, float(np.max(at_nodes, initial=0.0))),
                max(anywhere, float(np.max(beyond, initial=0.0))),
                violations + int(np.count_nonzero(at_nodes > TOLERANCE)),
            )
    return [_excess(run, one, *judged) for one, judged in zip(limited, worst, strict=True)]


def largest_use(run: Run) -> float:
    """Return the largest share of a limit of the machine that is used at a node: 1 at the limit.

    Limits that the algorithm may exceed with a penalty do not count.
    """
    limited = [one for one in _limited(run) if one.quantity not in run.soft and not one.comfort(run)]
    shares = [0.0]
    for part in run.parts():
        series = _series(part)
        for one in limited:
            at_nodes, (low, high) = one.at_nodes(part, one.of(series)), one.limit
            shares += [float(np.max(at_nodes)) / high]
            shares += [float(np.min(at_nodes)) / low] if low < 0.0 else []
    return float(np.max(shares))


def _limited(run: Run) -> list["_Limited"]:
    """Return every limited quantity of a run."""
    dofs = [DOFS[name] for name in run.dofs]
    of_base = () if run.base is None else run.platform.bases(dofs)
    limited = [one for dof in (*dofs, *of_base) for one in _of_dof(run, dof)]
    return limited + _of_circle(run) + _of_interference(run)


def _series(part: Run) -> dict[str, Mat]:
    """Return the limited series of a run, read once for all axes; those of a base are six more columns."""
    own = {name: getattr(part, name) for name in _SERIES}
    base, commands = part.base, part.base_command
    if base is None or commands is None:
        return own
    below = dict(zip(_SERIES, (base[:, :6], base[:, 6:12], base[:, 12:], commands), strict=True))
    return {name: np.hstack([own[name], below[name]]) for name in _SERIES}


@dataclass(frozen=True, slots=True)
class _Limited:
    """One limited quantity of a run."""

    quantity: str
    words: tuple[str, str]  # its name for readers, and its unit
    limit: tuple[float, float]  # low and high [SI]
    series: str  # a key of `_SERIES`
    axis: int | None  # None: the distance of surge and sway from neutral
    weights: Vec | None = None  # (12,) of a sum of places of platform and base

    def of(self, series: Mapping[str, Mat]) -> Vec:
        """Return its values, given the series of a run by name."""
        values = series[self.series]
        if self.weights is not None:
            return np.asarray(values @ self.weights)
        return np.hypot(values[:, 0], values[:, 1]) if self.axis is None else values[:, self.axis]

    def at_nodes(self, part: Run, values: Vec) -> Vec:
        """Return values of a part's series at the controller's nodes; commands exist there only."""
        return values if self.series == "command" else part.at_decisions(values)

    def comfort(self, run: Run) -> bool:
        """Return whether it protects the driver's comfort: a tilt's rate that is not noticed."""
        return self.quantity.endswith(" tilt_rate") and _noticed(run, self.quantity)


def _of_circle(run: Run) -> list[_Limited]:
    """Return the limit circle of surge and sway, if the platform has one and both are cued (section 4.2)."""
    radius = run.platform.circle
    if radius is None or not {"surge-pitch", "sway-roll"} <= set(run.dofs):
        return []
    return [_Limited("circle", ("distance of surge and sway", "m"), (0.0, radius), "pose", None)]


def _of_interference(run: Run) -> list[_Limited]:
    """Return where base and platform may be together; from below a sum is limited by their travel alone."""
    if run.base is None or run.platform.base is None:
        return []
    found = []
    for number, one in enumerate(run.platform.base.interference, start=1):
        lowest = -run.platform.farthest(-one.weights)
        for dof, weight in ((dof, one.weights[dof.axes[0]]) for dof in run.platform.base.dofs):
            if weight != 0.0:
                lowest += min(weight * end for end in run.platform.limits(dof)[0].position)
        name = f"interference {number}"
        words = (f"{name} of base and platform", "m")
        found.append(_Limited(name, words, (lowest, one.at_most_m), "pose", None, one.weights))
    return found


def _of_dof(run: Run, dof: Dof) -> list[_Limited]:
    """Return every limit of the axes of a degree of freedom, in the platform's own sign; or of the base's."""
    found = []
    for i, sign, limits in zip(dof.axes, dof.signs, run.platform.limits(dof), strict=True):
        bounds = {
            "pose": (min(sign * end for end in limits.position), max(sign * end for end in limits.position)),
            "twist": _either_way(limits.velocity),
            "acceleration": _either_way(limits.acceleration),
            "command": _either_way(limits.command),
        }
        names = _TILTED if dof.is_pair and i >= 3 else _MOVED
        for series, limit in bounds.items():
            if math.isfinite(limit[1]):
                quantity = f"{dof.name} {names[series]}"
                found.append(_Limited(quantity, _words(series, i), limit, series, i))
    return found


def _words(series: str, axis: int) -> tuple[str, str]:
    """Return the name of a series of the run along an axis, and its unit."""
    of_base, axis = divmod(axis, len(AXES))
    turns = axis >= len(AXES) // 2
    *names, per = _SERIES[series]
    return f"{'base ' * of_base}{AXES[axis]} {names[turns]}", ("deg" if turns else "m") + per


def _either_way(bound: float) -> tuple[float, float]:
    return -bound, bound


def _excess(run: Run, one: _Limited, at_nodes: float, between_nodes: float, violations: int) -> Excess:
    quantity = one.quantity
    return Excess(
        quantity=quantity,
        name=one.words[0],
        unit=one.words[1],
        limit=one.limit,
        soft=quantity in run.soft,
        comfort=one.comfort(run),
        at_nodes=at_nodes,
        between_nodes=between_nodes,
        violations=violations,
    )


def _noticed(run: Run, quantity: str) -> bool:
    """Return whether a pair's tilt rate is limited by the driver's perception and not by the machine."""
    axis = AXES[DOFS[quantity.partition(" ")[0]].rotation]
    machine = getattr(run.platform, axis).rate_degps
    threshold: float = getattr(run.platform.tilt_coordination, f"{axis}_degps")
    return machine is None or threshold < machine


def _beyond(series: Vec, low: float, high: float) -> Vec:
    """Return the distance outside [low, high], 0 inside; NaN counts as infinitely far."""
    outside: Vec = np.maximum(np.maximum(low - series, series - high), 0.0)
    return np.where(np.isnan(outside), np.inf, outside)
