"""The one certificate that judges every engine's answer: a number that no choice of units changes.

Write z_j = d_j z̃_j, multiply row i by e_i and the cost by c: the same problem in other units. Each condition
is therefore judged as a part of its own terms (see `otolith.qp.relative`), with R = (I_b; A):

    rows             r_i ≤ u_i + ε ρ_i                      ρ_i = Σ_j |R_ij z_j| + |u_i| (below likewise)
    stationarity     |H z + g + Rᵀ y|_j ≤ ε τ_j             τ_j = Σ_k |H_jk z_k| + |g_j| + Σ_i |R_ij y_i|
    complementarity  u_i − r_i ≤ ε ρ_i, where y_i > 0,      or |R_ij y_i| ≤ ε τ_j for all j

and the certificate is the least ε. It is a backward error: numbers of the problem that are changed by a
part ε, and multipliers dropped that make up no more than a part ε of any equation, leave the answer exactly
optimal. Because the distance to a bound or the multiplier must be small, not their product, an answer
certified with ε = 1e-6 is not merely within 1e-3 of the optimum, as one with a duality gap of 1e-6 may be.
Solvers' usual tests (OSQP: Stellato et al., 2020, §3.4; PIQP and HiGHS alike) take one norm over all
equations, which depends on units.

Two refinements, both unit-free:

- *Multipliers that cancel.* Two opposite rows with huge multipliers make τ as large as one likes, and then
  any point passes. So the error must also be small against the cost's own terms γ_j = Σ_k |H_jk z_k| +
  |g_j|, in total: Σ_j |H z + g + Rᵀ y|_j x_j ≤ ε Σ_j γ_j x_j, where x_j = max(|z_j|, γ_j / H_jj) is the
  size of z_j.
- *Equations without a number of their own* (z ≥ 0, g_j = 0) and with nothing but rounding in them have no
  size to be a part of. They borrow BORROWED of the size that is usual for their unknowns: ρ_i / |R_ij| and
  γ_k / |H_kj| for z_j, γ_j / |R_ij| for y_i, over equations with b_i ≠ 0 or g_k ≠ 0, and from there on
  outwards (`otolith.qp.sizes`).

Where a cost is not convex (`otolith.qp.convex`), these conditions also hold at saddles and maxima.
"""

from functools import cached_property

import numpy as np

from otolith.core.arrays import Vec
from otolith.qp.convex import convexity_fault
from otolith.qp.problem import Qp
from otolith.qp.relative import Rows, part, row_residual, worst_of
from otolith.qp.sizes import Sizes, natural_sizes, optimality_system

BORROWED = 1e-3  # with ε = 1e-6, rounding up to 1e-9 of what the unknowns are elsewhere is forgiven


def kkt_residual(qp: Qp, z: Vec, y: Vec) -> float:
    """How far (z, y) is from optimal, as a part of the problem's and the answer's own numbers; 0 is exact.

    No change of units changes it, see `otolith.qp.certificate`. A cost that is not convex, and anything not
    finite, gives infinity, so that an answer is accepted only on `residual < tolerance`.

    Parameters
    ----------
    z : (n,) primal point.
    y : (b + m,) signed multipliers.
    """
    return np.inf if convexity_fault(qp.H) else first_order_residual(qp, z, y)


def first_order_residual(qp: Qp, z: Vec, y: Vec) -> float:
    """`kkt_residual` of a cost that is known to be convex."""
    if not (np.isfinite(z).all() and np.isfinite(y).all()):
        return np.inf
    point = _Point(qp, z, y)
    rows = Rows(qp.rows(z), qp.lower, qp.upper, qp.penalties, point.row_terms())
    error, terms = point.stationarity, point.terms()
    return worst_of(part(error, terms), point.total(), row_residual(rows, y, point.shares(terms)))


class _Point:
    """The terms of all equations at one point; letters as above."""

    def __init__(self, qp: Qp, z: Vec, y: Vec) -> None:
        b = qp.bounds
        self.qp, self.z, self.y = qp, z, y
        self.absolute = np.abs(qp.A)
        self.stationarity = qp.H @ z + qp.g + qp.A.T @ y[b:]
        self.stationarity[:b] += y[:b]
        self.of_cost = np.abs(qp.H) @ np.abs(z) + np.abs(qp.g)  # γ (n,)
        self.of_rows = np.concatenate([np.abs(z[:b]), self.absolute @ np.abs(z)])  # Σ_j |R_ij z_j|

    def terms(self) -> Vec:
        """(n,) τ, and what costs without a linear term borrow."""
        b, n = self.qp.bounds, len(self.z)
        terms = self.of_cost + self.absolute.T @ np.abs(self.y[b:])
        terms[:b] += np.abs(self.y[:b])
        needy = (self.qp.g == 0.0) & (self.stationarity != 0.0)
        if needy.any():
            terms += BORROWED * np.where(needy, self._sizes.of_equations[:n], 0.0)
        return np.asarray(terms)

    def row_terms(self) -> Vec:
        """(b + m,) Σ_j |R_ij z_j|, and what rows with a bound at zero borrow."""
        needy = ((self.qp.lower == 0.0) | (self.qp.upper == 0.0)) & (self.of_rows != 0.0)
        if not needy.any():
            return self.of_rows
        return self.of_rows + BORROWED * np.where(needy, self._sizes.of_equations[len(self.z) :], 0.0)

    def shares(self, terms: Vec) -> Vec:
        """(b + m,) the largest |R_ij y_i| / τ_j over j, of the rows that have a multiplier."""
        b, n, held = self.qp.bounds, len(self.z), self.y != 0.0
        rows = np.vstack([np.eye(b, n)[held[:b]], self.absolute[held[b:]]])
        pull = rows * np.abs(self.y[held])[:, None]
        shares = np.zeros(len(self.y))
        shares[held] = part(pull, np.broadcast_to(terms, pull.shape)).max(axis=1, initial=0.0)
        return shares

    def total(self) -> float:
        """Σ |stationarity| x / Σ γ x."""
        curvature = np.diag(self.qp.H)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            reach = self.of_cost / curvature
        if (curvature == 0.0).any():
            reach = np.where(curvature > 0.0, reach, self._sizes.of_unknowns[: len(self.z)])
        x = np.maximum(np.abs(self.z), reach)
        scale = np.max(x, initial=0.0) or 1.0  # so that no product overflows
        return float(part(np.abs(self.stationarity) @ (x / scale), self.of_cost @ (x / scale)))

    @cached_property
    def _sizes(self) -> Sizes:
        qp = self.qp
        sides = np.abs(np.stack([qp.lower, qp.upper]))
        sides[sides == 0.0] = np.inf
        of_rows = self.of_rows + sides.min(axis=0)  # infinite where no bound is a number other than zero
        told = np.concatenate([np.where(qp.g == 0.0, np.inf, self.of_cost), of_rows])
        with np.errstate(divide="ignore", over="ignore"):
            at_most = self.of_cost @ np.abs(self.z) / np.concatenate([self.of_cost, self.of_rows])
        return natural_sizes(optimality_system(qp), told, at_most)
