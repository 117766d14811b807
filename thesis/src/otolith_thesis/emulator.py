"""Section 6.2: the four cueing models on the ideal platform ("offline") and on the emulator.

The emulator is our hexapod with the surrogate geometry of the platform's file. Everything else is as in
chapter 5, with the tilt rate softened by the slack of eq. 6.2. Iterations are those of a dual active-set
method that is warm-started from the previous step, the same kind as the thesis's
(`otolith_thesis.counting_engine`). Nothing here reads or writes files.
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
PLANT_OF: Final = {"offline": "ideal", "emulator": "hexapod"}  # by the terms of Tables 6.2 and 6.3
SCENARIOS: Final = {  # signals of section 6.1, by their names in the tables
    "Sine wave of low amplitude": "sine-0.5",
    "Step signal": "step-0.1",
    "Sine wave of high amplitude": "sine-1-0.01hz",
    "Combined sine wave": "combined-emulator",
}
FIGURES: Final = {"figure-6.2": "combined-emulator", "figure-c.8": "step-0.1", "figure-c.9": "sine-1-0.01hz"}
PENALTY: Final = 100.0  # penalty on the slack s of eq. 6.2, per rad/s; the thesis does not print its weight


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """One closed loop of section 6.2."""

    scenario: str
    where: str  # "offline" or "emulator"
    cueing: str = "hybrid-all"
    solver: str = COUNTED
    soft: bool = True  # whether the limit of the tilt rate is soft (eq. 6.2)
    washout: tuple[WashoutWeight, ...] = PRESETS["thesis-fit"]
    entry: Entry = Entry.REFERENCE

    def run(self) -> Run:
        """Simulate the closed loop."""
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
    """Return the figures of Tables 6.2 and 6.3: RMSE [m/s²], working-set changes, unsolved steps."""
    return {
        "rmse": float(tracking_rmse(run)[0]),
        "changes": distribution(run.changes),
        "unsolved": sum(status != Status.DECIDED for status in run.status),
    }


def table_rows(progress: Callable[[str], None] = lambda _: None) -> Iterator[dict[str, Any]]:
    """Yield the rows of Tables 6.2 and 6.3: scenario, plant, and `figures_of` by model."""
    for where in ("emulator", "offline"):
        for name in SCENARIOS.values():
            row: dict[str, Any] = {"scenario": name, "plant": where}
            for model in MODELS:
                progress(f"{model} on {name}, {where}")
                row[model] = figures_of(Case(scenario=name, where=where, cueing=model).run())
            yield row


def figure_runs(figure: str) -> tuple[Run, Run]:
    """Return the two runs of figure 6.2, C.8 or C.9, of the hybrid with all inputs: offline, emulator.

    Draw them with `otolith.report.comparison_figure`, in which they are named "offline" and "emulator".
    """
    name = FIGURES[figure]
    offline, emulated = (
        replace(Case(scenario=name, where=where, solver="structured").run(), cueing=where)
        for where in ("offline", "emulator")
    )
    return offline, emulated


def scaled(factor: float) -> tuple[WashoutWeight, ...]:
    """Return the adaptive weights that come closest to chapter 5, times a factor."""

    def times(w1: float, w2: float, w3: float, w4: float) -> tuple[float, float, float, float]:
        return factor * w1, factor * w2, factor * w3, factor * w4

    return tuple(
        replace(weight, coefficients=times(*weight.coefficients)) for weight in PRESETS["thesis-fit"]
    )


class _Recorded:
    """Repeats the commands of a run, whatever the platform does."""

    def __init__(self, run: Run) -> None:
        self._commands, self.period, self._next = run.command, run.period, 0

    def reset(self, state: PlatformState) -> None:
        """Start from the first command."""
        del state
        self._next = 0

    def step(self, state: PlatformState, reference: Reference) -> Command:
        """Return the next of the recorded commands."""
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
    """Apply the commands of a run of section 6.1 to the emulator."""
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


WEIGHTS: Final = {  # readings of the washout weights, by their names in docs/hexapod.md
    **{name: PRESETS[name] for name in ("printed", "thesis-fit", "constant-fit", "none")},
    **{f"thesis-fit times {factor:g}": scaled(factor) for factor in (0.5, 0.3, 0.2)},
}


def weight_rows() -> Iterator[dict[str, Any]]:
    """Yield Table 6.3's implicit MPC for each of `WEIGHTS`: RMSE [m/s²] by scenario and plant."""
    for name, weights in WEIGHTS.items():
        row: dict[str, Any] = {"weights": name}
        for signal in SCENARIOS.values():
            case = Case(
                scenario=signal, where="offline", cueing="implicit", solver="structured", washout=weights
            )
            row[signal] = {where: _rmse(replace(case, where=where)) for where in PLANT_OF}
        yield row


def servo_errors(washout: tuple[WashoutWeight, ...] = PRESETS["thesis-fit"]) -> dict[str, float]:
    """Return where the emulator's error on the combined signal comes from: RMSE [m/s²] of the implicit MPC.

    "offline" is on the ideal platform, "servos" applies the same commands to the hexapod, and "emulator"
    closes the loop. The first difference is the effect of the servos on a command, the second that of feeding
    it back.
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
    """Yield the combined signal on both plants, with guesses as references (eq. 3.1) and initial points."""
    for where in ("emulator", "offline"):
        for entry in (Entry.REFERENCE, Entry.PRIMAL):
            case = Case(scenario=SCENARIOS["Combined sine wave"], where=where, entry=entry)
            row: dict[str, Any] = {"plant": where, "entry": entry.value}
            yield row | {model: figures_of(replace(case, cueing=model).run()) for model in MODELS}
