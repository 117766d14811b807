"""Whether an axis can stay in its set for ever: a linear program at every vertex.

A set S = {x : C x ≤ b}, b > 0, is *λ-contractive* if from each of its states a command leads into λ S. Let
the commands u_i do so from the vertices x_i. From a state Σ θ_i x_i with θ_i ≥ 0, Σ θ_i = 1, the command Σ
θ_i u_i leads to Σ θ_i (A x_i + B u_i), which lies in λ S because λ S is convex. So it suffices to examine the
vertices, and this is exact (Gutman & Cwikel, 1986; Blanchini, 1994). With λ < 1 there is a margin for the
tolerance of a solver.

Surge and sway keep (z_surge, z_sway) within a circle together. It is sufficient that from every state of each
axis' set a command leads into λ S with |z⁺| ≤ (1 − μ) |z|. This holds if it holds at the vertices of the two
*cells* S ∩ {z ≥ 0} and S ∩ {z ≤ 0}, in which the condition is linear.
"""

import math
from functools import lru_cache
from typing import Final, NamedTuple

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.safety.invariant.axis import Axis, AxisSet
from otolith.safety.invariant.polytope import halfspaces, vertices

CONTRACTION: Final = 1e-11  # smallest 1 − λ of an accepted set, far above rounding errors
_STEP: Final = 1.1  # ratio of one time ahead to the previous one in the search
_TRIED: Final = 120  # number of times ahead in the search


class Cell(NamedTuple):
    """A part of an axis' set with the proved command at each of its vertices."""

    side: int  # +1 or −1: the part in which z has this sign; 0: the whole set
    vertices: Mat  # (n, 3)
    commands: Vec  # (n,)


def sides(axis: Axis) -> tuple[int, ...]:
    """Return the sides of the cells of which an axis' set consists."""
    return (1, -1) if axis.shares_circle else (0,)


def cells(of: AxisSet) -> tuple[Cell, ...]:
    """Return the cells of an axis' set, with the best command at each vertex."""
    return tuple(cell for cell, _ in _judged(of))


def shrink(of: AxisSet) -> float:
    """Return λ of an axis' set, that of its worst vertex; infinite if some vertex has no command."""
    return max(float(shrinks.max()) for _, shrinks in _judged(of))


def _judged(of: AxisSet) -> list[tuple[Cell, Vec]]:
    """Return every cell with the λ (n,) of its vertices."""
    axis, rows = of.axis, of.rows
    C, b = halfspaces(rows)
    z = C[len(rows) - 1]
    found = []
    for side in sides(axis):
        facets, bounds = cut(of, side)
        X = vertices(facets, bounds, axis.scale)
        low, high = _commands(axis, X, side * z)
        commands, shrinks = _best(axis, X, C / b[:, None], low, high)
        found.append((Cell(side, X, commands), shrinks))
    return found


def cut(of: AxisSet, side: int) -> tuple[Mat, Vec]:
    """Return the facets (C, b) of a cell."""
    rows = of.rows
    C, b = halfspaces(rows)
    return (np.vstack([C, -side * C[len(rows) - 1]]), np.append(b, 0.0)) if side else (C, b)


def _commands(axis: Axis, X: Mat, z: Vec) -> tuple[Vec, Vec]:
    """Return bounds (n,) on the commands at X (n, 3): U, and if z (3,) is not zero, |z⁺| ≤ (1 − μ) z."""
    A, B = axis.dynamics()
    low, high = np.full(len(X), -axis.command), np.full(len(X), axis.command)
    if z.any():
        now, then, by_u = (
            (1.0 - axis.towards_centre) * X @ z,
            X @ A.T @ z,
            z @ B,
        )  # z⁺ = then + by_u u, by_u ≠ 0
        ends = np.sort([(-now - then) / by_u, (now - then) / by_u], axis=0)
        low, high = np.maximum(low, ends[0]), np.minimum(high, ends[1])
    return low, high


def _best(axis: Axis, X: Mat, F: Mat, low: Vec, high: Vec) -> tuple[Vec, Vec]:
    """Minimise λ over u: F (A x + B u) ≤ λ, low ≤ u ≤ high, at every x of X (n, 3).

    This is a linear program in two variables. λ is the maximum of as many linear functions of u as F has
    rows, so the smallest λ lies where two of them meet, or at an end of the interval.

    Returns
    -------
    u (n,) and λ (n,); λ = ∞ if no command is allowed.
    """
    A, B = axis.dynamics()
    level, slope = X @ (F @ A).T, F @ B  # (n, m), (m,)
    i, j = np.triu_indices(len(slope), 1)
    meet = np.abs(slope[i] - slope[j]) > 1e-12 * np.abs(slope).max()
    i, j = i[meet], j[meet]
    crossing = (level[:, j] - level[:, i]) / (slope[i] - slope[j])  # (n, pairs)
    ends = [np.where(np.isfinite(end), end, 0.0)[:, None] for end in (low, high)]
    tried = np.clip(np.hstack([crossing, *ends]), low[:, None], np.maximum(low, high)[:, None])
    shrink = (level[:, None] + tried[..., None] * slope).max(axis=2)
    best = shrink.argmin(axis=1)[:, None]
    u, least = (np.take_along_axis(values, best, axis=1)[:, 0] for values in (tried, shrink))
    return u, np.where(low <= high, least, math.inf)


@lru_cache(maxsize=256)
def certified_ahead(axes: tuple[Axis, ...], least: float) -> float | None:
    """Return the first τ [s] of `least`, 1.1 `least`, … with which all axes have contractive sets.

    Returns None if there is none. Then some braking law asks more than its axis can do.
    """
    for ahead in least * _STEP ** np.arange(_TRIED):
        if all(shrink(AxisSet(axis, ahead)) <= 1.0 - CONTRACTION for axis in axes):
            return float(ahead)
    return None
