"""The MPC of any set of degrees of freedom as a stage problem, for 2, 4, 6 and more axes alike.

Notation: x (nx,) is the motion of all degrees of freedom (`otolith.cueing.mpc.motion`), o the states of the
organs of the sensed channels (`otolith.cueing.mpc.objective`), z = (x, o), and u (nu,) the commands. The
problem over the steps k = 1 … N is

    min Σ_k Σ_c ½ w_c (h_c(z_k) − r_c,k)² + ½ Σ_i W_i x_{k,i}² + ½ R ‖u_{k−1} − u_ref,k−1‖²

subject to the rows of every degree of freedom (eq. 4.10), the limit circle of section 4.2 and bounds on the
commands. Here h_c is what is felt or sensed through channel c, and r_c what should be. The vector z follows
one linear system, discretised exactly for held commands. Only h and the circle are linearised, about the
previous plan (`kernels`).

Inputs may be held over M blocks of steps. The cost is still that of every step, but the rows hold at the
blocks' ends only (`otolith.qp.blocked`). Without blocks every step is a block, M = N.
"""

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np
from scipy.linalg import block_diag

from otolith.core.arrays import Bools, Mat, Vec
from otolith.core.errors import InputError
from otolith.core.frames import GRAVITY, SURGE_PITCH, SWAY_ROLL, Dof
from otolith.core.lti import zero_order_hold
from otolith.core.methods import NO_METHOD, Bound
from otolith.cueing.mpc import kernels
from otolith.cueing.mpc.axis_sets import sets_with
from otolith.cueing.mpc.body import BODY_ROWS, FIRM, Body
from otolith.cueing.mpc.circle import Circle, circle_of
from otolith.cueing.mpc.motion import TILT, chains, dynamics, first_states, held, predict, stacked, states
from otolith.cueing.mpc.objective import Channel, carried_by, channels
from otolith.cueing.mpc.organs import organs_of
from otolith.cueing.mpc.rows import REST, Limits, Row, command_bounds, interference_rows, rest_rows, rows_of
from otolith.cueing.mpc.settings import MpcSettings
from otolith.cueing.mpc.washout_weights import WashoutWeight
from otolith.platforms import Braking, Platform
from otolith.qp.blocked import block_ends
from otolith.qp.engines import StageMemory
from otolith.qp.stage import StageProblem, StageSolution
from otolith.safety.invariant.axis import AxisSet

FIRM_REACHED: Final = (1.0 - 1e-9) * FIRM  # multiplier that counts as equal to the penalty of a firm row
BACK_OFF: Final = 2e-8  # [SI] per stage, above the solvers' 1e-9
CIRCLE_BACK_OFF: Final = 1e-6  # [m] per stage, above radius·φ²/2 for the turn φ of one step


Washout = Sequence[WashoutWeight] | Mapping[str, Sequence[WashoutWeight]]  # of all, or by degree of freedom


class Problem:
    """The constant data of the problem and the organs' states; it writes the rest into an engine's memory.

    Parameters
    ----------
    body : the platform as one body; None to model each degree of freedom by itself.

    Raises
    ------
    InputError : the platform lacks an axis of one of the degrees of freedom.
    """

    def __init__(
        self, platform: Platform, dofs: Sequence[Dof], settings: MpcSettings, *, body: Body | None = None
    ) -> None:
        self.dofs, self.settings, self._body = tuple(dofs), settings, body
        self.axes, self._first = stacked(self.dofs), first_states(self.dofs)
        self.channels = channels(self.dofs, settings.objective)
        if body is not None:
            self.channels = body.weighed(self.channels, self.dofs)
        sets = [sets_with(platform, dof, settings) for dof in self.dofs]
        self.circle = circle_of(platform, self.dofs, sets, settings)
        self._ends = block_ends(settings.lengths)
        limits = [platform.limits(dof) for dof in self.dofs]
        self._rows = [
            self._rows_of(dof, of_dof, platform.braking, own)
            for dof, of_dof, own in zip(self.dofs, limits, sets, strict=True)
        ]
        self._between = interference_rows(platform, self.axes, settings.braking)
        self.command_bound = np.concatenate(
            [
                command_bounds(dof, of_dof, settings.braking)
                for dof, of_dof in zip(self.dofs, limits, strict=True)
            ]
        )
        self._weights = self._weights_of(settings.washout if body is None else body.washout)
        self._control_weight = _control_weight(platform, self.dofs, settings)
        lag = np.array([settings.lag_of(platform, dof) for dof in self.dofs for _ in dof.axes])
        self._organs = organs_of(self.channels, settings.period)
        self._rows_felt = self._felt_rows()
        self.structure = self._stage_problem(lag)
        self._of_body = self._body_methods()  # keeps what the kernels read alive
        self.given = self._kernel_data(lag)
        self._no_reference = np.empty((0, len(self.axes.axis)))
        self._wanted = np.zeros((settings.horizon, len(self.channels)))

    @property
    def soft(self) -> frozenset[str]:
        """Return the rows that the next node may violate with a penalty.

        Rows of later nodes do not count, since these nodes are planned and never moved to.
        """
        names = [
            f"{dof.name} {row.name}" for dof, own in zip(self.dofs, self._rows, strict=True) for row in own
        ]
        names += [row.name for row in self._between]
        names += ["circle"] * len(self.structure.varying)  # commands, which come last, are hard
        soft = self.structure.penalty[0] < FIRM
        return frozenset(name for name, is_soft in zip(names, soft, strict=False) if is_soft)

    @property
    def can_stop(self) -> bool:
        """Return whether a platform that keeps the rows can always stop inside its limits."""
        return all(self.settings.braking.leads_on(dof) for dof in self.dofs)

    def relaxed(self, solution: StageSolution) -> bool:
        """Return whether an answer violates a row of the firm blocks, since no command holds all of them."""
        return self._body is not None and bool((np.abs(solution.y) >= FIRM_REACHED).any())

    def reset(self) -> None:
        """Set the organs of both drivers, in the simulator and in the car, to a long rest."""
        of = self._organs
        for series in (of.here, of.there, of.felt_here, of.felt_there):
            series[:] = 0.0

    def reweigh(self, washout: Washout) -> None:
        """Change the washout weights in place, where the kernels read them.

        Raises
        ------
        InputError : they are on other states than those before, for which the engine was built.
        """
        weights = self._weights_of(washout)
        before, now = (
            [(dof.name, weight.on, weight.of) for _, dof, weight in of] for of in (self._weights, weights)
        )
        if before != now:
            names = ", ".join(f"{of} {on}" for of, on, _ in now) or "none"
            bound = "on those states that were weighed at the start: " + (
                ", ".join(f"{of} {on}" for of, on, _ in before) or "none"
            )
            raise InputError("the new washout weights", f"on {names}", bound)
        self._weights = weights
        self.given.washout[:] = _washout(weights)

    def begin(self, memory: StageMemory) -> None:
        """Write the data that never change."""
        lower, upper = self.bounds()
        memory.lower[:], memory.upper[:] = lower[self._ends], upper[self._ends]
        memory.state_linear[:] = 0.0
        if self._body is None:
            memory.output[:] = self._outputs()[self.structure.output]

    def wanted(self, coming: Mat, late: float = 0.0) -> Mat:
        """Return what to feel through every channel in the next N periods (N, C), valid until the next call.

        Parameters
        ----------
        coming : (N + ⌈late⌉, 6) prediction of a `otolith.interfaces.Predictor`.
        late : number of periods by which the time of the state is later than that of the reference.
        """
        kernels.want(self.given.felt, np.ascontiguousarray(coming), late, self._wanted)
        return self._wanted

    def write(self, memory: StageMemory, x: Vec, plan: Mat, wanted: Mat, u_ref: Mat | None) -> None:
        """Write the problem at x (nx,), linearised about `plan` (N, nu), for `wanted` (N, C)."""
        contiguous = np.ascontiguousarray  # one memory layout, one compiled kernel
        u_ref = self._no_reference if u_ref is None else contiguous(u_ref)
        kernels.write(self.given, memory, x, contiguous(plan), contiguous(wanted), u_ref)

    def predicted(self, x: Vec, plan: Mat) -> Mat:
        """Return the motion x_1 … x_N (N, nx) from x (nx,) under a plan (N, nu)."""
        X = np.empty((len(plan), len(x)))
        predict(self.axes, self.given.hold, x, np.ascontiguousarray(plan), X)
        return X

    def felt(self, X: Mat) -> Mat:
        """Return what every channel physically feels (n, C) in motions X (n, nx), with the sines of tilts."""
        felt: Mat = X @ self._rows_felt.T
        for c, channel in enumerate(self.channels):
            tilt, outer = self._tilt(channel), self._outer(channel)
            if tilt >= 0:
                pull = np.cos(X[:, outer]) if outer >= 0 else 1.0
                felt[:, c] += GRAVITY * (pull * np.sin(X[:, tilt]) - X[:, tilt])
        return felt

    def of_steps(self, U: Mat) -> Mat:
        """Return the inputs of every step (N, nu) from those of the blocks (M, nu)."""
        return np.repeat(U, self.settings.lengths, axis=0)

    def _weights_of(self, washout: Washout) -> list[tuple[int, Dof, WashoutWeight]]:
        """Return the weights on states that the degrees of freedom have, each with its first state."""
        return [
            (first, dof, weight)
            for first, dof in zip(self._first, self.dofs, strict=False)
            for weight in (washout[dof.name] if isinstance(washout, Mapping) else washout)
            if weight.weighs(dof)
        ]

    def _rows_of(self, dof: Dof, limits: Limits, braking: Braking, sets: Sequence[AxisSet]) -> list[Row]:
        """Return the rows of a degree of freedom, without the position's if the limit circle implies them."""
        settings = self.settings
        rows = rows_of(dof, limits, braking, kind=settings.braking, sets=sets, terminal=settings.terminal)
        low, high = limits[0].position
        if self.circle is not None and dof.is_pair and min(-low, high) >= self.circle.radius:
            rows = [row for row in rows if row.name != "position"]
        return rows if self._body is None else rows + rest_rows(dof)

    @property
    def _all_rows(self) -> list[Row]:
        """Return the constant rows in order: of the degrees of freedom, then between base and platform."""
        return [row for own in self._rows for row in own] + self._between

    def _stage_problem(self, lag: Vec) -> StageProblem:
        """Return the structure for which the engines are built."""
        nx, A, B = self._first[-1], *self._dynamics(lag)
        of_dofs = block_diag(*[np.array([row.coefficients for row in own]) for own in self._rows])
        C = np.zeros((len(self._all_rows), len(A)))
        C[:, :nx] = np.vstack([of_dofs, *(row.coefficients[None] for row in self._between)])
        varying = np.zeros((0 if self.circle is None else 1, len(A)), dtype=bool)
        if self.circle is not None:
            varying[0, self.circle.states] = self.circle.weights != 0.0
        penalty = self._penalty(len(varying))
        if self._body is not None:
            varying = np.vstack([varying, self._body.row_structure(self.axes)])
            of_body = self._body.penalties(len(penalty), self.settings.hard_steps)
            penalty = np.insert(penalty, [penalty.shape[1] - B.shape[1]] * of_body.shape[1], of_body, axis=1)
        return StageProblem(
            horizon=self.settings.horizon,
            A=A,
            B=B,
            C=C,
            output=self._output_structure(),
            varying=varying,
            weighted=tuple(first + states(dof).index(weight.on) for first, dof, weight in self._weights),
            control_weight=self._control_weight,
            penalty=penalty,
        )

    def _dynamics(self, lag: Vec) -> tuple[Mat, Mat]:
        """Return the discrete (A, B) of z = (x, o); what is felt through the channels drives the organs."""
        of_x, of_u = dynamics(self.axes, lag)
        organs = [channel.organ for channel in self.channels if channel.organ is not None]
        A = block_diag(of_x, *(organ.A for organ in organs))
        B = np.vstack([of_u, np.zeros((len(A) - len(of_x), of_u.shape[1]))])
        for c, channel in enumerate(self.channels):
            if channel.organ is not None:
                low, high = len(of_x) + self._organs.first[c : c + 2]
                A[low:high, : len(of_x)] = channel.organ.B @ self._rows_felt[c][None]
        return zero_order_hold(A, B, self.settings.period)

    def _felt_rows(self) -> Mat:
        """Return what every channel feels, linear in the motion (C, nx)."""
        rows = np.zeros((len(self.channels), self._first[-1]))
        for row, channel in zip(rows, self.channels, strict=True):
            row[self._first[channel.of] : self._first[channel.of + 1]] = channel.row
        for first, dof in zip(self._first, self.dofs, strict=False):
            self._add_base(rows, first, dof)
        return rows

    def _add_base(self, rows: Mat, first: int, dof: Dof) -> None:
        """Add what an axis of a base makes felt together with what it carries: one more column of B."""
        for row, channel in zip(rows, self.channels, strict=True):
            if dof.is_base and channel.of == carried_by(dof, self.dofs) and channel.is_rate == dof.feels_rate:
                (chain,) = chains(dof)
                row[first + (chain.speed if dof.feels_rate else chain.acceleration)] = channel.sign

    def _outputs(self) -> Mat:
        """Return the weighted rows (C, nz) of what is felt or sensed, for small tilts."""
        D = np.zeros((len(self.channels), self._first[-1] + self._organs.first[-1]))
        for c, channel in enumerate(self.channels):
            D[c, : self._first[-1]] = self._rows_felt[c] * (
                1.0 if channel.organ is None else self._organs.D[c]
            )
            of_organ = slice(*self._organs.first[c : c + 2])
            D[c, self._first[-1] :][of_organ] = self._organs.C[of_organ]
            D[c] *= np.sqrt(channel.weight)
        return D

    def _output_structure(self) -> Bools:
        """Return where the output rows may be non-zero (C, nz); the cosine of an outer tilt counts, too."""
        if self._body is not None:
            return self._body.output_structure(self.axes, self.channels)
        structure: Bools = self._outputs() != 0.0
        for c, channel in enumerate(self.channels):
            if channel.organ is None and (outer := self._outer(channel)) >= 0:
                structure[c, outer] = True
        return structure

    def _tilt(self, channel: Channel) -> int:
        """Return the state of x whose tilt gives a channel gravity, or −1."""
        return -1 if channel.tilt < 0 else int(self._first[channel.of]) + channel.tilt

    def _outer(self, channel: Channel) -> int:
        """Return the state of x whose cosine reduces that gravity, or −1; roll turns within pitch."""
        within = channel.tilt >= 0 and self.dofs[channel.of] == SWAY_ROLL and SURGE_PITCH in self.dofs
        return int(self._first[self.dofs.index(SURGE_PITCH)]) + TILT if within else -1

    def _penalty(self, circles: int) -> Mat:
        """Return the penalties (N, rows) of `soft`; behind the firm blocks all rows on states are soft.

        A plan of blocks, shifted by one step, is no longer a plan of blocks, and between the ends of blocks
        nothing limits the states. So rows that are hard over the whole horizon may contradict each other.
        """
        settings = self.settings
        names = [row.name for row in self._all_rows] + ["circle"] * circles
        of_states = [settings.soft.get(name, np.inf) for name in names]
        penalty = np.tile(of_states + [np.inf] * len(self.command_bound), (settings.horizon, 1))
        later = penalty[settings.hard_steps :, : len(names)]
        later[:] = np.minimum(later, settings.later_penalty)
        return penalty

    def bounds(self) -> tuple[Mat, Mat]:
        """Return the lower and upper bounds (N, rows); terminal rows hold at the last hard stage only.

        Bounds on states tighten slightly from stage to stage, so that the plan of one step, shifted,
        satisfies the rows of the next step with a margin. Then neither the solver's tolerance nor a new
        linearisation of the circle makes the next problem infeasible (constraint tightening; Chisci, Rossiter
        & Zappa, 2001).
        """
        N, rows = self.settings.horizon, self._all_rows
        radius = [] if self.circle is None else [self.circle.radius]
        below = [row.lower for row in rows] + [-np.inf] * len(radius)
        above = [row.upper for row in rows] + radius
        stage = np.arange(1.0, N + 1.0)[:, None]
        back_off = np.array([0.0 if row.name.startswith(REST) else BACK_OFF for row in rows])
        back_off = np.append(back_off, [CIRCLE_BACK_OFF] * len(radius))
        commands = np.tile(self.command_bound, (N, 1))
        lower, upper = below + stage * back_off, above - stage * back_off
        for start, only in (("terminal", self.settings.hard_steps - 1), (REST, N - 1)):
            named = [i for i, row in enumerate(rows) if row.name.startswith(start)]
            others = np.ix_(np.arange(N) != only, named)
            lower[others], upper[others] = -np.inf, np.inf
        of_body = np.full((N, 0 if self._body is None else BODY_ROWS), np.inf)  # written in every step
        return np.hstack([lower, -of_body, -commands]), np.hstack([upper, of_body, commands])

    def _kernel_data(self, lag: Vec) -> kernels.Given:
        """Return everything that the kernels read."""
        N, settings = self.settings.horizon, self.settings
        circle = self.circle or Circle(0.0, np.zeros(3), np.zeros((2, 3), dtype=np.int64))
        return kernels.Given(
            axes=self.axes,
            hold=np.array([held(float(one), settings.period) for one in lag]),
            felt=self._felt(),
            organs=self._organs,
            ends=self._ends,
            of=np.array(
                [first + states(dof).index(weight.of) for first, dof, weight in self._weights], dtype=np.int64
            ),
            washout=_washout(self._weights),
            control_weight=self._control_weight,
            circle=circle.weights,
            in_circle=circle.states,
            circled=self.circle is not None,
            X=np.empty((N, self._first[-1])),
            body=self._of_body[0].method if self._of_body else NO_METHOD,
            judge=self._of_body[1].method if self._of_body else NO_METHOD,
        )

    def _body_methods(self) -> tuple[Bound, ...]:
        """Return the kernels that linearise the whole body and judge that; none where there is no body."""
        if self._body is None:
            return ()
        circles = 0 if self.circle is None else 2 * int(np.count_nonzero(self.circle.weights))
        before = len(self._all_rows) + (self.circle is not None)
        price = self.structure.penalty[self._ends, before : before + BODY_ROWS]
        return self._body.methods(self.axes, self.channels, self._ends, price, before=(circles, before))

    def _felt(self) -> kernels.Felt:
        """Return the channels as the kernels read them; slopes are indexed among all non-zeros of D."""
        place = np.cumsum(self.structure.output.ravel()).reshape(self.structure.output.shape) - 1
        tilt, outer = ([of(channel) for channel in self.channels] for of in (self._tilt, self._outer))
        every = range(len(self.channels))
        return kernels.Felt(
            row=self._rows_felt,
            root=np.sqrt([channel.weight for channel in self.channels]),
            sensed=np.array([channel.organ is not None for channel in self.channels]),
            tilt=np.array(tilt, dtype=np.int64),
            outer=np.array(outer, dtype=np.int64),
            of_tilt=np.array([place[c, tilt[c]] for c in every], dtype=np.int64),
            of_outer=np.array([place[c, outer[c]] for c in every], dtype=np.int64),
            linear=self.settings.linear,
            column=np.array([channel.column for channel in self.channels]),
            sign=np.array([channel.sign for channel in self.channels]),
        )


def _washout(weights: Sequence[tuple[int, Dof, WashoutWeight]]) -> Mat:
    """Return the coefficients and scales (w, 5) of washout weights."""
    return np.array([(*weight.coefficients, weight.scale) for _, _, weight in weights]).reshape(-1, 5)


def _control_weight(platform: Platform, dofs: Sequence[Dof], settings: MpcSettings) -> Vec:
    """Return R (nu,); a base's commands have a weight of their own, which decides where both could move."""
    of_base = 1.0 if platform.base is None else platform.base.weight
    return settings.control_weight * np.array(
        [of_base if dof.is_base else 1.0 for dof in dofs for _ in dof.axes]
    )
