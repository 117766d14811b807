"""Eliminate equality constraints before the engine sees the problem.

Notation: minimise ½ z'Hz + (f + F θ)'z subject to A z = b + B θ and G z ≤ w + S θ. With Y spanning the kernel
of A and A⁺ its pseudo-inverse, z = Y y + A⁺(b + B θ); the problem in y has no equalities. H need be positive
definite only on the kernel of A. Rows of A may depend on each other if their right-hand sides agree for every
θ.
"""

from dataclasses import dataclass

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.mpqp.problem import InvalidProblem, NoRegions, ParametricQp, unit_curvature

_RANK = 1e-10  # singular values of A below this part of the largest count as zero (rows of length one)
_AGREE = 1e-9  # largest contradiction of right-hand sides, relative to their size over the box
_ROUNDING = 1e-12  # a difference below this part of its terms counts as zero


@dataclass(frozen=True, slots=True)
class Eliminated:
    """A problem without equalities, and the way back to the original variables: z = Y y + z0 + Z θ."""

    problem: ParametricQp
    Y: Mat  # (n, n')
    z0: Vec  # (n,)
    Z: Mat  # (n, p)

    def lift(self, y: Vec, theta: Vec) -> Vec:
        """Compute z (n,) from the reduced minimiser y (n',) at θ (p,)."""
        z: Vec = self.Y @ y + self.z0 + self.Z @ theta
        return z


def eliminate(
    *, H: Mat, F: Mat, f: Vec, G: Mat, w: Vec, S: Mat, lower: Vec, upper: Vec, A: Mat, b: Vec, B: Mat
) -> Eliminated:
    """Solve A z = b + B θ for some of the variables.

    Raises
    ------
    NoRegions : the equalities contradict each other, for all θ or for all but a flat set of θ.
    InvalidProblem : no free variable is left, or the reduced problem is not strictly convex.
    """
    unit = unit_curvature(H)
    scaled = A * unit
    length = np.linalg.norm(scaled, axis=1)
    length = np.where(length > 0.0, length, 1.0)
    U, size, Vt = np.linalg.svd(scaled / length[:, None])
    rank = int((size > _RANK * size.max(initial=1e-300)).sum())
    right = np.column_stack([b + B @ (lower + upper) / 2, B * (upper - lower) / 2]) / length[:, None]
    if np.abs(U[:, rank:].T @ right).max(initial=0.0) > _AGREE * np.abs(right).sum(axis=1).max(initial=0.0):
        raise NoRegions("the equality constraints contradict each other for almost every parameter")
    if rank == A.shape[1]:
        raise InvalidProblem(f"{rank} independent equalities fix all {rank} variables")
    Y = unit[:, None] * Vt[rank:].T
    inverse = unit[:, None] * (Vt[:rank].T @ (U[:, :rank].T / size[:rank, None])) / length
    z0, Z = inverse @ b, inverse @ B
    curvature = Y.T @ H @ Y
    problem = ParametricQp(
        H=(curvature + curvature.T) / 2, F=Y.T @ (F + H @ Z), f=Y.T @ (f + H @ z0),
        G=_difference(np.zeros_like(G @ Y), -G, Y), w=_difference(w, G, z0), S=_difference(S, G, Z),
        lower=lower, upper=upper,
    )  # fmt: skip
    return Eliminated(problem, Y, z0, Z)


def _difference(whole: Mat, left: Mat, right: Mat) -> Mat:
    """Return whole - left @ right; entries that consist only of rounding errors become zero."""
    rest = whole - left @ right
    size = np.abs(whole) + np.abs(left) @ np.abs(right)
    return np.where(np.abs(rest) > _ROUNDING * size, rest, 0.0)
