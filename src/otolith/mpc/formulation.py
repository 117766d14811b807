"""The implicit MPC of any set of axis pairs as a stage problem; 2 and 4 DOF are the same code.

Notation as in `otolith.mpc.linearise`: per pair x_p = [ω θ v s a_tran a_rot], u_p = [a_rot a_tran], and
beside each other x = (x_1 … x_P), u = (u_1 … u_P). Per step k = 1 … N:

    min Σ_k ½‖f(x_k) − f_ref‖² + ½ Σ_i W_i x_{k,i}² + ½ R ‖u_{k−1} − u_ref,k−1‖²
    s.t. rows of eq. 4.10 per pair, the limit circle of section 4.2 for two, bounds on the commands.

Inputs may be held over M blocks of steps; the cost is still that of every step, the rows are those of the
blocks' ends (`otolith.qp.blocked`). Without blocks every step is one, M = N.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from scipy.linalg import block_diag

from otolith.core.arrays import Mat, Vec
from otolith.core.frames import SURGE_PITCH, SWAY_ROLL, AxisPair
from otolith.core.lti import zero_order_hold
from otolith.mpc import linearise
from otolith.mpc.model import (
    ACCELERATION,
    POSITION,
    STATES,
    TILT,
    VELOCITY,
    BrakingRows,
    Row,
    acceleration_rows,
    braking_rows,
    circle_weights,
    command_bound,
    implicit_dynamics,
    leading_rows,
    state_rows,
    terminal_rows,
)
from otolith.mpc.washout import WashoutWeight
from otolith.platforms import Platform
from otolith.qp.blocked import Lengths, block_ends
from otolith.qp.engines import StageMemory
from otolith.qp.stage import StageProblem

BACK_OFF: Final = 2e-8  # [SI] per stage, above the solvers' 1e-9
HAIR: Final = 1e-4  # [rad], 0.006 deg, far above all tolerances; see `Formulation._rows`
CIRCLE_BACK_OFF: Final = 1e-6  # [m] per stage, above radius·φ²/2 for the turn φ of one step


@dataclass(frozen=True, slots=True, kw_only=True)
class Setting:
    """What the formulation depends on, beside platform and pairs."""

    horizon: int
    period: float  # [s]
    lag: float  # [s]
    control_weight: float
    washout: tuple[WashoutWeight, ...]
    braking: BrakingRows
    terminal: bool  # the last state must be able to stop
    soft: Mapping[str, float]  # penalty by row name, e.g. {"tilt_rate": 100.0} (eq. 6.2)
    blocks: Lengths = ()  # steps of each, N in sum; none: every step its own
    firm: int = 2  # first blocks whose rows stay hard, unless `soft` names them
    later_penalty: float = np.inf  # of rows on states at the ends of the others


class Formulation:
    """Constant data of the problem, and how its changing part is written into an engine's memory."""

    def __init__(self, platform: Platform, pairs: Sequence[AxisPair], setting: Setting) -> None:
        self.pairs, self.setting = tuple(pairs), setting
        self.lengths = setting.blocks or (1,) * setting.horizon
        self._ends = block_ends(self.lengths)
        limits = [platform.pair_limits(pair) for pair in self.pairs]
        self.stopping = setting.braking is BrakingRows.STOPPING
        self.command_bound = np.ravel(
            [
                bound
                for one in limits
                for bound in (one.tilt_acceleration, command_bound(one, setting.braking))
            ]
        )
        self.radius = platform.circle if len(self.pairs) == 2 else None
        rows = [self._rows(platform, pair) for pair in self.pairs]
        self._quantities = [
            f"{pair.name} {r.name}" for pair, own in zip(pairs, rows, strict=True) for r in own
        ]
        self._quantities += ["circle"] * (self.radius is not None)  # commands, which come last, are hard
        self.A, self.B = zero_order_hold(*implicit_dynamics(setting.lag), setting.period)  # of one pair
        self.circle = circle_weights(limits, platform.braking, setting.braking, setting.lag, setting.period)
        self.problem = self._problem(rows)
        self._lower, self._upper = self._bounds([row for of_pair in rows for row in of_pair])
        washout = [(p, weight) for p in range(len(self.pairs)) for weight in setting.washout]
        self._given = linearise.Given(
            A=self.A,
            B=self.B,
            under=np.array([self._lies_under(pair) for pair in self.pairs], dtype=np.int64),
            ends=self._ends,
            of=np.array([6 * p + STATES.index(weight.of) for p, weight in washout], dtype=np.int64),
            washout=np.array([(*weight.coefficients, weight.scale) for _, weight in washout]).reshape(-1, 5),
            control_weight=np.full(2 * len(self.pairs), setting.control_weight),
            circle=self.circle,
            X=np.empty((setting.horizon, 6 * len(self.pairs))),
        )
        self._no_reference = np.empty((0, 2 * len(self.pairs)))

    @property
    def soft(self) -> frozenset[str]:
        """Rows that the very next node may violate at a price; those of later nodes are plans, not motion."""
        soft = np.isfinite(self.problem.penalty[0])
        return frozenset(name for name, is_soft in zip(self._quantities, soft, strict=False) if is_soft)

    def begin(self, memory: StageMemory) -> None:
        """Write what never changes."""
        memory.lower[:], memory.upper[:] = self._lower[self._ends], self._upper[self._ends]
        memory.state_linear[:] = 0.0

    def write(self, memory: StageMemory, x: Vec, plan: Mat, wanted: Mat, u_ref: Mat | None) -> None:
        """Write the problem at state x (6P,), linearised about `plan` (N, 2P), for forces (N, P) wanted."""
        contiguous = np.ascontiguousarray  # one memory layout, one compiled kernel
        u_ref = self._no_reference if u_ref is None else contiguous(u_ref)
        linearise.write(self._given, memory, x, contiguous(plan), contiguous(wanted), u_ref)

    def of_steps(self, U: Mat) -> Mat:
        """Inputs (N, 2P) of every step from those of the blocks (M, 2P)."""
        return np.repeat(U, self.lengths, axis=0)

    def _rows(self, platform: Platform, pair: AxisPair) -> list[Row]:
        """Rows of one pair; the position's own are left out where the limit circle implies them.

        A tilt that waits at its limit would have both its rows active, the braking row and the limit, at
        every stage: twice as many as there are inputs to move them. So the braking row ends a hair before.
        """
        limits, setting = platform.pair_limits(pair), self.setting
        if self.stopping:
            rows = leading_rows(limits, platform.braking, lag=setting.lag, period=setting.period)
        else:
            rows = state_rows(limits) + acceleration_rows(limits)
        rows += [_a_hair_less(row) for row in braking_rows(limits, platform.braking, setting.braking)]
        rows += terminal_rows(limits) if setting.terminal else []
        if self.radius is not None and min(-limits.position[0], limits.position[1]) >= self.radius:
            rows = [row for row in rows if row.name != "position"]
        return rows

    def _problem(self, rows: list[list[Row]]) -> StageProblem:
        P, setting = len(self.pairs), self.setting
        C = block_diag(*[np.array([row.coefficients for row in of_pair]) for of_pair in rows])
        circles = 0 if self.radius is None else 1
        names = [row.name for of_pair in rows for row in of_pair]
        names += ["circle"] * circles + ["command"] * (2 * P)
        output, circle = np.zeros((P, 6 * P), dtype=bool), np.zeros((circles, 6 * P), dtype=bool)
        for p, pair in enumerate(self.pairs):
            output[p, [6 * p + TILT, 6 * p + ACCELERATION]] = True
            if (q := self._lies_under(pair)) >= 0:
                output[p, 6 * q + TILT] = True
            of_pair = [6 * p + VELOCITY, 6 * p + POSITION, 6 * p + ACCELERATION]
            circle[:, of_pair] = self.circle != 0.0
        return StageProblem(
            horizon=setting.horizon,
            A=block_diag(*[self.A] * P),
            B=block_diag(*[self.B] * P),
            C=C,
            output=output,
            varying=circle,
            weighted=tuple(6 * p + STATES.index(w.on) for p in range(P) for w in setting.washout),
            control_weight=np.full(2 * P, setting.control_weight),
            penalty=self._penalty(names),
        )

    def _penalty(self, names: list[str]) -> Mat:
        """(N, rows) penalties, as `soft` says; after the firm blocks all rows on states are soft.

        A plan of blocks, one step on, is no plan of blocks any more, and between their ends nothing limits
        the states: rows that are hard all over the horizon may contradict each other.
        """
        setting = self.setting
        penalty = np.tile([setting.soft.get(name, np.inf) for name in names], (setting.horizon, 1))
        if setting.blocks:
            after, states = sum(setting.blocks[: setting.firm]), len(names) - len(self.command_bound)
            penalty[after:, :states] = np.minimum(penalty[after:, :states], setting.later_penalty)
        return penalty

    def _bounds(self, rows: list[Row]) -> tuple[Mat, Mat]:
        """(N, rows) lower and upper bounds; terminal rows hold at the last stage only.

        Bounds on states tighten by a hair from stage to stage, so that the plan of one step, shifted,
        satisfies the rows of the next with room to spare: what a solver leaves of a row, and what
        relinearising the circle moves, then never makes the next problem infeasible (constraint
        tightening; Chisci, Rossiter & Zappa, 2001).
        """
        N = self.setting.horizon
        lower = np.tile(np.concatenate([[r.lower for r in rows], self._below(), -self.command_bound]), (N, 1))
        upper = np.tile(np.concatenate([[r.upper for r in rows], self._above(), self.command_bound]), (N, 1))
        tighter = BACK_OFF * np.arange(1.0, N + 1.0)[:, None]
        lower[:, : len(rows)] += tighter
        upper[:, : len(rows)] -= tighter
        if self.radius is not None:
            upper[:, len(rows)] -= CIRCLE_BACK_OFF * np.arange(1.0, N + 1.0)
        last_only = [i for i, row in enumerate(rows) if row.name.startswith("terminal")]
        lower[:-1, last_only], upper[:-1, last_only] = -np.inf, np.inf
        return lower, upper

    def _below(self) -> Vec:
        return np.array([] if self.radius is None else [-np.inf])

    def _above(self) -> Vec:
        return np.array([] if self.radius is None else [self.radius])

    def _lies_under(self, pair: AxisPair) -> int:
        """Index of the pair under whose tilt this one's gravity lies: roll turns within pitch."""
        return self.pairs.index(SURGE_PITCH) if pair is SWAY_ROLL and SURGE_PITCH in self.pairs else -1


def _a_hair_less(row: Row) -> Row:
    """The braking row of the tilt within bounds tighter by `HAIR`, any other as it is."""
    if row.name != "braking_tilt":
        return row
    return replace(row, lower=row.lower + HAIR, upper=row.upper - HAIR)
