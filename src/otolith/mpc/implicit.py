"""The implicit half: one Gauss-Newton step of the thesis's online MPC per period (section 4.1.2).

Notation: x = [ω θ v s a_tran a_rot], u = [a_rot a_tran] commanded, N horizon, U (N·2,) inputs stage
by stage, X = Φ x₀ + Γ U, ū the plan that the output is linearised about, u_ref the guess:

    min_U  Σ_{k=1..N} (f(x_k) − f_ref)² + Σ_i W_i x_{k,i}² + R ‖u_{k−1} − u_ref,k−1‖²
    s.t.   rows of eq. 4.10 at x_1 … x_N, bounds on the commands.

The dynamics are linear and discretised exactly, so multiple shooting and its condensed form agree;
only f = a_tran + g sin θ is linearised, about the previous plan, not shifted.
"""

from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError
from otolith.core.frames import GRAVITY, AxisPair
from otolith.core.lti import condense, zero_order_hold
from otolith.interfaces import Command, Outcome, PlatformState, Reference
from otolith.mpc.hybrid import Guess
from otolith.mpc.model import (
    ACCELERATION,
    POSITION,
    ROT,
    STATES,
    TILT,
    TILT_RATE,
    TRAN,
    VELOCITY,
    BrakingRows,
    Row,
    acceleration_rows,
    bounded,
    brake,
    braking_rows,
    implicit_dynamics,
    planar_state,
    plausible,
    state_rows,
)
from otolith.mpc.washout import PRESETS, WashoutWeight
from otolith.platforms import Braking, PairLimits
from otolith.qp import DenseSolver, Qp, Solution, Status


class Entry(StrEnum):
    """How a guess enters the implicit MPC."""

    REFERENCE = "reference"  # eq. 3.1 as printed: u_ref of the cost; it changes the optimum
    PRIMAL = "primal"  # the plan that is linearised about: it changes the way, hardly the answer


def parse_entry(name: str) -> Entry:
    """Read an option's value, or say in one sentence what it may be."""
    try:
        return Entry(name)
    except ValueError:
        raise InputError("guess entry", repr(name), "one of " + ", ".join(Entry)) from None


@dataclass(frozen=True, slots=True, kw_only=True)
class ImplicitSettings:
    """What the implicit MPC is; the defaults are the thesis's, with adaptive washout."""

    horizon: int = 50  # N
    period: float = 0.01  # [s]
    lag: float = 0.01  # [s] between commanded and actual acceleration
    control_weight: float = 1e-3  # R
    washout: tuple[WashoutWeight, ...] = PRESETS["thesis-fit"]
    braking: BrakingRows = BrakingRows.POSITION
    solver: DenseSolver = field(default_factory=DenseSolver)

    def __post_init__(self) -> None:
        if self.horizon < 2:
            raise InputError("implicit horizon", self.horizon, "at least 2 steps")
        for name in ("period", "lag", "control_weight"):
            if not 0.0 < getattr(self, name) < np.inf:
                raise InputError(name, getattr(self, name), "finite and greater than 0")


class _Prediction:
    """Everything of the QP that never changes: predictions, rows, Gram matrices."""

    def __init__(self, rows: list[Row], bounds: tuple[Vec, Vec], settings: ImplicitSettings) -> None:
        N = settings.horizon
        self.A, self.B = zero_order_hold(*implicit_dynamics(settings.lag), settings.period)
        self.Phi, Gamma = condense(self.A, self.B, N)  # (N, 6, 6), (N, 6, 2N)
        self.Gamma = np.ascontiguousarray(Gamma.transpose(1, 0, 2))  # (6, N, 2N), state by state
        self.gram = {w.on: self._of(w.on).T @ self._of(w.on) for w in settings.washout}  # (2N, 2N)

        C = np.array([row.coefficients for row in rows])  # (r, 6)
        self.rows_of_U = np.einsum("ri,kij->rkj", C, Gamma).reshape(-1, 2 * N)
        self.rows_of_x = np.einsum("ri,kij->rkj", C, self.Phi).reshape(-1, 6)
        self.row_lower = np.repeat([row.lower for row in rows], N)
        self.row_upper = np.repeat([row.upper for row in rows], N)
        self.command_lower, self.command_upper = (np.tile(side, N) for side in bounds)

    def _of(self, state: str) -> Mat:
        rows: Mat = self.Gamma[STATES.index(state)]
        return rows


class Implicit:
    """Cueing by one certified QP per period, with or without a guess: the thesis's four models."""

    def __init__(
        self,
        pair: AxisPair,
        limits: PairLimits,
        braking: Braking,
        *,
        settings: ImplicitSettings,
        guess: Guess,
        entry: Entry = Entry.REFERENCE,
    ) -> None:
        self.settings = settings
        self._pair, self._guess, self._entry = pair, guess, entry
        rows = (
            state_rows(limits) + acceleration_rows(limits) + braking_rows(limits, braking, settings.braking)
        )
        self._command_bound = np.array([limits.tilt_acceleration, limits.command])  # order of u
        self._fixed = _Prediction(rows, (-self._command_bound, self._command_bound), settings)
        self._plan = np.zeros((settings.horizon, 2))
        self._working_set = np.zeros(len(self._fixed.row_lower) + 2 * settings.horizon, dtype=np.int64)

    @property
    def period(self) -> float:
        """Time between two decisions [s]."""
        return self.settings.period

    def reset(self, state: PlatformState) -> None:
        """Forget plan, working set and guess."""
        del state
        self._plan[:] = 0.0
        self._working_set[:] = 0
        self._guess.reset()

    def step(self, state: PlatformState, reference: Reference) -> Command:
        """Solve one QP; on failure follow the last certified plan, and say why."""
        x = planar_state(state, self._pair)
        wanted = float(reference.specific_force[self._pair.translation])
        solution, missed = self._solve(x, wanted)
        if solution.status is Status.OPTIMAL:
            self._plan = solution.z.reshape(-1, 2)
            self._working_set = solution.working_set
        else:
            self._plan = self._fallback(x)
            self._working_set[:] = 0
        return self._command(x, solution, missed)

    def _solve(self, x: Vec, wanted: float) -> tuple[Solution, bool]:
        if not plausible(x, wanted):
            rows = len(self._working_set)
            return Solution.none(Status.INVALID, variables=self._plan.size, rows=rows), False
        qp, missed = self.problem(x, wanted)
        return self.settings.solver.solve(qp, self._working_set), missed

    def problem(self, x: Vec, wanted: float) -> tuple[Qp, bool]:
        """The QP at state x (6,) for a force wanted [m/s²], and whether a guess was missed."""
        guessed = self._guess.controls(x, wanted, self._plan)
        missed = guessed is None and self._guess.active
        about = guessed if guessed is not None and self._entry is Entry.PRIMAL else self._plan
        H, g = self._cost(x, wanted, np.asarray(about).ravel())
        if guessed is not None and self._entry is Entry.REFERENCE:
            g -= self.settings.control_weight * guessed.ravel()

        fixed = self._fixed
        free = fixed.rows_of_x @ x
        lower = np.concatenate([fixed.command_lower, fixed.row_lower - free])
        upper = np.concatenate([fixed.command_upper, fixed.row_upper - free])
        return Qp(H, g, fixed.rows_of_U, lower, upper), missed

    def _cost(self, x: Vec, wanted: float, about: Vec) -> tuple[Mat, Vec]:
        """Gauss-Newton Hessian (2N, 2N) and gradient (2N,) at U = 0, linearised about `about`."""
        fixed, settings = self._fixed, self.settings
        X = fixed.Phi @ x  # (N, 6) free response
        tilt = X[:, TILT] + fixed.Gamma[TILT] @ about
        slope = GRAVITY * np.cos(tilt)  # (N,) ∂f/∂θ
        C = fixed.Gamma[ACCELERATION] + slope[:, None] * fixed.Gamma[TILT]  # (N, 2N) ∂f/∂U
        error = X[:, ACCELERATION] + GRAVITY * np.sin(tilt) + slope * (X[:, TILT] - tilt) - wanted
        H, g = C.T @ C, C.T @ error
        for washout in settings.washout:
            weight, i = washout.at(x), STATES.index(washout.on)
            H += weight * fixed.gram[washout.on]
            g += weight * (fixed.Gamma[i].T @ X[:, i])
        H[np.diag_indices_from(H)] += settings.control_weight
        return H, g

    def _fallback(self, x: Vec) -> Mat:
        """The last certified plan, one step on; where there is none, brake to rest."""
        if not self._plan.any():
            return np.tile(brake(x, 5.0 * self.settings.period, self._command_bound), (len(self._plan), 1))
        return np.vstack([self._plan[1:], np.zeros((1, 2))])

    def _command(self, x: Vec, solution: Solution, missed: bool) -> Command:
        u = self._plan[0]
        after = self._fixed.A @ bounded(x) + self._fixed.B @ u
        in_axes = np.zeros((len(self._plan), 6))
        in_axes[:, self._pair.translation] = self._plan[:, TRAN]
        in_axes[:, self._pair.rotation] = self._pair.sign * self._plan[:, ROT]
        return Command(
            acceleration=in_axes[0],
            pose=self._pair.axes(after[POSITION], after[TILT]),
            twist=self._pair.axes(after[VELOCITY], after[TILT_RATE]),
            plan=in_axes[1:],
            outcome=Outcome(
                status=solution.status,
                changes=solution.changes,
                residual=solution.residual,
                guess_missed=missed,
            ),
        )
