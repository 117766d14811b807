"""Section 6.2 computed: the four cueing models on the ideal platform ("offline") and on the emulator.

The emulator is our hexapod on the surrogate geometry of the platform's file; everything else is as in
chapter 5, with the tilt rate softened by the slack of eq. 6.2. Counts are those of the dense engine, a dual
active set warm-started from the step before, the thesis's in kind. Nothing here reads or writes files.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any, Final

from otolith.core.frames import SURGE_PITCH
from otolith.metrics import distribution, tracking_rmse
from otolith.mpc.design import Design
from otolith.mpc.implicit import ImplicitSettings
from otolith.platforms import load
from otolith.registry import CUEING, PLANTS, SOLVERS
from otolith.scenarios import scenario
from otolith.simulate import Run, simulate

MODELS: Final = ("implicit", "implicit-trajectory", "hybrid-first", "hybrid-all")
PLANT_OF: Final = {"offline": "ideal", "emulator": "hexapod"}  # in the words of Tables 6.2 and 6.3
SCENARIOS: Final = {  # those of section 6.1, by their names in the tables
    "Sine wave of low amplitude": "sine-0.5",
    "Step signal": "step-0.1",
    "Sine wave of high amplitude": "sine-1-0.01hz",
    "Combined sine wave": "combined-emulator",
}
FIGURES: Final = {"figure-6.2": "combined-emulator", "figure-c.8": "step-0.1", "figure-c.9": "sine-1-0.01hz"}
PENALTY: Final = 100.0  # of the slack s of eq. 6.2, per rad/s; the thesis does not print its weight


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """One closed loop of section 6.2."""

    scenario: str
    where: str  # "offline" or "emulator"
    cueing: str = "hybrid-all"
    solver: str = "dense"
    soft: bool = True  # the tilt rate's rows (eq. 6.2)

    def run(self) -> Run:
        """Close the loop."""
        platform = load("thesis")
        soft = {"tilt_rate": PENALTY} if self.soft else {}
        settings = ImplicitSettings(soft=soft, engine=SOLVERS[self.solver].load())
        design = Design(platform=platform, implicit=settings)
        plant = PLANT_OF[self.where]
        return simulate(
            CUEING[self.cueing].load()(design),
            PLANTS[plant].load()(platform),
            scenario(self.scenario),
            platform=platform,
            pairs=(SURGE_PITCH.name,),
            names=(self.cueing, plant),
            settings={"soft": soft, "solver": self.solver},
        )


def figures_of(run: Run) -> dict[str, Any]:
    """What Tables 6.2 and 6.3 tell of a run: RMSE [m/s²], changes of the working set, unsolved steps."""
    return {
        "rmse": float(tracking_rmse(run)[0]),
        "changes": distribution(run.changes),
        "unsolved": sum(status != "optimal" for status in run.status),
    }


def table_rows(tell: Callable[[str], None] = lambda _: None) -> Iterator[dict[str, Any]]:
    """Rows of Tables 6.2 and 6.3 in their order: scenario, plant, and by model what `figures_of` gives."""
    for where in ("emulator", "offline"):
        for name in SCENARIOS.values():
            row: dict[str, Any] = {"scenario": name, "plant": where}
            for model in MODELS:
                tell(f"{model} on {name}, {where}")
                row[model] = figures_of(Case(scenario=name, where=where, cueing=model).run())
            yield row


def figure_runs(figure: str) -> tuple[Run, Run]:
    """The two runs of figure 6.2, C.8 or C.9: offline, then on the emulator; hybrid with all inputs.

    Draw them with `otolith.report.comparison_figure`; their names there are "offline" and "emulator".
    """
    name = FIGURES[figure]
    offline, emulated = (
        replace(Case(scenario=name, where=where, solver="structured").run(), cueing=where)
        for where in ("offline", "emulator")
    )
    return offline, emulated
