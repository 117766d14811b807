"""The certificate that judges every engine's answer: one number, independent of the choice of units.

Write z_j = d_j z̃_j, multiply row i by e_i and the cost by c: this is the same problem in other units.
Therefore each condition is judged relative to its own terms (see `otolith.qp.relative`), with R = (I_b; A):

    rows             r_i ≤ u_i + ε ρ_i                      ρ_i = Σ_j |R_ij z_j| + |u_i| (lower side likewise)
    stationarity     |H z + g + Rᵀ y|_j ≤ ε τ_j             τ_j = Σ_k |H_jk z_k| + |g_j| + Σ_i |R_ij y_i|
    complementarity  u_i − r_i ≤ ε ρ_i, where y_i > 0,      or |R_ij y_i| ≤ ε τ_j for all j

The certificate is the least ε for which all conditions hold. It is a backward error: change the problem's
numbers by a part ε, drop multipliers that contribute at most a part ε to any equation, and the answer is
exactly optimal. The distance to a bound or the multiplier itself must be small, not only their product. So an
answer certified with ε = 1e-6 is not merely within 1e-3 of the optimum, as an answer with a duality gap of
1e-6 may be. Common solver tests (OSQP: Stellato et al., 2020, §3.4; also PIQP and HiGHS) take one norm over
all equations, which depends on the units.

There are two refinements, both independent of units:

- *Multipliers that cancel.* Two opposite rows with huge multipliers make τ arbitrarily large, and then any
  point would pass. So the error must also be small relative to the cost's own terms γ_j = Σ_k |H_jk z_k| +
  |g_j|, in total: Σ_j |H z + g + Rᵀ y|_j x_j ≤ ε Σ_j γ_j x_j, where x_j = max(|z_j|, γ_j / H_jj) is the
  size of z_j.
- *Equations without a number of their own* (z ≥ 0, or g_j = 0) that contain only rounding errors have no size
  of their own. They borrow the part BORROWED of the usual size of their unknowns: ρ_i / |R_ij| and
  γ_k / |H_kj| for z_j, γ_j / |R_ij| for y_i, taken over equations with b_i ≠ 0 or g_k ≠ 0 and propagated from
  there (`otolith.qp.sizes`).

If a cost is not convex (`otolith.qp.convex`), these conditions also hold at saddle points and maxima.
"""

from functools import cached_property

import numpy as np

from otolith.core.arrays import Vec
from otolith.qp.convex import convexity_fault
from otolith.qp.problem import Qp
from otolith.qp.relative import Rows, part, row_residual, worst_of
from otolith.qp.sizes import Sizes, natural_sizes, optimality_system

BORROWED = 1e-3  # with ε = 1e-6, rounding errors up to 1e-9 of the unknowns' usual size are tolerated


def kkt_residual(qp: Qp, z: Vec, y: Vec) -> float:
    """Measure how far (z, y) is from optimal, relative to the numbers of the problem and the answer; 0 is
    exact.

    The result is independent of units, see `otolith.qp.certificate`. It is infinite if the cost is not convex
    or any number is not finite, so accept an answer only if `residual < tolerance`.

    Parameters
    ----------
    z : (n,) primal point.
    y : (b + m,) signed multipliers.
    """
    return np.inf if convexity_fault(qp.H) else first_order_residual(qp, z, y)


def first_order_residual(qp: Qp, z: Vec, y: Vec) -> float:
    """Return `kkt_residual` without the test of convexity, for a cost that is known to be convex."""
    if not (np.isfinite(z).all() and np.isfinite(y).all()):
        return np.inf
    point = _Point(qp, z, y)
    rows = Rows(qp.rows(z), qp.lower, qp.upper, qp.penalties, point.row_terms())
    error, terms = point.stationarity, point.terms()
    return worst_of(part(error, terms), point.total(), row_residual(rows, y, point.shares(terms)))


class _Point:
    """The terms of all equations at one point, with the letters of the module's docstring."""

    def __init__(self, qp: Qp, z: Vec, y: Vec) -> None:
        b = qp.bounds
        self.qp, self.z, self.y = qp, z, y
        self.absolute = np.abs(qp.A)
        self.stationarity = qp.H @ z + qp.g + qp.A.T @ y[b:]
        self.stationarity[:b] += y[:b]
        self.of_cost = np.abs(qp.H) @ np.abs(z) + np.abs(qp.g)  # γ (n,)
        self.of_rows = np.concatenate([np.abs(z[:b]), self.absolute @ np.abs(z)])  # Σ_j |R_ij z_j|

    def terms(self) -> Vec:
        """Return τ (n,), including what costs without a linear term borrow."""
        b, n = self.qp.bounds, len(self.z)
        terms = self.of_cost + self.absolute.T @ np.abs(self.y[b:])
        terms[:b] += np.abs(self.y[:b])
        needy = (self.qp.g == 0.0) & (self.stationarity != 0.0)
        if needy.any():
            terms += BORROWED * np.where(needy, self._sizes.of_equations[:n], 0.0)
        return np.asarray(terms)

    def row_terms(self) -> Vec:
        """Return Σ_j |R_ij z_j| (b + m,), including what rows with a bound at zero borrow."""
        needy = ((self.qp.lower == 0.0) | (self.qp.upper == 0.0)) & (self.of_rows != 0.0)
        if not needy.any():
            return self.of_rows
        return self.of_rows + BORROWED * np.where(needy, self._sizes.of_equations[len(self.z) :], 0.0)

    def shares(self, terms: Vec) -> Vec:
        """Return the largest |R_ij y_i| / τ_j over j for each row with a multiplier, (b + m,)."""
        b, n, held = self.qp.bounds, len(self.z), self.y != 0.0
        rows = np.vstack([np.eye(b, n)[held[:b]], self.absolute[held[b:]]])
        pull = rows * np.abs(self.y[held])[:, None]
        shares = np.zeros(len(self.y))
        shares[held] = part(pull, np.broadcast_to(terms, pull.shape)).max(axis=1, initial=0.0)
        return shares

    def total(self) -> float:
        """Return Σ |stationarity| x / Σ γ x."""
        curvature = np.diag(self.qp.H)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            reach = self.of_cost / curvature
        if (curvature == 0.0).any():
            reach = np.where(curvature > 0.0, reach, self._sizes.of_unknowns[: len(self.z)])
        x = np.maximum(np.abs(self.z), reach)
        scale = np.max(x, initial=0.0) or 1.0  # prevents overflow in the products
        return float(part(np.abs(self.stationarity) @ (x / scale), self.of_cost @ (x / scale)))

    @cached_property
    def _sizes(self) -> Sizes:
        qp = self.qp
        sides = np.abs(np.stack([qp.lower, qp.upper]))
        sides[sides == 0.0] = np.inf
        of_rows = self.of_rows + sides.min(axis=0)  # infinite where no bound is finite and non-zero
        stated = np.concatenate([np.where(qp.g == 0.0, np.inf, self.of_cost), of_rows])
        with np.errstate(divide="ignore", over="ignore"):
            at_most = self.of_cost @ np.abs(self.z) / np.concatenate([self.of_cost, self.of_rows])
        return natural_sizes(optimality_system(qp), stated, at_most)
