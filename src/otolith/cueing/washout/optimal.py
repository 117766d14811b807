"""The optimal washout (thesis, section 2.2.2), linear and nonlinear, with the filters of `riccati`.

The LQ problem includes the gravity of the tilt, so its inputs are force and rate as the driver should feel
them. Force and rate pass through the same filter separately, because the tilt for the force must not be
noticed and is limited in rate, while the rotation for the rate is a cue. For small signals this is exactly
the filter.

The nonlinear variant (Telban & Cardullo, NASA CR-2005-213747) raises the degree of stability with the
excursion, α = c (s² + v²): small cues last, large ones wash out quickly. Its gains are computed once on a
grid of α and the exactly discretised filters are interpolated, instead of solving a Riccati equation in every
period.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.frames import Dof
from otolith.core.jit import kernel
from otolith.core.lti import StateSpace
from otolith.core.methods import Bound
from otolith.cueing.washout import tuning as tables
from otolith.cueing.washout.feedforward import PERIOD, Task, Washout
from otolith.cueing.washout.kernels import CHANNELS, FORCE, RATE, TILT, TILT_RATE, TURNING, VELOCITY
from otolith.cueing.washout.riccati import LqProblem, lq_problem
from otolith.perception import Vestibular

GRID = 33  # number of values of α


PAIR, TURN, HEAVE = range(3)  # kinds of degrees of freedom


class _Memory(NamedTuple):
    """F LQ filters that filter each of their m inputs separately; α is common, so that the results add up.

    Tables hold G values of α; a filter of fewer states or inputs than the largest fills them in part.
    """

    kind: Ints  # (F,)
    states: Ints  # (F,) n
    inputs: Ints  # (F,) m
    A: Mat  # (F, G, n, n)
    B: Mat  # (F, G, n, m)
    C: Mat  # (F, G, n + m, n)
    D: Mat  # (F, G, n + m, m)
    largest: float  # α of the last table
    per_excursion: float
    position: Ints  # (F,) index among the states; −1 where there is none
    velocity: Ints  # (F,)
    tilt: Ints  # (F,)
    felt: Ints  # (F,) axis of the force or rate that is cued, of three
    rotation: Ints  # (F,) of a pair, of three
    sign: Vec  # (F,) of a pair's tilt against that rotation
    x: Mat  # (F, n, m): column j is moved by input j alone
    ends: Mat  # (F, n + m, m)


@kernel
def _mix(table: Mat, i: int, share: float, row: int, column: int) -> float:
    """Return an entry of a table's matrix, linear between the points of the grid."""
    low: float = table[i, row, column]
    return low if share == 0.0 else low + share * (table[i + 1, row, column] - low)


@kernel
def _advance(of: Any, f: int, inputs: Vec) -> None:
    """Move filter f on by one period: its states, and at its end states and u_s of every input."""
    n, m, G = of.states[f], of.inputs[f], of.A.shape[1]
    x, after, ends = of.x[f], np.zeros_like(of.x[f]), of.ends[f]
    place = 0.0
    if G > 1:
        place = min(max(_excursion(of, f) * of.per_excursion / of.largest, 0.0), 1.0) * (G - 1)
    i = max(0, min(int(place), G - 2))
    share = place - i
    for j in range(m):
        for row in range(n):
            after[row, j] = _mix(of.B[f], i, share, row, j) * inputs[j]
            for k in range(n):
                after[row, j] += _mix(of.A[f], i, share, row, k) * x[k, j]
        for row in range(n):
            x[row, j] = after[row, j]
        for row in range(n + m):
            ends[row, j] = _mix(of.D[f], i, share, row, j) * inputs[j]
            for k in range(n):
                ends[row, j] += _mix(of.C[f], i, share, row, k) * x[k, j]


@kernel
def _excursion(of: Any, f: int) -> float:
    """Return s² + v² of all inputs together; 0 if nothing translates."""
    position, velocity = 0.0, 0.0
    for j in range(of.inputs[f]):
        if of.position[f] >= 0:
            position += of.x[f, of.position[f], j]
        if of.velocity[f] >= 0:
            velocity += of.x[f, of.velocity[f], j]
    return position * position + velocity * velocity


@kernel
def _filter(of: Any, fresh: int, demand: Vec, motion: Vec) -> int:
    """Filter one demand; see `otolith.cueing.washout.kernels.CHANNELS`."""
    if fresh == 1:
        of.x[:] = 0.0
    motion[:] = 0.0
    inputs = np.zeros(2)
    for f in range(len(of.kind)):
        kind, felt, turn, n, sign = of.kind[f], of.felt[f], of.rotation[f], of.states[f], of.sign[f]
        if kind == PAIR:
            inputs[0], inputs[1] = sign * demand[RATE + turn], demand[FORCE + felt]
        else:
            inputs[0] = demand[RATE + felt] if kind == TURN else demand[FORCE + felt]
        _advance(of, f, inputs)
        ends = of.ends[f]
        if kind == PAIR:
            motion[VELOCITY + felt] = ends[of.velocity[f], 0] + ends[of.velocity[f], 1]
            motion[TURNING + turn] = sign * ends[n, 0]
            motion[TILT + turn] = sign * ends[of.tilt[f], 1]
            motion[TILT_RATE + turn] = sign * ends[n, 1]
        elif kind == TURN:
            motion[TURNING + felt] = ends[n, 0]
        else:
            motion[VELOCITY + felt] = ends[of.velocity[f], 0]
    return 0


def optimal_channels(task: Task, period: float, *, nonlinear: bool) -> Bound:
    """Return one LQ filter per axis pair, and one each for heave and yaw."""
    tuning = task.tuning.of(tables.Optimal)
    largest = tuning.largest_alpha_per_s if nonlinear else 0.0
    alphas = np.linspace(0.0, largest, GRID if nonlinear else 1)
    problems = [_problem(dof, tuning) for dof in task.dofs]
    filters = [
        [problem.closed(problem.gain(alpha)).discretise(period) for alpha in alphas] for problem in problems
    ]
    sizes = np.array([one[0].sizes[:2] for one in filters])

    def row(name: str) -> Ints:
        return np.array([problem.rows.get(name, -1) for problem in problems])

    return CHANNELS.bind(
        _filter,
        _Memory(
            kind=np.array([PAIR if dof.is_pair else TURN if dof.feels_rate else HEAVE for dof in task.dofs]),
            states=sizes[:, 0].copy(),
            inputs=sizes[:, 1].copy(),
            A=_tables(filters, "A"),
            B=_tables(filters, "B"),
            C=_tables(filters, "C"),
            D=_tables(filters, "D"),
            largest=largest,
            per_excursion=tuning.alpha_per_s if nonlinear else 0.0,
            position=row("position"),
            velocity=row("velocity"),
            tilt=row("tilt"),
            felt=np.array([dof.felt for dof in task.dofs]),
            rotation=np.array([dof.rotation - 3 if dof.is_pair else 0 for dof in task.dofs]),
            sign=np.array([dof.sign for dof in task.dofs]),
            x=np.zeros((len(filters), *sizes.max(axis=0))),
            ends=np.zeros((len(filters), sizes.sum(axis=1).max(), sizes[:, 1].max())),
        ),
    )


def _tables(filters: Sequence[Sequence[StateSpace]], name: str) -> Mat:
    """Return the matrices of one name of all filters and α, in one array that holds the largest of them."""
    shapes = [getattr(one[0], name).shape for one in filters]
    table = np.zeros((len(filters), len(filters[0]), *np.max(shapes, axis=0)))
    for f, of_alphas in enumerate(filters):
        for g, system in enumerate(of_alphas):
            matrix = getattr(system, name)
            table[f, g, : matrix.shape[0], : matrix.shape[1]] = matrix
    return table


def _problem(dof: Dof, tuning: tables.Optimal) -> LqProblem:
    """Return the LQ problem of a degree of freedom; a pair rotates and translates."""
    rotates, translates = dof.is_pair or dof.feels_rate, not dof.feels_rate
    return lq_problem(tuning, Vestibular(), rotates=rotates, translates=translates)


def optimal(task: Task) -> Washout:
    """Make the linear optimal washout."""
    return Washout(task, optimal_channels(task, PERIOD, nonlinear=False))


def optimal_nonlinear(task: Task) -> Washout:
    """Make the nonlinear optimal washout."""
    return Washout(task, optimal_channels(task, PERIOD, nonlinear=True))
