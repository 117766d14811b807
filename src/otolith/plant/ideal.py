"""The ideal platform of chapter 5: every axis follows its commanded acceleration.

Notation: per axis ṗ = v, v̇ = a, ȧ = (a_cmd − a) / T with lag T (eq. 4.9); a = a_cmd if T = 0 (eq. 4.1).
"""

import math
from functools import lru_cache
from typing import Any, Final, NamedTuple

import numpy as np

from otolith.compiled import FOLLOW
from otolith.core.arrays import Mat, Vec, frozen_array
from otolith.core.errors import InputError
from otolith.core.jit import kernel
from otolith.core.lti import zero_order_hold
from otolith.core.methods import Bound
from otolith.core.rotation import felt
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


class _Axes(NamedTuple):
    motion: Mat  # (3, 6) pose, twist, acceleration
    A: Mat  # (3, 3) of one axis, over one step
    B: Mat  # (3, 1)
    head: Vec  # (3,) [m]
    senses: bool


@kernel
def note(motion: Mat, head: Vec, senses: bool, row: Mat, force: Vec) -> None:
    """Record a motion (3, 6) in a row of the same shape, and the force felt at the head (3,)."""
    for i in range(3):
        force[i] = np.nan
        for axis in range(6):
            row[i, axis] = motion[i, axis]
    if senses:
        felt(head, motion[0], motion[1], motion[2], force)


@kernel
def _follow(of: Any, command: Vec, motion: Mat, force: Mat) -> int:
    """Follow one command for n steps; see `otolith.compiled.FOLLOW`."""
    for k in range(len(motion)):
        move_axes(of.motion, of.A, of.B, command)
        note(of.motion, of.head, of.senses, motion[k], force[k])
    return 0


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
        self._lag = checked_lag(lag)
        self._head = None if head is None else np.array(head, dtype=np.float64)
        self._motion = np.zeros((3, 6))  # pose, twist, acceleration
        self._dt = 0.0  # [s] of the method
        self._method: Bound | None = None  # made on first use

    def reset(self, state: PlatformState) -> None:
        """Set the platform to `state`."""
        self._motion[0], self._motion[1], self._motion[2] = state.pose, state.twist, state.acceleration

    def step(self, command: Command, dt: float) -> PlatformState:
        """Integrate the commanded accelerations (6,) over dt [s]."""
        return stepped(_follow, self.compiled(dt), command, self._head is not None)

    def compiled(self, dt: float) -> Bound:
        """Return the method of this plant for steps of dt [s]."""
        if self._method is None or dt != self._dt:
            A, B = axis_dynamics(self._lag, dt)
            head = np.zeros(3) if self._head is None else self._head
            axes = _Axes(self._motion, A, B, head, self._head is not None)
            self._dt, self._method = dt, FOLLOW.bind(_follow, axes)
        return self._method


def stepped(follow: Any, method: Bound, command: Command, senses: bool) -> PlatformState:
    """Return the state after one step by a plant's kernel."""
    motion, force = np.empty((1, 3, 6)), np.empty((1, 3))
    follow(method.held, command.acceleration, motion, force)
    return PlatformState.of_motion(motion[0], force[0] if senses else None)


def checked_lag(lag: float) -> float:
    """Return a lag [s] if it is one.

    Raises
    ------
    InputError : it is negative, not finite, or so short that its exponential would overflow.
    """
    if not 0.0 <= lag < np.inf:
        raise InputError("plant lag", lag, "finite and at least 0 s")
    if 0.0 < lag < SHORTEST:
        raise InputError("plant lag", lag, f"0 or at least {SHORTEST:g} s")
    return lag


@kernel
def part_of_step(lag: float, dt: float, A: Mat, B: Mat) -> None:
    """Write what `axis_dynamics` returns, in closed form: for durations that are not known beforehand."""
    A[0, 0] = A[1, 1] = 1.0
    A[0, 1] = dt
    B[0, 0], B[1, 0], B[2, 0] = 0.5 * dt * dt, dt, 1.0
    if lag > 0.0:
        gone = -math.expm1(-dt / lag)  # 1 − e^(−Δ/T)
        A[1, 2] = lag * gone
        A[0, 2] = lag * (dt - A[1, 2])
        A[2, 2] = 1.0 - gone
        B[0, 0] -= A[0, 2]
        B[1, 0] -= A[1, 2]
        B[2, 0] = gone


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
