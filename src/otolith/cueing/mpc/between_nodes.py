"""How far legs may leave, between two nodes, what a controller's rows hold at both.

Notation: Δ period, T lag; L, L̇, L̈ coordinate, speed, acceleration of a leg. Within a period the acceleration
of every axis goes from a₀ to a₁ along one curve, a = a₀ + s(t) (a₁ − a₀), s = (1 − e^{−t/T})/(1 − e^{−Δ/T}).
If legs were linear in the pose, L̈ would go along the same curve, and so stay between its values at the nodes.
It differs from that curve by

    |r| ≤ ρ = κ D,    κ = max (1 − s) t + s (Δ − t),

where D is the largest rate at which L̈(q, v, a) changes with pose and speed while a is held: along both ends'
a the difference can grow by D for no longer than the time from that end. The speed is held by L̇ + T L̈, which
without r is a straight line in time, since the curve is that of the lag; r adds ρ (Δ/2 + T). The length is
held by L + (τ + T) L̇ + τ T L̈, without r a parabola that leaves its chord by Δ²/8 times its curvature; r
adds ρ (Δ²/8 + (τ + T) Δ/2 + τ T). If what leads stays within a bound, so does what follows it through a
low-pass.

Everything is derived but D, for which no closed form is known to us. It is the largest of many motions at the
limits: of poses on the way to all corners of the reach, with legs as fast, and speeding up as much, as limits
allow. So these figures are computed, not proved.
"""

from typing import Any, Final, NamedTuple, Self

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.copying import copy_to
from otolith.core.jit import kernel
from otolith.core.slopes import rotation_jet
from otolith.platforms.hexapod import Hexapod
from otolith.platforms.kinematics import Actuators, solve
from otolith.platforms.leg_slopes import leg_slopes

MOTIONS: Final = 600  # among which the fastest change is sought
SHRINK: Final = 0.8  # of a pose until the legs hold it, …
SHRINKS: Final = 40  # … which is so at the neutral one
TINY: Final = 1e-300  # divides where a leg has no room, and nothing that needs any


class Reach(NamedTuple):
    """What the axes may do (6,) in SI units; zeros for those that are not cued."""

    place: Mat  # (2, 6) lowest and highest
    speed: Vec  # ±
    acceleration: Vec  # ±


class Between(NamedTuple):
    """The largest excess over a bound between two nodes that keep it."""

    length: float  # [m]
    speed: float  # [m/s]
    acceleration: float  # [m/s²]

    @classmethod
    def of(cls, legs: Hexapod, reach: Reach, *, lead: float, lag: float, period: float) -> Self:
        """Compute the excess for one machine.

        Parameters
        ----------
        lead, lag : τ and T [s] of the rows.
        period : Δ [s].
        """
        draws = np.random.default_rng(0).uniform(-1.0, 1.0, (MOTIONS, 4, 6))
        fastest = _fastest_change(legs.actuators, legs.stroke, legs.speed, legs.acceleration, reach, draws)
        t = np.linspace(0.0, period, 201)
        whole = 1.0 - np.exp(-period / lag)
        s = (1.0 - np.exp(-t / lag)) / whole
        off = float(fastest * np.max((1.0 - s) * t + s * (period - t)))
        curvature = legs.acceleration * (2.0 / whole - 1.0)
        of_length = off * (period**2 / 8 + (lead + lag) * period / 2 + lead * lag)
        return cls(curvature * period**2 / 8 + of_length, off * (period / 2 + lag), off)


@kernel
def _slopes_at(of: Actuators, motion: Mat, jet: Mat, values: Vec, slopes: Mat) -> None:
    rotation_jet(motion, jet)
    leg_slopes(motion, jet, of, values, slopes)


@kernel
def _at_limits(J: Mat, towards: Vec, offset: Vec, most: float, axes: Vec, out: Vec) -> None:
    """Write rates (6,) of the axes within ±`axes` that bring the motion of all legs, or of one, to ±most.

    That motion is J·rates + offset; where the offset alone is larger than `most`, it is not exceeded.

    Parameters
    ----------
    towards : (6,) whose signs say which way each leg should go.
    offset : (6,) part of the legs' motion that does not depend on these rates.
    """
    for i in range(6):
        out[i] = (most if towards[i] > 0.0 else -most) - offset[i]
    if not solve(J.copy(), out):
        copy_to(out, axes)
    for i in range(6):
        out[i] = min(axes[i], max(-axes[i], out[i]))
    share = 1.0
    for i in range(6):
        added = 0.0
        for j in range(6):
            added += J[i, j] * out[j]
        room = max(most, abs(offset[i])) - (offset[i] if added > 0.0 else -offset[i])
        share = min(share, room / max(room, abs(added), TINY))
    for i in range(6):
        out[i] *= share


@kernel
def _within(values: Vec, stroke: tuple[float, float]) -> bool:
    """Return whether all six coordinates lie within the stroke; False for a NaN."""
    inside = 0
    for i in range(6):
        inside += stroke[0] <= values[i] <= stroke[1]
    return inside == 6


@kernel
def _fastest_change(
    of: Actuators, stroke: tuple[float, float], speed: float, acceleration: float, reach: Any, draws: Any
) -> float:
    """Return D [m/s³], the largest among motions made of random numbers (n, 4, 6) between ±1."""
    motion, jet, true = np.zeros((3, 6)), np.empty((4, 3, 3, 3)), np.empty(6)
    values, slopes, J, fastest = np.empty(18), np.empty((18, 18)), np.empty((6, 6)), 0.0
    for k in range(len(draws)):
        motion[:] = 0.0
        for axis in range(6):
            share = draws[k, 0, axis]
            motion[0, axis] = abs(share) * reach.place[1 if share > 0.0 else 0, axis]
        _slopes_at(of, motion, jet, values, slopes)
        for _ in range(SHRINKS):
            if _within(values, stroke):
                break
            for axis in range(6):
                motion[0, axis] *= SHRINK
            _slopes_at(of, motion, jet, values, slopes)
        for leg in range(6):
            copy_to(J[leg], slopes[leg])
        _at_limits(J, draws[k, 1], np.zeros(6), speed, reach.speed, motion[1])
        _slopes_at(of, motion, jet, values, slopes)
        offset = values[12:].copy()
        _at_limits(J, draws[k, 2], offset, acceleration, reach.acceleration, motion[2])
        _at_limits(J, draws[k, 3], offset, acceleration, reach.acceleration, true)
        _slopes_at(of, motion, jet, values, slopes)
        for leg in range(6):
            change = 0.0
            for axis in range(6):
                change += slopes[12 + leg, axis] * motion[1, axis]
                change += slopes[12 + leg, 6 + axis] * true[axis]
            fastest = max(fastest, abs(change))
    return fastest
