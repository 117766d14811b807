"""Section 6.2 computed: the four cueing models on the ideal platform ("offline") and on the emulator.

The emulator is our hexapod on the surrogate geometry of the platform's file; everything else is as in
chapter 5, with the tilt rate softened by the slack of eq. 6.2. Counts are those of a dual active set that is
warm-started from the step before, the thesis's in kind (`otolith_thesis.counting_engine`). Nothing here
reads or writes files.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from otolith.core.frames import SURGE_PITCH
from otolith.cueing.design import Design
from otolith.cueing.mpc.rows import BrakingRows
from otolith.cueing.mpc.settings import Entry, MpcSettings
from otolith.cueing.mpc.washout_weights import PRESETS, WashoutWeight
from otolith.interfaces import Command, Outcome, PlatformState, Reference, Status
from otolith.loop import Run, simulate
from otolith.metrics import distribution, tracking_rmse
from otolith.platforms import load
from otolith.registry import CUEING, FOUR_MODELS, PLANTS
from otolith.scenarios import scenario
from otolith_thesis.counting_engine import COUNTED, engine_named

MODELS: Final = FOUR_MODELS
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
    solver: str = COUNTED
    soft: bool = True  # the tilt rate's rows (eq. 6.2)
    washout: tuple[WashoutWeight, ...] = PRESETS["thesis-fit"]
    entry: Entry = Entry.REFERENCE

    def run(self) -> Run:
        """Close the loop."""
        platform = load("thesis")
        soft = {"tilt_rate": PENALTY} if self.soft else {}
        settings = MpcSettings(
            braking=BrakingRows.POSITION, soft=soft, washout=self.washout, engine=engine_named(self.solver)
        )
        design = Design(platform=platform, mpc=settings, entry=self.entry)
        plant = PLANT_OF[self.where]
        return simulate(
            CUEING[self.cueing].load()(design),
            PLANTS[plant].load()(platform),
            scenario(self.scenario),
            platform=platform,
            dofs=(SURGE_PITCH.name,),
            names=(self.cueing, plant),
            settings={"soft": soft, "solver": self.solver},
        )


def figures_of(run: Run) -> dict[str, Any]:
    """What Tables 6.2 and 6.3 report of a run: RMSE [m/s²], changes of the working set, unsolved steps."""
    return {
        "rmse": float(tracking_rmse(run)[0]),
        "changes": distribution(run.changes),
        "unsolved": sum(status != Status.DECIDED for status in run.status),
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


def scaled(factor: float) -> tuple[WashoutWeight, ...]:
    """The adaptive weights that come closest to chapter 5, times a factor."""

    def times(w1: float, w2: float, w3: float, w4: float) -> tuple[float, float, float, float]:
        return factor * w1, factor * w2, factor * w3, factor * w4

    return tuple(
        replace(weight, coefficients=times(*weight.coefficients)) for weight in PRESETS["thesis-fit"]
    )


class _Recorded:
    """The commands of a run once more, with nobody watching what becomes of them."""

    def __init__(self, run: Run) -> None:
        self._commands, self.period, self._next = run.command, run.period, 0

    def reset(self, state: PlatformState) -> None:
        """Begin again."""
        del state
        self._next = 0

    def step(self, state: PlatformState, reference: Reference) -> Command:
        """Give the next of the recorded commands."""
        del state, reference
        self._next += 1
        return Command(
            acceleration=self._commands[self._next - 1],
            pose=np.zeros(6),
            twist=np.zeros(6),
            plan=np.zeros((0, 6)),
            outcome=Outcome(status=Status.DECIDED),
        )


def in_open_loop(run: Run) -> Run:
    """The commands of a run of section 6.1, given to the emulator."""
    plant = PLANT_OF["emulator"]
    return simulate(
        _Recorded(run),
        PLANTS[plant].load()(run.platform),
        scenario(run.scenario),
        platform=run.platform,
        dofs=run.dofs,
        names=("recorded", plant),
    )


def _rmse(case: Case) -> float:
    return float(tracking_rmse(case.run())[0])


WEIGHTS: Final = {  # readings of the washout weights, by the names of docs/hexapod.md
    **{name: PRESETS[name] for name in ("printed", "thesis-fit", "constant-fit", "none")},
    **{f"thesis-fit times {factor:g}": scaled(factor) for factor in (0.5, 0.3, 0.2)},
}


def weight_rows() -> Iterator[dict[str, Any]]:
    """Table 6.3's implicit MPC with each of `WEIGHTS`: RMSE [m/s²] by scenario and place."""
    for name, weights in WEIGHTS.items():
        row: dict[str, Any] = {"weights": name}
        for signal in SCENARIOS.values():
            case = Case(
                scenario=signal, where="offline", cueing="implicit", solver="structured", washout=weights
            )
            row[signal] = {where: _rmse(replace(case, where=where)) for where in PLANT_OF}
        yield row


def servo_errors(washout: tuple[WashoutWeight, ...] = PRESETS["thesis-fit"]) -> dict[str, float]:
    """Where the emulator's error on the combined signal comes from: RMSE [m/s²] of the implicit MPC.

    "offline" on the ideal platform; "servos" of the same commands, given to the hexapod; "emulator" with
    the loop closed. The first step is what servos do to a command, the second what feeding it back does.
    """
    offline = Case(
        scenario=SCENARIOS["Combined sine wave"],
        where="offline",
        cueing="implicit",
        solver="structured",
        washout=washout,
    )
    run = offline.run()
    return {
        "offline": float(tracking_rmse(run)[0]),
        "servos": float(tracking_rmse(in_open_loop(run))[0]),
        "emulator": _rmse(replace(offline, where="emulator")),
    }


def entry_rows() -> Iterator[dict[str, Any]]:
    """The combined signal on both plants, its guesses entering as eq. 3.1 prints and as a mere start."""
    for where in ("emulator", "offline"):
        for entry in (Entry.REFERENCE, Entry.PRIMAL):
            case = Case(scenario=SCENARIOS["Combined sine wave"], where=where, entry=entry)
            row: dict[str, Any] = {"plant": where, "entry": entry.value}
            yield row | {model: figures_of(replace(case, cueing=model).run()) for model in MODELS}
