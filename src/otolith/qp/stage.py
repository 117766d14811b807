"""A QP with stages: linear dynamics over a horizon, its solution, its certificate, its condensed form.

Notation: x_{k+1} = A x_k + B u_k, k = 0 … N−1, x_0 given. Everything indexed k below belongs to the pair
(x_{k+1}, u_k), so that all arrays have N entries along axis 0:

    min Σ_k ½‖D_k x_{k+1} + e_k‖² + ½ Σ_{i∈I} (W_ki x_i² + 2 p_ki x_i)_{k+1} + ½ u_kᵀ diag(R) u_k + r_kᵀ u_k
    s.t. l_k ≤ (C x_{k+1}, V_k x_{k+1}, u_k) ≤ u_k

The *rows* of a stage are ordered: constant rows C, varying rows V_k, inputs. A row with a finite penalty w is
soft: it may be violated by σ ≥ 0 at the cost w σ (exact L1 penalty). Each row has one signed multiplier y, as
in `otolith.qp.problem`; |y| ≤ w on a soft row.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
import scipy  # scipy imports its modules on first use, so a caller waits only for those it needs
from numpy.typing import NDArray

from otolith.core.arrays import Bools, Ints, Mat, Vec, frozen_array
from otolith.core.lti import condense as predict
from otolith.qp.problem import Qp, Status
from otolith.qp.relative import Rows, part, row_residual, worst_of

OnRequest = Callable[[], Ints | None]  # makes a hint in the form of `StageSolution.working_set`, or None


@dataclass(frozen=True, slots=True, kw_only=True)
class StageProblem:
    """The part of a stage QP that is the same for all problems; engines are built for it.

    Raises
    ------
    ValueError : a field does not have the shape in its comment, or a value is not allowed.
    """

    horizon: int  # N
    A: Mat  # (nx, nx)
    B: Mat  # (nx, nu)
    C: Mat  # (nc, nx) constant rows
    output: Bools  # (ny, nx) where D_k may be non-zero
    varying: Bools  # (nv, nx) where V_k may be non-zero
    weighted: tuple[int, ...]  # I, the states that have a weight W and a linear term p
    control_weight: Vec  # (nu,) R, positive
    penalty: Mat  # (N, nc + nv + nu) w, +inf for a hard row; a single line applies to all stages

    def __post_init__(self) -> None:
        nx, nu = np.shape(self.B)
        shapes: dict[str, tuple[int, ...]] = {"A": (nx, nx), "B": (nx, nu), "C": (len(self.C), nx)}
        shapes |= {"output": (len(self.output), nx), "varying": (len(self.varying), nx)}
        shapes |= {"control_weight": (nu,), "penalty": (self.horizon, self.rows)}
        if np.ndim(self.penalty) == 1:
            object.__setattr__(self, "penalty", np.tile(self.penalty, (self.horizon, 1)))
        for name, shape in shapes.items():
            dtype = np.bool_ if name in {"output", "varying"} else np.float64
            array = frozen_array(getattr(self, name), dtype=dtype)
            if array.shape != shape:
                raise ValueError(f"StageProblem.{name} has shape {array.shape}, expected {shape}")
            object.__setattr__(self, name, array)
        finite = all(np.isfinite(getattr(self, name)).all() for name in ("A", "B", "C", "control_weight"))
        if not (finite and (self.control_weight > 0).all() and (self.penalty > 0).all()):
            raise ValueError("StageProblem needs finite matrices, positive control weights and penalties")

    @property
    def states(self) -> int:
        """Number of states of one stage."""
        return len(self.B)

    @property
    def inputs(self) -> int:
        """Number of inputs of one stage."""
        return int(self.B.shape[1])

    @property
    def rows(self) -> int:
        """Rows of one stage: nc + nv + nu."""
        return len(self.C) + len(self.varying) + self.inputs

    @property
    def groups(self) -> Ints:
        """Number (rows,) of the group of each row of a stage; neither dynamics nor constant rows connect two
        groups.

        A varying row is a group of its own. Active rows of different groups depend on each other only through
        the cost.
        """
        moved, held = (self.B != 0.0).astype(np.float64), (self.C != 0.0).astype(np.float64)
        linked = np.abs(self.A) + moved @ moved.T + held.T @ held
        number, of_state = scipy.sparse.csgraph.connected_components(linked, directed=False)
        of_inputs = of_state[np.argmax(moved, axis=0)]
        of_rows = of_state[np.argmax(held, axis=1)] if len(self.C) else of_state[:0]
        return np.concatenate([of_rows, number + np.arange(len(self.varying)), of_inputs])


@dataclass(frozen=True, slots=True, kw_only=True)
class StageQp:
    """One stage QP. Its arrays are not copied: an engine reads them once per solve."""

    problem: StageProblem
    x0: Vec  # (nx,)
    output: Mat  # (N, ny, nx) D_k
    error: Mat  # (N, ny) e_k
    state_weight: Mat  # (N, len(I)) W_k ≥ 0
    state_linear: Mat  # (N, len(I)) p_k
    input_linear: Mat  # (N, nu) r_k
    varying: Mat  # (N, nv, nx) V_k
    lower: Mat  # (N, nc + nv + nu), −inf where there is no bound
    upper: Mat  # (N, nc + nv + nu), +inf where there is no bound

    def well_posed(self) -> bool:
        """True when all numbers except bounds are finite, no bound is NaN, lower ≤ upper, and no weight
        is negative.
        """
        judged = [f.name for f in fields(self) if f.name not in {"problem", "lower", "upper"}]
        finite = all(np.isfinite(getattr(self, name)).all() for name in judged)
        return finite and bool((self.lower <= self.upper).all() and (self.state_weight >= 0.0).all())

    def changed(self, **values: Any) -> "StageQp":
        """Return a copy with some fields replaced."""
        return replace(self, **values)


@dataclass(frozen=True, slots=True)
class StageSolution:
    """What an engine returns: always arrays, and a status that says whether to trust them."""

    status: Status
    U: Mat  # (N, nu)
    X: Mat  # (N, nx) states x_1 … x_N
    y: Mat  # (N, nc + nv + nu) signed multipliers
    changes: int  # rows that entered or left the working set, counted from the start
    factorisations: int  # factorisations of the working set's linear system
    iterations: int  # iterations of the interior point; 0 when it was not needed
    residual: float  # stage_residual of (U, y); infinite when there is no answer
    hinted: bool = False  # True when the search continued from the hint instead of the start

    @property
    def working_set(self) -> Ints:
        """Active rows (N, nc + nv + nu): +1 where the upper side is active, −1 where the lower is, 0
        elsewhere.
        """
        return np.sign(self.y).astype(np.int64)


def rollout(qp: StageQp, U: Mat) -> Mat:
    """Compute the states x_1 … x_N (N, nx) under the inputs U (N, nu)."""
    problem, x = qp.problem, qp.x0
    X = np.empty((problem.horizon, problem.states))
    for k, u in enumerate(U):
        x = problem.A @ x + problem.B @ u
        X[k] = x
    return X


def row_values(qp: StageQp, U: Mat, X: Mat) -> Mat:
    """Values (N, nc + nv + nu) of all rows, to which the bounds `lower` and `upper` apply."""
    varying = np.einsum("kvi,ki->kv", qp.varying, X)
    return np.hstack([X @ qp.problem.C.T, varying, U])


def cost(qp: StageQp, U: Mat, X: Mat) -> float:
    """Value of the objective, without the penalty of soft rows."""
    xi = X[:, list(qp.problem.weighted)]  # (N, len(I))
    force = np.einsum("kyi,ki->ky", qp.output, X) + qp.error
    of_states = 0.5 * np.sum(force**2) + np.sum((0.5 * qp.state_weight * xi + qp.state_linear) * xi)
    return float(of_states + np.sum((0.5 * qp.problem.control_weight * U + qp.input_linear) * U))


def stationarity(qp: StageQp, U: Mat, X: Mat, y: Mat) -> Mat:
    """Gradient (N, nu) of the Lagrangian with respect to U, with the dynamics eliminated by their costates.

    With s_k = ∂(stage k)/∂x_{k+1} + Aᵀ s_{k+1} the gradient is R u_k + r_k + Bᵀ s_k + y_inputs.
    """
    return _gradient(qp, U, X, y)[0]


def _gradient(qp: StageQp, U: Mat, X: Mat, y: Mat) -> tuple[Mat, Mat]:
    """Return `stationarity`, and for each entry the sum of its absolute terms, including those of s_k."""
    problem = qp.problem
    nc, nv = len(problem.C), len(problem.varying)
    weighted = list(problem.weighted)
    force = np.einsum("kyi,ki->ky", qp.output, X) + qp.error
    washout, of_states, of_varying = qp.state_weight * X[:, weighted], y[:, :nc], y[:, nc : nc + nv]
    gradient = np.einsum("kyi,ky->ki", qp.output, force) + of_states @ problem.C
    gradient += np.einsum("kv,kvi->ki", of_varying, qp.varying)
    gradient[:, weighted] += washout + qp.state_linear
    of_s = np.einsum("kyi,ky->ki", np.abs(qp.output), np.abs(force)) + np.abs(of_states) @ np.abs(problem.C)
    of_s += np.einsum("kv,kvi->ki", np.abs(of_varying), np.abs(qp.varying))
    of_s[:, weighted] += np.abs(washout) + np.abs(qp.state_linear)

    own, of_inputs = problem.control_weight * U, y[:, nc + nv :]
    total = own + qp.input_linear + of_inputs
    terms = np.abs(own) + np.abs(qp.input_linear) + np.abs(of_inputs)
    s = np.zeros(problem.states)
    for k in reversed(range(problem.horizon)):
        terms[k] += np.abs(problem.B.T) @ (of_s[k] + np.abs(s))
        s = gradient[k] + s
        total[k] += problem.B.T @ s
        s = problem.A.T @ s
    return total, terms


def stage_residual(qp: StageQp, U: Mat, y: Mat) -> float:
    """Measure how far (U, y) is from optimal, relative to the numbers of the problem and the answer; 0 is
    exact.

    The result does not depend on the units of states, inputs, rows or cost; `otolith.qp.certificate` explains
    why each condition is judged as it is. All stages have the same units, so usual sizes are taken over all
    stages:

    - a row's size is the largest value that this row takes at any stage, plus its bound's own size;
    - the gradient with respect to an input is judged relative to the largest sum of its absolute terms at any
      stage;
    - a multiplier is negligible when y times its row's size is a small part of Σ_j (largest sum of
      the gradient's terms in u_j) · (largest |u_j|).

    The result is infinite if any number is not finite, so accept an answer only if `residual < tolerance`.

    Parameters
    ----------
    U : (N, nu) inputs.
    y : (N, nc + nv + nu) signed multipliers.
    """
    if not (np.isfinite(U).all() and np.isfinite(y).all()):
        return np.inf
    X = rollout(qp, U)
    values = row_values(qp, U, X)
    reach = np.broadcast_to(np.abs(values).max(axis=0), values.shape)
    gradient, terms = _gradient(qp, U, X, y)
    of_inputs = terms.max(axis=0)
    size = reach + np.abs(np.where(y > 0.0, qp.upper, qp.lower))
    whole = np.full(y.shape, of_inputs @ np.abs(U).max(axis=0))
    with np.errstate(invalid="ignore"):
        share = part(np.where(y == 0.0, 0.0, np.abs(y) * size), whole)
    rows = Rows(values, qp.lower, qp.upper, qp.problem.penalty, reach)
    return worst_of(part(gradient, np.broadcast_to(of_inputs, gradient.shape)), row_residual(rows, y, share))


def condense(qp: StageQp) -> Qp:
    """Eliminate the states: a problem in U (n = N·nu) with bounds on inputs and all other rows in A."""
    problem = qp.problem
    N, nu, nr = problem.horizon, problem.inputs, problem.rows - problem.inputs
    Phi, Gamma = predict(problem.A, problem.B, N)  # (N, nx, nx), (N, nx, n)
    free = Phi @ qp.x0  # (N, nx)
    weighted = list(problem.weighted)

    D, e = qp.output @ Gamma, np.einsum("kyi,ki->ky", qp.output, free) + qp.error  # (N, ny, n), (N, ny)
    Gw, xw = Gamma[:, weighted], free[:, weighted]  # (N, len(I), n), (N, len(I))
    H = np.einsum("kyi,kyj->ij", D, D) + np.einsum("kw,kwi,kwj->ij", qp.state_weight, Gw, Gw)
    H += np.diag(np.tile(problem.control_weight, N))
    g = np.einsum("kyi,ky->i", D, e) + np.einsum("kwi,kw->i", Gw, qp.state_weight * xw + qp.state_linear)

    C = np.concatenate([np.broadcast_to(problem.C, (N, *problem.C.shape)), qp.varying], axis=1)  # (N, nr, nx)
    offset = np.einsum("kri,ki->kr", C, free)
    return Qp(
        H,
        g + qp.input_linear.ravel(),
        (C @ Gamma).reshape(N * nr, N * nu),
        np.concatenate([qp.lower[:, nr:].ravel(), (qp.lower[:, :nr] - offset).ravel()]),
        np.concatenate([qp.upper[:, nr:].ravel(), (qp.upper[:, :nr] - offset).ravel()]),
        by_columns(problem.penalty, problem),
    )


def by_rows(y: NDArray[Any], problem: StageProblem) -> NDArray[Any]:
    """Reshape numbers of the condensed problem's rows (N·(nu + nr),) to stages and rows (N, nr + nu).

    With blocks, N is the number of blocks, here and in `by_columns`.
    """
    N, nu = len(y) // problem.rows, problem.inputs
    return np.hstack([y[N * nu :].reshape(N, -1), y[: N * nu].reshape(N, nu)])


def by_columns(y: NDArray[Any], problem: StageProblem) -> NDArray[Any]:
    """Reshape numbers of stages and rows to the condensed problem's order; the inverse of `by_rows`."""
    nr = problem.rows - problem.inputs
    return np.concatenate([y[:, nr:].ravel(), y[:, :nr].ravel()])
