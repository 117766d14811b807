"""The optimal washout (thesis, section 2.2.2), linear and nonlinear: `riccati`'s filters at work.

The LQ problem contains the tilt's gravity itself, so force and rate go in as the driver should feel
them. Force and rate run through the same filter apart, since the tilt that force asks for must not be
noticed and is limited in rate, while the rotation that rate asks for is a cue. Small signals are the
filter exactly.

The nonlinear variant (Telban & Cardullo, NASA CR-2005-213747) raises the degree of stability with the
excursion, α = c (s² + v²): small cues last, large ones wash out quickly. Its gains are solved for on a
grid of α once, and the exactly discretised filters interpolated, instead of solving a Riccati equation
in every period.
"""

from collections.abc import Sequence

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.frames import Dof
from otolith.cueing.washout import tuning as tables
from otolith.cueing.washout.feedforward import PERIOD, Demand, Motion, Task, Washout
from otolith.cueing.washout.riccati import LqProblem, lq_problem
from otolith.perception import Vestibular

GRID = 33  # values of α


class Scheduled:
    """One LQ filter at work, each input through a copy of its own; α is shared, so that copies add up."""

    def __init__(self, problem: LqProblem, alphas: Vec, period: float) -> None:
        self.problem, self._alphas = problem, alphas
        held = [problem.closed(problem.gain(alpha)).discretise(period) for alpha in alphas]
        self._A, self._B, self._C, self._D = (np.array([getattr(s, name) for s in held]) for name in "ABCD")
        self.reset()

    def reset(self) -> None:
        """Start from rest."""
        self._x = np.zeros(self._B.shape[1:])  # (n, m): column j is moved by input j alone

    def excursion(self) -> float:
        """s² + v² of all inputs together; 0 where nothing translates."""
        rows = self.problem.rows
        moved = [float(np.sum(self._x[rows[name]])) for name in ("position", "velocity") if name in rows]
        return sum(value**2 for value in moved)

    def step(self, inputs: Vec, alpha: float) -> Mat:
        """States and u_s (n + m, m) at the period's end, column j due to input j."""
        A, B, C, D = (self._at(alpha, table) for table in (self._A, self._B, self._C, self._D))
        self._x = A @ self._x + B * inputs
        ends: Mat = C @ self._x + D * inputs
        return ends

    def _at(self, alpha: float, table: Mat) -> Mat:
        """A table's matrix at α, linear between the grid's."""
        if len(self._alphas) == 1:
            return np.asarray(table[0])
        place = min(max(alpha / self._alphas[-1], 0.0), 1.0) * (len(self._alphas) - 1)
        i = min(int(place), len(self._alphas) - 2)
        return np.asarray(table[i] + (place - i) * (table[i + 1] - table[i]))


class OptimalChannels:
    """One LQ filter per axis pair, and one each for heave and yaw."""

    def __init__(self, task: Task, period: float, *, nonlinear: bool) -> None:
        tuning = task.tuning.of(tables.Optimal)
        largest = tuning.largest_alpha_per_s if nonlinear else 0.0
        alphas = np.linspace(0.0, largest, GRID if nonlinear else 1)
        self._per_excursion = tuning.alpha_per_s if nonlinear else 0.0
        self._dofs = task.dofs
        self.filters = [Scheduled(_problem(dof, tuning), alphas, period) for dof in self._dofs]

    def reset(self) -> None:
        """Forget the past."""
        for one in self.filters:
            one.reset()

    def step(self, demand: Demand) -> Motion:
        """Filter one demand."""
        motion = Motion()
        for dof, one in zip(self._dofs, self.filters, strict=True):
            if dof.is_pair:
                self._cue_pair(dof, one, demand, motion)
            elif dof.feels_rate:
                motion.turning[dof.felt] = self._run(one, [demand.rate_world[dof.felt]])[-1, 0]
            else:
                ends = self._run(one, [demand.force_driver[dof.felt]])
                motion.velocity[dof.felt] = ends[one.problem.rows["velocity"], 0]
        return motion

    def _cue_pair(self, pair: Dof, one: Scheduled, demand: Demand, motion: Motion) -> None:
        force, turn = demand.force_driver[pair.felt], pair.rotation - 3
        ends = self._run(one, [pair.sign * demand.rate_world[turn], force])
        rows, n = one.problem.rows, len(ends) - 2
        motion.velocity[pair.translation] = np.sum(ends[rows["velocity"]])
        motion.turning[turn] = pair.sign * ends[n, 0]
        motion.tilt[turn] = pair.sign * ends[rows["tilt"], 1]
        motion.tilt_rate[turn] = pair.sign * ends[n, 1]

    def _run(self, one: Scheduled, inputs: Sequence[float]) -> Mat:
        return one.step(np.array(inputs), self._per_excursion * one.excursion())


def _problem(dof: Dof, tuning: tables.Optimal) -> LqProblem:
    """The LQ problem of a degree of freedom; a pair rotates and translates."""
    rotates, translates = dof.is_pair or dof.feels_rate, not dof.feels_rate
    return lq_problem(tuning, Vestibular(), rotates=rotates, translates=translates)


def optimal(task: Task) -> Washout:
    """The linear optimal washout."""
    return Washout(task, OptimalChannels(task, PERIOD, nonlinear=False))


def optimal_nonlinear(task: Task) -> Washout:
    """The nonlinear optimal washout."""
    return Washout(task, OptimalChannels(task, PERIOD, nonlinear=True))
