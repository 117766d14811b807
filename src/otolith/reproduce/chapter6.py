"""Chapter 6: the emulator's tables (6.2, 6.3), the laps of Hockenheim (6.4, 6.5), and their figures.

Laps are cued by the structured engine: with the dense one they would take half an hour. Its changes are
counted otherwise than the thesis's iterations, so that Table 6.4 compares what the guesses save, not counts.
"""

import functools
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from otolith.core.frames import PAIRS
from otolith.plant import Ideal
from otolith.reproduce.emulator import FIGURES, SCENARIOS, Case, figures_of
from otolith.reproduce.figures import motion_panels
from otolith.reproduce.laboratory import Answers
from otolith.reproduce.loop import FOUR_DOF, MODELS, Closed, Loop, closed
from otolith.reproduce.outcome import Cell, Claim, Grid, Outcome, Panel
from otolith.reproduce.published import Row, published
from otolith.reproduce.verdict import Number, judged_row
from otolith.scenarios import Scenario
from otolith.scenarios.perceived import perceived
from otolith.simulate import simulate
from otolith.vehicle.study import SPEEDS, hockenheim_reference

SAME: Final = ("study-solver", "study-start", "study-damping")
PLACES: Final = ("emulator", "offline")
NAMES: Final = dict(  # the thesis's section 6.1 in the published rows -> the emulator's scenarios
    zip(("sine-0.5", "step-0.1", "sine-1-0.01hz", "combined-fast"), SCENARIOS.values(), strict=True)
)
SAYS: Final = {"longitudinal": "surge-pitch", "lateral": "sway-roll"}


@dataclass(frozen=True, slots=True)
class Emulated:
    """One closed loop of section 6.2."""

    case: Case

    @property
    def label(self) -> str:
        """For the progress line."""
        return f"{self.case.cueing} on {self.case.scenario}, {self.case.where}"

    @property
    def cost(self) -> float:
        """Seconds, roughly."""
        return 9.0 if "0.01hz" in self.case.scenario else 3.0

    def run(self) -> dict[str, Any]:
        """Figures of the run and, of the hybrid with all inputs, its motion."""
        run = self.case.run()
        loop = Loop(scenario=self.case.scenario)
        return {**figures_of(run), "motion": closed(loop, run).motion["surge-pitch"]}


def _emulated(row: Row, model: str) -> Emulated:
    return Emulated(Case(scenario=NAMES[row["scenario"]], where=row["plant"], cueing=model))


def emulator_jobs() -> list[Emulated]:
    """All cells of Tables 6.2 and 6.3."""
    return [_emulated(row, model) for row in published("table-6.2").rows for model in MODELS]


def emulator_table(name: str, answers: Answers) -> Outcome:
    """Table 6.2 or 6.3."""
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
    """Both runs of figure 6.2, C.8 or C.9."""
    return [Emulated(Case(scenario=FIGURES[figure], where=place, cueing="hybrid-all")) for place in PLACES]


def emulator_figure(figure: str, answers: Answers) -> Outcome:
    """Figure 6.2, C.8 or C.9: emulator and offline simulation, each with its parts."""
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


@dataclass(frozen=True, slots=True)
class Lap:
    """One lap of Hockenheim in 4 DOF."""

    speed: int  # [km/h]
    cueing: str
    share: float = 1.0  # of the reference that is asked for

    @property
    def label(self) -> str:
        """For the progress line."""
        return f"{self.cueing} on {self.share:g} × a lap at {self.speed} km/h"

    @property
    def cost(self) -> float:
        """Seconds, roughly."""
        return 8.0

    @property
    def loop(self) -> Loop:
        """The controller: that of chapter 5 in 4 DOF."""
        return Loop(scenario="lap", cueing=self.cueing, dofs=FOUR_DOF, solver="structured")

    def run(self) -> Closed:
        """Drive, then cue."""
        loop = self.loop
        reference = perceived(_reference(self.speed), lambda force, _: self.share * force, name="a factor")
        run = simulate(loop.controller(), Ideal(), reference, platform=loop.platform, pairs=loop.dofs)
        return closed(loop, run)


@functools.lru_cache(maxsize=len(SPEEDS))
def _reference(speed: int) -> Scenario:
    return hockenheim_reference(speed)


def lap_jobs() -> list[Lap]:
    """All cells of Tables 6.4 and 6.5."""
    return [Lap(speed, model) for speed in SPEEDS for model in MODELS]


def lap_table(name: str, answers: Answers) -> Outcome:
    """Table 6.4 or 6.5."""
    printed, counts = published(name), name == "table-6.4"
    numbers: list[Number] = []
    for row in printed.rows:
        found = {model: answers[Lap(row["speed_kmh"], model)] for model in MODELS}
        pair = SAYS.get(row.get("direction", ""), "")
        ours = {model: one.spread()["mean"] if counts else one.rmse[pair] for model, one in found.items()}
        name_of_row = " ".join(filter(None, (f"{row['speed_kmh']} km/h", row.get("direction"))))
        numbers += judged_row(name_of_row, row, ours)
    return Outcome(
        name=name,
        kind="table",
        title=printed.title,
        section=printed.section,
        text=(
            "The car, its driver and the track are ours, not CarMaker's; the reference is the car's "
            "acceleration through eq. 6.4, as in the thesis. Cued by the structured engine, whose changes "
            "are counted otherwise. The thesis's reference is not published."
        ),
        numbers=tuple(numbers),
        claims=_lap_claims(answers, counts=counts),
        grids=(_lap_grid(answers),),
        reasons=("study-lap-size",),
    )


def _lap_claims(answers: Answers, *, counts: bool) -> tuple[Claim, ...]:
    if counts:
        saved = {
            model: float(
                np.mean([1.0 - _mean(answers, speed, model) / _mean(answers, speed) for speed in SPEEDS])
            )
            for model in MODELS[1:]
        }
        figures = ", ".join(f"{model} {100 * value:.1f} %" for model, value in saved.items())
        return (
            Claim(
                text="Every guess saves iterations on the laps",
                holds=min(saved.values()) > 0.0,
                figures=figures,
            ),
            Claim(
                text="The hybrid with all inputs saves the most",
                holds=max(saved, key=saved.__getitem__) == "hybrid-all",
                figures=figures,
            ),
        )
    by_speed = {
        direction: [answers[Lap(speed, "implicit")].rmse[pair] for speed in SPEEDS]
        for direction, pair in SAYS.items()
    }
    return (
        Claim(
            text="The error grows with the speed in both directions",
            holds=all(errors == sorted(errors) for errors in by_speed.values()),
            figures="; ".join(
                f"{name} {', '.join(f'{error:.4f}' for error in errors)}" for name, errors in by_speed.items()
            ),
        ),
    )


def _mean(answers: Answers, speed: int, model: str = "implicit") -> float:
    one: Closed = answers[Lap(speed, model)]
    return one.spread()["mean"]


def _lap_grid(answers: Answers) -> Grid:
    rows: list[tuple[Cell, ...]] = []
    for speed in SPEEDS:
        for model in MODELS:
            one: Closed = answers[Lap(speed, model)]
            spread = one.spread()
            rows.append(
                (
                    f"{speed} km/h",
                    model,
                    spread["mean"],
                    spread["p99"],
                    spread["max"],
                    one.step_us["p99"],
                    one.unsolved,
                )
            )
    return Grid(
        title="Changes of the structured engine, its step time, and steps without an answer",
        header=("lap", "model", "mean", "p99", "max", "p99 of the step [µs]", "unsolved"),
        rows=tuple(rows),
    )


LAP_FIGURES: Final = {  # figure -> speed [km/h], axis pair
    "figure-6.4": (120, "surge-pitch"),
    "figure-6.5": (120, "sway-roll"),
    "figure-c.10": (80, "surge-pitch"),
    "figure-c.11": (80, "sway-roll"),
    "figure-c.12": (100, "surge-pitch"),
    "figure-c.13": (100, "sway-roll"),
}


def lap_figure_jobs(figure: str) -> list[Lap]:
    """The run of one lap figure."""
    return [Lap(LAP_FIGURES[figure][0], "hybrid-all")]


def lap_figure(figure: str, answers: Answers) -> Outcome:
    """One direction of one lap; on figure 6.4 also where the hardest braking is."""
    speed, pair = LAP_FIGURES[figure]
    (job,) = lap_figure_jobs(figure)
    motion = answers[job].motion[pair]
    hardest = float(motion.time[int(np.argmin(motion.wanted))])
    claim = Claim(
        text="The hardest braking is at around 80 s",
        holds=abs(hardest - 80.0) <= 10.0,
        figures=f"the most negative reference at {hardest:.1f} s",
    )
    direction = {name: word for word, name in SAYS.items()}[PAIRS[pair].name]
    return Outcome(
        name=figure,
        kind="figure",
        title=f"A lap of Hockenheim at {speed} km/h, {direction}",
        section="6.3, C.4.2",
        claims=(claim,) if figure == "figure-6.4" else (),
        panels=motion_panels(motion, pair),
    )
