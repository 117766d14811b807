"""The form of a parametric QP that the engine works on: a least-distance problem over a unit box.

Notation: θ = c + s τ with τ in [-1, 1]^p; H = R'R; z = z_free(τ) + σ R⁻¹ u, where z_free is the unconstrained
minimiser. Then the QP is min ½|u|² subject to M u ≤ d(τ), with rows of M of length one. An optimal u is -M'λ
with λ ≥ 0, so that for the active rows A

    λ_A = -Q_AA⁻¹ d_A(τ),   slack_i = d_i(τ) + Q_iA λ_A,   Q = M M',   z = Z τ + z0 - V_A' λ_A.

Derivation: substitute z and complete the square. Checked by
test_least_distance_form_has_the_same_minimiser.

Units: u is dimensionless. Its unit σ makes the largest |d| one, so that no tolerance depends on the units of
the cost, of z, of the rows or of θ. Where curvature is weak, or a row is far away, |d| is not typical of the
set in which z moves; so σ is at most REACH times the *span* of the rows, the distance of the median row from
z = 0. The *grain* states how much coarser than usual rounding then is: the unconstrained minimiser lies so
far outside that its distance, of which the slacks are small differences, exceeds REACH spans by this factor.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from otolith.core.arrays import Bools, Ints, Mat, Vec, frozen_array
from otolith.mpqp.dualqp import LOOSE, RETRIED, TIGHT
from otolith.mpqp.problem import InvalidProblem, NoRegions, ParametricQp

REACH = 1e3  # largest unit of u in spans of the rows; the laws of platforms have 17 to 160
_FAR = 1e9  # a row further away from z = 0 than this many spans does not constrain z
_COARSEST = 1e4  # largest grain at which the engine's decisions are known to be correct
_MIRROR = 1e-10  # two rows that agree to within this are mirror images of each other


@dataclass(frozen=True, slots=True, kw_only=True)
class LeastDistance:
    """The problem min ½|u|² subject to M u ≤ d(τ), τ in the unit box and E'τ ≤ e; m rows, n variables.

    Column p of the affine arrays is the constant part. `mirror` maps every row to its image under τ → -τ, u →
    -u; it is empty when the problem is not centrally symmetric.
    """

    centre: Vec  # (p,) c
    half: Vec  # (p,) s
    rows: Ints  # (m,) the constraint of the parametric QP behind each row
    weights: Vec  # (m,) multiplier of the parametric QP = weight · λ
    place: Vec  # (m,) largest distance of each row from z = 0 over the box
    Q: Mat  # (m, m)
    d: Mat  # (p + 1, m)
    V: Mat  # (m, n)
    Z: Mat  # (n, p + 1)
    E: Mat  # (p, ne) rows of constraints on the parameter alone, each of length one
    e: Vec  # (ne,)
    mirror: Ints  # (m,) or (0,)

    def __post_init__(self) -> None:
        for name in ("centre", "half", "weights", "place", "Q", "d", "V", "Z", "E", "e"):
            object.__setattr__(self, name, frozen_array(getattr(self, name)))
        for name in ("rows", "mirror"):
            object.__setattr__(self, name, frozen_array(getattr(self, name), dtype=np.int64))

    @property
    def sizes(self) -> tuple[int, int, int]:
        """Numbers of rows m, variables n and parameters p."""
        return self.V.shape[0], self.V.shape[1], len(self.half)

    @property
    def grain(self) -> float:
        """Factor by which rounding is coarser than in a well-scaled problem, at least 1."""
        return max(1.0, _outside(self.d) / (REACH * _span(self.place)))

    @property
    def blur(self) -> float:
        """Largest violation, in spans of the rows, at which the engine may call a parameter feasible."""
        return max(LOOSE, RETRIED * TIGHT * self.grain) / _span(self.place)

    def scaled(self, theta: Mat) -> Mat:
        """Convert θ to τ, for one point (p,) or many (N, p)."""
        tau: Mat = (theta - self.centre) / self.half
        return tau

    def without(self, dropped: Ints) -> "LeastDistance":
        """Return this problem without the rows `dropped`; its symmetry is determined anew."""
        keep = np.setdiff1d(np.arange(len(self.rows)), dropped)
        rows = _Rows(
            self.rows[keep], self.weights[keep], self.place[keep], self.Q[np.ix_(keep, keep)],
            self.d[:, keep], self.V[keep],
        )  # fmt: skip
        return _assemble(self.centre, self.half, rows.in_unit(_unit(1.0, rows.place)), self.Z, self.E, self.e)

    def unsymmetric(self) -> "LeastDistance":
        """Return this problem with its central symmetry ignored."""
        names = ("centre", "half", "rows", "weights", "place", "Q", "d", "V", "Z", "E", "e")
        return LeastDistance(
            **{name: getattr(self, name) for name in names}, mirror=np.empty(0, dtype=np.int64)
        )


class _Rows(NamedTuple):
    """The arrays of `LeastDistance` that belong to the rows."""

    numbers: Ints
    weights: Vec
    place: Vec
    Q: Mat
    d: Mat
    V: Mat

    def in_unit(self, sigma: float) -> "_Rows":
        """Return the rows in a unit of u that is `sigma` times the current one."""
        return self._replace(
            weights=sigma * self.weights, place=self.place / sigma, d=self.d / sigma, V=sigma * self.V
        )


def least_distance(problem: ParametricQp) -> LeastDistance:
    """Transform and scale a problem, and separate the constraints that do not involve z.

    Raises
    ------
    NoRegions : a constraint involves neither z nor the parameter and cannot be satisfied.
    InvalidProblem : the cost has so little curvature for its slope that rounding would decide.
    """
    c, s = (problem.lower + problem.upper) / 2, (problem.upper - problem.lower) / 2
    factor = cho_factor(problem.H)
    W = cho_solve(factor, problem.G.T).T  # (m, n) G H⁻¹
    Z = -cho_solve(factor, np.column_stack([problem.F * s, problem.f + problem.F @ c]))
    right = np.column_stack([problem.S * s, problem.w + problem.S @ c])  # (m, p + 1)
    d = right - problem.G @ Z
    length = np.sqrt(np.maximum(np.einsum("ij,ij->i", problem.G, W), 0.0))
    place, holds = _places(length, np.abs(right).sum(axis=1))
    E, e = _parameter_rows(np.flatnonzero(~holds), d, np.abs(right))
    unit = 1.0 / length[holds]
    rows = _Rows(
        np.flatnonzero(holds), unit, place[holds],
        (problem.G[holds] @ W[holds].T) * np.outer(unit, unit), (d[holds] * unit[:, None]).T,
        W[holds] * unit[:, None],
    )  # fmt: skip
    sigma = _unit(float(np.abs(rows.d).max(initial=0.0)) or 1.0, rows.place)
    return _assemble(c, s, rows.in_unit(sigma), Z, E, e)


def _places(length: Vec, level: Vec) -> tuple[Vec, Bools]:
    """Distance (m,) from z = 0 of rows of these lengths, and which of them involve z."""
    place = np.divide(level, length, out=np.full(len(level), np.inf), where=length > 0.0)
    return place, (length > 0.0) & (place <= _FAR * _span(place))


def _span(place: Vec) -> float:
    """Median distance of the rows from z = 0, without rows through zero; infinite if there are no others."""
    away = place[(place > 0.0) & np.isfinite(place)]
    return float(np.median(away)) if len(away) else np.inf


def _unit(sigma: float, place: Vec) -> float:
    """Choose the unit of u: `sigma`, or less if that lies far beyond the rows."""
    return min(sigma, REACH * _span(place))


def _outside(d: Mat) -> float:
    """Largest distance over the box by which the unconstrained minimiser violates a row; 0 if it violates
    none.
    """
    return max(0.0, float(np.max(np.abs(d[:-1]).sum(axis=0) - d[-1], initial=0.0)))


def _assemble(centre: Vec, half: Vec, rows: _Rows, Z: Mat, E: Mat, e: Vec) -> LeastDistance:
    form = LeastDistance(
        centre=centre, half=half, rows=rows.numbers, weights=rows.weights, place=rows.place,
        Q=(rows.Q + rows.Q.T) / 2, d=rows.d, V=rows.V, Z=Z, E=E, e=e, mirror=_mirror(rows.d, rows.V, E, e),
    )  # fmt: skip
    if form.grain > _COARSEST:
        raise InvalidProblem(
            f"without constraints the minimiser lies {REACH * form.grain:.1g} times further away than the "
            f"constraints, must be at most {REACH * _COARSEST:.0e} times: the cost has too little curvature "
            "for its slope; add a quadratic cost, or take less of the linear one"
        )
    return form


def _parameter_rows(free: Ints, d: Mat, size: Mat) -> tuple[Mat, Vec]:
    """Return the constraints without z as unit rows E'τ ≤ e, without those that always hold.

    `size` (m, p + 1) contains the magnitudes of the terms; a remainder that is small relative to it is
    rounding.
    """
    E, e = -d[free, :-1], d[free, -1]
    length = np.linalg.norm(E, axis=1)
    bound = length > 1e-12 * (length + np.abs(e))
    if (violated := ~bound & (e < -1e-9 * size[free].sum(axis=1))).any():
        row = int(free[violated][0])
        raise NoRegions(f"constraint {row} holds no variable and no parameter, and is violated")
    E, e = E[bound] / length[bound, None], e[bound] / length[bound]
    binding = np.abs(E).sum(axis=1) > e
    return np.ascontiguousarray(E[binding].T), e[binding]


def _mirror(d: Mat, V: Mat, E: Mat, e: Vec) -> Ints:
    """Find each row's image under central symmetry; empty if a row has none."""
    none = np.empty(0, dtype=np.int64)
    if d.shape[1] == 0 or _partners(np.column_stack([E.T, e]), 1) is None:
        return none
    scale = np.maximum(np.abs(V).max(axis=0), 1e-300)  # each variable in its own unit
    partners = _partners(np.column_stack([V / scale, d.T]), 1)
    if partners is None or (partners[partners] != np.arange(len(partners))).any():
        return none
    return partners


def _partners(data: Mat, even: int) -> Ints | None:
    """For each row, find the row that is equal except for the sign of all but the last `even` columns."""
    image = data.copy()
    image[:, :-even] *= -1.0
    partners = np.empty(len(data), dtype=np.int64)
    for i, row in enumerate(image):
        gap = np.abs(data - row).max(axis=1)
        partners[i] = gap.argmin()
        if gap[partners[i]] > _MIRROR:
            return None
    return partners
