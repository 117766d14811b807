"""The explicit law of the same constraints on a coarse grid, whose active rows are a hint for the fine one.

The coarse problem is that of the implicit MPC for one axis pair, with inputs held over ten blocks of the
horizon (or over the blocks that the MPC uses), and rows at the ends of the blocks: same dynamics, same limits
and braking rows, same washout. Two changes make it explicit: the output is linearised at zero tilt, where cos
θ = 1, and the adaptive washout weights take the nearest of a few levels. The parameter is ϑ = (x, r), seven
per pair. The law contains the regions that training visited; elsewhere its QP is solved, which is small.

A row of the coarse grid represents the same row of the fine grid at the nearest times, and an input
represents the inputs of its block. Rows that belong to several pairs together (the limit circle) stay free.
"""

import copy
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from otolith.core.arrays import Ints, Mat, Vec, frozen_array
from otolith.core.frames import Dof
from otolith.cueing.mpc.explicit_problem import UNLIMITED
from otolith.cueing.mpc.problem import Problem
from otolith.cueing.mpc.settings import MpcSettings
from otolith.cueing.mpc.washout_weights import WashoutWeight
from otolith.mpqp import ParametricQp, PartialLaw
from otolith.mpqp.leastdistance import least_distance
from otolith.mpqp.prune import prune
from otolith.platforms import Platform
from otolith.qp.blocked import Lengths, block_ends
from otolith.qp.condensed import CondensedSolver
from otolith.qp.engines import CondensedEngine, expand
from otolith.qp.problem import Qp

COARSE: Final = 10  # number of blocks of the coarse grid
REFERENCE_BOUND: Final = 100.0  # [m/s²] largest force that the law covers


@dataclass(frozen=True, slots=True)
class CoarseLaws:
    """The regions of the laws that training visited, one law per pair and level of the washout weights."""

    levels: Mat  # (L, washout weights)
    parameters: tuple[Mat, ...]  # (regions, 7) each, by pair and within a pair by level

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return plain arrays."""
        lengths = np.array([len(part) for part in self.parameters])
        return {
            "law.levels": self.levels,
            "law.lengths": lengths,
            "law.parameters": np.vstack([*self.parameters, np.empty((0, 7))]),
        }

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> "CoarseLaws":
        """Restore from plain arrays.

        Raises
        ------
        ValueError : the arrays do not belong together.
        KeyError : an array is missing.
        """
        lengths, parameters = arrays["law.lengths"], arrays["law.parameters"]
        if lengths.sum() != len(parameters):
            raise ValueError("the coarse laws' lengths do not fit")
        parts = np.split(parameters, np.cumsum(lengths)[:-1])
        return cls(frozen_array(arrays["law.levels"]), tuple(frozen_array(part) for part in parts))


def coarse_lengths(settings: MpcSettings) -> Lengths:
    """Return the number of steps of each block of the coarse grid."""
    if settings.blocks:
        return settings.blocks
    ends = np.round(np.linspace(0.0, settings.horizon, min(COARSE, settings.horizon) + 1))
    return tuple(int(steps) for steps in np.diff(ends))


@dataclass(frozen=True, slots=True)
class CoarseProblem:
    """An mpQP, with the row of the coarse grid and the side of each of its constraints."""

    problem: ParametricQp
    row: Ints  # (m,) index in blocks x rows
    side: Ints  # (m,) +1 or -1

    def only(self, constraints: Ints) -> "CoarseProblem":
        """Keep only the constraints with these indices."""
        whole, kept = self.problem, constraints
        problem = replace(whole, G=whole.G[kept], w=whole.w[kept], S=whole.S[kept])
        return CoarseProblem(problem, self.row[kept], self.side[kept])


def coarse_problem(platform: Platform, pair: Dof, settings: MpcSettings, weights: Vec) -> CoarseProblem:
    """Return the coarse problem of one pair with constant washout weights (w,)."""
    lengths = coarse_lengths(settings)
    formulation = Problem(platform, (pair,), replace(settings, blocks=lengths, firm=len(lengths)))
    qps = _affine_samples(formulation, lengths, weights)
    base, units = qps[0], qps[1:]
    b, n = base.bounds, len(base.g)
    of_z, row, side = np.vstack([np.eye(b, n), base.A]), _rows_by_columns(formulation, lengths), []
    G, w, S, rows = [], [], [], []
    for sign, name in ((1, "upper"), (-1, "lower")):
        bound = getattr(base, name)
        used = np.flatnonzero(np.isfinite(bound))
        G.append(sign * of_z[used])
        w.append(sign * bound[used])
        S.append(sign * np.column_stack([getattr(unit, name)[used] - bound[used] for unit in units]))
        rows.append(row[used])
        side.append(np.full(len(used), sign))
    low, high = _box(platform, pair)
    problem = ParametricQp(
        H=base.H,
        f=base.g,
        F=np.column_stack([unit.g - base.g for unit in units]),
        G=np.vstack(G),
        w=np.concatenate(w),
        S=np.vstack(S),
        lower=low,
        upper=high,
    )
    return CoarseProblem(problem, np.concatenate(rows), np.concatenate(side))


def _problems_of_levels(
    platform: Platform, pair: Dof, settings: MpcSettings, levels: Mat
) -> list[CoarseProblem]:
    """Return the problem of each level, without redundant constraints, which do not depend on weights."""
    made = [coarse_problem(platform, pair, settings, weights) for weights in levels]
    binding = np.sort(prune(least_distance(made[0].problem)).form.rows)
    return [one.only(binding) for one in made]


def _affine_samples(formulation: Problem, lengths: Lengths, weights: Vec) -> list[Qp]:
    """Return the condensed QP at ϑ = 0 and at the seven unit vectors, which determine an affine problem."""
    engine = CondensedEngine(formulation.structure, tolerance=1e-6, blocks=lengths)
    solver, memory, N = CondensedSolver(formulation.structure, blocks=lengths), engine.memory, sum(lengths)
    formulation.begin(memory)
    formulation.write(memory, np.zeros(6), np.zeros((N, 2)), np.zeros((N, 1)), None)
    memory.state_weight[:] = weights
    made = []
    for theta in np.vstack([np.zeros(7), np.eye(7)]):
        memory.start[:], memory.error[:] = theta[:6], -theta[6]
        qp = solver.condense(expand(formulation.structure, memory, lengths))
        made.append(replace(qp, A=qp.A.copy()))  # the solver rewrites its own array at every call
    return made


def _rows_by_columns(formulation: Problem, lengths: Lengths) -> Ints:
    """Return the index in (blocks, rows) of every row of the condensed problem, inputs first."""
    problem = formulation.structure
    numbers = np.arange(len(lengths) * problem.rows).reshape(len(lengths), problem.rows)
    inner = problem.rows - problem.inputs
    return np.concatenate([numbers[:, inner:].ravel(), numbers[:, :inner].ravel()])


def _box(platform: Platform, pair: Dof) -> tuple[Vec, Vec]:
    travel, tilt = platform.limits(pair)
    rates = (tilt.velocity, travel.velocity, travel.acceleration, tilt.acceleration)
    rate, speed, acceleration, turning = (min(value, UNLIMITED) for value in rates)
    high = [rate, tilt.position[1], speed, travel.position[1], acceleration, turning, REFERENCE_BOUND]
    low = [-rate, tilt.position[0], -speed, travel.position[0], -acceleration, -turning, -REFERENCE_BOUND]
    return np.array(low), np.array(high)


class Coarse:
    """Evaluates the laws and returns their active rows at the nearest times of the fine grid."""

    def __init__(
        self,
        laws: CoarseLaws,
        platform: Platform,
        pairs: Sequence[Dof],
        settings: MpcSettings,
    ) -> None:
        fine = Problem(platform, pairs, settings)
        self._washout: tuple[WashoutWeight, ...] = settings.washout
        self._levels = np.log(np.maximum(laws.levels, 1e-9))
        self._of_pair = len(laws.levels)
        self._problems = [
            made for pair in pairs for made in _problems_of_levels(platform, pair, settings, laws.levels)
        ]
        self._learned = [PartialLaw(made.problem, pruned=True) for made in self._problems]
        for law, parameters in zip(self._learned, laws.parameters, strict=True):
            law.learn(parameters)
        self._laws = copy.deepcopy(self._learned)
        self._carry = _Carry(fine, [Problem(platform, (pair,), settings) for pair in pairs], settings)
        self._region = [-1] * len(self._laws)

    @property
    def regions(self) -> int:
        """Return the number of regions of all laws."""
        return sum(len(law) for law in self._laws)

    def reset(self) -> None:
        """Restore the laws, which grow with every new region, so that equal runs are equal."""
        for number, asked in enumerate(self._region):
            if asked >= 0:
                self._laws[number] = copy.deepcopy(self._learned[number])
        self._region = [-1] * len(self._laws)

    def sets(self, x: Vec, wanted: Vec, plan: Mat) -> Ints | None:
        """Return a hint (1, M, rows), or None if one of the laws has no answer."""
        del plan
        found = np.zeros((1, *self._carry.shape), dtype=np.int64)
        for p, r in enumerate(wanted):
            rows = self.coarse_set(p, x[6 * p : 6 * p + 6], float(r))
            if rows is None:
                return None
            self._carry.add(p, rows, found[0])
        return found

    def visit(self, x: Mat, wanted: Mat) -> tuple[Mat, ...]:
        """Return, for every law, the parameters (regions, 7) that enter a region first.

        Parameters
        ----------
        x : (n, 6P) states.
        wanted : (n, P) wanted forces.
        """
        met: list[list[Vec]] = [[] for _ in self._laws]
        for state, forces in zip(x, wanted, strict=True):
            for p, r in enumerate(forces):
                of_pair = state[6 * p : 6 * p + 6]
                number = p * self._of_pair + self._level(of_pair)
                known = len(self._laws[number])
                self.coarse_set(p, of_pair, float(r))
                if len(self._laws[number]) > known:
                    met[number].append(np.append(of_pair, r))
        return tuple(np.reshape(points, (-1, 7)) for points in met)

    def coarse_set(self, p: int, x: Vec, r: float) -> Ints | None:
        """Return the rows (blocks, rows) of the coarse grid that the law of pair p holds active."""
        number = p * self._of_pair + self._level(x)
        answer = self._laws[number].evaluate(np.append(x, r), self._region[number])
        if not answer.found:
            return None
        self._region[number] = answer.region
        made = self._problems[number]
        rows = np.zeros(self._carry.coarse_shape[p], dtype=np.int64)
        rows.flat[made.row[answer.active]] = made.side[answer.active]
        return rows

    def _level(self, x: Vec) -> int:
        weights = np.log(np.maximum([weight.at(x) for weight in self._washout], 1e-9))
        return int(np.argmin(np.sum((self._levels - weights) ** 2, axis=1)))


class _Carry:
    """Maps the rows of the pairs' coarse problems to the fine joint problem."""

    def __init__(self, fine: Problem, pairs: Sequence[Problem], settings: MpcSettings) -> None:
        lengths, problem = coarse_lengths(settings), fine.structure
        ends = block_ends(fine.settings.lengths)
        self.shape = (len(fine.settings.lengths), problem.rows)
        self.coarse_shape = [(len(lengths), one.structure.rows) for one in pairs]
        self._nearest = np.argmin(np.abs(ends[:, None] - block_ends(lengths)), axis=1)
        self._held = np.searchsorted(block_ends(lengths), ends)
        self._from: list[Ints] = []
        self._to: list[Ints] = []
        for p, one in enumerate(pairs):
            embedded = np.zeros((len(one.structure.C), problem.states))
            embedded[:, 6 * p : 6 * p + 6] = one.structure.C
            same = (embedded[:, None] == problem.C).all(axis=2)  # (rows of the pair, rows of all)
            self._from.append(np.flatnonzero(same.any(axis=1)))
            self._to.append(np.argmax(same[self._from[-1]], axis=1))

    def add(self, p: int, coarse: Ints, fine: Ints) -> None:
        """Write the rows (blocks, rows) of pair p into the set (M, rows) of all pairs."""
        fine[:, self._to[p]] = coarse[self._nearest][:, self._from[p]]
        inputs = self.shape[1] - 2 * len(self._to) + 2 * p
        fine[:, inputs : inputs + 2] = coarse[self._held][:, -2:]
