"""A discrete optimal control problem over a long horizon, its cost, and its answer.

Notation: x_{k+1} = A x_k + B u_k for k = 0 … N−1, with x_0 given. The limits bound w_k = (x_{k+1}, u_k).

    min φ(x, u) = Σ_k φ_k(x_k, u_k)
    s.t. l ≤ w_k ≤ u, and in every disc d: ‖(x_i, x_j)_{k+1}‖ ≤ r_d

The limits are the same at all stages, and x = 0, u = 0 lies strictly inside them. The cost φ is smooth, and
its Gauss-Newton Hessian is positive definite in u.
"""

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec, freeze, frozen_array


class Expansion(NamedTuple):
    """A cost at one motion: its value, and its gradient and Hessian in (x_k, u_k)."""

    value: float
    gradient: Mat  # (N, nx + nu)
    hessian: Mat  # (N, nx + nu, nx + nu)


class Cost(Protocol):
    """The cost φ of a motion X (N + 1, nx), which starts with x_0, and U (N, nu)."""

    def expand(self, X: Mat, U: Mat, *, exact: bool) -> Expansion:
        """Return φ with its derivatives at (X, U); the next call may overwrite the arrays.

        Parameters
        ----------
        exact : whether the Hessian is φ's own, which may be indefinite, or that of Gauss and Newton, which is
            not. A cost that has only one of them returns that.
        """


class Disc(NamedTuple):
    """Two states that stay within a circle about zero."""

    states: tuple[int, int]
    radius: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Dynamics:
    """The linear dynamics and the limits of a motion.

    Raises
    ------
    ValueError : a field has another shape than its comment states, or zero is not strictly inside a limit.
    """

    A: Mat  # (nx, nx)
    B: Mat  # (nx, nu)
    lower: Vec  # (nx + nu,) of w; −inf where there is none
    upper: Vec  # (nx + nu,); +inf where there is none
    discs: tuple[Disc, ...] = ()

    def __post_init__(self) -> None:
        nx, nu = np.shape(self.B)
        freeze(self, A=(nx, nx), B=(nx, nu), lower=(nx + nu,), upper=(nx + nu,))
        inside = bool((self.lower < 0.0).all() and (self.upper > 0.0).all())
        if not (inside and all(disc.radius > 0.0 for disc in self.discs)):
            raise ValueError("the limits of an optimal control problem must hold zero strictly inside")

    @property
    def states(self) -> int:
        """Return the number of states nx."""
        return int(self.B.shape[0])

    @property
    def inputs(self) -> int:
        """Return the number of inputs nu."""
        return int(self.B.shape[1])

    def sides(self) -> "Sides":
        """Return every finite bound as a one-sided one."""
        found = [
            (column, sign, float(bound))
            for sign, bounds in ((-1.0, self.lower), (1.0, self.upper))
            for column, bound in enumerate(bounds)
            if np.isfinite(bound)
        ]
        column, sign, bound = zip(*found, strict=True) if found else ((), (), ())
        return Sides(frozen_array(column, dtype=np.int64), frozen_array(sign), frozen_array(bound))


class Sides(NamedTuple):
    """One-sided bounds: sign (bound − w[column]) ≥ 0, the *distance* to the side."""

    column: Ints  # (m,) of w
    sign: Vec  # (m,) +1 for an upper bound, −1 for a lower one
    bound: Vec  # (m,)


@dataclass(frozen=True, slots=True, kw_only=True)
class Answer:
    """A motion, and the multipliers that prove that it is optimal."""

    X: Mat  # (N + 1, nx)
    U: Mat  # (N, nu)
    of_sides: Mat  # (N, m) multipliers ≥ 0 of `Dynamics.sides`, per unit of distance
    of_discs: Mat  # (N, discs) multipliers ≥ 0 of r² − ‖·‖² over 2 r
    iterations: int
    converged: bool  # by the solver's own test; the certificate decides
