"""Cueing with the explicit law, which is looked up and not solved (section 5.2.1)."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from otolith.core.arrays import Mat, Vec, frozen_array
from otolith.core.frames import Dof
from otolith.cueing.mpc.explicit_problem import ExplicitSettings
from otolith.cueing.mpc.motion import chains, in_six_axes, model_state, stacked
from otolith.cueing.mpc.rows import plausible
from otolith.cueing.several import added
from otolith.interfaces import Command, Outcome, PlatformState, Reference, Status
from otolith.mpqp import Law
from otolith.mpqp.lookup import MISSED
from otolith.platforms import Platform
from otolith.qp.problem import Status as SolverStatus
from otolith.safety.stopping import Stopping

EDGE_TOLERANCE: Final = 1e-7  # relative distance outside its box that rounding may cause


class ExplicitLaw:
    """The stored law, evaluated by walking from the region of the last query."""

    def __init__(self, law: Law, dof: Dof, settings: ExplicitSettings) -> None:
        self.settings = settings
        self._law = law
        self._inputs = len(chains(dof))
        self._T = frozen_array(settings.blocking(self._inputs))
        self._low, self._high = law.problem.lower, law.problem.upper
        self._edge = EDGE_TOLERANCE * (self._high - self._low)
        self._theta = np.empty(len(self._low))
        self._region = -1

    def __len__(self) -> int:
        return len(self._law)

    def reset(self) -> None:
        """Discard the last region, so that equal runs are equal."""
        self._region = -1

    def inputs(self, x: Vec, wanted: float) -> Mat | None:
        """Return accelerations (N, nu) for a motion x, or None if the explicit problem is infeasible there.

        Parameters
        ----------
        x : (nx,) as in `otolith.cueing.mpc.motion`; its accelerations, which come last, are not read.
        wanted : the specific force [m/s²] or the rate [rad/s].
        """
        theta = self._theta
        theta[:-1], theta[-1] = x[: len(theta) - 1], wanted
        inside = np.clip(theta, self._low, self._high)
        if not np.all(np.abs(inside - theta) <= self._edge):  # also if NaN, which fails every comparison
            return None
        z, region = self._law.first(inside, self._T.shape[1], self._region)
        if region < MISSED:
            return None
        if region >= 0:
            self._region = region
        U: Mat = (self._T @ z).reshape(-1, self._inputs)
        return U


class Explicit:
    """Cueing by explicit laws alone, one for each degree of freedom.

    With a linearised output and separate reaches, the joint law of several degrees of freedom consists of
    these laws: none depends on another's state.

    Where a law has no answer, its axes stop by `otolith.safety.stopping`. A law with rows that guarantee
    stopping (`BrakingRows.STOPPING`) is also checked: an answer that leads to a state from which the axes
    could not stop is not followed.
    """

    def __init__(self, platform: Platform, dofs: Sequence[Dof], laws: Sequence[ExplicitLaw]) -> None:
        self._parts = [_OfDof(platform, dof, law) for dof, law in zip(dofs, laws, strict=True)]

    @property
    def period(self) -> float:
        """Return the time between two decisions [s]."""
        return self._parts[0].law.settings.period

    def reset(self, state: PlatformState) -> None:
        """Start from `state`; the only memory of the laws is the region of their last query."""
        for part in self._parts:
            part.reset(state)

    def step(self, state: PlatformState, reference: Reference) -> Command:
        """Look each law up."""
        return added([part.step(state, reference) for part in self._parts])


class _OfDof:
    """The law of one degree of freedom, and the stopping of its axes."""

    def __init__(self, platform: Platform, dof: Dof, law: ExplicitLaw) -> None:
        self.law, self._dof, self._axes = law, dof, stacked((dof,))
        self._stopping = Stopping(platform, (dof,), lag=0.0, period=law.settings.period)

    def reset(self, state: PlatformState) -> None:
        """Discard the last region."""
        self.law.reset()
        self._stopping.reset(state)

    def step(self, state: PlatformState, reference: Reference) -> Command:
        """Look the law up; if it has no answer, stop and report why."""
        felt = reference.angular_rate if self._dof.feels_rate else reference.specific_force
        wanted = felt[self._dof.felt]
        if not (self._stopping.observe(state) and plausible(wanted)):
            return self._stopping.rest(Outcome(status=Status.INVALID))
        U = self.law.inputs(model_state(self._axes, state), float(wanted))
        if U is None:
            infeasible = SolverStatus.INFEASIBLE.value
            return self._stopping.rest(Outcome(status=Status.FALLBACK, solver=infeasible))
        plan = in_six_axes(self._axes, U)
        if self.law.settings.braking.leads and not self._stopping.allows(plan[0]):
            return self._stopping.rest(Outcome(status=Status.REFUSED))
        return self._stopping.decided(plan, Outcome(status=Status.DECIDED))
