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

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.frames import Dof
from otolith.cueing.washout import tuning as tables
from otolith.cueing.washout.feedforward import PERIOD, Demand, Motion, Task, Washout
from otolith.cueing.washout.riccati import LqProblem, lq_problem
from otolith.perception import Vestibular

GRID = 33  # number of values of α


class Scheduled:
    """One LQ filter that filters each input separately; α is common, so that the results add up."""

    def __init__(self, problem: LqProblem, alphas: Vec, period: float) -> None:
        self.problem, self._alphas = problem, alphas
        held = [problem.closed(problem.gain(alpha)).discretise(period) for alpha in alphas]
        self._A, self._B, self._C, self._D = (np.array([getattr(s, name) for s in held]) for name in "ABCD")
        self.reset()

    def reset(self) -> None:
        """Start from rest."""
        self._x = np.zeros(self._B.shape[1:])  # (n, m): column j is moved by input j alone

    def excursion(self) -> float:
        """Return s² + v² of all inputs together; 0 if nothing translates."""
        rows = self.problem.rows
        moved = [float(np.sum(self._x[rows[name]])) for name in ("position", "velocity") if name in rows]
        return sum(value**2 for value in moved)

    def step(self, inputs: Vec, alpha: float) -> Mat:
        """Return states and u_s (n + m, m) at the end of the period; column j is due to input j."""
        A, B, C, D = (self._at(alpha, table) for table in (self._A, self._B, self._C, self._D))
        self._x = A @ self._x + B * inputs
        ends: Mat = C @ self._x + D * inputs
        return ends

    def _at(self, alpha: float, table: Mat) -> Mat:
        """Return a table's matrix at α, linear between the points of the grid."""
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
        """Discard the past."""
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
    """Return the LQ problem of a degree of freedom; a pair rotates and translates."""
    rotates, translates = dof.is_pair or dof.feels_rate, not dof.feels_rate
    return lq_problem(tuning, Vestibular(), rotates=rotates, translates=translates)


def optimal(task: Task) -> Washout:
    """Make the linear optimal washout."""
    return Washout(task, OptimalChannels(task, PERIOD, nonlinear=False))


def optimal_nonlinear(task: Task) -> Washout:
    """Make the nonlinear optimal washout."""
    return Washout(task, OptimalChannels(task, PERIOD, nonlinear=True))
