"""The additional column of a certified guess, which leaves the minimiser unchanged.

The coarse explicit law of the *same* limits and weights proposes a working set. The solver takes it only if
fewer optimality conditions contradict it than the previous step's set (`otolith.cueing.hints`). The law is
learned here from a few training manoeuvres, none of which is a signal of the thesis.
"""

from dataclasses import dataclass
from typing import Final

from otolith.core.frames import Dof
from otolith.cueing.hints.coarse import Coarse, CoarseLaws
from otolith.cueing.hints.training.fit import Effort, fit_laws
from otolith.cueing.hints.training.manoeuvres import along, training
from otolith.cueing.hints.training.recording import record
from otolith.cueing.mpc.controller import Mpc
from otolith.cueing.mpc.rows import BrakingRows
from otolith.cueing.mpc.settings import MpcSettings
from otolith.cueing.mpc.washout_weights import WashoutWeight
from otolith.platforms import Platform
from otolith_thesis.loop import Closed, Loop, close_with

NAME: Final = "certified guess"
DEFAULT: Final = Effort()


@dataclass(frozen=True, slots=True, kw_only=True)
class Hinted:
    """Closed loops of several signals with one hint."""

    dofs: tuple[str, ...]
    washout: tuple[WashoutWeight, ...]
    scenarios: tuple[str, ...]
    every: int = 5  # only one training manoeuvre in this many is used; 5 gives about four minutes of driving
    effort: Effort = DEFAULT

    @property
    def label(self) -> str:
        """Return the text for the progress line."""
        return f"certified guess, {2 * len(self.dofs)} DOF: {', '.join(self.scenarios)}"

    @property
    def cost(self) -> float:
        """Return the approximate duration [s]."""
        return 12.0 + sum(self.loop(scenario).cost for scenario in self.scenarios)

    def loop(self, scenario: str) -> Loop:
        """Return the loop of this job on one signal, without a hint."""
        return Loop(scenario=scenario, dofs=self.dofs, washout=self.washout)

    def run(self) -> dict[str, Closed]:
        """Learn the hint, then close the loops; return the results by signal."""
        first = self.loop(self.scenarios[0])
        platform, pairs = first.platform, first.pairs
        settings = MpcSettings(braking=BrakingRows.POSITION, washout=self.washout, engine=first.engine)
        laws = coarse_laws(
            platform,
            pairs,
            MpcSettings(braking=BrakingRows.POSITION, washout=self.washout),
            every=self.every,
            effort=self.effort,
        )
        return {
            scenario: close_with(
                self.loop(scenario),
                Mpc(platform, pairs, settings, hint=Coarse(laws, platform, pairs, settings)),
            )
            for scenario in self.scenarios
        }


def coarse_laws(
    platform: Platform,
    pairs: tuple[Dof, ...],
    settings: MpcSettings,
    *,
    every: int,
    effort: Effort = DEFAULT,
) -> CoarseLaws:
    """Learn the coarse explicit laws of these settings from every `every`-th training manoeuvre."""
    recording = record(platform, pairs, settings, along(training()[::every], pairs))
    return fit_laws(platform, pairs, settings, recording, effort)
