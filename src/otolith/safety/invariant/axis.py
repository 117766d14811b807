"""One axis of a platform: how it moves from node to node, and the rows that its motion must keep.

Notation: x = (p, v, a) is place, speed and acceleration; u is the command, held over a period Δ, and a lags
it by T; q = p + T v and w = v + T a are the leading motion (`otolith.safety.law`). At the nodes

    x⁺ = A x + B u,    q⁺ = q + Δ w + ½ Δ² u,    w⁺ = w + Δ u.

The set of an axis is a polytope in x. It consists of the platform's limits on p, v and a, of limits on the
leading motion, and of the *wedge*: z = q + τ w lies within the reach, so that stopping in the time τ ends
inside. If a braking law slows the axis (eq. C.2), its rows belong to the set as well.
"""

import math
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.lti import zero_order_hold
from otolith.platforms import AxisLimits

LEAST_LAG: Final = 1e-4  # [s] lag of the model for a platform without lag


class AxisRow(NamedTuple):
    """A row of one axis: lower ≤ place · p + speed · v + acceleration · a ≤ upper."""

    name: str
    place: float
    speed: float
    acceleration: float
    lower: float
    upper: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Axis:
    """The data of which the set of an axis is made; rest at the neutral pose keeps all its rows."""

    limits: AxisLimits
    lag: float  # T [s], at least `LEAST_LAG`
    period: float  # Δ [s]
    slowing: tuple[AxisRow, ...] = ()  # rows of the braking law
    # Whether it shares a circle with another axis; then z may not move away from the centre
    shares_circle: bool = False

    @property
    def command(self) -> float:
        """Return the bound U on the commands, and so on the acceleration; infinite if there is none."""
        return min(self.limits.command, self.limits.acceleration)

    @property
    def scale(self) -> Vec:
        """Return the largest place, speed and acceleration in the set (3,), by which states are scaled."""
        low, high = self.limits.position
        most = min(self.command, self.limits.velocity / self.lag)
        return np.array([max(-low, high), self.limits.velocity, most])

    @property
    def towards_centre(self) -> float:
        """Return the share μ of |z| by which z can approach the centre of a shared circle in every period.

        It takes at most a hundredth of the largest speed.
        """
        reach, fastest, _ = self.scale
        return min(1e-4, 0.01 * float(fastest * self.period / reach))

    def dynamics(self) -> tuple[Mat, Vec]:
        """Return (A (3, 3), B (3,)) of one period."""
        of_x = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0 / self.lag]])
        A, B = zero_order_hold(of_x, np.array([[0.0], [0.0], [1.0 / self.lag]]), self.period)
        return A, B[:, 0]

    def limit_rows(self) -> tuple[AxisRow, ...]:
        """Return the platform's limits on place and speed, and the rows of the braking law."""
        low, high = self.limits.position
        rows = [AxisRow("place", 1.0, 0.0, 0.0, low, high)]
        rows.append(AxisRow("speed", 0.0, 1.0, 0.0, -self.limits.velocity, self.limits.velocity))
        return (*rows, *self.slowing)

    def leading_rows(self, ahead: float) -> tuple[AxisRow, AxisRow]:
        """Return limits on v + 2 T a and on z = q + τ w, with τ = `ahead`.

        While both hold, v follows v + 2 T a, q follows z, and p follows q, each through a low-pass. So the
        limits on v and p hold as well, also between the nodes. With T in place of 2 T the speed could reach
        its limit within one period, and a servo that follows imprecisely would overshoot it.
        """
        T, V = self.lag, self.limits.velocity
        return (
            AxisRow("speed", 0.0, 1.0, 2.0 * T, -V, V),
            AxisRow("wedge", 1.0, T + ahead, ahead * T, *self.limits.position),
        )


class AxisSet(NamedTuple):
    """An axis and a set in which it can always stay (`otolith.safety.invariant.contraction`)."""

    axis: Axis
    ahead: float  # τ [s] of the wedge

    @property
    def beyond_limits(self) -> tuple[AxisRow, ...]:
        """Return the rows of the set other than limits on place and speed and the braking law.

        The accelerations stay within U, which may be less than the platform's limit on them.
        """
        U = self.axis.command
        a = (AxisRow("acceleration", 0.0, 0.0, 1.0, -U, U),) if math.isfinite(U) else ()
        q = AxisRow("centre", 1.0, self.axis.lag, 0.0, *self.axis.limits.position)
        return (*a, q, *self.axis.leading_rows(self.ahead))

    @property
    def rows(self) -> tuple[AxisRow, ...]:
        """Return all rows of the set; that of the wedge is the last."""
        return (*self.axis.limit_rows(), *self.beyond_limits)
