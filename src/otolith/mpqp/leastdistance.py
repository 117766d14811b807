"""A parametric QP in the form that the engine works on: a least-distance problem over a unit box.

Notation: θ = c + s τ with τ in [-1, 1]^p; H = R'R; z = z_free(τ) + σ R⁻¹ u, where z_free is the
unconstrained minimiser. Then the QP is min ½|u|² subject to M u ≤ d(τ), the rows of M of length one.
An optimal u is -M'λ with λ ≥ 0, so that for the active rows A

    λ_A = -Q_AA⁻¹ d_A(τ),   slack_i = d_i(τ) + Q_iA λ_A,   Q = M M',   z = Z τ + z0 - V_A' λ_A.

Derivation: substitute z and complete the square; σ makes the largest |d| one, so that tolerances do
not depend on the scale of the cost. Checked by test_least_distance_form_has_the_same_minimiser.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from otolith.core.arrays import Ints, Mat, Vec, frozen_array
from otolith.mpqp.problem import NoRegions, ParametricQp

_ZERO_ROW = 1e-9  # a constraint row shorter than this, relative to the longest, does not hold z
_MIRROR = 1e-10  # two rows within this are mirror images of each other


@dataclass(frozen=True, slots=True, kw_only=True)
class LeastDistance:
    """min ½|u|² subject to M u ≤ d(τ), τ in the unit box and E'τ ≤ e; m rows, n variables.

    Column p of the affine arrays is the constant part. `mirror` pairs every row with the row that
    is its image under τ → -τ, u → -u; it is empty when the problem is not centrally symmetric.
    """

    centre: Vec  # (p,) c
    half: Vec  # (p,) s
    rows: Ints  # (m,) the constraint of the parametric QP behind each row
    weights: Vec  # (m,) multiplier of the parametric QP = weight · λ
    Q: Mat  # (m, m)
    d: Mat  # (p + 1, m)
    V: Mat  # (m, n)
    Z: Mat  # (n, p + 1)
    E: Mat  # (p, ne) rows of constraints on the parameter alone, each of length one
    e: Vec  # (ne,)
    mirror: Ints  # (m,) or (0,)

    def __post_init__(self) -> None:
        for name in ("centre", "half", "weights", "Q", "d", "V", "Z", "E", "e"):
            object.__setattr__(self, name, frozen_array(getattr(self, name)))
        for name in ("rows", "mirror"):
            object.__setattr__(self, name, frozen_array(getattr(self, name), dtype=np.int64))

    @property
    def sizes(self) -> tuple[int, int, int]:
        """Rows m, variables n and parameters p."""
        return self.V.shape[0], self.V.shape[1], len(self.half)

    def scaled(self, theta: Mat) -> Mat:
        """τ of θ, for one point (p,) or many (N, p)."""
        tau: Mat = (theta - self.centre) / self.half
        return tau

    def without(self, dropped: Ints) -> "LeastDistance":
        """The same problem with some rows left out; the symmetry is looked for anew."""
        keep = np.setdiff1d(np.arange(len(self.rows)), dropped)
        return _assemble(
            self.centre, self.half, self.rows[keep], self.weights[keep],
            self.Q[np.ix_(keep, keep)], self.d[:, keep], self.V[keep], self.Z, self.E, self.e,
        )  # fmt: skip

    def unsymmetric(self) -> "LeastDistance":
        """The same problem with its central symmetry not made use of."""
        names = ("centre", "half", "rows", "weights", "Q", "d", "V", "Z", "E", "e")
        return LeastDistance(
            **{name: getattr(self, name) for name in names}, mirror=np.empty(0, dtype=np.int64)
        )


def least_distance(problem: ParametricQp) -> LeastDistance:
    """Transform, scale, and split off the constraints that do not hold z.

    Raises
    ------
    NoRegions : a constraint holds neither z nor the parameter and cannot be met.
    """
    c, s = (problem.lower + problem.upper) / 2, (problem.upper - problem.lower) / 2
    factor = cho_factor(problem.H)
    W = cho_solve(factor, problem.G.T).T  # (m, n) G H⁻¹
    Z = -cho_solve(factor, np.column_stack([problem.F * s, problem.f + problem.F @ c]))
    d = np.column_stack([problem.S * s, problem.w + problem.S @ c]) - problem.G @ Z  # (m, p + 1)
    length = np.sqrt(np.maximum(np.einsum("ij,ij->i", problem.G, W), 0.0))
    holds = length > _ZERO_ROW * max(1e-300, float(length.max(initial=0.0)))
    E, e = _parameter_rows(np.flatnonzero(~holds), d)
    rows = np.flatnonzero(holds)
    unit = 1.0 / length[rows]
    dn = (d[rows] * unit[:, None]).T
    sigma = float(np.abs(dn).max(initial=0.0)) or 1.0
    Q = (problem.G[rows] @ W[rows].T) * np.outer(unit, unit)
    V = W[rows] * (sigma * unit)[:, None]
    return _assemble(c, s, rows, sigma * unit, Q, dn / sigma, V, Z, E, e)


def _assemble(
    centre: Vec, half: Vec, rows: Ints, weights: Vec, Q: Mat, d: Mat, V: Mat, Z: Mat, E: Mat, e: Vec
) -> LeastDistance:
    symmetric = (Q + Q.T) / 2
    return LeastDistance(
        centre=centre, half=half, rows=rows, weights=weights, Q=symmetric, d=d, V=V, Z=Z, E=E, e=e,
        mirror=_mirror(d, V, E, e),
    )  # fmt: skip


def _parameter_rows(free: Ints, d: Mat) -> tuple[Mat, Vec]:
    """Constraints without z as unit rows E'τ ≤ e; those that always hold are dropped."""
    E, e = -d[free, :-1], d[free, -1]
    length = np.linalg.norm(E, axis=1)
    bound = length > 1e-12 * (1.0 + np.abs(e))
    if (e[~bound] < -1e-9).any():
        row = int(free[~bound][np.argmin(e[~bound])])
        raise NoRegions(f"constraint {row} holds no variable and no parameter, and is violated")
    E, e = E[bound] / length[bound, None], e[bound] / length[bound]
    binding = np.abs(E).sum(axis=1) > e
    return np.ascontiguousarray(E[binding].T), e[binding]


def _mirror(d: Mat, V: Mat, E: Mat, e: Vec) -> Ints:
    """For each row the row that is its image under central symmetry; empty if one has none."""
    none = np.empty(0, dtype=np.int64)
    if d.shape[1] == 0 or _partners(np.column_stack([E.T, e]), 1) is None:
        return none
    scale = float(np.abs(V).max()) or 1.0
    partners = _partners(np.column_stack([V / scale, d.T]), 1)
    if partners is None or (partners[partners] != np.arange(len(partners))).any():
        return none
    return partners


def _partners(data: Mat, even: int) -> Ints | None:
    """Index of the row equal to each row with the sign of all but the last `even` columns changed."""
    image = data.copy()
    image[:, :-even] *= -1.0
    partners = np.empty(len(data), dtype=np.int64)
    for i, row in enumerate(image):
        gap = np.abs(data - row).max(axis=1)
        partners[i] = gap.argmin()
        if gap[partners[i]] > _MIRROR:
            return None
    return partners
