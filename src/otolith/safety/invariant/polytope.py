"""Polytopes {x : C x ≤ b} in three dimensions, with few facets."""

from collections.abc import Sequence
from functools import cache
from itertools import combinations
from typing import Final

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.safety.invariant.axis import AxisRow

_NEAR: Final = 1e-9  # a point within this of a facet, in scaled numbers, lies on it
_PARALLEL: Final = 1e-9  # three scaled facets with a smaller determinant have no common point


def halfspaces(rows: Sequence[AxisRow]) -> tuple[Mat, Vec]:
    """Return C (2 r, 3) and b (2 r,) of rows: their upper sides, then their lower ones."""
    forms = np.array([[row.place, row.speed, row.acceleration] for row in rows])
    upper, lower = (np.array([getattr(row, side) for row in rows]) for side in ("upper", "lower"))
    return np.vstack([forms, -forms]), np.concatenate([upper, -lower])


@cache
def _triples(facets: int) -> Ints:
    """Return all triples of facets (n, 3)."""
    return np.array(list(combinations(range(facets), 3)))


def vertices(C: Mat, b: Vec, scale: Vec) -> Mat:
    """Return all vertices (n, 3) of a bounded polytope: every three facets are intersected.

    Parameters
    ----------
    scale : (3,) typical size of each coordinate.
    """
    D = C * scale
    length = np.abs(D).max(axis=1)
    D, d = D / length[:, None], b / length
    triples = _triples(len(d))
    corners = np.abs(np.linalg.det(D[triples])) > _PARALLEL
    points = np.linalg.solve(D[triples][corners], d[triples][corners][..., None])[..., 0]
    inside = (points @ D.T <= d + _NEAR).all(axis=1)
    distinct: Mat = points[inside][_first_of_each(points[inside])]
    return distinct * scale


def _first_of_each(points: Mat) -> Ints:
    """Return the indices of distinct points, one for each group that coincides."""
    apart = np.abs(points[:, None] - points[None]).max(axis=2) > 10.0 * _NEAR
    return np.flatnonzero((apart | ~np.tri(len(points), k=-1, dtype=bool)).all(axis=1))
