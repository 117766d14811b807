"""The coarse MPC of section 4.1.1 as a multi-parametric QP, which the explicit law solves.

Notation: x the states without accelerations, [ω θ v s] of an axis pair and [v s] of a single axis; u the
accelerations, [a_rot a_tran] and [a]; N horizon, T blocking, U = T z the inputs step by step, parameter ϑ =
(x₀, y_ref), and y what is felt: a_tran + g θ of a pair, linear in the tilt; a of heave; v of yaw, at the end
of the period, where an input first changes it:

    min_z  Σ_{k<N} (y_k − y_ref)² + ‖R^½ u_k‖² + ‖Q^½ x_k‖²   s.t. states x_1 … x_N and inputs within limits.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag

from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError
from otolith.core.frames import AXES, GRAVITY, Dof
from otolith.core.lti import condense, zero_order_hold
from otolith.cueing.mpc.axis_sets import axes_of, sets_apart
from otolith.cueing.mpc.motion import TILT, TRAN, chains, explicit_dynamics
from otolith.cueing.mpc.rows import (
    BrakingRows,
    Limits,
    Row,
    acceleration_rows,
    braking_rows,
    leading_rows,
    state_rows,
)
from otolith.cueing.mpc.settings import LONGEST, check_period
from otolith.cueing.mpc.washout_weights import check_weight
from otolith.mpqp import ParametricQp, Progress
from otolith.mpqp.separable import JointLaw, enumerate_parts
from otolith.platforms import Braking, Platform

UNLIMITED = 20.0  # [SI] range of a state without a limit, e.g. the velocity [m/s] in Table C.1
WIDEST_ALONE = 10.0  # range of references of a single axis's law, relative to its speed or acceleration


@dataclass(frozen=True, slots=True, kw_only=True)
class ExplicitSettings:
    """Settings of the explicit MPC; the defaults are the law that the thesis's hybrids use."""

    horizon: int = 5  # N
    period: float = 0.1  # [s]
    block_from: int | None = 2  # inputs are free before this stage (1 = first) and equal from it on
    braking: BrakingRows = BrakingRows.NONE
    control_weight: float = 1e-3  # on a_rot² and a_tran² (eq. 4.5)
    state_weights: tuple[float, float, float, float] = (
        0.0,
        0.0,
        0.0,
        0.0,
    )  # of a pair, on ω², θ², v², s² (Table C.3)
    reference_bound: float = 100.0  # [m/s²] largest |y_ref| that the law covers, beyond any drive
    open_bound: float = UNLIMITED  # [SI] range that the law covers of a state without a limit

    def __post_init__(self) -> None:
        if not 1 <= self.horizon <= LONGEST:
            raise InputError("explicit horizon", self.horizon, f"from 1 to {LONGEST} steps")
        check_period("explicit period", self.period)
        check_weight("control weight", self.control_weight)
        if not 0.0 < self.open_bound < math.inf:
            raise InputError("open bound", self.open_bound, "finite and greater than 0")
        if self.block_from is not None and not 1 <= self.block_from <= self.horizon:
            raise InputError("block-from", self.block_from, f"from 1 to the horizon of {self.horizon} steps")

    def blocking(self, inputs: int) -> Mat:
        """Return T (N·nu, n) with U = T z: the free inputs, then the last one held to the horizon's end."""
        free = self.block_from or self.horizon
        T = np.zeros((self.horizon, free))
        for k in range(self.horizon):
            T[k, min(k, free - 1)] = 1.0
        blocked: Mat = np.kron(T, np.eye(inputs)).astype(np.float64)
        return blocked


def explicit_problem(dof: Dof, limits: Limits, braking: Braking, settings: ExplicitSettings) -> ParametricQp:
    """Condense the explicit MPC of one degree of freedom into an mpQP.

    An infinite limit imposes no row; the law then covers that state up to `open_bound`.

    Returns
    -------
    ParametricQp : z (n,) the blocked inputs [rad/s², m/s²], ϑ = (x₀, y_ref) in SI units: (5,) for a pair,
        (3,) for an axis.
    """
    N, nu = settings.horizon, len(chains(dof))
    T = settings.blocking(nu)
    A, B = zero_order_hold(*explicit_dynamics(dof), settings.period)
    Phi, Gamma = condense(A, B, N)
    Phi = np.concatenate([np.eye(len(A))[None], Phi])  # (N + 1, nx, nx), x_k = Phi[k] x₀ + Gamma[k] z
    Gamma = np.concatenate([np.zeros((1, len(A), nu * N)), Gamma]) @ T  # (N + 1, nx, n)
    u = T.reshape(N, nu, -1)  # u_k = u[k] z

    Y, of_x = _felt(dof, Phi, Gamma, u)
    Y_theta = np.column_stack([of_x, -np.ones(N)])  # (N, nx + 1)
    H = Y.T @ Y + settings.control_weight * np.einsum("kin,kim->nm", u, u)
    F = Y.T @ Y_theta
    for i, weight in enumerate(settings.state_weights if dof.is_pair else ()):
        H += weight * Gamma[:N, i].T @ Gamma[:N, i]
        F[:, : len(A)] += weight * Gamma[:N, i].T @ Phi[:N, i]

    G, w, S = _one_sided(_stage_rows(dof, limits, braking, settings), dof, Phi, Gamma, u)
    G_u, w_u = _input_rows(dof, acceleration_rows(dof, limits), T.shape[1])
    low, high = _box(dof, limits, settings)
    return ParametricQp(
        H=H,
        f=np.zeros(len(H)),
        F=F,
        G=np.vstack([G, G_u]),
        w=np.concatenate([w, w_u]),
        S=np.vstack([S, np.zeros((len(w_u), len(low)))]),
        lower=low,
        upper=high,
    )


def _felt(dof: Dof, Phi: Mat, Gamma: Mat, u: Mat) -> tuple[Mat, Mat]:
    """Return what is felt at every step: y = (N, n) z + (N, nx) x₀."""
    N, of = len(u), chains(dof)
    if dof.feels_rate:
        return Gamma[1:, of[0].speed], Phi[1:, of[0].speed]
    if not dof.is_pair:
        return u[:, 0], np.zeros((N, Phi.shape[2]))
    return u[:, TRAN] + GRAVITY * Gamma[:N, TILT], GRAVITY * Phi[:N, TILT]


def _box(dof: Dof, limits: Limits, settings: ExplicitSettings) -> tuple[Vec, Vec]:
    """Return the bounds of the parameter: limits of the states, and the references that the law covers."""
    bounds = np.zeros((2 * len(chains(dof)), 2))
    for chain in chains(dof):
        of_axis = limits[chain.of]
        bounds[chain.speed] = -of_axis.velocity, of_axis.velocity
        bounds[chain.place] = of_axis.position
    reference = settings.reference_bound
    if not dof.is_pair:
        widest = limits[0].velocity if dof.feels_rate else limits[0].acceleration
        reference = min(reference, WIDEST_ALONE * widest)
    inside = np.clip(bounds, -settings.open_bound, settings.open_bound)
    return np.append(inside[:, 0], -reference), np.append(inside[:, 1], reference)


def _stage_rows(
    dof: Dof, limits: Limits, braking: Braking, settings: ExplicitSettings
) -> list[tuple[Row, int]]:
    """Return rows with the first stage at which an input can affect them."""
    if settings.braking.leads:
        axes = axes_of(dof, limits, braking, settings.braking, lag=0.0, period=settings.period)
        of_states = leading_rows(dof, sets_apart(dof, braking, axes))
    else:
        of_states = state_rows(dof, limits)
    slowing = braking_rows(dof, limits, braking, settings.braking)
    return [(row, 1) for row in of_states] + [(row, 0) for row in slowing]  # x_1 … x_N; (x_k, u_k), k < N


def _one_sided(
    rows: Sequence[tuple[Row, int]], dof: Dof, Phi: Mat, Gamma: Mat, u: Mat
) -> tuple[Mat, Vec, Mat]:
    """Return G z ≤ w + S ϑ for every row, stage and side."""
    N, nx = len(u), Phi.shape[2]
    by_input = [chain.acceleration for chain in chains(dof)]
    G, w, S = [], [], []
    for row, first in rows:
        c, of_u = row.coefficients[:nx], row.coefficients[by_input]
        for k in range(first, N + first):
            of_z = c @ Gamma[k] + (of_u @ u[k] if first == 0 else 0.0)
            of_x = c @ Phi[k]
            for side, bound in ((1.0, row.upper), (-1.0, -row.lower)):
                if not math.isfinite(bound):
                    continue
                G.append(side * of_z)
                w.append(bound)
                S.append(-side * np.append(of_x, 0.0))
    return np.array(G), np.array(w), np.array(S)


def _input_rows(dof: Dof, rows: Sequence[Row], n: int) -> tuple[Mat, Vec]:
    """Return limits on the accelerations, which are the explicit model's inputs, once per free input."""
    by_input = [chain.acceleration for chain in chains(dof)]
    nu = len(by_input)
    G, w = [], []
    for row in rows:
        for j in range(n // nu):
            g = np.zeros(n)
            g[nu * j : nu * (j + 1)] = row.coefficients[by_input]
            G += [g, -g]
            w += [row.upper, -row.lower]
    return np.array(G).reshape(-1, n), np.array(w)


def joint_problem(parts: Sequence[ParametricQp]) -> ParametricQp:
    """Combine several problems into one, block by block; that it separates is found from its data."""
    blocks = {name: block_diag(*[getattr(part, name) for part in parts]) for name in ("H", "F", "G", "S")}
    vectors = {
        name: np.concatenate([getattr(part, name) for part in parts]) for name in ("f", "w", "lower", "upper")
    }
    return ParametricQp(**blocks, **vectors)


def explicit_platform(platform: Platform, dofs: Sequence[Dof]) -> Platform:
    """Return the platform as explicit laws see it: commands are accelerations, and a circle is not a row.

    If both pairs are cued, surge and sway get a square inside the circle.
    """
    seen = platform.boxed() if sum(dof.is_pair for dof in dofs) > 1 else platform
    tables = {axis: getattr(seen, axis) for axis in AXES[:3] if getattr(seen, axis) is not None}
    same = {axis: table.model_copy(update={"command_mps2": None}) for axis, table in tables.items()}
    return seen.model_copy(update=same)


def joint_law(
    platform: Platform,
    dofs: Sequence[Dof],
    settings: ExplicitSettings,
    *,
    tolerance: float = 1e-7,
    progress: Callable[[Progress], None] | None = None,
    workers: int | None = None,
) -> JointLaw:
    """Enumerate the explicit law of degrees of freedom, part by part (`otolith.mpqp.separable`).

    `workers` is the number of threads, by default one for each processor; the law does not depend on it.

    Raises
    ------
    InputError : the platform lacks an axis of one of them.
    """
    seen = explicit_platform(platform, dofs)
    whole = joint_problem([explicit_problem(dof, seen.limits(dof), seen.braking, settings) for dof in dofs])
    return enumerate_parts(whole, tolerance=tolerance, progress=progress, workers=workers)
