"""A primal-dual interior-point method that stays inside all bounds, with Newton steps along the horizon.

Notation is that of `problem`. For each side of a stage, d > 0 is the distance to it and λ its multiplier; for
each disc d = (r² − ‖x‖²) / 2r. The conditions of the barrier problem are ∇φ − Σ λ ∇d = 0 and λ d = μ. When
the step of λ is eliminated, a side adds λ/d to the diagonal of the Hessian and −∇d m/d to the gradient, where
m is the desired λ d. So each step is one pass of `kernels.factorise`, whatever the number of limits.

The dynamics are linear and every step obeys them, so each iterate is a motion inside all bounds. A disc is
curved, so its distance is not linear along a step. Its d is therefore a variable of its own, which agrees
with the distance in the end. Predictor and corrector share the factors (Mehrotra, 1992).

The Hessian is the cost's own; where it is not positive along the dynamics, it is that of Gauss and Newton,
which drops what may make it so and needs many more steps where the cost stays large.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.errors import OtolithError
from otolith.ocp import kernels
from otolith.ocp.problem import Answer, Cost, Disc, Dynamics, Expansion

_TO_BOUNDARY: Final = 0.995  # share of the way to the nearest limit
_LEAST_SHIFT, _LARGEST_SHIFT = 1e-10, 1e15  # added to the Hessian's inputs until its factors exist
_SETTLED: Final = 1e-7  # of the largest input: the largest change of any input in the last step


class Breakdown(OtolithError):
    """The iteration cannot continue: a derivative is not a number, or no shift makes the Hessian positive."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """When the iteration stops."""

    accuracy: float = 1e-11  # μ at the end, relative to the cost per limit at the start
    slack: float = 1e-9  # largest difference at the end between a disc's d and its distance
    iteration_limit: int = 200


def solve(dynamics: Dynamics, cost: Cost, x0: Vec, N: int, settings: Settings | None = None) -> Answer:
    """Minimise the cost over N steps from x0, by default to eleven digits of the cost at the start.

    Parameters
    ----------
    x0 : (nx,) strictly inside the limits, such that the motion without inputs stays there, as it does from
        rest.

    Returns
    -------
    The last iterate, which is a motion inside all bounds whether `converged` is true or not.

    Raises
    ------
    ValueError : the motion without inputs does not stay inside.
    Breakdown : a cost or a derivative is not a number, or no shift makes the Hessian positive.
    """
    return _Iteration(dynamics, cost, x0, N, settings or Settings()).run()


class _Iteration:
    """The iterates of one solve."""

    def __init__(self, dynamics: Dynamics, cost: Cost, x0: Vec, N: int, settings: Settings) -> None:
        self.of, self.cost, self.settings = dynamics, cost, settings
        self.sides, self.discs = dynamics.sides(), dynamics.discs
        nx, nu = dynamics.B.shape
        self.A, self.B = np.array(dynamics.A), np.array(dynamics.B)
        self.X, self.U = np.zeros((N + 1, nx)), np.zeros((N, nu))
        self.X[0] = x0
        kernels.roll(self.A, self.B, self.U, self.X)
        self.d = self._distances(self.X, self.U)
        if not (self.d > 0.0).all():
            raise ValueError("the motion without inputs must stay strictly inside the limits")
        self.missed = np.zeros_like(self.d)  # distances less d: zero except for discs
        self.gains, self.factors = np.empty((N, nu, nx)), np.empty((N, nu, nu))
        self.value, self.gradient, self.hessian = self._expanded(self.X, self.U)
        self.mu = max(self.value, 1e-6) / max(1, self.d.size)
        self.y = self.mu / self.d

    def run(self) -> Answer:
        """Iterate until μ is small enough or the iteration limit is reached."""
        converged, iterations = False, 0
        floor = self.settings.accuracy * self.mu
        while iterations < self.settings.iteration_limit:
            iterations += 1
            moved = self._step(floor)
            gap = _mean(self.y * self.d)
            missed = float(np.abs(self.missed).max(initial=0.0))
            if gap <= 2.0 * floor and moved < _SETTLED and missed < self.settings.slack:
                converged = True
                break
        m = len(self.sides.bound)
        return Answer(
            X=self.X,
            U=self.U,
            of_sides=self.y[:, :m],
            of_discs=self.y[:, m:],
            iterations=iterations,
            converged=converged,
        )

    def _step(self, floor: float) -> float:
        """Take one step; return the largest relative change of the cost or of an input."""
        affine = self._direction(np.zeros_like(self.d), fresh=True)
        reach_p, reach_d = self._reach(affine)
        after = _mean((self.d + reach_p * affine.d) * (self.y + reach_d * affine.y))
        now = _mean(self.d * self.y)
        self.mu = max(floor, now * min(1.0, max(after / now, 0.0) ** 3) if now > 0.0 else 0.0)
        target = self.mu - affine.d * affine.y if reach_p > 0.1 else np.full_like(self.d, self.mu)
        step = self._direction(np.clip(target, -10.0 * now, 10.0 * now), fresh=False)
        return self._move(step)

    def _distances(self, X: Mat, U: Mat) -> Mat:
        """Return the distances (N, sides + discs), which are positive inside."""
        w = np.hstack([X[1:], U])
        d = self.sides.sign * (self.sides.bound - w[:, self.sides.column])
        return np.hstack([d, *(_of_disc(disc, X[1:]) for disc in self.discs)])

    def _direction(self, target: Mat, *, fresh: bool) -> "_Direction":
        """Return the Newton step towards λ d = target; with `fresh` the factors are computed anew."""
        nx = self.X.shape[1]
        weight, pull = self.y / self.d, (target - self.y * self.missed) / self.d
        h = self.gradient.copy()
        last_h = np.zeros(nx)
        self._add_gradient(h, last_h, pull)
        if fresh:
            self._factorise(weight)
        dX, dU = np.empty_like(self.X), np.empty_like(self.U)
        kernels.solve(self.A, self.B, self.gains, self.factors, h, last_h, dX, dU)
        dd = self._change(dX, dU) + self.missed
        return _Direction(dX, dU, dd, (target - self.y * self.d - self.y * dd) / self.d)

    def _factorise(self, weight: Mat) -> None:
        """Compute the factors of the exact Hessian or, if there are none, of Gauss-Newton's and a shift."""
        inputs = range(self.X.shape[1], self.hessian.shape[1])
        if self._has_factors(self.hessian, weight):
            return
        H, shift = self._expanded(self.X, self.U, exact=False).hessian, 0.0
        while not self._has_factors(H, weight):
            if shift >= _LARGEST_SHIFT:
                raise Breakdown(f"no effort of up to {shift:.0e} makes the Hessian positive")
            shift = max(10.0 * shift, _LEAST_SHIFT)
            H[:, inputs, inputs] += shift

    def _has_factors(self, hessian: Mat, weight: Mat) -> bool:
        """Compute the factors of a Hessian with the limits' part; return whether they exist."""
        nx = self.X.shape[1]
        H, last = hessian.copy(), np.zeros((nx, nx))
        self._add_hessian(H, last, weight)
        return bool(kernels.factorise(self.A, self.B, H, last, self.gains, self.factors))

    def _add_hessian(self, H: Mat, last: Mat, weight: Mat) -> None:
        """Add the limits' part; row k of `weight` belongs to the state x_{k+1} and the input u_k."""
        nx = self.X.shape[1]
        for s, column in enumerate(self.sides.column):
            if column >= nx:
                H[:, column, column] += weight[:, s]
            else:
                H[1:, column, column] += weight[:-1, s]
                last[column, column] += weight[-1, s]
        for s, disc in enumerate(self.discs, start=len(self.sides.bound)):
            i, j = disc.states
            x, y, r = self.X[1:, i], self.X[1:, j], disc.radius
            curvature = self.y[:, s] / r
            for a, b, value in (
                (i, i, weight[:, s] * x * x / r**2 + curvature),
                (j, j, weight[:, s] * y * y / r**2 + curvature),
                (i, j, weight[:, s] * x * y / r**2),
                (j, i, weight[:, s] * x * y / r**2),
            ):
                H[1:, a, b] += value[:-1]
                last[a, b] += value[-1]

    def _add_gradient(self, h: Mat, last: Vec, pull: Mat) -> None:
        """Add −pull ∇d of every limit."""
        nx = self.X.shape[1]
        for s, (column, sign) in enumerate(zip(self.sides.column, self.sides.sign, strict=True)):
            if column >= nx:
                h[:, column] += sign * pull[:, s]
            else:
                h[1:, column] += sign * pull[:-1, s]
                last[column] += sign * pull[-1, s]
        for s, disc in enumerate(self.discs, start=len(self.sides.bound)):
            for i in disc.states:
                part = pull[:, s] * self.X[1:, i] / disc.radius
                h[1:, i] += part[:-1]
                last[i] += part[-1]

    def _change(self, dX: Mat, dU: Mat) -> Mat:
        """Return the change ∇d · step of every distance, to first order."""
        dw = np.hstack([dX[1:], dU])
        changes = [-self.sides.sign * dw[:, self.sides.column]]
        for disc in self.discs:
            i, j = disc.states
            changes.append(-(self.X[1:, i] * dX[1:, i] + self.X[1:, j] * dX[1:, j])[:, None] / disc.radius)
        return np.hstack(changes)

    def _reach(self, step: "_Direction") -> tuple[float, float]:
        """Return the longest steps, at most 1, with which the motion and the multipliers stay inside."""
        return (
            min(1.0, _TO_BOUNDARY * _longest(self.d, step.d)),
            min(1.0, _TO_BOUNDARY * _longest(self.y, step.y)),
        )

    def _move(self, step: "_Direction") -> float:
        """Take the step as far as it stays inside; return the largest relative change of an input."""
        reach_p, reach_d = self._reach(step)
        X, U = self.X + reach_p * step.X, self.U + reach_p * step.U
        true, d = self._distances(X, U), self.d + reach_p * step.d
        m = len(self.sides.bound)
        d[:, :m] = true[:, :m]
        # A disc that is farther away than predicted counts as such
        d[:, m:] = np.maximum(d[:, m:], true[:, m:])
        self.missed = true - d
        changed = reach_p * np.abs(step.U).max() / (1.0 + np.abs(U).max())
        self.X, self.U, self.d = X, U, d
        self.y = self.y + reach_d * step.y
        self.value, self.gradient, self.hessian = self._expanded(X, U)
        return float(changed)

    def _expanded(self, X: Mat, U: Mat, *, exact: bool = True) -> Expansion:
        """Return the expansion of the cost; raise `Breakdown` if it is not finite."""
        found = self.cost.expand(X, U, exact=exact)
        if not all(np.isfinite(part).all() for part in found):
            raise Breakdown("the cost of a motion, or a derivative of it, is no number")
        return found


@dataclass(frozen=True, slots=True)
class _Direction:
    X: Mat
    U: Mat
    d: Mat  # change of the distances, to first order
    y: Mat


def _of_disc(disc: Disc, X: Mat) -> Mat:
    """Return the distances (N, 1) of the states X (N, nx) to the disc."""
    i, j = disc.states
    distance: Mat = ((disc.radius**2 - X[:, i] ** 2 - X[:, j] ** 2) / (2.0 * disc.radius))[:, None]
    return distance


def _mean(products: Mat) -> float:
    return float(products.sum()) / max(1, products.size)


def _longest(values: Mat, change: Mat) -> float:
    """Return the longest step for which `values` + step · `change` stay positive."""
    fastest = float(np.max(-change / values, initial=0.0))
    return 1.0 / fastest if fastest > 0.0 else math.inf
