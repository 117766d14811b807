"""Whether an axis can be kept in its set for ever: a linear program at every vertex.

A set S = {x : C x ≤ b}, b > 0, is *λ-contractive* when from each of its states a command leads into λ S. Let
commands u_i do so from the vertices x_i. A state Σ θ_i x_i, θ_i ≥ 0, Σ θ_i = 1, is led by Σ θ_i u_i to
Σ θ_i (A x_i + B u_i), which lies in λ S: it is convex. So the vertices decide, exactly (Gutman & Cwikel,
1986; Blanchini, 1994). With λ < 1 there is room for what a solver leaves of a row.

Surge and sway keep (z_surge, z_sway) within a circle together. It is enough that from every state of each
axis' set a command leads into λ S with |z⁺| ≤ (1 − μ) |z|. That holds where it does at the vertices of the
two *cells* S ∩ {z ≥ 0} and S ∩ {z ≤ 0}, in which the condition is linear.
"""

import math
from functools import lru_cache
from typing import Final, NamedTuple

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.safety.invariant.axis import Axis, AxisSet
from otolith.safety.invariant.polytope import halfspaces, vertices

CONTRACTION: Final = 1e-11  # least 1 − λ of a set that counts as found, far above rounding
_STEP: Final = 1.1  # between one time ahead that is tried and the next
_TRIED: Final = 120


class Cell(NamedTuple):
    """A part of an axis' set with the command that is proved at each of its vertices."""

    side: int  # +1 or −1: where z has this sign; 0: all of the set
    vertices: Mat  # (n, 3)
    commands: Vec  # (n,)


def sides(axis: Axis) -> tuple[int, ...]:
    """Sides of the cells that an axis' set consists of."""
    return (1, -1) if axis.shares_circle else (0,)


def cells(of: AxisSet) -> tuple[Cell, ...]:
    """The cells of the set of an axis, with the best command at each vertex."""
    return tuple(cell for cell, _ in _judged(of))


def shrink(of: AxisSet) -> float:
    """λ of the set of an axis, that of its worst vertex; infinite where some vertex has no command at all."""
    return max(float(shrinks.max()) for _, shrinks in _judged(of))


def _judged(of: AxisSet) -> list[tuple[Cell, Vec]]:
    """Every cell with the λ (n,) of its vertices."""
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
    """The facets (C, b) of a cell."""
    rows = of.rows
    C, b = halfspaces(rows)
    return (np.vstack([C, -side * C[len(rows) - 1]]), np.append(b, 0.0)) if side else (C, b)


def _commands(axis: Axis, X: Mat, z: Vec) -> tuple[Vec, Vec]:
    """Bounds (n,) on the commands at X (n, 3): U, and where z (3,) is not zero, |z⁺| ≤ (1 − μ) z."""
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

    A linear program in two variables: λ is the greatest of as many straight lines of u as F has rows, so the
    least λ lies where two of them meet, or at an end.

    Returns
    -------
    u (n,) and λ (n,); λ = ∞ where no command is allowed.
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
    """The first τ [s] of `least`, 1.1 `least`, 1.21 `least` … with which all axes have contractive sets.

    None where there is none: then some braking law asks for more than its axis can do.
    """
    for ahead in least * _STEP ** np.arange(_TRIED):
        if all(shrink(AxisSet(axis, ahead)) <= 1.0 - CONTRACTION for axis in axes):
            return float(ahead)
    return None
