"""The optimality of a motion, judged from the solver's answer alone by code that the solver does not share.

The derivatives of the cost are taken here by complex steps (Squire & Trapp, 1998), which are exact to
rounding. So the solver's own derivatives are checked, too. The conditions are those of Karush, Kuhn and
Tucker. Where the cost is not convex, they also hold at a motion that is only locally the best.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from otolith.core.arrays import Mat, Vec
from otolith.ocp.problem import Answer, Dynamics

MARKED: Final = 1e-6  # share of the cost of standing still by which an optimum near zero is measured
_STEP: Final = 1e-30  # of the complex step; its square is far below rounding

# Costs (N,) of the steps, from the states (N, nx) before them and the inputs (N, nu), which may be complex.
StageCosts = Callable[[NDArray[Any], NDArray[Any]], NDArray[Any]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Certificate:
    """How far an answer is from optimal. Each figure is relative, and zero at an optimum.

    Where a figure is relative to the cost, this is the cost of the answer, plus MARKED times the cost of
    standing still, plus `nothing` of `certify`. The two terms keep the figures meaningful if the optimum is
    near zero or the drive wants nothing.
    """

    dynamics: float  # largest error of a state, relative to the largest state
    outside: float  # largest excess over a limit, relative to the limit; 0 inside
    sign: float  # most negative multiplier, relative to the largest
    stationarity: float  # Σ |gradient| · range of input, relative to the cost: what inputs could still gain
    gap: float  # Σ λ d, relative to the cost: what a motion nearer to the limits could still gain

    @property
    def worst(self) -> float:
        """Return the largest of all figures."""
        return max(self.dynamics, self.outside, self.sign, self.stationarity, self.gap)


def certify(dynamics: Dynamics, costs: StageCosts, answer: Answer, *, nothing: float = 1e-12) -> Certificate:
    """Judge an answer.

    Where the cost is convex, no motion costs less by more than stationarity and gap together.

    Parameters
    ----------
    costs : gives the cost of every step, see `StageCosts`; their sum is the cost.
    nothing : a cost that counts as zero.
    """
    X, U = answer.X, answer.U
    value = float(costs(X[:-1], U).sum() + nothing)
    value += MARKED * float(costs(np.zeros_like(X[:-1]), np.zeros_like(U)).sum())
    of_x, of_u = _gradient(costs, X[:-1], U)
    after, of_u_limits = _of_limits(dynamics, answer)
    total = _by_inputs(dynamics, of_x, of_u + of_u_limits, after)
    distance, reach = _distances(dynamics, X, U)
    y = np.hstack([answer.of_sides, answer.of_discs])
    error = np.abs(X[1:] - X[:-1] @ dynamics.A.T - U @ dynamics.B.T).max()
    return Certificate(
        dynamics=float(error / (np.abs(X).max() + 1e-12)),
        outside=float((-distance / reach).max(initial=0.0)),
        sign=float((-y).max(initial=0.0) / (np.abs(y).max(initial=0.0) + 1e-300)),
        stationarity=float((np.abs(total) * _ranges(dynamics, U)).sum() / value),
        gap=float((y * np.maximum(distance, 0.0)).sum() / value),
    )


def _ranges(dynamics: Dynamics, U: Mat) -> Vec:
    """Return how far apart two values of each input can be (nu,); without limits, twice the largest used."""
    ranges = dynamics.upper[dynamics.states :] - dynamics.lower[dynamics.states :]
    used: Vec = np.where(np.isfinite(ranges), ranges, 2.0 * np.abs(U).max(axis=0))
    return used


def _gradient(costs: StageCosts, X: Mat, U: Mat) -> tuple[Mat, Mat]:
    """Return the derivatives (N, nx), (N, nu) of the cost of every step by its state and its input."""

    def derivative(of_input: bool, column: int) -> Mat:
        x, u = X.astype(np.complex128), U.astype(np.complex128)
        (u if of_input else x)[:, column] += 1j * _STEP
        slope: Mat = costs(x, u).imag / _STEP
        return slope

    return (
        np.stack([derivative(False, i) for i in range(X.shape[1])], axis=1),
        np.stack([derivative(True, i) for i in range(U.shape[1])], axis=1),
    )


def _of_limits(dynamics: Dynamics, answer: Answer) -> tuple[Mat, Mat]:
    """Return −Σ λ ∇d by the states after each step (N, nx) and by its inputs (N, nu)."""
    nx, sides = dynamics.states, dynamics.sides()
    by_w = np.zeros((len(answer.U), nx + dynamics.inputs))
    for s, (column, sign) in enumerate(zip(sides.column, sides.sign, strict=True)):
        by_w[:, column] += sign * answer.of_sides[:, s]
    for s, disc in enumerate(dynamics.discs):
        for i in disc.states:
            by_w[:, i] += answer.of_discs[:, s] * answer.X[1:, i] / disc.radius
    return by_w[:, :nx], by_w[:, nx:]


def _by_inputs(dynamics: Dynamics, of_x: Mat, of_u: Mat, after: Mat) -> Mat:
    """Return the total derivative (N, nu) by the inputs, on which the states depend.

    Parameters
    ----------
    of_x, of_u : direct derivatives by the state before each step and by its input.
    after : (N, nx) direct derivatives by the state after it.
    """
    A, B = dynamics.A.T, dynamics.B.T
    p, total = np.zeros(dynamics.states), np.empty_like(of_u)
    for k in range(len(of_u) - 1, -1, -1):
        p = p + after[k]
        total[k] = of_u[k] + B @ p
        p = of_x[k] + A @ p
    return total


def _distances(dynamics: Dynamics, X: Mat, U: Mat) -> tuple[Mat, Mat]:
    """Return the distances (N, limits) to every limit, and the limits' sizes (limits,)."""
    w, sides = np.hstack([X[1:], U]), dynamics.sides()
    distance = [sides.sign * (sides.bound - w[:, sides.column])]
    for disc in dynamics.discs:
        square = np.sum(X[1:, list(disc.states)] ** 2, axis=1)
        distance.append((disc.radius**2 - square)[:, None] / (2.0 * disc.radius))
    size = np.concatenate([np.abs(sides.bound), [disc.radius for disc in dynamics.discs]])
    return np.hstack(distance), size
