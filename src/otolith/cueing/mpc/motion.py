"""The motion of a degree of freedom: its states, its commands, and their order.

Notation: per axis p position, v speed, a acceleration, which follows its command u with lag T (eqs. 4.9 and
4.21):

    ṗ = v,  v̇ = a,  ȧ = (u − a)/T.

An axis pair has x = [ω θ v s a_tran a_rot], u = [a_rot a_tran] in the thesis's order, with ω, θ rate and
angle of the tilt, v, s speed and position of the translation. A single axis has x = [v s a], u = [a]. Several
degrees of freedom have x = (x_1, x_2 …), u = (u_1, u_2 …). Without the lag (the explicit model, eq. 4.1) the
accelerations are the inputs, and the states are the others.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.frames import Dof
from otolith.core.jit import kernel
from otolith.core.lti import zero_order_hold
from otolith.interfaces import PlatformState

STATES: Final = (
    "tilt_rate",
    "tilt",
    "velocity",
    "position",
    "acceleration",
    "tilt_acceleration",
)  # of a pair
TILT_RATE, TILT, VELOCITY, POSITION, ACCELERATION, TILT_ACCELERATION = range(6)
ROT, TRAN = range(2)  # a pair's commands
STATES_ALONE: Final = ("velocity", "position", "acceleration")  # of a single axis


@dataclass(frozen=True, slots=True)
class Chain:
    """One axis of a degree of freedom as a chain of integrators: acceleration, speed, position."""

    of: int  # index in `Dof.axes`
    place: int  # index among the degree of freedom's states, like the next two
    speed: int
    acceleration: int


_PAIR: Final = (
    Chain(1, TILT, TILT_RATE, TILT_ACCELERATION),
    Chain(0, POSITION, VELOCITY, ACCELERATION),
)
_ALONE: Final = (Chain(0, place=1, speed=0, acceleration=2),)


def chains(dof: Dof) -> tuple[Chain, ...]:
    """Return the axes of a degree of freedom, in the order of its commands."""
    return _PAIR if dof.is_pair else _ALONE


def states(dof: Dof) -> tuple[str, ...]:
    """Return the names of its states, by which washout weights and soft rows refer to them."""
    return STATES if dof.is_pair else STATES_ALONE


class Axes(NamedTuple):
    """All axes of several degrees of freedom, one entry per command (nu,); x is (nx,)."""

    axis: Ints  # index among the platform's six axes; 6 more for those of its base
    sign: Vec  # sign of the model's motion relative to the platform's
    place: Ints  # index in x, like the next two
    speed: Ints
    acceleration: Ints


def stacked(dofs: Sequence[Dof]) -> Axes:
    """Return the indices of the axes when degrees of freedom are stacked."""
    first, found = 0, []
    for dof in dofs:
        for chain in chains(dof):
            in_x = (first + chain.place, first + chain.speed, first + chain.acceleration)
            found.append((dof.axes[chain.of], dof.signs[chain.of], *in_x))
        first += len(states(dof))
    axis, sign, place, speed, acceleration = map(np.array, zip(*found, strict=True))
    return Axes(axis, sign, place, speed, acceleration)


def first_states(dofs: Sequence[Dof]) -> Ints:
    """Return the index in x of the first state of every degree of freedom, and the total (len + 1,)."""
    return np.cumsum([0, *(len(states(dof)) for dof in dofs)])


def dynamics(axes: Axes, lag: float | Vec) -> tuple[Mat, Mat]:
    """Return continuous (A (nx, nx), B (nx, nu)) of axes that follow their commands.

    Parameters
    ----------
    lag : [s] of all axes, or of each (nu,).
    """
    nu = len(axes.axis)
    A, B = np.zeros((3 * nu, 3 * nu)), np.zeros((3 * nu, nu))
    A[axes.place, axes.speed] = A[axes.speed, axes.acceleration] = 1.0
    A[axes.acceleration, axes.acceleration] = -1.0 / lag
    B[axes.acceleration, np.arange(nu)] = 1.0 / lag
    return A, B


def explicit_dynamics(dof: Dof) -> tuple[Mat, Mat]:
    """Return continuous (A, B) of eq. 4.1, double integrators whose inputs are the accelerations."""
    of = chains(dof)
    A, B = np.zeros((2 * len(of), 2 * len(of))), np.zeros((2 * len(of), len(of)))
    for i, chain in enumerate(of):
        A[chain.place, chain.speed] = B[chain.speed, i] = 1.0
    return A, B


def held(lag: float, period: float) -> Vec:
    """Return the coefficients (Δ, c₁ … c₅) that `predict` needs for one axis over a period, exact.

    p⁺ = p + Δ v + c₁ a + c₂ u,  v⁺ = v + c₃ a + c₄ u,  a⁺ = c₅ a + (1 − c₅) u.
    """
    A, B = zero_order_hold(
        np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0 / lag]]),
        np.array([[0.0], [0.0], [1.0 / lag]]),
        period,
    )
    return np.array([period, A[0, 2], B[0, 0], A[1, 2], B[1, 0], A[2, 2]])


@kernel
def predict(axes: Axes, hold: Mat, x0: Vec, plan: Mat, X: Mat) -> None:
    """Write the states x_1 … x_N into X (N, nx) under the commands `plan` (N, nu).

    Parameters
    ----------
    hold : (nu, 6) rows of `held`.
    """
    for k in range(X.shape[0]):
        before = x0 if k == 0 else X[k - 1]
        for i in range(len(axes.axis)):
            u, c = plan[k, i], hold[i]
            v, a = before[axes.speed[i]], before[axes.acceleration[i]]
            X[k, axes.place[i]] = before[axes.place[i]] + c[0] * v + c[1] * a + c[2] * u
            X[k, axes.speed[i]] = v + c[3] * a + c[4] * u
            X[k, axes.acceleration[i]] = c[5] * a + (1.0 - c[5]) * u


@kernel
def read(axes: Axes, motion: Mat, x: Vec) -> None:
    """Write the model's x (nx,) of a platform's motion (3, 6), or of that on a base (6, 6)."""
    for i in range(len(axes.axis)):
        axis, sign, row = axes.axis[i], axes.sign[i], 0
        if axis >= 6:
            axis, row = axis - 6, 3
        x[axes.place[i]] = sign * motion[row, axis]
        x[axes.speed[i]] = sign * motion[row + 1, axis]
        x[axes.acceleration[i]] = sign * motion[row + 2, axis]


def model_state(axes: Axes, state: PlatformState) -> Vec:
    """Return the model's x (nx,) for a platform's state."""
    x, motion = np.empty(3 * len(axes.axis)), np.empty((6, 6))
    state.write(motion)
    read(axes, motion, x)
    return x


def in_six_axes(axes: Axes, plan: Mat) -> Mat:
    """Return the accelerations (N, 6) of the platform for the model's commands (N, nu)."""
    command = np.zeros((len(plan), 6))
    command[:, axes.axis] = axes.sign * plan
    return command
