"""Remove the constraints that never bind, by linear programs over variables and parameters jointly.

Notation: the joint polytope is {(u, τ): M u - D τ ≤ d0, |τ_i| ≤ 1, E'τ ≤ e}, written A x ≤ b with rows of
length one. A row is redundant when max A_i x over the other rows does not exceed b_i. Rows that a ray from
the centre meets first and alone are known to bind without a linear program.
"""

from dataclasses import dataclass

import numpy as np

from otolith.core.arrays import Bools, Ints, Mat, Vec
from otolith.mpqp.leastdistance import LeastDistance
from otolith.mpqp.problem import NoRegions

_REDUNDANT = 1e-9  # largest excess at which a row counts as implied by the others
_FLAT = 1e-10  # largest inscribed radius at which the joint polytope counts as flat
_RAYS = 2000
_EXACT = 1e-10  # tolerance of the linear programs


@dataclass(frozen=True, slots=True)
class Pruned:
    """The problem without redundant rows, and a feasible parameter (p,) far inside, if there is one."""

    form: LeastDistance
    inside: Vec


def prune(form: LeastDistance) -> Pruned:
    """Drop every redundant row.

    Raises
    ------
    NoRegions : no parameter of the box is feasible.
    """
    A, b = _joint(form)
    centre, radius = _deepest(A, b)
    if not radius > -_REDUNDANT:
        raise NoRegions("no parameter in the box is feasible")
    m, _, p = form.sizes
    unique = _first_of_equals(A, b)
    binding = _hit_by_rays(A, b, centre) if radius > _FLAT else np.zeros(len(b), dtype=np.bool_)
    keep = unique | (np.arange(len(b)) >= m)
    for i in np.flatnonzero(keep[:m] & ~binding[:m]):
        keep[i] = False
        keep[i] = not _implied(A[keep], b[keep], A[i], b[i])
    return Pruned(form.without(np.flatnonzero(~keep[:m])), centre[-p:])


def _joint(form: LeastDistance) -> tuple[Mat, Vec]:
    """Return A (m + 2p + ne, n + p) and b of the joint polytope."""
    _, n, p = form.sizes
    M = _rows_from_gram(form)
    box = np.vstack([np.eye(p), -np.eye(p), form.E.T])
    A = np.block([[M, -form.d[:p].T], [np.zeros((len(box), n)), box]])
    b = np.concatenate([form.d[p], np.ones(2 * p), form.e])
    length = np.linalg.norm(A, axis=1)
    return A / length[:, None], b / length


def _rows_from_gram(form: LeastDistance) -> Mat:
    """Return M (m, n) with M M' = Q, up to a rotation of u that does not matter here."""
    m, n, _ = form.sizes
    values, vectors = np.linalg.eigh(form.Q)
    M = np.zeros((m, n))
    r = min(m, n)
    M[:, :r] = vectors[:, ::-1][:, :r] * np.sqrt(np.maximum(values[::-1][:r], 0.0))
    return M


def _maximum(cost: Vec, A: Mat, b: Vec) -> tuple[float, Vec]:
    """Maximise cost·x over A x ≤ b; return the value and x. Infinite if unbounded, NaN if infeasible."""
    from scipy.optimize import (
        linprog,
    )  # imported on use, since this import takes longer than the rest of the package

    result = linprog(
        -cost,
        A_ub=A,
        b_ub=b,
        bounds=(None, None),
        options={"primal_feasibility_tolerance": _EXACT, "dual_feasibility_tolerance": _EXACT},
    )
    if result.status == 0 and result.fun is not None:
        return -float(result.fun), np.asarray(result.x)
    return (np.inf if result.status == 3 else np.nan), np.full(len(cost), np.nan)


def inscribed(A: Mat, b: Vec) -> float:
    """Radius, at most one, of the largest ball in {x: A x ≤ b}; negative when that is empty."""
    return _deepest(A, b)[1]


def largest_ball(A: Mat, b: Vec, reach: Vec) -> float:
    """Largest r with A x + reach r ≤ b for some x; a ball in other units extends reach_i (m,) towards row
    i.
    """
    radius, _ = _maximum(np.eye(A.shape[1] + 1)[-1], np.column_stack([A, reach]), b)
    return radius


def _deepest(A: Mat, b: Vec) -> tuple[Vec, float]:
    """Centre and radius of a largest ball in the polytope; the radius is at most one."""
    size = A.shape[1]
    rows = np.vstack([np.column_stack([A, np.ones(len(b))]), np.eye(size + 1)[-1]])
    radius, x = _maximum(np.eye(size + 1)[-1], rows, np.append(b, 1.0))
    return x[:-1], radius


def _first_of_equals(A: Mat, b: Vec) -> Bools:
    """Mark the rows that do not repeat an earlier row."""
    unique = np.ones(len(b), dtype=np.bool_)
    data = np.column_stack([A, b])
    for i in range(1, len(b)):
        unique[i] = not (np.abs(data[:i] - data[i]).max(axis=1) < 1e-12)[unique[:i]].any()
    return unique


def _hit_by_rays(A: Mat, b: Vec, centre: Vec) -> Bools:
    """Mark the rows that some random ray from the centre meets strictly before every other row."""
    directions = np.random.default_rng(0).standard_normal((_RAYS, A.shape[1]))
    directions = np.vstack([directions, A, -A])
    with np.errstate(divide="ignore"):
        reach = 1.0 / np.maximum((directions @ A.T) / (b - A @ centre), 0.0)  # (rays, rows)
    first = reach.argmin(axis=1)
    nearest = np.partition(reach, 1, axis=1)
    alone = (nearest[:, 1] - nearest[:, 0] > 1e-6 * nearest[:, 0]) & np.isfinite(nearest[:, 0])
    hit = np.zeros(len(b), dtype=np.bool_)
    hit[first[alone]] = True
    return hit


def _implied(A: Mat, b: Vec, row: Vec, bound: float) -> bool:
    """True when row x ≤ bound follows from A x ≤ b; the row itself is relaxed by one meanwhile."""
    greatest, _ = _maximum(row, np.vstack([A, row]), np.append(b, bound + 1.0))
    return greatest <= bound + _REDUNDANT


def flat_directions(form: LeastDistance) -> Ints:
    """Parameters for which the feasible set leaves no room; see the error of `enumerate_regions`."""
    A, b = _joint(form)
    p = form.sizes[2]
    units = np.eye(A.shape[1])[-p:]
    widths = [_maximum(unit, A, b)[0] + _maximum(-unit, A, b)[0] for unit in units]
    return np.flatnonzero(np.array(widths) < 1e-7)
