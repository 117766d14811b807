"""The ideal platform of chapter 5: every axis follows its commanded acceleration.

Notation: per axis ṗ = v, v̇ = a, ȧ = (a_cmd − a) / T with lag T (eq. 4.9); a = a_cmd if T = 0 (eq. 4.1).
"""

from functools import lru_cache
from typing import Final

import numpy as np

from otolith.core.arrays import Mat, Vec, frozen_array
from otolith.core.errors import InputError
from otolith.core.jit import kernel
from otolith.core.lti import zero_order_hold
from otolith.core.rotation import felt_along
from otolith.interfaces import Command, PlatformState
from otolith.platforms import Platform

SHORTEST: Final = 1e-6  # [s] shortest lag except zero


@kernel
def move_axes(motion: Mat, A: Mat, B: Mat, command: Vec) -> None:
    """Advance pose, twist and acceleration (3, 6) in place under commanded accelerations (6,)."""
    for axis in range(6):
        p, v, a, u = motion[0, axis], motion[1, axis], motion[2, axis], command[axis]
        for row in range(3):
            motion[row, axis] = A[row, 0] * p + A[row, 1] * v + A[row, 2] * a + B[row, 0] * u


class Ideal:
    """Six independent axes, each a double integrator behind a first-order lag, solved exactly.

    Parameters
    ----------
    lag : T [s].
    head : (3,) [m] the driver's head from the reference point. If given, the force there is sensed, including
        rotation and lever arm; otherwise the planar models' force is used.
    """

    dead_time: Final = None  # moves as the controllers' models assume

    def __init__(self, lag: float = 0.01, *, head: tuple[float, float, float] | None = None) -> None:
        if not 0.0 <= lag < np.inf:
            raise InputError("plant lag", lag, "finite and at least 0 s")
        if 0.0 < lag < SHORTEST:  # its exponential would overflow
            raise InputError("plant lag", lag, f"0 or at least {SHORTEST:g} s")
        self._lag = lag
        self._head = None if head is None else np.array(head, dtype=np.float64)
        self._motion = np.zeros((3, 6))  # pose, twist, acceleration

    def reset(self, state: PlatformState) -> None:
        """Set the platform to `state`."""
        self._motion[0], self._motion[1], self._motion[2] = state.pose, state.twist, state.acceleration

    def step(self, command: Command, dt: float) -> PlatformState:
        """Integrate the commanded accelerations (6,) over dt [s]."""
        A, B = axis_dynamics(self._lag, dt)
        motion = self._motion
        move_axes(motion, A, B, command.acceleration)
        return PlatformState(
            pose=motion[0], twist=motion[1], acceleration=motion[2], specific_force=self._sensed(motion)
        )

    def _sensed(self, motion: Mat) -> Vec | None:
        if self._head is None:
            return None
        force = np.empty(3)
        felt_along(self._head, motion[0:1], motion[1:2], motion[2:3], force[None])
        return force


@lru_cache(maxsize=64)
def axis_dynamics(lag: float, dt: float) -> tuple[Mat, Mat]:
    """Return the exact (A (3, 3), B (3, 1)) of one axis (p, v, a) over dt with the command held."""
    if lag == 0.0:
        A = np.array([[1.0, dt, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0]])
        B = np.array([[0.5 * dt**2], [dt], [1.0]])
    else:
        integrators = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0 / lag]])
        A, B = zero_order_hold(integrators, np.array([[0.0], [0.0], [1.0 / lag]]), dt)
    return frozen_array(A), frozen_array(B)


def ideal(platform: Platform | None = None) -> Ideal:
    """Return the plant that the implicit model assumes (eq. 4.9), with the lag of the platform's file."""
    if platform is None:
        return Ideal()
    return Ideal(platform.actuators.lag_s, head=platform.head)


def without_lag(platform: Platform | None = None) -> Ideal:
    """Return the plant that the explicit model assumes, whose accelerations follow at once (eq. 4.1)."""
    return Ideal(lag=0.0, head=None if platform is None else platform.head)
