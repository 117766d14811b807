"""The speed that a driver plans: as fast as limits of speed and acceleration allow everywhere on the road.

Notation: w = v² at the nodes; Δ distance between nodes; a_y = w |κ|. The longitudinal acceleration that
remains while cornering is a (1 − (a_y/a_y,max)^p)^(1/p): p = 2 is the friction ellipse, p = 1 a diamond, a
large p a rectangle. Since w' = 2 a, a forward pass bounds the gain of speed and a backward pass the loss. On
a closed road each pass runs twice around, the first time to find the speed at the seam.
"""

from typing import NamedTuple

import numpy as np

from otolith.core.arrays import Vec
from otolith.core.jit import kernel
from otolith.vehicle.road import Road

SLOWEST = 1.0  # [m/s] planned at a standing start, because a plan over distance would never leave 0


class Limits(NamedTuple):
    """A driver's acceleration limits, all positive [m/s²]; defaults are thesis eq. 6.3."""

    drive: float = 3.0
    brake: float = 4.0
    lateral: float = 4.0
    exponent: float = 2.0  # p


class Plan(NamedTuple):
    """Planned speed [m/s] and longitudinal acceleration [m/s²], each (n + 1,) at the road's nodes."""

    speed: Vec
    acceleration: Vec


def plan_speed(road: Road, limits: Limits, *, power: float, mass: float, standing: bool) -> Plan:
    """Return the fastest speeds within the road's speed limits and the driver's acceleration limits.

    Parameters
    ----------
    power, mass : of the car [W, kg]: its acceleration is at most power/(mass · speed).
    standing : whether to start from rest; otherwise at the planned speed, which on a closed road is that of
        the seam.
    """
    curvature = np.abs(road.curvature)
    cornering = np.sqrt(limits.lateral / np.maximum(curvature, 1e-9))
    w = np.minimum(road.speed_limit, cornering) ** 2
    w = np.minimum(w, 150.0**2)  # bound for roads without a limit: no car here is faster
    ring = road.closed and not standing
    if road.closed:
        w[0] = w[-1] = min(w[0], w[-1])
    if standing:
        w[0] = SLOWEST**2
    for _ in range(2 if ring else 1):
        _forward(w, curvature, road.step, limits, power / mass)
        if ring:
            w[0] = w[-1] = min(w[0], w[-1])
    for _ in range(2 if ring else 1):
        _backward(w, curvature, road.step, limits)
        if ring:
            w[0] = w[-1] = min(w[0], w[-1])
    return Plan(np.sqrt(w), 0.5 * np.gradient(w, road.step))


@kernel
def _left(full: float, w: float, curvature: float, limits: Limits) -> float:
    """Return the longitudinal acceleration that remains of `full` while cornering."""
    share = min(1.0, w * curvature / limits.lateral)
    return float(full * (1.0 - share**limits.exponent) ** (1.0 / limits.exponent))


@kernel
def _forward(w: Vec, curvature: Vec, step: float, limits: Limits, power: float) -> None:
    """Bound the speed gained from node to node, in place; `power` is per mass [W/kg]."""
    for i in range(len(w) - 1):
        full = min(limits.drive, power / max(np.sqrt(w[i]), 1.0))
        w[i + 1] = min(w[i + 1], w[i] + 2.0 * step * _left(full, w[i], curvature[i], limits))


@kernel
def _backward(w: Vec, curvature: Vec, step: float, limits: Limits) -> None:
    """Bound the speed lost from node to node, in place."""
    for i in range(len(w) - 2, -1, -1):
        w[i] = min(w[i], w[i + 1] + 2.0 * step * _left(limits.brake, w[i + 1], curvature[i + 1], limits))
