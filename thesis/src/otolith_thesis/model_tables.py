"""Comparison of the four cueing models of section 3.1: Tables 5.3 to 5.12 and C.4 to C.6.

Iterations are working-set changes of a dual active-set method on the condensed problem, where each step
starts from the previous step's set, the same kind as the thesis's qpOASES (`otolith_thesis.counting_engine`).
Every table is computed in two readings of the washout weights (presets `thesis-fit` and `printed`). Its
numbers are those of `thesis-fit`; the others are in a grid below.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from otolith.cueing.mpc.washout_weights import PRESETS, WashoutWeight, constant
from otolith_thesis.claims import (
    HYBRIDS,
    Values,
    both,
    fewest,
    least_mean,
    savings,
    savings_and_trend,
    tracking,
)
from otolith_thesis.counting_engine import COUNTED
from otolith_thesis.hint_loops import NAME, Hinted
from otolith_thesis.jobs import Answers
from otolith_thesis.loop import FOUR_DOF, MODELS, TWO_DOF, Closed, Loop
from otolith_thesis.outcome import Cell, Grid, Outcome
from otolith_thesis.published import Published, published
from otolith_thesis.verdict import Number, judged, judged_row

OFTEN: Final = 5  # only one training manoeuvre in this many is used for a certified guess
# The same with constant weights, where each pair of weights has its own hint, a single law
SELDOM: Final = 15
GUESSES: Final = {"thesis-fit": ("velocity", 0.1), "printed": ("tilt_rate", 1.0)}
READINGS: Final = ("thesis-fit", "printed")
SAME: Final = (
    "study-acado-start",
    "study-mean",
    "study-solver",
    "study-start",
    "study-damping",
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Setting:
    """One of the thesis's comparisons: the cued axes and the kind of washout."""

    dofs: tuple[str, ...]
    scenarios: tuple[str, ...]
    constant: bool = False

    @property
    def counts_both(self) -> bool:
        """Return whether changes are counted in both readings, as for the main table in 2 DOF."""
        return len(self.dofs) == 1 and not self.constant

    def loop(self, scenario: str, model: str, reading: str) -> Loop:
        """Return the closed loop of one cell."""
        weights = best_constant(scenario, reading) if self.constant else PRESETS[reading]
        # Outside Table 5.5, only the motion of the other reading is needed.
        motion_only = reading != READINGS[0] and not self.counts_both
        return Loop(
            scenario=scenario,
            cueing=model,
            dofs=self.dofs,
            washout=weights,
            solver="structured" if motion_only else COUNTED,
        )

    def loops(self) -> list[Loop]:
        """Return all cells in both readings."""
        return [
            self.loop(scenario, model, reading)
            for reading in READINGS
            for scenario in self.scenarios
            for model in MODELS
        ]

    def hinted(self) -> list[Hinted]:
        """Return the loops with a certified guess in the fitting reading, one hint for each washout."""
        groups: dict[tuple[WashoutWeight, ...], list[str]] = {}
        for scenario in self.scenarios:
            groups.setdefault(self.loop(scenario, "implicit", READINGS[0]).washout, []).append(scenario)
        every = SELDOM if self.constant else OFTEN
        return [
            Hinted(dofs=self.dofs, washout=washout, scenarios=tuple(scenarios), every=every)
            for washout, scenarios in groups.items()
        ]

    def counted(self) -> list[Loop | Hinted]:
        """Return all jobs of a table of iterations."""
        return [*self.loops(), *self.hinted()]

    def values(self, answers: Answers, reading: str, of: Callable[[Closed], float]) -> Values:
        """Return one figure of every cell."""
        return {
            scenario: {model: of(answers[self.loop(scenario, model, reading)]) for model in MODELS}
            for scenario in self.scenarios
        }


def best_constant(scenario: str, reading: str) -> tuple[WashoutWeight, ...]:
    """Return the thesis's tuned constant weights of one signal (Table 5.3), in one of two readings.

    As printed, they are on tilt rate and position. As it fits, the first is on the velocity, and a tenth of
    the second on the position: the one scale that brings errors and travels closest to the table
    (`study-constant-weights`).
    """
    row = next(row for row in published("table-5.3").rows if row["scenario"] == scenario)
    return constant_weights(row["tilt_rate"], row["position"], reading)


def constant_weights(first: float, second: float, reading: str) -> tuple[WashoutWeight, ...]:
    """Return constant weights for the thesis's pair (tilt rate, displacement) in one of the two readings."""
    state, factor = GUESSES[reading]
    return constant({state: first, "position": factor * second})


def _scenarios(table: str) -> tuple[str, ...]:
    return tuple(row["scenario"] for row in published(table).rows)


ADAPTIVE_2: Final = Setting(dofs=TWO_DOF, scenarios=_scenarios("table-5.5"))
ADAPTIVE_4: Final = Setting(dofs=FOUR_DOF, scenarios=_scenarios("table-5.9"))
CONSTANT_2: Final = Setting(dofs=TWO_DOF, scenarios=_scenarios("table-c.4"), constant=True)


def _numbers(printed: Published, ours: Values, digits: int = 4) -> tuple[Number, ...]:
    found: list[Number] = []
    for row in printed.rows:
        of_row: dict[str, float] = {model: ours[row["scenario"]][model] for model in MODELS if model in row}
        found += judged_row(row["scenario"], row, of_row, digits=digits)
    return tuple(found)


def _in_print(printed: Published) -> Values:
    return {row["scenario"]: {m: float(row[m]) for m in MODELS if m in row} for row in printed.rows}


def _mean_changes(closed: Closed) -> float:
    return closed.spread()["mean"]


def iterations(table: str, setting: Setting, answers: Answers) -> Outcome:
    """Build Tables 5.5, 5.9 and C.4: mean iterations, with the distributions that the means hide."""
    printed = published(table)
    ours = setting.values(answers, READINGS[0], _mean_changes)
    other = setting.values(answers, READINGS[1], _mean_changes)
    return Outcome(
        name=table,
        kind="table",
        title=printed.title,
        section=printed.section,
        text="Working-set changes per step, each step started from the working set of the step before.",
        numbers=_numbers(printed, ours),
        claims=both(_in_print(printed), ours, least_mean if setting.constant else fewest),
        grids=(
            _distributions(setting, answers),
            _pooled(setting, answers),
            *([_grid("The same with washout weights as printed", other)] if setting.counts_both else []),
        ),
        reasons=SAME,
    )


def percentages(table: str, counts: str, setting: Setting, answers: Answers) -> Outcome:
    """Build Tables 5.6, 5.10 and C.5: savings of changes relative to the implicit MPC [%].

    The thesis prints magnitudes, so a model that needs more iterations counts as an improvement in its
    averages. Our numbers have a sign, positive if a model needs fewer.
    """
    printed = published(table)
    means = setting.values(answers, READINGS[0], _mean_changes)
    ours = _saved(means)
    in_print = _in_print(published(counts))
    signed = _saved(in_print)
    average = {model: float(np.mean([row[model] for row in ours.values()])) for model in HYBRIDS}
    numbers = _numbers(printed, ours, digits=2)
    numbers += judged(
        [
            Number(row="average", column=model, published=value, ours=average[model], digits=2)
            for model, value in printed.average.items()
        ]
    )
    return Outcome(
        name=table,
        kind="table",
        title=printed.title,
        section=printed.section,
        text="The thesis prints magnitudes; ours are positive where a model needs fewer changes.",
        numbers=numbers,
        claims=both(signed, ours, savings if setting.constant else savings_and_trend),
        grids=(
            _grid("What the published means give, with their sign", signed, averaged=True),
            _grid("All signals taken together", {"published": _in_all(in_print), "ours": _in_all(means)}),
        ),
        reasons=(*SAME, "study-arithmetic"),
    )


def errors(table: str, setting: Setting, answers: Answers, pair: str) -> Outcome:
    """Build Tables 5.7, 5.11, 5.12 and C.6: RMSE of the felt specific force."""
    printed = published(table)
    ours = setting.values(answers, READINGS[0], lambda closed: closed.rmse[pair])
    other = setting.values(answers, READINGS[1], lambda closed: closed.rmse[pair])
    return Outcome(
        name=table,
        kind="table",
        title=printed.title,
        section=printed.section,
        text="RMSE of the felt specific force [m/s²].",
        numbers=_numbers(printed, ours),
        claims=both(_in_print(printed), ours, tracking),
        grids=(_grid("The same with washout weights as printed", other),),
        reasons=(*_weighed(setting), "study-terminal", "study-step", "study-guess"),
    )


def _weighed(setting: Setting) -> tuple[str, ...]:
    """Return the studies of the limits and weights that concern a comparison."""
    if setting.constant:
        return ("study-constant-weights",)
    return ("study-weights", "study-circle") if len(setting.dofs) == 2 else ("study-weights",)


def _in_all(values: Values) -> dict[str, float]:
    """Return savings in percent of the sum over all signals, which no signal with few changes dominates."""
    total = {model: sum(row[model] for row in values.values()) for model in MODELS}
    return _saved({"all": total})["all"]


def _saved(values: Values) -> Values:
    return {
        scenario: {model: 100.0 * (1.0 - row[model] / row["implicit"]) for model in HYBRIDS}
        for scenario, row in values.items()
    }


# --- grids


def _grid(title: str, values: Values, *, averaged: bool = False) -> Grid:
    models = [model for model in MODELS if model in next(iter(values.values()))]
    rows: list[tuple[Cell, ...]] = [
        (scenario, *(row[model] for model in models)) for scenario, row in values.items()
    ]
    if averaged:
        rows.append(("average", *(float(np.mean([row[m] for row in values.values()])) for m in models)))
    return Grid(title=title, header=("signal", *models), rows=tuple(rows))


def _by_model(setting: Setting, answers: Answers) -> dict[str, dict[str, Closed]]:
    """Return closed loops by model, then by signal; the certified guess is the last model."""
    found = {
        model: {s: answers[setting.loop(s, model, READINGS[0])] for s in setting.scenarios}
        for model in MODELS
    }
    return found | {NAME: {s: one for job in setting.hinted() for s, one in answers[job].items()}}


def _distributions(setting: Setting, answers: Answers) -> Grid:
    found = _by_model(setting, answers)
    rows: list[tuple[Cell, ...]] = []
    for scenario in setting.scenarios:
        spreads = [by_signal[scenario].spread() for by_signal in found.values()]
        rows.append((scenario, *(f"{s['mean']:.2f} / {s['p99']:.0f} / {s['max']:.0f}" for s in spreads)))
    return Grid(
        title="Changes per step: mean / p99 / max; the last column has the minimiser of the first",
        header=("signal", *found),
        rows=tuple(rows),
    )


def _pooled(setting: Setting, answers: Answers) -> Grid:
    """Return figures over all signals: changes, cost of a step, missed guesses and unsolved steps."""
    rows: list[tuple[Cell, ...]] = []
    models = _by_model(setting, answers)
    for model, by_signal in models.items():
        closed = list(by_signal.values())
        changes = np.concatenate([one.changes for one in closed])
        rows.append(
            (
                model,
                float(np.mean(changes)),
                float(np.percentile(changes, 99)),
                int(np.max(changes)),
                f"{100.0 * np.mean(changes == 0):.0f} %",
                f"{100.0 * _share_of_worst(changes):.0f} %",
                f"{_middle(closed, 'median'):.0f} / {_middle(closed, 'p99'):.0f}",
                _moved(by_signal, models["implicit"]),
                f"{sum(one.missed for one in closed)} / {sum(one.unsolved for one in closed)}",
            )
        )
    header = ("model", "mean", "p99", "max", "steps without a change", "changes in the worst 1 % of steps")
    return Grid(
        title="All signals together; times are those of the structured engine, without the counting",
        header=(*header, "step, median / p99 [µs]", "RMSE moved by", "missed / unsolved"),
        rows=tuple(rows),
    )


def _middle(closed: Sequence[Closed], figure: str) -> float:
    """Return the median over the signals of a figure of the step times [µs]."""
    return float(np.median([one.step_us[figure] for one in closed]))


def _moved(by_signal: dict[str, Closed], base: dict[str, Closed]) -> str:
    """Return the largest relative change of the RMSE against the implicit MPC without a guess."""
    gaps = [
        abs(one.rmse[pair] / base[scenario].rmse[pair] - 1.0)
        for scenario, one in by_signal.items()
        for pair in one.rmse
    ]
    return f"{100.0 * max(gaps):.2g} %"


def _share_of_worst(changes: Sequence[int] | np.ndarray) -> float:
    ordered = np.sort(np.asarray(changes))[::-1]
    return float(np.sum(ordered[: max(1, len(ordered) // 100)]) / max(1, np.sum(ordered)))


def loops_of(settings: Iterable[Setting]) -> list[Loop]:
    """Return the closed loops that tables of these settings need."""
    return [loop for setting in settings for loop in setting.loops()]
