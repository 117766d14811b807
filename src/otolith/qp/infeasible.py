"""Prove that no point satisfies all hard rows (Farkas, 1902).

The proof consists of multipliers y with Rᵀ y = 0 and Σ y⁺ u − y⁻ l < 0: with these every feasible z would
give 0 = yᵀ R z ≤ Σ y⁺ u − y⁻ l < 0. An engine that fails to find a point has proved nothing, since its
tolerance may have stopped it. So "infeasible" is reported only together with such a y.
"""

import numpy as np
import scipy  # scipy imports its modules on first use, so a caller waits only for those it needs

from otolith.core.arrays import Vec
from otolith.qp.equilibrate import equilibrate
from otolith.qp.problem import Qp

_ROUNDING = 1e-12  # a component of Rᵀ y below this part of its terms counts as zero
_MARGIN = 1e-9  # Σ y⁺ u − y⁻ l must be below zero by this part of its terms
_IDLE = 1e-9  # multipliers of the linear program below this part of the largest are dropped


def is_proof(qp: Qp, y: Vec) -> bool:
    """True when y (b + m,) proves infeasibility; each condition is judged relative to its own terms.

    If Rᵀ y is zero only up to rounding, the proof states that any feasible point is at least _MARGIN /
    _ROUNDING times larger than the bounds suggest.
    """
    side = np.where(y > 0.0, qp.upper, qp.lower)
    held = y != 0.0
    usable = np.isfinite(side) & np.isfinite(y) & np.isinf(qp.penalties)
    if not held.any() or not usable[held].all():
        return False
    b, n = qp.bounds, len(qp.g)
    rows = np.vstack([np.eye(b, n)[held[:b]], qp.A[held[b:]]])
    y, side = y[held], side[held]
    balanced = np.abs(rows.T @ y) <= _ROUNDING * (np.abs(rows.T) @ np.abs(y))
    return bool(balanced.all() and y @ side < -_MARGIN * (np.abs(y) @ np.abs(side)))


def infeasible(qp: Qp) -> bool:
    """Search for a proof of infeasibility; False when there is none or it is not clear enough.

    A linear program chooses the rows; its multipliers are refined to Rᵀ y = 0 on these rows and then judged.
    """
    hard = _only_hard(qp) if qp.has_soft_rows else qp
    units = equilibrate(hard)
    y = _ray(units.qp)
    return y is not None and is_proof(hard, units.back(np.zeros(len(qp.g)), _balanced(units.qp, y))[1])


def _only_hard(qp: Qp) -> Qp:
    soft = np.isfinite(qp.penalties)
    lower, upper = np.where(soft, -np.inf, qp.lower), np.where(soft, np.inf, qp.upper)
    return Qp(qp.H, qp.g, qp.A, lower, upper)


def _ray(qp: Qp) -> Vec | None:
    """Multipliers y (b + m,) that minimise Σ y⁺ u − y⁻ l over Rᵀ y = 0, Σ |y| ≤ 1; None if y = 0 is
    optimal.
    """
    b, n = qp.bounds, len(qp.g)
    above, below = np.flatnonzero(np.isfinite(qp.upper)), np.flatnonzero(np.isfinite(qp.lower))
    R = np.vstack([np.eye(b, n), qp.A])
    columns = np.hstack([R[above].T, -R[below].T])
    sides = np.concatenate([qp.upper[above], -qp.lower[below]])
    if not len(sides):  # nothing is bounded, and scipy refuses a program without variables
        return None
    found = scipy.optimize.linprog(
        sides,
        A_ub=np.ones((1, len(sides))),
        b_ub=np.ones(1),
        A_eq=columns,
        b_eq=np.zeros(n),
        method="highs",
        options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10},
    )
    if found.x is None or found.fun is None or not found.fun < 0.0:
        return None
    y = np.zeros(len(R))
    np.add.at(y, above, found.x[: len(above)])
    np.add.at(y, below, -found.x[len(above) :])
    return y


def _balanced(qp: Qp, y: Vec) -> Vec:
    """Project multipliers onto Rᵀ y = 0, using the same rows."""
    b, n = qp.bounds, len(qp.g)
    held = np.abs(y) > _IDLE * np.max(np.abs(y), initial=0.0)
    rows = np.vstack([np.eye(b, n)[held[:b]], qp.A[held[b:]]])
    near = y[held]
    for _ in range(3):  # once would suffice in exact arithmetic
        near = near - np.linalg.lstsq(rows.T, rows.T @ near, rcond=1e-10)[0]
    balanced = np.zeros_like(y)
    balanced[held] = near
    return balanced
