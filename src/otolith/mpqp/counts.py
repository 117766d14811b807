"""Count the regions of a law by more than one definition of what counts as a region.

Where a thesis or a paper prints a number of regions, it leaves two things open:

- how thin a region may be. `enumerate_regions` measures the largest ball with the parameter box scaled to
  [-1, 1]^p. The Multi-Parametric Toolbox (Herceg, Kvasnica, Jones & Morari, 2013) measures it in the
  parameters' own units and requires a diameter of 1e-7 (`region_tol`): see `count_regions`.
- whether regions may overlap. Where more constraints bind than there are independent ones, several active
  sets are optimal at one parameter; a law keeps one of them (`dualqp`). `overlapping_sets` finds the others.

The notation is that of `leastdistance`; τ = (θ - c) / s. A ball of radius r in θ/scale lies within a'τ ≤ b,
|a| = 1, when a'x + r |a·scale/s| ≤ b at its centre x. Derivation: the greatest a'(τ - x) over
|(θ - θ_x)/scale| ≤ r. Checked by test_radii_in_own_units_are_those_of_a_general_solver.
"""

from itertools import combinations
from typing import Final

import numpy as np

from otolith.core.arrays import Bools, Ints, Mat, Vec
from otolith.core.jit import jit_entry
from otolith.mpqp.geometry import affine_multipliers, affine_slacks
from otolith.mpqp.law import Law
from otolith.mpqp.leastdistance import LeastDistance
from otolith.mpqp.prune import largest_ball
from otolith.mpqp.region import Form, Work, halfspaces, kernel_form, start_ball, work_memory
from otolith.mpqp.simplex import UNDECIDED, factorise, solve

NO_REGION: Final = -1.0  # radius of a set that is dependent, weakly active or never optimal
_NULL: Final = (
    1e-9  # a function of the parameter with gradient, slack and multiplier up to this size counts as zero
)


def ball_radii(law: Law, scale: Vec | None = None) -> Vec:
    """Radius (h,) of the largest ball in every stored region, in θ/scale.

    Parameters
    ----------
    law : only its stored regions are measured, one of each mirror pair.
    scale : (p,) in the units of the parameters; None measures the ball in these units themselves.
    """
    return _radii(law.form, law.bits(), np.ones(len(law.form.half)) if scale is None else scale)


def count_regions(law: Law, radius: float, scale: Vec | None = None) -> int:
    """Count the regions, mirror images included, that contain a ball of `radius` in θ/scale (see
    `ball_radii`).

    Regions thinner than the tolerance of the law are not in it. For a full count the tolerance must be at
    most radius · min(scale/s), where s is half the parameter box.
    """
    large = ball_radii(law, scale) >= radius
    return int(2 * large.sum() - large[: law.alone].sum())


def overlapping_sets(law: Law, radius: float, scale: Vec | None = None) -> set[tuple[int, ...]]:
    """Find active sets besides those of the law that are optimal throughout a ball of `radius` in θ/scale.

    Each is independent, with no multiplier that is zero throughout, and is given as rows of `law.form`. The
    result is complete: the law has a set for every affine minimiser; any other set with the same minimiser
    lies among the rows B that bind wherever it holds, and remains when zero multipliers are dropped from a
    basis of B. The work grows with the number of such bases, which is binomial in the number of dependent
    rows.
    """
    form = law.form
    own = {tuple(law.form_rows(region).tolist()) for region in range(len(law))}
    tied = {rows for rows in _all_binding(law) if _rank(form, rows) < len(rows)}
    others = sorted({found for rows in tied for found in _supports(form, rows)} - own)
    active = np.zeros((len(others), len(form.rows)), dtype=np.bool_)
    for place, rows in enumerate(others):
        active[place, list(rows)] = True
    large = _radii(form, active, np.ones(len(form.half)) if scale is None else scale) >= radius
    return {rows for rows, keep in zip(others, large, strict=True) if keep}


def _all_binding(law: Law) -> set[tuple[int, ...]]:
    """For each region with more rows that bind throughout than are active, these rows; mirror images
    included.
    """
    form, found = law.form, set()
    for region in range(len(law.radius)):
        A = law.form_rows(region)
        zero = np.abs(affine_slacks(form, A)).max(axis=1) < _NULL
        zero[A] = True
        if zero.sum() > len(A):
            rows = np.flatnonzero(zero)
            found.add(tuple(rows.tolist()))
            if len(form.mirror):
                found.add(tuple(np.sort(form.mirror[rows]).tolist()))
    return found


def _rank(form: LeastDistance, rows: tuple[int, ...]) -> int:
    return int(np.linalg.matrix_rank(form.Q[np.ix_(rows, rows)], tol=_NULL)) if rows else 0


def _supports(form: LeastDistance, rows: tuple[int, ...]) -> set[tuple[int, ...]]:
    """For each basis of dependent rows, the rows whose multipliers are not zero throughout."""
    rank = _rank(form, rows)
    found = set()
    for basis in combinations(rows, rank):
        if _rank(form, basis) == rank:
            held = np.abs(affine_multipliers(form, np.array(basis))).max(axis=1) > _NULL
            found.add(tuple(np.array(basis)[held].tolist()))
    return found


def _radii(form: LeastDistance, active: Bools, scale: Vec) -> Vec:
    """Radius (N,) of the largest ball in θ/scale of the sets (N, m); `NO_REGION` where there is none."""
    kernel = kernel_form(form)
    radius = np.empty(len(active))
    stretch = np.asarray(scale, dtype=np.float64) / form.half
    _measure(kernel, work_memory(kernel), np.ascontiguousarray(active), stretch, radius)
    for lost in np.flatnonzero(radius == UNDECIDED):
        radius[lost] = _by_general_solver(form, np.flatnonzero(active[lost]), stretch)
    return radius


@jit_entry
def _measure(form: Form, work: Work, active: Bools, stretch: Vec, radius: Vec) -> None:
    """Compute `_radii`, with UNDECIDED where the simplex method exceeds its number of steps."""
    lp = work.lp
    for t in range(active.shape[0]):
        k = 0
        for i in range(active.shape[1]):
            if active[t, i]:
                work.A[k] = i
                k += 1
        M = halfspaces(form, work, k)
        if M < 0:
            radius[t] = NO_REGION
            continue
        start_ball(work, M)
        for j in range(M):
            s = 0.0
            for c in range(stretch.shape[0]):
                s += (lp.A[c, j] * stretch[c]) ** 2
            lp.nu[j] = np.sqrt(s)
        factorise(lp, -1)
        radius[t] = solve(lp, M, -1, -1e300)


def _by_general_solver(form: LeastDistance, A: Ints, stretch: Vec) -> float:
    """Compute the radius for one active set with scipy's interior-point linear program."""
    affine = affine_slacks(form, A)
    affine[A] = affine_multipliers(form, A)
    rows = affine[np.linalg.norm(affine[:, :-1], axis=1) >= _NULL]
    rows = rows * np.append(-np.ones(len(stretch)), 1.0)
    rows /= np.linalg.norm(rows[:, :-1], axis=1, keepdims=True)
    p = len(stretch)
    box: Mat = np.vstack([rows[:, :-1], np.eye(p), -np.eye(p), form.E.T])
    level = np.concatenate([rows[:, -1], np.ones(2 * p), form.e])
    return largest_ball(box, level, np.linalg.norm(box * stretch, axis=1))
