"""The nonlinear problem of `six-axis`, solved to the end by IPOPT: the reference for its single steps.

Nothing of the linearisation is shared: forces, legs and rates are written once more, as symbols, and
differentiated by casadi (Andersson et al., 2019); IPOPT (Wächter & Biegler, 2006) has the exact Hessian. Soft
rows have slack variables. A decision takes a tenth of a second and more, so this is for comparisons only. It
belongs to the extra `check`.
"""

from typing import Any, Final

import casadi as ca
import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.frames import GRAVITY
from otolith.core.lti import condense as predict
from otolith.cueing.mpc.body import FIRM, Body
from otolith.cueing.mpc.problem import Problem
from otolith.qp.blocked import Lengths, block_ends, hold
from otolith.qp.engines import StageMemory, empty_memory
from otolith.qp.problem import Status
from otolith.qp.stage import OnRequest, StageProblem, StageSolution

_OPTIONS: Final[dict[str, Any]] = {
    "ipopt.print_level": 0,
    "ipopt.sb": "yes",
    "print_time": False,
    "ipopt.tol": 1e-9,
    "ipopt.nlp_scaling_method": "none",  # scaling by the penalties would loosen the tolerance
    "ipopt.bound_relax_factor": 0.0,  # else slacks below zero earn their penalties
    "ipopt.max_iter": 200,
}


class IpoptEngine:
    """An engine that takes from the memory where the platform is, and solves the nonlinear problem.

    Parameters are those of `otolith.qp.engines.CondensedEngine`. Before the first problem, `attach` tells
    which problem this is.
    """

    def __init__(self, problem: StageProblem, *, tolerance: float, blocks: Lengths = ()) -> None:
        self._problem, self._tolerance = problem, tolerance
        self._lengths = blocks or (1,) * problem.horizon
        self.memory: StageMemory = empty_memory(problem, blocks)
        self._solver: Any = None
        self.cost, self.iterations = np.nan, 0  # of the last answer
        self._z: Vec | None = None

    def attach(self, problem: Problem, body: Body, wanted: Mat) -> None:
        """Build the solver of a problem; `wanted` (N, C) is read in every run."""
        self._wanted = wanted
        nlp = _Nlp(problem, body, self._lengths)
        symbols = nlp.symbols()
        self._solver = ca.nlpsol("six_axis", "ipopt", symbols, _OPTIONS)
        self._value = ca.Function("value", [symbols["x"], symbols["p"]], [symbols["f"], symbols["g"]])
        self._nlp = nlp

    def reset(self) -> None:
        """Forget the last answer."""
        self._z = None

    def run(self, start: Ints | None = None, hint: OnRequest | None = None) -> StageSolution:
        """Solve, starting from the last answer; a working set or a hint is of no use to it."""
        del start, hint
        M, problem = len(self._lengths), self._problem
        y = np.zeros((M, problem.rows))
        if self._solver is None:  # only while the controller is being built
            return self._answer(Status.OPTIMAL, np.zeros(M * problem.inputs), y, 0.0)
        if not (np.isfinite(self.memory.start).all() and np.isfinite(self._wanted).all()):
            return self._answer(Status.INVALID, np.zeros(M * problem.inputs), y, np.inf)
        bounds = self._nlp.bounds()
        guess = np.zeros(len(bounds["lbx"])) if self._z is None else self._z
        parameters = np.concatenate([self.memory.start, self._wanted.ravel()])
        found = self._solver(x0=guess, p=parameters, **bounds)
        stats = self._solver.stats()
        z, self.cost, self.iterations = np.array(found["x"]).ravel(), float(found["f"]), stats["iter_count"]
        if not stats["success"]:
            self._z = None
            return self._answer(Status.LIMIT, z[: M * problem.inputs], y, np.inf)
        self._z = z
        final = max(stats["iterations"][name][-1] for name in ("inf_pr", "inf_du"))
        return self._answer(Status.OPTIMAL, z[: M * problem.inputs], y, min(final, self._tolerance))

    def judge(self, U: Mat) -> tuple[float, float]:
        """Return the cost of inputs (M, nu) for the problem in memory, and their excess over firm rows.

        The cost includes what the rows of later blocks cost, but not the firm ones.
        """
        bounds = self._nlp.bounds()
        z = np.zeros(len(bounds["lbx"]))
        z[: U.size] = U.ravel()
        parameters = np.concatenate([self.memory.start, self._wanted.ravel()])
        cost, rows = (np.array(part).ravel() for part in self._value(z, parameters))
        excess = np.maximum(np.maximum(bounds["lbg"] - rows, rows - bounds["ubg"]), 0.0)
        price = self._nlp.prices()
        firm = price >= FIRM
        return float(cost[0] + price[~firm] @ excess[~firm]), float(excess[firm].max(initial=0.0))

    def _answer(self, status: Status, z: Vec, y: Mat, residual: float) -> StageSolution:
        U, X = z.reshape(len(self._lengths), -1), np.zeros((len(self._lengths), self._problem.states))
        return StageSolution(status, U, X, y, 0, 0, 0, residual)


class _Nlp:
    """The problem as symbols: inputs of all blocks, then slacks of soft rows; parameters x₀ and wanted."""

    def __init__(self, problem: Problem, body: Body, lengths: Lengths) -> None:
        self._of, self._body, self._lengths = problem, body, lengths
        structure = problem.structure
        self._n = len(lengths) * structure.inputs
        Phi, Gamma = predict(structure.A, structure.B, structure.horizon)
        self._Phi, self._Gamma = Phi, Gamma @ hold(lengths, structure.inputs)
        self._low: list[float] = []
        self._high: list[float] = []
        self._penalties: list[float] = []

    def symbols(self) -> dict[str, Any]:
        """Return variables, parameters, cost and rows for casadi."""
        structure, C = self._of.structure, len(self._of.channels)
        U, x0 = ca.SX.sym("U", self._n), ca.SX.sym("x", structure.states)
        wanted = ca.SX.sym("r", structure.horizon * C)
        ends, rows, cost = set(block_ends(self._lengths).tolist()), [], ca.SX(0)
        for k in range(structure.horizon):
            x = ca.mtimes(ca.DM(self._Phi[k]), x0) + ca.mtimes(ca.DM(self._Gamma[k]), U)
            cost += self._cost(x, wanted[k * C : (k + 1) * C])
            if k in ends:
                rows += self._rows(x, k)
        R = np.outer(self._lengths, structure.control_weight).ravel()
        cost += 0.5 * ca.dot(ca.DM(R) * U, U)
        slack = ca.SX.sym("s", sum(1 for w in self._penalties if np.isfinite(w)))
        for i, j in enumerate([i for i, w in enumerate(self._penalties) if np.isfinite(w)]):
            cost += self._penalties[j] * slack[i]
            rows.append(rows[j] - slack[i])
            rows[j] = rows[j] + slack[i]
            self._low.append(-np.inf)
            self._high.append(self._high[j])
            self._high[j] = np.inf
        self._slacks = slack.numel()
        return {"x": ca.vertcat(U, slack), "p": ca.vertcat(x0, wanted), "f": cost, "g": ca.vertcat(*rows)}

    def prices(self) -> Vec:
        """Return the penalties of all rows for casadi, infinite for hard ones."""
        soft = [w for w in self._penalties if np.isfinite(w)]
        return np.array(self._penalties + soft)

    def bounds(self) -> dict[str, Vec]:
        """Return bounds on variables and rows, for casadi."""
        commands = np.tile(self._of.command_bound, len(self._lengths))
        slacks = np.zeros(self._slacks)
        return {
            "lbx": np.concatenate([-commands, slacks]),
            "ubx": np.concatenate([commands, slacks + np.inf]),
            "lbg": np.array(self._low),
            "ubg": np.array(self._high),
        }

    def _motion(self, x: Any) -> tuple[Any, Any, Any]:
        """Return pose, twist and acceleration (6,) of the platform."""
        axes, motion = self._of.axes, [ca.SX.zeros(6) for _ in range(3)]
        for part, states in zip(motion, (axes.place, axes.speed, axes.acceleration), strict=True):
            for axis, sign, i in zip(axes.axis.tolist(), axes.sign.tolist(), states.tolist(), strict=True):
                part[axis] = sign * x[i]
        return motion[0], motion[1], motion[2]

    def _cost(self, x: Any, wanted: Any) -> Any:
        """Return the cost of one step, without that of the controls."""
        pose, twist, acceleration = self._motion(x)
        feels = ca.vertcat(self._force(pose, twist, acceleration), _body_rates(pose, twist))
        cost = 0.0
        for c, channel in enumerate(self._of.channels):
            cost += 0.5 * channel.weight * (feels[channel.column] - wanted[c]) ** 2
        for i, weights in zip(self._of.structure.weighted, self._of.given.washout, strict=True):
            cost += 0.5 * float(weights[0]) * x[i] ** 2
        return cost

    def _rows(self, x: Any, k: int) -> list[Any]:
        """Return the rows at the end of a block that have a bound, and note their bounds and penalties."""
        structure, of = self._of.structure, self._of
        pose, twist, acceleration = self._motion(x)
        lower, upper = (side[k] for side in of.bounds())
        rows = [ca.dot(ca.DM(row), x) for row in structure.C]
        if of.circle is not None:
            reach = [ca.dot(ca.DM(of.circle.weights), x[states.tolist()]) for states in of.circle.states]
            rows.append(ca.sqrt(reach[0] ** 2 + reach[1] ** 2 + 1e-12))
        low, high = self._body.bounds(of.axes)
        lower = np.concatenate([lower[: len(rows)], low])
        upper = np.concatenate([upper[: len(rows)], high])
        rows += ca.vertsplit(self._legs(pose, twist, acceleration)) + ca.vertsplit(_body_rates(pose, twist))
        kept = [i for i in range(len(rows)) if np.isfinite(lower[i]) or np.isfinite(upper[i])]
        self._low += [float(lower[i]) for i in kept]
        self._high += [float(upper[i]) for i in kept]
        self._penalties += [float(structure.penalty[k, i]) for i in kept]
        return [rows[i] for i in kept]

    def _legs(self, pose: Any, twist: Any, acceleration: Any) -> Any:
        """Return where lengths lead, speeds and accelerations (18,) of the legs."""
        q, v, a = ca.SX.sym("q", 6), ca.SX.sym("v", 6), ca.SX.sym("a", 6)
        legs = self._body.platform.six_legs()
        R, ends = _rotation(q), []
        for joint, anchor in zip(legs.joints, legs.anchors, strict=True):
            ends.append(ca.norm_2(q[:3] + ca.mtimes(R, ca.DM(joint)) - ca.DM(anchor)))
        length = ca.vertcat(*ends)
        speed = ca.jtimes(length, q, v)
        growth = ca.jtimes(speed, q, v) + ca.jtimes(length, q, a)
        T, lead = self._body.lag, self._body.lead
        ahead = speed + T * growth
        of = ca.Function("legs", [q, v, a], [ca.vertcat(length + T * speed + lead * ahead, ahead, growth)])
        return of(pose, twist, acceleration)

    def _force(self, pose: Any, twist: Any, acceleration: Any) -> Any:
        """Return the specific force (3,) at the driver's head."""
        q, v, a = ca.SX.sym("q", 6), ca.SX.sym("v", 6), ca.SX.sym("a", 6)
        up = ca.DM([0.0, 0.0, GRAVITY])
        place = q[:3] + ca.mtimes(_rotation(q), ca.DM(list(self._body.platform.head or (0.0, 0.0, 0.0))))
        moving = ca.jtimes(ca.jtimes(place, q, v), q, v) + ca.jtimes(place, q, a)
        felt = ca.mtimes(_rotation(q).T, moving + up) - up
        return ca.Function("force", [q, v, a], [felt])(pose, twist, acceleration)


def _rotation(q: Any) -> Any:
    """Return R = Rz Ry Rx of a pose."""
    turns = []
    for axis in range(3):
        c, s = ca.cos(q[3 + axis]), ca.sin(q[3 + axis])
        turn = ca.SX.eye(3)
        i, j = (axis + 1) % 3, (axis + 2) % 3
        turn[i, i], turn[i, j], turn[j, i], turn[j, j] = c, -s, s, c
        turns.append(turn)
    return ca.mtimes([turns[2], turns[1], turns[0]])


def _body_rates(pose: Any, twist: Any) -> Any:
    """Return the rates (3,) about the platform's axes: Rᵀ Ṙ is their cross-product matrix."""
    q, v = ca.SX.sym("q", 6), ca.SX.sym("v", 6)
    R = _rotation(q)
    turning = ca.mtimes(R.T, ca.reshape(ca.jtimes(ca.reshape(R, 9, 1), q, v), 3, 3))
    return ca.Function("rates", [q, v], [ca.vertcat(turning[2, 1], turning[0, 2], turning[1, 0])])(
        pose, twist
    )
