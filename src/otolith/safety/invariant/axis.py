"""One axis of a platform: how it moves from node to node, and the rows that its motion must keep.

Notation: x = (p, v, a) place, speed and acceleration; u the command, held over a period Δ, that a lags by T;
q = p + T v and w = v + T a the leading motion (`otolith.safety.law`). At the nodes

    x⁺ = A x + B u,    q⁺ = q + Δ w + ½ Δ² u,    w⁺ = w + Δ u.

The set of an axis is a polytope in x. It consists of the platform's limits on p, v and a, of limits on the
leading motion, and of the *wedge*: z = q + τ w within the reach, so that the way to rest in the time τ ends
inside. Where a braking law slows the axis (eq. C.2), its rows belong to the set as well.
"""

import math
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.lti import zero_order_hold
from otolith.platforms import AxisLimits

LEAST_LAG: Final = 1e-4  # [s] of the model, for a platform that has none


class AxisRow(NamedTuple):
    """lower ≤ place · p + speed · v + acceleration · a ≤ upper."""

    name: str
    place: float
    speed: float
    acceleration: float
    lower: float
    upper: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Axis:
    """What the set of an axis is made from; rest at the neutral pose keeps all its rows."""

    limits: AxisLimits
    lag: float  # T [s], at least `LEAST_LAG`
    period: float  # Δ [s]
    slowing: tuple[AxisRow, ...] = ()  # rows of the braking law
    shares_circle: bool = False  # with another axis: no step may lead its z away from the centre

    @property
    def command(self) -> float:
        """Bound U on the commands, which keeps the acceleration as well; infinite where there is none."""
        return min(self.limits.command, self.limits.acceleration)

    @property
    def scale(self) -> Vec:
        """Largest place, speed and acceleration in the set (3,), by which its numbers become comparable."""
        low, high = self.limits.position
        most = min(self.command, self.limits.velocity / self.lag)
        return np.array([max(-low, high), self.limits.velocity, most])

    @property
    def towards_centre(self) -> float:
        """Share μ of |z| by which an axis that shares a circle can get nearer to the centre in every period.

        It asks for a hundredth of the largest speed, or less.
        """
        reach, fastest, _ = self.scale
        return min(1e-4, 0.01 * float(fastest * self.period / reach))

    def dynamics(self) -> tuple[Mat, Vec]:
        """(A (3, 3), B (3,)) of one period."""
        of_x = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0 / self.lag]])
        A, B = zero_order_hold(of_x, np.array([[0.0], [0.0], [1.0 / self.lag]]), self.period)
        return A, B[:, 0]

    def limit_rows(self) -> tuple[AxisRow, ...]:
        """The platform's limits on place and speed, and the braking law's rows."""
        low, high = self.limits.position
        rows = [AxisRow("place", 1.0, 0.0, 0.0, low, high)]
        rows.append(AxisRow("speed", 0.0, 1.0, 0.0, -self.limits.velocity, self.limits.velocity))
        return (*rows, *self.slowing)

    def leading_rows(self, ahead: float) -> tuple[AxisRow, AxisRow]:
        """Limits on v + 2 T a and on z = q + τ w, with τ = `ahead`.

        While both hold, v follows v + 2 T a, q follows z, and p follows q, each through a low-pass; so the
        limits on v and p hold as well, between the nodes too. With T in place of 2 T the speed would run into
        its limit within one period, and a servo that follows not quite would overshoot it.
        """
        T, V = self.lag, self.limits.velocity
        return (
            AxisRow("speed", 0.0, 1.0, 2.0 * T, -V, V),
            AxisRow("wedge", 1.0, T + ahead, ahead * T, *self.limits.position),
        )


class AxisSet(NamedTuple):
    """An axis and its set, which it need never leave (`otolith.safety.invariant.contraction`)."""

    axis: Axis
    ahead: float  # τ [s] of the wedge

    @property
    def beyond_limits(self) -> tuple[AxisRow, ...]:
        """The rows of the set that are neither limits on place and speed nor the braking law's.

        The accelerations stay within U, which may be less than the platform's own limit on them.
        """
        U = self.axis.command
        a = (AxisRow("acceleration", 0.0, 0.0, 1.0, -U, U),) if math.isfinite(U) else ()
        q = AxisRow("centre", 1.0, self.axis.lag, 0.0, *self.axis.limits.position)
        return (*a, q, *self.axis.leading_rows(self.ahead))

    @property
    def rows(self) -> tuple[AxisRow, ...]:
        """All rows of the set; the wedge's is the last."""
        return (*self.axis.limit_rows(), *self.beyond_limits)
