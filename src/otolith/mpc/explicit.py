"""The explicit half: the coarse MPC of section 4.1.1 as a multi-parametric QP, and its law at work.

Notation: x = [ω θ v s], u = [a_rot a_tran], N horizon, T blocking, U = T z the inputs stage by
stage, y_k = a_tran,k + g θ_k the linearised specific force, parameter ϑ = (x₀, y_ref):

    min_z  Σ_{k<N} (y_k − y_ref)² + ‖R^½ u_k‖² + ‖Q^½ x_k‖²   s.t. states x_1 … x_N and inputs within limits.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from otolith.core.arrays import Mat, Vec, frozen_array
from otolith.core.errors import InputError
from otolith.core.frames import GRAVITY, AxisPair
from otolith.core.lti import condense, zero_order_hold
from otolith.interfaces import Command, Outcome, PlatformState, Reference
from otolith.mpc.model import (
    ROT,
    TILT,
    TRAN,
    BrakingRows,
    Row,
    acceleration_rows,
    braking_rows,
    explicit_dynamics,
    leading_rows,
    planar_state,
    plausible,
    state_rows,
)
from otolith.mpc.several import added
from otolith.mpqp import Law, ParametricQp
from otolith.platforms import Braking, PairLimits, Platform
from otolith.qp import Status
from otolith.stopping import Stopping

UNLIMITED = 20.0  # [SI] range of a state without a limit, e.g. of the velocity [m/s] in Table C.1
EDGE_TOLERANCE = 1e-7  # how far outside its box, relative to it, a parameter may lie through rounding


@dataclass(frozen=True, slots=True, kw_only=True)
class ExplicitSettings:
    """What the explicit MPC is; the defaults are the law that the thesis's hybrids use."""

    horizon: int = 5  # N
    period: float = 0.1  # [s]
    block_from: int | None = 2  # inputs are free before this stage (1 = first) and equal from it on
    braking: BrakingRows = BrakingRows.NONE
    control_weight: float = 1e-3  # on a_rot² and a_tran² (eq. 4.5)
    state_weights: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)  # on ω², θ², v², s² (Table C.3)
    reference_bound: float = 100.0  # [m/s²] |y_ref| that the law covers: wider than any drive
    open_bound: float = UNLIMITED  # [SI] what the law covers of a state without a limit

    def __post_init__(self) -> None:
        if self.horizon < 1:
            raise InputError("explicit horizon", self.horizon, "at least 1 step")
        if not self.period > 0.0:
            raise InputError("explicit period", self.period, "greater than 0 s")
        if not 0.0 < self.control_weight < math.inf:
            raise InputError("control weight", self.control_weight, "finite and greater than 0")
        if not 0.0 < self.open_bound < math.inf:
            raise InputError("open bound", self.open_bound, "finite and greater than 0")
        if self.block_from is not None and not 1 <= self.block_from <= self.horizon:
            raise InputError("block-from", self.block_from, f"from 1 to the horizon of {self.horizon} steps")

    @property
    def blocking(self) -> Mat:
        """T (N·2, n) with U = T z: the free inputs, then the last one held to the horizon's end."""
        free = self.block_from or self.horizon
        T = np.zeros((self.horizon, free))
        for k in range(self.horizon):
            T[k, min(k, free - 1)] = 1.0
        blocked: Mat = np.kron(T, np.eye(2)).astype(np.float64)
        return blocked


def explicit_problem(limits: PairLimits, braking: Braking, settings: ExplicitSettings) -> ParametricQp:
    """Condense the explicit MPC of one axis pair into an mpQP.

    A limit that is infinite imposes no row; the law then covers that state up to `open_bound`.

    Returns
    -------
    ParametricQp : z (n,) the blocked inputs [rad/s², m/s²], ϑ (5,) = [ω, θ, v, s, y_ref] in SI.
    """
    N, T = settings.horizon, settings.blocking
    A, B = zero_order_hold(*explicit_dynamics(), settings.period)
    Phi, Gamma = condense(A, B, N)
    Phi = np.concatenate([np.eye(4)[None], Phi])  # (N + 1, 4, 4), x_k = Phi[k] x₀ + Gamma[k] z
    Gamma = np.concatenate([np.zeros((1, 4, 2 * N)), Gamma]) @ T  # (N + 1, 4, n)
    u = T.reshape(N, 2, -1)  # u_k = u[k] z

    Y = u[:, TRAN] + GRAVITY * Gamma[:N, TILT]  # (N, n)
    Y_theta = np.column_stack([GRAVITY * Phi[:N, TILT], -np.ones(N)])  # (N, 5)
    H = Y.T @ Y + settings.control_weight * np.einsum("kin,kim->nm", u, u)
    F = Y.T @ Y_theta
    for i, weight in enumerate(settings.state_weights):
        H += weight * Gamma[:N, i].T @ Gamma[:N, i]
        F[:, :4] += weight * Gamma[:N, i].T @ Phi[:N, i]

    G, w, S = _one_sided(_stage_rows(limits, braking, settings), Phi, Gamma, u)
    G_u, w_u = _input_rows(acceleration_rows(limits), T.shape[1])
    high = np.array([limits.tilt_rate, limits.tilt[1], limits.velocity, limits.position[1]])
    low = np.array([-limits.tilt_rate, limits.tilt[0], -limits.velocity, limits.position[0]])
    return ParametricQp(
        H=H,
        f=np.zeros(len(H)),
        F=F,
        G=np.vstack([G, G_u]),
        w=np.concatenate([w, w_u]),
        S=np.vstack([S, np.zeros((len(w_u), 5))]),
        lower=np.append(np.maximum(low, -settings.open_bound), -settings.reference_bound),
        upper=np.append(np.minimum(high, settings.open_bound), settings.reference_bound),
    )


def _stage_rows(limits: PairLimits, braking: Braking, settings: ExplicitSettings) -> list[tuple[Row, int]]:
    """Rows with the first stage at which an input can still move them."""
    if settings.braking is BrakingRows.STOPPING:
        of_states = leading_rows(limits, braking, lag=0.0, period=settings.period)
    else:
        of_states = state_rows(limits)
    slowing = braking_rows(limits, braking, settings.braking)
    return [(row, 1) for row in of_states] + [(row, 0) for row in slowing]  # x_1 … x_N; (x_k, u_k), k < N


def _one_sided(rows: Sequence[tuple[Row, int]], Phi: Mat, Gamma: Mat, u: Mat) -> tuple[Mat, Vec, Mat]:
    """G z ≤ w + S ϑ for every row, stage and side."""
    N = len(u)
    G, w, S = [], [], []
    for row, first in rows:
        c, (c_tran, c_rot) = row.coefficients[:4], row.coefficients[4:]
        for k in range(first, N + first):
            of_z = c @ Gamma[k] + (c_tran * u[k, TRAN] + c_rot * u[k, ROT] if first == 0 else 0.0)
            of_x = c @ Phi[k]
            for side, bound in ((1.0, row.upper), (-1.0, -row.lower)):
                if not math.isfinite(bound):
                    continue
                G.append(side * of_z)
                w.append(bound)
                S.append(-side * np.append(of_x, 0.0))
    return np.array(G), np.array(w), np.array(S)


def _input_rows(rows: Sequence[Row], n: int) -> tuple[Mat, Vec]:
    """Limits on the accelerations, which are the explicit model's inputs: once per free input."""
    G, w = [], []
    for row in (row for row in rows if math.isfinite(row.upper)):
        per_stage = np.array([row.coefficients[5], row.coefficients[4]])  # order of u: a_rot, a_tran
        for j in range(n // 2):
            g = np.zeros(n)
            g[2 * j : 2 * j + 2] = per_stage
            G += [g, -g]
            w += [row.upper, -row.lower]
    return np.array(G).reshape(-1, n), np.array(w)


class ExplicitLaw:
    """The stored law, evaluated by walking from the region of the last query."""

    def __init__(self, law: Law, settings: ExplicitSettings) -> None:
        self.settings = settings
        self._law = law
        self._T = frozen_array(settings.blocking)
        self._low, self._high = law.problem.lower, law.problem.upper
        self._edge = EDGE_TOLERANCE * (self._high - self._low)
        self._theta = np.empty(5)
        self._region = -1

    def __len__(self) -> int:
        return len(self._law)

    def reset(self) -> None:
        """Forget the last region, so that equal runs are equal."""
        self._region = -1

    def inputs(self, x: Vec, wanted: float) -> Mat | None:
        """(N, 2) accelerations [a_rot, a_tran] from state x (≥ 4,), or None where no law exists.

        None means that the explicit problem is infeasible there: no input keeps its limits.
        """
        theta = self._theta
        theta[:4], theta[4] = x[:4], wanted
        inside = np.clip(theta, self._low, self._high)
        if not np.all(np.abs(inside - theta) <= self._edge):  # so written, a NaN is outside too
            return None
        answer = self._law.evaluate(inside, self._region)
        if not answer.found:
            return None
        if answer.region >= 0:
            self._region = answer.region
        U: Mat = (self._T @ answer.z).reshape(-1, 2)
        return U


class Explicit:
    """Cueing by explicit laws alone (section 5.2.1), one per axis pair.

    With the linearised output and separate reaches, the joint law of several pairs is these laws
    beside each other: neither can see the other's state.

    Where a law has no answer, its pair stops as `otolith.stopping` says. A law whose rows are to make that
    possible (`BrakingRows.STOPPING`) is also held to it: an answer that leads to a state from which the pair
    could not stop is not followed.
    """

    def __init__(
        self,
        platform: Platform,
        pairs: Sequence[AxisPair],
        limits: Sequence[PairLimits],
        laws: Sequence[ExplicitLaw],
    ) -> None:
        self._pairs, self._laws = tuple(pairs), tuple(laws)
        self._stopping = [
            Stopping(platform, (pair,), limits=(_at_once(of_pair),), lag=0.0, period=self.period)
            for pair, of_pair in zip(pairs, limits, strict=True)
        ]

    @property
    def period(self) -> float:
        """Time between two decisions [s]."""
        return self._laws[0].settings.period

    def reset(self, state: PlatformState) -> None:
        """Start afresh; the laws have no memory but the region of their last query."""
        for law, stopping in zip(self._laws, self._stopping, strict=True):
            law.reset()
            stopping.reset(state)

    def step(self, state: PlatformState, reference: Reference) -> Command:
        """Look the laws up, each on its own."""
        return added(
            [
                self._of_pair(pair, law, stopping, state, reference)
                for pair, law, stopping in zip(self._pairs, self._laws, self._stopping, strict=True)
            ]
        )

    def _of_pair(
        self, pair: AxisPair, law: ExplicitLaw, stopping: Stopping, state: PlatformState, reference: Reference
    ) -> Command:
        wanted = reference.specific_force[pair.translation]
        if not (stopping.observe(state) and plausible(wanted)):
            return stopping.rest(Outcome(status=Status.INVALID))
        U = law.inputs(planar_state(state, pair)[:4], float(wanted))
        if U is None:
            return stopping.rest(Outcome(status=Status.INFEASIBLE))
        plan = np.zeros((len(U), 6))
        plan[:, pair.translation] = U[:, TRAN]
        plan[:, pair.rotation] = pair.sign * U[:, ROT]
        if law.settings.braking is BrakingRows.STOPPING and not stopping.allows(plan[0]):
            return stopping.rest(Outcome(status=Status.UNCERTIFIED))
        return stopping.decided(plan, Outcome(status=Status.OPTIMAL))


def _at_once(limits: PairLimits) -> PairLimits:
    """The same limits in the explicit model, where a command is the acceleration itself."""
    return replace(limits, command=limits.acceleration)
