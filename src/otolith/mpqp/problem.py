"""The multi-parametric quadratic program and the errors of this package.

Notation: z decision (n,), θ parameter (p,), G z ≤ w + S θ the m constraints.
"""

import hashlib
from dataclasses import dataclass, fields

import numpy as np

from otolith.core.arrays import Mat, Vec, freeze
from otolith.core.errors import OtolithError

_LEAST_CURVATURE = 1e-13  # smallest accepted eigenvalue of H with its diagonal scaled to one


class InvalidProblem(OtolithError):
    """The data do not describe a strictly convex multi-parametric QP."""


class NoRegions(OtolithError):
    """The problem has no full-dimensional region: it is infeasible, or feasible on a flat set only."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ParametricQp:
    """min_z ½ z'Hz + (f + F θ)'z  subject to  G z ≤ w + S θ,  lower ≤ θ ≤ upper.

    Units are the caller's. All arrays are copied and read-only.

    Raises
    ------
    InvalidProblem : a shape, a value that is not finite, an empty parameter box, or an H that is
        not symmetric positive definite (then the minimiser need not be unique).
    """

    H: Mat  # (n, n)
    F: Mat  # (n, p)
    f: Vec  # (n,)
    G: Mat  # (m, n)
    w: Vec  # (m,)
    S: Mat  # (m, p)
    lower: Vec  # (p,)
    upper: Vec  # (p,)

    def __post_init__(self) -> None:
        _check_shapes(self)
        n, m, p = np.shape(self.f)[0], np.shape(self.w)[0], np.shape(self.lower)[0]
        freeze(self, H=(n, n), F=(n, p), f=(n,), G=(m, n), w=(m,), S=(m, p), lower=(p,), upper=(p,))
        _check_finite(self)
        _check_box(self.lower, self.upper)
        _check_hessian(self.H)

    def at(self, theta: Vec) -> tuple[Vec, Vec]:
        """Gradient (n,) and right-hand side (m,) of the ordinary QP at `theta` (p,)."""
        return self.f + self.F @ theta, self.w + self.S @ theta

    @property
    def digest(self) -> str:
        """SHA-256 of the data; it identifies the model behind a law."""
        sha = hashlib.sha256()
        for field in fields(self):
            array = getattr(self, field.name)
            sha.update(f"{field.name}{array.shape}".encode())
            sha.update(np.ascontiguousarray(array, dtype="<f8").tobytes())
        return sha.hexdigest()


def _check_shapes(problem: ParametricQp) -> None:
    """Check every shape against n, m and p, the lengths of f, w and lower."""
    if any(np.ndim(getattr(problem, name)) != 1 for name in ("f", "w", "lower")):
        raise InvalidProblem("f, w and lower must be vectors")
    n, m, p = len(problem.f), len(problem.w), len(problem.lower)
    if n == 0 or p == 0:
        raise InvalidProblem(f"{n} variables and {p} parameters, must be at least one each")
    expected = {"H": (n, n), "F": (n, p), "G": (m, n), "S": (m, p), "upper": (p,)}
    for name, shape in expected.items():
        if (found := np.shape(getattr(problem, name))) != shape:
            raise InvalidProblem(f"{name} has shape {found}, must be {shape}")


def _check_finite(problem: ParametricQp) -> None:
    for field in fields(problem):
        if not np.isfinite(getattr(problem, field.name)).all():
            raise InvalidProblem(f"{field.name} holds a value that is not finite")


def _check_box(lower: Vec, upper: Vec) -> None:
    for i, (low, high) in enumerate(zip(lower, upper, strict=True)):
        if not low < high:
            raise InvalidProblem(f"parameter {i} ranges from {low:g} to {high:g}, must be a proper interval")


def _check_hessian(H: Mat) -> None:
    """Check H with its diagonal scaled to one, so that the result does not depend on the variables' units."""
    scale = unit_curvature(H)
    unit = H * np.outer(scale, scale)
    if (np.abs(unit - unit.T) > 1e-9).any():
        raise InvalidProblem(f"H differs from its transpose by {np.abs(H - H.T).max():g}, must be symmetric")
    least = float(np.linalg.eigvalsh(unit)[0])
    if (np.diag(H) <= 0.0).any() or least <= _LEAST_CURVATURE:
        raise InvalidProblem(
            f"H has the eigenvalue {np.linalg.eigvalsh(H)[0]:g}, must be positive definite: without "
            "curvature the minimiser is not unique (an mpLP-like problem); add a small quadratic cost on the "
            "free directions"
        )


def unit_curvature(H: Mat) -> Vec:
    """Units (n,) of the variables in which each has the curvature 1 along its own axis."""
    curvature = np.diag(H)
    return np.where(curvature > 0.0, 1.0 / np.sqrt(np.where(curvature > 0.0, curvature, 1.0)), 1.0)
