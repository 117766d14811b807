"""The ideal platform of chapter 5: every axis follows its commanded acceleration.

Notation: per axis ṗ = v, v̇ = a, ȧ = (a_cmd − a) / T with lag T (eq. 4.9); a = a_cmd when T = 0 (eq. 4.1).
"""

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError
from otolith.core.lti import zero_order_hold
from otolith.interfaces import Command, PlatformState


class Ideal:
    """Six independent axes, each a double integrator behind a first-order lag; solved exactly."""

    def __init__(self, lag: float = 0.01) -> None:
        if not 0.0 <= lag < np.inf:
            raise InputError("plant lag", lag, "finite and at least 0 s")
        self._lag = lag
        self._dt = np.nan
        self._state = PlatformState()

    def reset(self, state: PlatformState) -> None:
        """Put the platform to `state`."""
        self._state = state

    def step(self, command: Command, dt: float) -> PlatformState:
        """Integrate the commanded accelerations (6,) over dt [s]."""
        if dt != self._dt:
            self._dt, (self._A, self._B) = dt, self._discretise(dt)
        now = self._state
        motion = np.stack([now.pose, now.twist, now.acceleration])  # (3, 6)
        after = self._A @ motion + self._B * command.acceleration
        self._state = PlatformState(pose=after[0], twist=after[1], acceleration=after[2])
        return self._state

    def _discretise(self, dt: float) -> tuple[Mat, Vec]:
        if self._lag == 0.0:
            A = np.array([[1.0, dt, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0]])
            return A, np.array([[0.5 * dt**2], [dt], [1.0]])
        integrators = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0 / self._lag]])
        return zero_order_hold(integrators, np.array([[0.0], [0.0], [1.0 / self._lag]]), dt)


def without_lag() -> Ideal:
    """The plant that the explicit model assumes: accelerations follow at once (eq. 4.1)."""
    return Ideal(lag=0.0)
