"""Section 6.2: Tables 6.2 and 6.3 of the emulator, and their figures."""

from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from otolith_thesis.emulator import FIGURES, SCENARIOS, Case, figures_of
from otolith_thesis.figures import motion_panels
from otolith_thesis.jobs import Answers
from otolith_thesis.loop import MODELS, Loop, closed
from otolith_thesis.outcome import Claim, Outcome, Panel
from otolith_thesis.published import Row, published
from otolith_thesis.verdict import Number, judged_row

SAME: Final = ("study-solver", "study-start", "study-damping")
PLACES: Final = ("emulator", "offline")
NAMES: Final = dict(  # name in the published rows (section 6.1) -> the emulator's scenario
    zip(("sine-0.5", "step-0.1", "sine-1-0.01hz", "combined-fast"), SCENARIOS.values(), strict=True)
)


@dataclass(frozen=True, slots=True)
class Emulated:
    """One closed loop of section 6.2, as a job."""

    case: Case

    @property
    def label(self) -> str:
        """Return the text for the progress line."""
        return f"{self.case.cueing} on {self.case.scenario}, {self.case.where}"

    @property
    def cost(self) -> float:
        """Return the approximate duration [s]."""
        return 4.0 if "0.01hz" in self.case.scenario else 1.5

    def run(self) -> dict[str, Any]:
        """Return the figures of the run, and its motion."""
        run = self.case.run()
        loop = Loop(scenario=self.case.scenario)
        return {**figures_of(run), "motion": closed(loop, run).motion["surge-pitch"]}


def _emulated(row: Row, model: str) -> Emulated:
    return Emulated(Case(scenario=NAMES[row["scenario"]], where=row["plant"], cueing=model))


def emulator_jobs() -> list[Emulated]:
    """Return all cells of Tables 6.2 and 6.3."""
    return [_emulated(row, model) for row in published("table-6.2").rows for model in MODELS]


def emulator_table(name: str, answers: Answers) -> Outcome:
    """Build Table 6.2 or 6.3."""
    printed, counts = published(name), name == "table-6.2"
    numbers: list[Number] = []
    for row in printed.rows:
        found = {model: answers[_emulated(row, model)] for model in MODELS}
        ours = {model: one["changes"]["mean"] if counts else one["rmse"] for model, one in found.items()}
        numbers += judged_row(f"{row['plant']}, {row['scenario']}", row, ours)
    return Outcome(
        name=name,
        kind="table",
        title=printed.title,
        section=printed.section,
        text=(
            "The emulator is our hexapod on a geometry fitted to Table 6.1; the tilt rate is soft (eq. "
            "6.2), with a penalty of 100 per rad/s, which the thesis does not print."
        ),
        numbers=tuple(numbers),
        claims=(_fewest(numbers),) if counts else (_worse_emulated(numbers),),
        reasons=("study-emulator-guess", *SAME) if counts else ("study-emulator-weights", "study-weights"),
    )


def _fewest(numbers: list[Number]) -> Claim:
    rows = {number.row for number in numbers}
    least = 0
    for row in rows:
        ours = {number.column: number.ours for number in numbers if number.row == row}
        least += ours["hybrid-all"] <= min(ours.values())
    return Claim(
        text="The hybrid with all inputs needs the fewest iterations, on the emulator and offline",
        holds=least == len(rows),
        figures=f"on {least} of {len(rows)} rows",
    )


def _worse_emulated(numbers: list[Number]) -> Claim:
    mean = {place: float(np.mean([n.ours for n in numbers if n.row.startswith(place)])) for place in PLACES}
    return Claim(
        text="Offline simulations track better than the emulator",
        holds=mean["offline"] < mean["emulator"],
        figures=", ".join(f"{place} {value:.4f} m/s² in the mean" for place, value in mean.items()),
    )


def figure_jobs(figure: str) -> list[Emulated]:
    """Return both runs of figure 6.2, C.8 or C.9."""
    return [Emulated(Case(scenario=FIGURES[figure], where=place, cueing="hybrid-all")) for place in PLACES]


def emulator_figure(figure: str, answers: Answers) -> Outcome:
    """Draw figure 6.2, C.8 or C.9: emulator and offline simulation, each with its parts."""
    panels: list[Panel] = []
    for job in figure_jobs(figure):
        force, tilt, travel = motion_panels(answers[job]["motion"], "surge-pitch")
        panels += [_titled(panel, job.case.where) for panel in (force, tilt, travel)]
    return Outcome(
        name=figure,
        kind="figure",
        title=f"Emulator and offline simulation, {FIGURES[figure]}",
        section="6.2, C.4.2",
        panels=tuple(panels),
    )


def _titled(panel: Panel, place: str) -> Panel:
    words = panel.title.split(",")[0]
    return Panel(
        title=f"{words}, {place}",
        x_label=panel.x_label,
        y_label=panel.y_label,
        right_label=panel.right_label,
        curves=panel.curves,
    )
