"""The speed a driver plans: as fast as the limits of speed and acceleration allow, everywhere on the road.

Notation: w = v² at the nodes; Δ way between nodes; a_y = w |κ|. The longitudinal acceleration a driver has
left while cornering is a (1 − (a_y/a_y,max)^p)^(1/p): p = 2 is the friction ellipse, p = 1 a diamond, a
large p a rectangle. As w' = 2 a, a forward pass bounds what can be gained and a backward pass what can be
lost; on a closed road each runs twice around, the first time to learn the speed at the seam.
"""

from typing import NamedTuple

import numpy as np

from otolith.core.arrays import Vec
from otolith.core.jit import kernel
from otolith.vehicle.road import Road

SLOWEST = 1.0  # [m/s] planned at a standing start: at 0 a plan over the way would never leave it


class Limits(NamedTuple):
    """Accelerations that a driver keeps to, all positive [m/s²]; defaults of thesis eq. 6.3."""

    drive: float = 3.0
    brake: float = 4.0
    lateral: float = 4.0
    exponent: float = 2.0  # p


class Plan(NamedTuple):
    """Planned speed [m/s] and longitudinal acceleration [m/s²], each (n + 1,) at the road's nodes."""

    speed: Vec
    acceleration: Vec


def plan_speed(road: Road, limits: Limits, *, power: float, mass: float, standing: bool) -> Plan:
    """Fastest speeds within the road's speed limits and the driver's acceleration limits.

    Parameters
    ----------
    power, mass : of the car [W, kg]: it gains no more than power/(mass · speed).
    standing : start from rest; otherwise at the planned speed, which on a closed road is that of the seam.
    """
    curvature = np.abs(road.curvature)
    cornering = np.sqrt(limits.lateral / np.maximum(curvature, 1e-9))
    w = np.minimum(road.speed_limit, cornering) ** 2
    w = np.minimum(w, 150.0**2)  # a road without any limit still has one: no car here is faster
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
    """Longitudinal acceleration left of `full` while cornering."""
    share = min(1.0, w * curvature / limits.lateral)
    return float(full * (1.0 - share**limits.exponent) ** (1.0 / limits.exponent))


@kernel
def _forward(w: Vec, curvature: Vec, step: float, limits: Limits, power: float) -> None:
    """Speed gained from node to node, in place; `power` per mass [W/kg]."""
    for i in range(len(w) - 1):
        full = min(limits.drive, power / max(np.sqrt(w[i]), 1.0))
        w[i + 1] = min(w[i + 1], w[i] + 2.0 * step * _left(full, w[i], curvature[i], limits))


@kernel
def _backward(w: Vec, curvature: Vec, step: float, limits: Limits) -> None:
    """Speed lost from node to node, in place."""
    for i in range(len(w) - 2, -1, -1):
        w[i] = min(w[i], w[i + 1] + 2.0 * step * _left(limits.brake, w[i + 1], curvature[i + 1], limits))
