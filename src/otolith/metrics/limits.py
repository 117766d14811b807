"""Whether the platform stayed within its limits, judged by its motion and its file alone.

Nothing here is shared with the controllers: it reads what the plant did and what the platform file
allows, so that a controller's wrong model or row cannot hide its own violation.
"""

from dataclasses import dataclass

import numpy as np

from otolith.core.arrays import Vec
from otolith.core.frames import AXES, PAIRS, AxisPair
from otolith.simulate import Run

TOLERANCE = 1e-6  # in SI units of each quantity


@dataclass(frozen=True, slots=True)
class Excess:
    """How far one quantity went beyond its limit; 0 when it never did."""

    quantity: str  # e.g. "surge-pitch tilt_rate"
    at_nodes: float  # largest excess at the controller's nodes [SI]
    between_nodes: float  # largest excess at any plant sample [SI]
    violations: int  # nodes with an excess above TOLERANCE


def excesses(run: Run) -> list[Excess]:
    """One `Excess` per limited quantity of every cued axis pair, and of heave and yaw where cued.

    MPC imposes limits at its nodes only; between them, motion may go beyond by what one period
    allows, which `between_nodes` shows.
    """
    of_pairs = [excess for name in run.pairs for excess in _of_pair(run, PAIRS[name])]
    of_singles = [excess for axis in run.singles for excess in _of_single(run, axis)]
    return of_pairs + of_singles + _of_circle(run)


def _of_circle(run: Run) -> list[Excess]:
    """The limit circle of surge and sway, where the platform has one and both are cued (section 4.2)."""
    if run.platform.circle is None or len(run.pairs) < 2:
        return []
    beyond = np.maximum(np.hypot(run.pose[:, 0], run.pose[:, 1]) - run.platform.circle, 0.0)
    beyond = np.where(np.isnan(beyond), np.inf, beyond)
    return [_excess("circle", run.at_decisions(beyond), beyond)]


def _of_pair(run: Run, pair: AxisPair) -> list[Excess]:
    limits = run.platform.pair_limits(pair)
    s, th = pair.translation, pair.rotation
    tilt_low, tilt_high = sorted(pair.sign * bound for bound in limits.tilt)  # back to the platform's angle
    moving = {
        "position": (run.pose[:, s], *limits.position),
        "tilt": (run.pose[:, th], tilt_low, tilt_high),
        "velocity": (run.twist[:, s], -limits.velocity, limits.velocity),
        "tilt_rate": (run.twist[:, th], -limits.tilt_rate, limits.tilt_rate),
        "acceleration": (run.acceleration[:, s], -limits.acceleration, limits.acceleration),
    }
    return _moving(run, pair.name, moving, run.command[:, s], limits.command)


def _of_single(run: Run, axis: str) -> list[Excess]:
    limits, i = run.platform.axis_limits(axis), AXES.index(axis)
    moving = {
        "position": (run.pose[:, i], *limits.position),
        "velocity": (run.twist[:, i], -limits.velocity, limits.velocity),
        "acceleration": (run.acceleration[:, i], -limits.acceleration, limits.acceleration),
    }
    return _moving(run, axis, moving, run.command[:, i], limits.acceleration)


def _moving(
    run: Run, name: str, moving: dict[str, tuple[Vec, float, float]], command: Vec, largest: float
) -> list[Excess]:
    """Excesses of quantities (series, low, high), and of the command over ±largest."""
    found = [
        _excess(
            f"{name} {quantity}", _beyond(run.at_decisions(series), low, high), _beyond(series, low, high)
        )
        for quantity, (series, low, high) in moving.items()
    ]
    commanded = _beyond(command, -largest, largest)
    return [*found, _excess(f"{name} command", commanded, commanded)]


def _beyond(series: Vec, low: float, high: float) -> Vec:
    """Distance outside [low, high], 0 inside; what is not a number counts as infinitely far."""
    outside: Vec = np.maximum(np.maximum(low - series, series - high), 0.0)
    return np.where(np.isnan(outside), np.inf, outside)


def _excess(quantity: str, at_nodes: Vec, anywhere: Vec) -> Excess:
    return Excess(
        quantity,
        at_nodes=float(np.max(at_nodes)),
        between_nodes=float(np.max(anywhere)),
        violations=int(np.count_nonzero(at_nodes > TOLERANCE)),
    )
