"""Which iterations the thesis counts: how ACADO starts its solver, and over which steps the mean is taken."""

from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np

from otolith_thesis.jobs import Answers
from otolith_thesis.loop import MODELS, Closed, Loop
from otolith_thesis.model_tables import ADAPTIVE_2, ADAPTIVE_4, CONSTANT_2, READINGS
from otolith_thesis.outcome import Bearing, Cell, Claim, Grid, Outcome
from otolith_thesis.solver_variants import ACADO
from otolith_thesis.studies.common import COUNTED, PAIR, bearing, fit, row_of, signals

TABLE: Final = "table-5.5"
FOLLOWED: Final = ("sine-1", "step-1")  # signals on which ACADO's start is tested
COMPARED: Final = {  # table of iterations -> its loops, and the table of its percentages
    "table-5.5": (ADAPTIVE_2, "table-5.6"),
    "table-c.4": (CONSTANT_2, "table-c.5"),
    "table-5.9": (ADAPTIVE_4, "table-5.10"),
}
NEAR: Final = 0.0953  # ln 1.1, the largest fit within 10 %
PART: Final = 0.8  # largest remaining share of a fit if a reading explains a part of it

# --- ACADO's start

PREVIOUS: Final = "previous working set"
START: Final = "ACADO’s start"
PRINTED: Final = "published"


def _loops(table: str) -> list[Loop]:
    """Return the four models on the tested signals, signal by signal."""
    setting, _ = COMPARED[table]
    return [setting.loop(s, m, READINGS[0]) for s in FOLLOWED for m in MODELS]


def _started(loop: Loop) -> Loop:
    return replace(loop, solver=ACADO)


def acado_jobs() -> list[Loop]:
    """Return the four models with ACADO's start and with the previous working set."""
    return [job for table in COMPARED for loop in _loops(table) for job in (loop, _started(loop))]


def acado(answers: Answers) -> Outcome:
    """Compare the iterations of a solver that starts from the last multipliers, as ACADO's code does."""
    means = {table: _means(table, answers) for table in COMPARED}
    fits = {table: _fits(of_table) for table, of_table in means.items()}
    saved = {
        table: {name: _saved(values) for name, values in of_table.items()}
        for table, of_table in means.items()
    }
    figures = "; ".join(f"{table}: {_in_percent(of_table)}" for table, of_table in fits.items())
    moved = max(_moved(answers, loop) for table in COMPARED for loop in _loops(table))
    return Outcome(
        name="study-acado-start",
        kind="study",
        title="ACADO’s way of starting its solver explains part of the iterations, not all",
        section="D.1",
        text=(
            "The code that ACADO generates makes a new qpOASES problem at every step and hands it the last "
            "multipliers, nothing else; qpOASES then follows a homotopy from a made-up problem, whose length "
            "does not depend on any guess of the controls. The same loops, the same answers "
            f"(RMSE moved by {100.0 * moved:.1g} % at most), counted along that way."
        ),
        claims=(
            Claim(
                text="It gives the published iterations (median within 10 %)",
                holds=all(of_table[START] <= NEAR for of_table in fits.values()),
                figures=figures,
            ),
            Claim(
                text="It comes nearer to them than the previous working set",
                holds=all(of_table[START] < of_table[PREVIOUS] for of_table in fits.values()),
                figures=figures,
            ),
            Claim(
                text="Counted so, every guess saves iterations, as in print",
                holds=all(min(of_table[START]) > 0.0 for of_table in saved.values()),
                figures="; ".join(f"{table}: {_percent(of_table)}" for table, of_table in saved.items()),
            ),
        ),
        grids=tuple(_grid(table, of_table) for table, of_table in means.items()),
        bears_on={
            name: Bearing.EXPLAINS if of_table[START] <= PART * of_table[PREVIOUS] else Bearing.EXCLUDED
            for table, of_table in fits.items()
            for name in (table, COMPARED[table][1])
        },
    )


def _means(table: str, answers: Answers) -> dict[str, list[float]]:
    """Return the mean changes of every loop with either start, and as published."""
    loops = _loops(table)
    return {
        PREVIOUS: [_mean(answers[loop]) for loop in loops],
        START: [_mean(answers[_started(loop)]) for loop in loops],
        PRINTED: [float(row_of(table, loop.scenario)[loop.cueing]) for loop in loops],
    }


def _fits(means: dict[str, list[float]]) -> dict[str, float]:
    return {name: fit(means[name], means[PRINTED]) for name in (PREVIOUS, START)}


def _moved(answers: Answers, loop: Loop) -> float:
    """Return the largest relative difference of the RMSE between the two starts."""
    base, other = answers[loop].rmse, answers[_started(loop)].rmse
    return float(max(abs(other[pair] / base[pair] - 1.0) for pair in base))


def _grid(table: str, means: dict[str, list[float]]) -> Grid:
    rows: list[tuple[Cell, ...]] = [
        (loop.scenario, loop.cueing, *(f"{values[k]:.2f}" for values in means.values()))
        for k, loop in enumerate(_loops(table))
    ]
    title = f"Mean changes per step, loops of {table}"
    return Grid(title=title, header=("signal", "model", *means), rows=tuple(rows))


def _percent(saved: dict[str, list[float]]) -> str:
    return ", ".join(
        f"{name} {' / '.join(f'{value:.0f} %' for value in values)}" for name, values in saved.items()
    )


def _mean(closed: Closed) -> float:
    return closed.spread()["mean"]


def _saved(values: list[float]) -> list[float]:
    """Return the savings of each guess in percent of the sum over the signals."""
    sums = np.reshape(values, (-1, len(MODELS))).sum(axis=0)
    return [float(value) for value in 100.0 * (1.0 - sums[1:] / sums[0])]


def _in_percent(fits: dict[str, float]) -> str:
    return ", ".join(f"{name}: {100.0 * (np.exp(value) - 1.0):.0f} %" for name, value in fits.items())


# --- the steps over which the mean is taken


def _active(closed: Closed) -> float:
    """Return the mean over the steps at which the reference is not zero."""
    return float(np.mean(closed.changes[np.abs(closed.motion[PAIR].wanted) > 0.0]))


def _confirmed(closed: Closed) -> float:
    """Return the mean if the last check, which finds nothing to change, also counts."""
    return _mean(closed) + 1.0


MEANS: Final[dict[str, Callable[[Closed], float]]] = {
    "changes, all steps": _mean,
    "changes, while the reference is not zero": _active,
    "changes and the last look, all steps": _confirmed,
}


def mean_jobs() -> list[Loop]:
    """Return the loops of Table 5.5 in the fitting reading."""
    return [ADAPTIVE_2.loop(s, m, READINGS[0]) for s in ADAPTIVE_2.scenarios for m in MODELS]


def means(answers: Answers) -> Outcome:
    """Compare other readings of "mean iterations" on the same loops of Table 5.5."""
    printed = [float(row_of(TABLE, s)[m]) for s in signals(TABLE) for m in MODELS]
    found = {name: [of(answers[loop]) for loop in mean_jobs()] for name, of in MEANS.items()}
    fits = {name: fit(np.maximum(values, 1e-3).tolist(), printed) for name, values in found.items()}
    least = min(printed)
    rows: list[tuple[Cell, ...]] = [
        (
            s,
            *(f"{values[len(MODELS) * k]:.2f}" for values in found.values()),
            f"{printed[len(MODELS) * k]:.2f}",
        )
        for k, s in enumerate(signals(TABLE))
    ]
    return Outcome(
        name="study-mean",
        kind="study",
        title="What is averaged does not explain the iterations",
        section="5.1, C.4.1",
        text=(
            "The thesis averages over the entire simulation (section C.4.1). Tried besides: over the steps "
            "at which the reference is not zero; with the last look of every step counted, which finds "
            "nothing to change."
        ),
        claims=(
            Claim(
                text="A mean over the active time gives the published iterations (median within 10 %)",
                holds=fits["changes, while the reference is not zero"] <= NEAR,
                figures=_in_percent(fits),
            ),
            Claim(
                text="The last look is counted: no published mean is below 1",
                holds=least >= 1.0,
                figures=f"the least is {least:.4f}",
            ),
        ),
        grids=(
            Grid(
                title="Implicit MPC without a guess, iterations per step",
                header=("signal", *found, "published (5.5)"),
                rows=tuple(rows),
            ),
        ),
        bears_on=bearing(COUNTED, fits["changes, while the reference is not zero"] <= NEAR, Bearing.EXPLAINS),
    )
