"""The record of a closed loop, sample by sample and decision by decision."""

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from otolith.core.arrays import Bools, Ints, Vec
from otolith.core.rotation import rate_along
from otolith.interfaces import Status
from otolith.platforms import Platform
from otolith.safety.supervisor import Intervention

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_NOTEBOOK: Final = "otolith.report.notebook"  # imported on use: reports read runs, not the other way round


@dataclass(frozen=True, slots=True, kw_only=True)
class Run:
    """One closed-loop run; time runs along axis 0, with n plant samples and m control steps.

    A plant sample stands at the end of its plant step, t = dt, 2 dt, …; where a signal jumps there,
    the sample holds the value just before the jump. Control samples stand at the decision.
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
    pose: Vec  # (n, 6) [m ×3, rad ×3]
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

    interventions: tuple[Intervention, ...] = ()  # of a plant's supervisor, in order of time

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
        rate = np.empty((len(self.pose), 3))
        rate_along(self.pose, self.twist, rate)
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
