"""The method of ACADO's generated solver: it solves a QP from the last multipliers by a homotopy.

ACADO's interface makes a new qpOASES problem at every step and initialises it only with the last multipliers
(`qp.init(H, g, A, …, nWSR, y)`); it does not hot-start. qpOASES then constructs a problem that these
multipliers and the point zero solve, and follows the solution while gradient and bounds move linearly to the
right ones. Every change of the working set along this path is an iteration (Ferreau, Bock & Diehl, 2008,
section 3; Ferreau, Kirches, Potschka, Bock & Diehl, 2014, section 3).

Notation: min ½ zᵀH z + gᵀz, l ≤ R z ≤ u with R = (I_b; A), multipliers y signed as in `otolith.qp.problem`. L
Lᵀ = H, T = L⁻¹Rᵀ, so that RH⁻¹Rᵀ = TᵀT. At τ from 0 to 1 the problem has the gradient (1 - τ)(-Rᵀy₀) + τ g; a
row of the first working set, where y₀ ≠ 0, has the bound τ b; any other row has (1 - τ)(±FAR) + τ b.

The starting point of the path does not matter: with another point p instead of zero, z - (1 - τ)p replaces z,
and nothing else changes. Checked by test_the_point_from_which_the_way_starts_plays_no_part.
"""

from dataclasses import dataclass, replace
from typing import Final, NamedTuple

import numpy as np
from scipy.linalg import solve_triangular

from otolith.core.arrays import Ints, Mat, Vec
from otolith.qp.certificate import kkt_residual
from otolith.qp.engines import CondensedEngine
from otolith.qp.problem import Qp, Solution, Status
from otolith.qp.stage import OnRequest, StageProblem, StageSolution

# Initial distance of rows outside the first working set from their bounds (qpOASES' relaxation)
FAR: Final = 1e4
OPEN: Final = 1e6  # replaces an infinite bound
LIMIT: Final = 1000  # largest number of changes
# Relative squared distance from the span of the active rows, below which a row depends on them
_DEPENDENT: Final = 1e-10
_MOVES: Final = 1e-12  # rate below which a row or a multiplier is constant


class _Way(NamedTuple):
    """The data that are constant along the path."""

    gram: Mat  # (rows, rows) TᵀT
    of_gradient: Vec  # (rows,) TᵀL⁻¹ times the gradient's rate
    rates: tuple[Vec, Vec]  # (rows,) rates of lower and upper bounds


class _State:
    """The point on the path: rows r (rows,), multipliers y (rows,), sides ±1 of active rows, their order."""

    def __init__(self, gram: Mat, y: Vec, point: Vec) -> None:
        self.side: Ints = np.sign(y).astype(np.int64)
        self.active = _independent(gram, np.flatnonzero(self.side))
        self.side[np.setdiff1d(np.flatnonzero(self.side), self.active)] = 0
        self.y = np.where(self.side != 0, y, 0.0)
        self.rows = point.copy()


@dataclass(slots=True)
class FromMultipliers:
    """A dense solver that starts from the multipliers of its last answer, as ACADO's qpOASES does."""

    tolerance: float
    y: Vec | None = None  # (rows,) multipliers of the last answer; None if there is none

    def solve(self, qp: Qp, start: Ints | None = None) -> Solution:
        """Solve `qp`; `start` is ignored."""
        del start
        found = follow(qp, np.zeros(len(qp.upper)) if self.y is None else self.y)
        if not found.residual < self.tolerance and found.status is Status.OPTIMAL:
            found = replace(found, status=Status.UNCERTIFIED)
        self.y = found.y.copy() if found.status is Status.OPTIMAL else None
        return found


class ParametricEngine:
    """The condensed engine with ACADO's start; it counts what ACADO reports as iterations."""

    def __init__(self, problem: StageProblem, *, tolerance: float, blocks: tuple[int, ...] = ()) -> None:
        self._dense = FromMultipliers(tolerance)
        self._engine = CondensedEngine(
            problem, tolerance=tolerance, blocks=blocks, dense=lambda **_: self._dense
        )
        self.memory = self._engine.memory

    def run(self, start: Ints | None = None, hint: OnRequest | None = None) -> StageSolution:
        """Solve the problem in the memory; `start` and `hint` are ignored."""
        del start, hint
        return self._engine.run()

    def reset(self) -> None:
        """Discard the multipliers."""
        self._engine.reset()
        self._dense.y = None


def follow(qp: Qp, y0: Vec, point: Vec | None = None) -> Solution:
    """Return the solution, with the number of working-set changes along the path to it.

    Parameters
    ----------
    y0 : (rows,) initial multipliers; their signs are the first working set.
    point : (n,) starting point of the path; None for zero.
    """
    R = np.vstack([np.eye(qp.bounds, len(qp.g)), qp.A])
    L = np.linalg.cholesky(qp.H)
    T = solve_triangular(L, R.T, lower=True)
    gram = T.T @ T
    p = np.zeros(len(qp.g)) if point is None else point
    at = _State(gram, y0, R @ p)
    lower, upper = (np.where(at.side == s, at.rows, at.rows + s * FAR) for s in (-1, 1))
    gradient = qp.g + qp.H @ p + R.T @ at.y
    way = _Way(
        gram,
        T.T @ solve_triangular(L, gradient, lower=True),
        (np.maximum(qp.lower, -OPEN) - lower, np.minimum(qp.upper, OPEN) - upper),
    )
    changes = _walk(way, at, lower, upper)
    if changes < 0:
        return Solution.none(Status.LIMIT, qp)
    w = solve_triangular(L, qp.g + R.T @ at.y, lower=True)
    z = -solve_triangular(L.T, w, lower=False)
    return Solution(Status.OPTIMAL, z, at.y, changes, kkt_residual(qp, z, at.y))


def _walk(way: _Way, at: _State, lower: Vec, upper: Vec) -> int:
    """Follow the solution from τ = 0 to 1; return the number of changes, -1 if the path is lost."""
    tau, changes = 0.0, 0
    while changes <= LIMIT:
        W = np.array(at.active, dtype=np.int64)
        of_bounds = np.where(at.side[W] > 0, way.rates[1][W], way.rates[0][W])
        dy: Vec = np.asarray(
            -np.linalg.solve(way.gram[np.ix_(W, W)], of_bounds + way.of_gradient[W]), dtype=np.float64
        )
        dr: Vec = -(way.of_gradient + way.gram[:, W] @ dy)
        sides = (lower + tau * way.rates[0], upper + tau * way.rates[1])
        step, event = _first(way, at, W, dy, dr, sides, 1.0 - tau)
        at.y[W] += step * dy
        at.rows += step * dr
        tau += step
        if event is None:
            return changes
        if not _change(way.gram, at, W, *event):
            return -1
        changes += 1
    return -1


def _first(
    way: _Way, at: _State, W: Ints, dy: Vec, dr: Vec, sides: tuple[Vec, Vec], rest: float
) -> tuple[float, tuple[int, int] | None]:
    """Return the step to the first row that meets a bound (row, side) or zero multiplier (row, 0)."""
    step, event = rest, None
    for side, bound, rate in zip((-1, 1), sides, way.rates, strict=True):
        closing, gap = side * (dr - rate), np.maximum(side * (bound - at.rows), 0.0)
        meets = (at.side == 0) & (closing > _MOVES)
        when = np.where(meets, gap / np.where(meets, closing, 1.0), np.inf)
        if when.min(initial=np.inf) < step:
            step, event = float(when.min()), (int(when.argmin()), side)
    falling = -at.side[W] * dy
    fades = falling > _MOVES
    when = np.where(fades, np.maximum(at.side[W] * at.y[W], 0.0) / np.where(fades, falling, 1.0), np.inf)
    if when.min(initial=np.inf) < step:
        step, event = float(when.min()), (int(W[when.argmin()]), 0)
    return step, event


def _change(gram: Mat, at: _State, W: Ints, row: int, side: int) -> bool:
    """Remove a row (side 0) or add it, in exchange for another one if it depends on the active rows."""
    if side == 0:
        _drop(at, row)
        return True
    c = np.linalg.solve(gram[np.ix_(W, W)], gram[W, row])
    if gram[row, row] - gram[row, W] @ c < _DEPENDENT * gram[row, row]:
        shares = side * c * at.side[W]
        gives = shares > 1e-9
        if not gives.any():
            return False
        when = np.where(gives, np.maximum(at.side[W] * at.y[W], 0.0) / np.where(gives, shares, 1.0), np.inf)
        at.y[W] -= when.min() * side * c
        at.y[row] = side * when.min()
        _drop(at, int(W[when.argmin()]))
    at.active.append(row)
    at.side[row] = side
    return True


def _drop(at: _State, row: int) -> None:
    at.active.remove(row)
    at.side[row], at.y[row] = 0, 0.0


def _independent(gram: Mat, rows: Ints) -> list[int]:
    """Return the rows without those that depend on earlier ones."""
    if _regular(gram, rows):
        return [int(row) for row in rows]
    chosen: list[int] = []
    for row in rows:
        if _regular(gram, np.array([*chosen, row])):
            chosen.append(int(row))
    return chosen


def _regular(gram: Mat, rows: Ints) -> bool:
    """Return whether no row depends on earlier ones."""
    own = gram[np.ix_(rows, rows)]
    try:
        pivots = np.diag(np.linalg.cholesky(own)) ** 2
    except np.linalg.LinAlgError:
        return False
    return bool((pivots >= _DEPENDENT * np.diag(own)).all())
