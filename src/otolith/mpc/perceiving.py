"""One QP in which the driver's vestibular organs are part of the prediction.

Notation: z = (x_1 … x_P, o_1 … o_C) with x_p the states of the parts, o_c those of the organ of
channel c, which is driven by f_c = row_c x; N horizon. One linear system, discretised exactly for held
inputs, so that any stage engine solves

    min Σ_k Σ_c ½ q_c (h_c(z_k) − r_c,k)² + ½ Σ W x² + ½ R ‖u‖²    s.t. the parts' rows, bounds on u,

h_c what is sensed in the simulator, r_c what is sensed in the car: its organs are followed along the
reference, and predicted with the force held (or previewed).

Gravity is g θ in z. What sin θ (and the cosine of an outer tilt) lacks, Δ = g (cos θ_q sin θ − θ), is
evaluated along the previous plan and its sensed part added to the prediction: the value is that of the
nonlinear model, the Jacobian is that of small tilts, a Gauss-Newton step with a fixed Jacobian. A
linear MPC leaves Δ out.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.frames import GRAVITY
from otolith.core.lti import StateSpace, condense, first_order_hold, zero_order_hold
from otolith.interfaces import Reference
from otolith.mpc.formulation import BACK_OFF
from otolith.mpc.model import ACCELERATION, POSITION, VELOCITY
from otolith.mpc.parts import Part
from otolith.mpc.washout import WashoutWeight
from otolith.qp.blocked import Lengths, block_ends
from otolith.qp.engines import StageMemory
from otolith.qp.stage import StageProblem, StageSolution


class Organ:
    """An organ in the car or in the simulator: where it is, and what it will sense over the horizon."""

    def __init__(self, system: StateSpace, horizon: int, period: float) -> None:
        self.A, self.B0, self.B1 = first_order_hold(system.A, system.B, period)
        A, B = zero_order_hold(system.A, system.B, period)
        Phi, Gamma = condense(A, B, horizon)
        self._free = (system.C @ Phi)[:, 0]  # (N, nx)
        self._forced = (system.C @ Gamma)[:, 0] + system.D.item() * np.eye(horizon)  # (N, N)
        self.reset()

    def reset(self) -> None:
        """At rest, nothing felt."""
        self.x, self._felt = np.zeros(len(self.A)), 0.0

    def feel(self, value: float) -> None:
        """Move on by one period, at whose end `value` is felt; straight in between."""
        self.x = self.A @ self.x + self.B0[:, 0] * self._felt + self.B1[:, 0] * value
        self._felt = value

    def ahead(self, values: Vec) -> Vec:
        """Sensed at the ends of the next N periods, under the values (N,) held over each."""
        sensed: Vec = self._free @ self.x + self._forced @ values
        return sensed

    def response(self, values: Vec) -> Vec:
        """What `values` alone adds to that."""
        added: Vec = self._forced @ values
        return added


@dataclass(frozen=True, slots=True, kw_only=True)
class PerceivingSettings:
    """What the problem depends on, beside its parts."""

    horizon: int
    period: float  # [s]
    control_weight: float
    washout: tuple[WashoutWeight, ...]
    blocks: Lengths
    firm: int  # first blocks whose rows are hard
    later_penalty: float
    exact_gravity: bool  # whether Δ is added along the previous plan
    circle: float | None  # [m] the places of the first two parts keep within, linearised about the plan
    circle_weights: Vec  # (3,) of velocity, position and acceleration in those places


class Perceiving:
    """The problem's constant data, the organs' states, and how the rest is written for every decision."""

    def __init__(self, parts: Sequence[Part], settings: PerceivingSettings) -> None:
        self.parts, self.settings = tuple(parts), settings
        N, period = settings.horizon, settings.period
        self.channels = [(p, channel) for p, part in enumerate(parts) for channel in part.channels]
        self._first = np.cumsum([0, *(len(part.A) for part in parts)])  # where each part's states begin
        self.inputs = sum(part.B.shape[1] for part in parts)
        self.here = [Organ(channel.organ, N, period) for _, channel in self.channels]
        self.there = [Organ(channel.organ, N, period) for _, channel in self.channels]
        self.A, self.B = zero_order_hold(*self._dynamics(), period)
        self.problem = self._problem()
        self.lengths = settings.blocks or (1,) * N
        self._weights = [(self._first[p] + self.parts[p].names.index(w.of), w) for p, w in self._washout()]
        self._predict = condense(self.A, self.B, N)

    def reset(self) -> None:
        """Both drivers at rest."""
        for organ in (*self.here, *self.there):
            organ.reset()

    def begin(self, memory: StageMemory) -> None:
        """Write what never changes."""
        N, rows = self.settings.horizon, [row for part in self.parts for row in part.rows]
        circles = 0 if self.settings.circle is None else 1
        bounds = np.concatenate([part.bounds for part in self.parts])
        radius = np.full(circles, self.settings.circle or 0.0)
        lower = np.tile(
            np.concatenate([[row.lower for row in rows], -np.inf * np.ones(circles), -bounds]), (N, 1)
        )
        upper = np.tile(np.concatenate([[row.upper for row in rows], radius, bounds]), (N, 1))
        tighter = BACK_OFF * np.arange(1.0, N + 1.0)[:, None]
        lower[:, : len(rows)] += tighter
        upper[:, : len(rows) + circles] -= tighter
        last = [i for i, row in enumerate(rows) if row.name.startswith("terminal")]
        lower[:-1, last], upper[:-1, last] = -np.inf, np.inf
        ends = block_ends(self.lengths)
        memory.lower[:], memory.upper[:] = lower[ends], upper[ends]
        memory.state_linear[:] = memory.input_linear[:] = 0.0
        memory.output[:] = self._outputs()[self.problem.output]

    def write(self, memory: StageMemory, x: Vec, reference: Reference, plan: Mat) -> None:
        """Write the problem at the parts' states x, about `plan` (N, nu), and move both drivers on."""
        memory.start[: len(x)] = x
        ahead = self._ahead(x, plan)
        gravity = self._missing_gravity(ahead)
        at = len(x)
        for c, (p, channel) in enumerate(self.channels):
            own = x[self._first[p] : self._first[p + 1]]
            tilted = self.parts[p].tilt >= 0 and channel is self.parts[p].channels[0]
            missing = gravity[p] if tilted else np.zeros(len(plan) + 1)
            self.here[c].feel(float(channel.row @ own) + missing[0])
            memory.start[at : at + len(self.here[c].x)] = self.here[c].x
            at += len(self.here[c].x)
            wanted = channel.wanted(reference)
            self.there[c].feel(float(wanted[0]))
            held = wanted[np.minimum(np.arange(len(plan)), len(wanted) - 1)]
            error = self.here[c].response(missing[1:]) - self.there[c].ahead(held)
            memory.error[:, c] = np.sqrt(channel.weight) * error
        memory.state_weight[:] = [self._weight(i, weight, x) for i, weight in self._weights]
        if self.settings.circle is not None:
            memory.varying[:] = self._directions(ahead)

    def of_steps(self, solution: StageSolution) -> Mat:
        """Inputs (N, nu) of every step."""
        return np.repeat(solution.U, self.lengths, axis=0)

    def of_parts(self, plan: Mat) -> list[Mat]:
        """The columns of every part of a plan (N, nu)."""
        return np.split(plan, np.cumsum([part.B.shape[1] for part in self.parts])[:-1], axis=1)

    def _washout(self) -> list[tuple[int, WashoutWeight]]:
        """Part and weight, of the weights whose states the part has."""
        every = [(p, weight) for p in range(len(self.parts)) for weight in self.settings.washout]
        return [(p, w) for p, w in every if {w.on, w.of} <= set(self.parts[p].names)]

    def _weight(self, state: int, weight: WashoutWeight, x: Vec) -> float:
        w1, w2, w3, w4 = weight.coefficients
        r = abs(x[state]) / weight.scale
        return float(w1 + w2 * r + w3 * r**2 + w4 * r**4)

    def _ahead(self, x: Vec, plan: Mat) -> Mat:
        """States of the parts (N + 1, nx) under the plan, the present ones first."""
        Phi, Gamma = self._predict
        n = len(x)
        later = Phi[:, :n, :n] @ x + Gamma[:, :n] @ plan.ravel()
        return np.vstack([x, later])

    def _missing_gravity(self, ahead: Mat) -> list[Vec]:
        """Δ (N + 1,) of every part: zero without a tilt; only the present one where it is left out."""
        found, outer = [], np.ones(len(ahead))
        for p, part in enumerate(self.parts):
            if part.tilt < 0:
                found.append(np.zeros(len(ahead)))
                continue
            tilt = ahead[:, self._first[p] + part.tilt]
            delta = GRAVITY * (outer * np.sin(tilt) - tilt)
            if not self.settings.exact_gravity:
                delta[1:] = 0.0
            found.append(delta)
            outer = np.cos(tilt)  # the next pair turns within this one
        return found

    def _directions(self, ahead: Mat) -> Mat:
        """Rows (M, values) of the circle about the places predicted for the blocks' ends."""
        weights = self.settings.circle_weights
        of_parts = ahead[1:][block_ends(self.lengths)][:, self._in_circle]  # (M, 2, 3)
        places = of_parts @ weights
        length = np.linalg.norm(places, axis=1, keepdims=True)
        directions = np.where(length > 1e-9, places / np.maximum(length, 1e-9), 0.0)
        rows: Mat = directions[:, :, None] * weights[weights != 0.0]
        return rows.reshape(len(rows), -1)

    @property
    def _in_circle(self) -> Ints:
        """(2, 3) columns of velocity, position and acceleration of the first two parts."""
        return np.array([self._first[p] + np.array([VELOCITY, POSITION, ACCELERATION]) for p in range(2)])

    def _dynamics(self) -> tuple[Mat, Mat]:
        """Continuous (A, B) of z."""
        n = int(self._first[-1])
        A = block_diag(*(part.A for part in self.parts), *(channel.organ.A for _, channel in self.channels))
        at = n
        for p, channel in self.channels:
            m = len(channel.organ.A)
            A[at : at + m, self._first[p] : self._first[p + 1]] = channel.organ.B @ channel.row[None]
            at += m
        B = np.zeros((len(A), self.inputs))
        B[:n] = block_diag(*(part.B for part in self.parts))
        return A, B

    def _outputs(self) -> Mat:
        """D (C, nz): weighted rows of what is sensed."""
        D = np.zeros((len(self.channels), len(self.A)))
        at = int(self._first[-1])
        for c, (p, channel) in enumerate(self.channels):
            m = len(channel.organ.A)
            D[c, self._first[p] : self._first[p + 1]] = channel.organ.D.item() * channel.row
            D[c, at : at + m] = channel.organ.C[0]
            D[c] *= np.sqrt(channel.weight)
            at += m
        return D

    def _problem(self) -> StageProblem:
        settings, n, nz = self.settings, int(self._first[-1]), len(self.A)
        rows = [row for part in self.parts for row in part.rows]
        C = np.zeros((len(rows), nz))
        C[:, :n] = block_diag(*(np.array([row.coefficients for row in part.rows]) for part in self.parts))
        circle = np.zeros((0 if settings.circle is None else 1, nz), dtype=bool)
        if len(circle):
            circle[0, self._in_circle] = settings.circle_weights != 0.0
        penalty = np.full((settings.horizon, len(rows) + len(circle) + self.inputs), np.inf)
        if settings.blocks:
            after = sum(settings.blocks[: settings.firm])
            penalty[after:, : len(rows) + len(circle)] = settings.later_penalty
        weighted = [int(self._first[p]) + self.parts[p].names.index(w.on) for p, w in self._washout()]
        return StageProblem(
            horizon=settings.horizon,
            A=self.A,
            B=self.B,
            C=C,
            output=self._outputs() != 0.0,
            varying=circle,
            weighted=tuple(weighted),
            control_weight=np.full(self.inputs, settings.control_weight),
            penalty=penalty,
        )
