"""The record of a closed loop, sample by sample and decision by decision."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from importlib import import_module
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from otolith.core.arrays import Bools, Ints, Mat, Vec
from otolith.core.errors import InputError
from otolith.core.rotation import rate_along
from otolith.interfaces import Status
from otolith.platforms import Platform
from otolith.safety.supervisor import Intervention

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_NOTEBOOK: Final = "otolith.report.notebook"  # imported on use: reports read runs, not the other way round
PART: Final = 60_000  # plant samples of a part of a run, about 13 MB
SAMPLED: Final = (
    "time",
    "reference_force",
    "reference_rate",
    "felt_force",
    "pose",
    "twist",
    "acceleration",
    "base",
)  # series at the plant's rate
OF_BASE: Final = ("base", "base_command")  # of these, None where the platform stands on the ground
DECIDED: Final = (
    "command_time",
    "command",
    "base_command",
    "status",
    "solver",
    "changes",
    "residual",
    "guess_missed",
    "step_time",
)  # series at the controller's rate


def periods_of_part(period: float, plant_period: float) -> int:
    """Return the number of the controller's periods in a part of a run, at least one."""
    return max(1, PART // round(period / plant_period))


def steps_of_period(period: float, plant_period: float) -> int:
    """Return the number of plant steps in a period of the controller, both in [s].

    Raises
    ------
    InputError : that is no whole number.
    """
    steps = round(period / plant_period)
    if steps < 1 or abs(steps * plant_period - period) > 1e-9:
        raise InputError("period of the controller", f"{period} s", f"a multiple of {plant_period} s")
    return steps


def rows_of(run: "Run", name: str, first: int, last: int) -> Any:
    """Return rows of one of a run's series; None of a base that it does not have."""
    series = getattr(run, name)
    return None if series is None else series[first:last]


@dataclass(frozen=True, slots=True, kw_only=True)
class Run:
    """One closed-loop run; time runs along axis 0, with n plant samples and m control steps.

    A plant sample stands at the end of its plant step, t = dt, 2 dt, …; where a signal jumps there,
    the sample holds the value just before the jump. Control samples stand at the decision.

    A long run may be stored in a file and not in memory (`otolith.stored`): then every series is read when it
    is asked for. What has to be computed of any run goes through its `parts`, one after the other.
    """

    scenario: str
    cueing: str
    plant: str
    platform: Platform
    dofs: tuple[str, ...]  # names of what was cued, see otolith.core.frames.DOFS
    settings: Mapping[str, Any]  # what the user chose, for the record: plain JSON values
    soft: tuple[str, ...] = ()  # limits that the algorithm may pass at a price, e.g. "surge-pitch tilt_rate"
    period: float  # [s] of the controller
    plant_period: float  # [s]

    time: Vec  # (n,) [s]
    reference_force: Vec  # (n, 3) [m/s²] to be felt, driver's frame
    reference_rate: Vec  # (n, 3) [rad/s] to be felt, driver's frame; NaN where a file did not keep it
    felt_force: Vec  # (n, 3) [m/s²] felt, driver's frame
    pose: Vec  # (n, 6) [m ×3, rad ×3]; about the neutral pose on the base, if there is one
    twist: Vec  # (n, 6) [m/s ×3, rad/s ×3]
    acceleration: Vec  # (n, 6) [m/s² ×3, rad/s² ×3]

    command_time: Vec  # (m,) [s]
    command: Vec  # (m, 6) commanded accelerations
    status: tuple[str, ...]  # (m,) values of otolith.interfaces.Status
    solver: tuple[str, ...]  # (m,) status of the solver in each decision; "" without a solver
    changes: Ints  # (m,) working-set changes
    residual: Vec  # (m,) certificate of each solution
    guess_missed: Bools  # (m,)
    step_time: Vec  # (m,) [s] thread CPU time of each decision

    base: Mat | None = None  # (n, 18) pose, twist and acceleration of the base that carries the platform
    base_command: Mat | None = None  # (m, 6) accelerations commanded to it
    interventions: tuple[Intervention, ...] = ()  # of a plant's supervisor, in order of time

    @property
    def decisions(self) -> int:
        """Return the number of control steps, m."""
        return len(self.command_time)

    @property
    def samples(self) -> int:
        """Return the number of plant samples, n."""
        return len(self.time)

    @property
    def duration(self) -> float:
        """Return the time of the last plant sample [s]."""
        return float(self.part(self.decisions - 1, self.decisions).time[-1])

    def part(self, first: int, last: int) -> "Run":
        """Return the control steps from `first` up to `last`, and their plant samples, as a run of its own.

        The series are views of this run's, or are read from its file.
        """
        every = round(self.period / self.plant_period)
        samples = {name: rows_of(self, name, first * every, last * every) for name in SAMPLED}
        return replace(self, **samples, **{name: rows_of(self, name, first, last) for name in DECIDED})

    def parts(self) -> Iterator["Run"]:
        """Yield consecutive parts of about `PART` plant samples, which together are the whole run.

        A figure that is computed part by part needs little memory, however long the run is.
        """
        size, m = periods_of_part(self.period, self.plant_period), self.decisions
        if m <= size:
            yield self
            return
        for first in range(0, m, size):
            yield self.part(first, min(first + size, m))

    @property
    def outcomes(self) -> tuple[str, ...]:
        """Return the status (m,) of each decision, as text.

        A fallback names the solver's status, too: "fallback (infeasible)".
        """
        return tuple(
            f"{status} ({solver})" if status == Status.FALLBACK and solver else status
            for status, solver in zip(self.status, self.solver, strict=True)
        )

    @property
    def felt_rate(self) -> Vec:
        """Return the felt angular rate (n, 3) [rad/s] in the driver's frame, equal all over the platform."""
        pose, twist, base = self.pose, self.twist, self.base
        if base is not None:  # it turns about the vertical only, as the outermost angle of a pose does
            twist = twist.copy()
            twist[:, 5] += base[:, 11]
        rate = np.empty((len(pose), 3))
        rate_along(pose, twist, rate)
        return rate

    def _repr_html_(self) -> str:
        """Return the key figures as a small table for a notebook."""
        card: str = import_module(_NOTEBOOK).card([self])
        return card

    def plot(self, dof: str | None = None) -> "Figure":
        """Draw what was wanted and felt, and how the platform moved, for one degree of freedom.

        Parameters
        ----------
        dof : its name; None: the first that was cued.

        Raises
        ------
        InputError : this degree of freedom was not cued.
        """
        drawn: Figure = import_module(_NOTEBOOK).figure([self], dof)
        return drawn

    def at_decisions(self, series: Vec) -> Vec:
        """Return the rows of a plant-rate series at the control nodes: one row per period, at its end."""
        every = round(self.period / self.plant_period)
        return series[every - 1 :: every]
