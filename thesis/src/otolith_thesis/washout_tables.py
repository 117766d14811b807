"""Tables 5.3 and 5.4: constant and adaptive washout weights of the implicit MPC, and their false cues.

The thesis does not define a false cue. Ours are those of `otolith.metrics.false_cues`, with a threshold of
0.17 m/s². So counts are compared only in size and order.
"""

from typing import Final

from otolith_thesis.jobs import Answers
from otolith_thesis.loop import Closed, Loop
from otolith_thesis.model_tables import READINGS, best_constant, constant_weights
from otolith_thesis.outcome import Cell, Claim, Grid, Outcome
from otolith_thesis.published import Row, published
from otolith_thesis.studies.common import PAIR
from otolith_thesis.verdict import Number, judged

SHARED: Final = (0.001, 0.9)  # the constant weights of Table 5.4 on tilt rate and displacement
REASONS: Final = ("study-constant-weights", "study-terminal", "study-false-cues")


def _best(scenario: str, reading: str) -> Loop:
    return Loop(scenario=scenario, washout=best_constant(scenario, reading))


def _shared(scenario: str, reading: str) -> Loop:
    return Loop(scenario=scenario, washout=constant_weights(*SHARED, reading))


def _adaptive(scenario: str) -> Loop:
    return Loop(scenario=scenario)


def best_jobs() -> list[Loop]:
    """Return the loops of Table 5.3 in both readings."""
    rows = published("table-5.3").rows
    return [_best(row["scenario"], reading) for row in rows for reading in READINGS]


def compared_jobs() -> list[Loop]:
    """Return the loops of Table 5.4."""
    signals = [row["scenario"] for row in published("table-5.4").rows]
    constant = [_shared(signal, reading) for signal in signals for reading in READINGS]
    return constant + [_adaptive(signal) for signal in signals]


def _cues(closed: Closed) -> float:
    return float(sum(closed.cues.values()))


def _number(row: Row, column: str, ours: float) -> Number:
    counts = column == "false_cues"
    return Number(
        row=row["scenario"],
        column=column,
        published=float(row[column]),
        ours=ours,
        digits=0 if counts else 4,
    )


def best(answers: Answers) -> Outcome:
    """Build Table 5.3 with the thesis's weights."""
    printed = published("table-5.3")
    numbers: list[Number] = []
    other: list[tuple[Cell, ...]] = []
    for row in printed.rows:
        closed, as_printed = (answers[_best(row["scenario"], reading)] for reading in READINGS)
        for column, ours in (
            ("false_cues", _cues(closed)),
            ("rmse", closed.rmse[PAIR]),
            ("travel", closed.travel[PAIR]),
        ):
            numbers += judged([_number(row, column, ours)])
        other.append(
            (row["scenario"], int(_cues(as_printed)), as_printed.rmse[PAIR], as_printed.travel[PAIR])
        )
    by_signal = {row["scenario"]: answers[_best(row["scenario"], READINGS[0])] for row in printed.rows}
    return Outcome(
        name="table-5.3",
        kind="table",
        title=printed.title,
        section=printed.section,
        text="The thesis's weights, in the reading that fits; the printed reading stands below.",
        numbers=tuple(numbers),
        claims=(
            Claim(
                text="Tracking worsens with the amplitude, for sines and steps alike",
                holds=_grows(by_signal, ("sine-0.5", "sine-1", "sine-2"))
                and _grows(by_signal, ("step-0.5", "step-1", "step-2")),
                figures=", ".join(f"{s} {c.rmse[PAIR]:.4f}" for s, c in by_signal.items()),
            ),
            Claim(
                text="The smallest sine is cued without a false cue",
                holds=_cues(by_signal["sine-0.5"]) == 0,
                figures=f"{_cues(by_signal['sine-0.5']):.0f}",
            ),
        ),
        grids=(
            Grid(
                title="With the weights on tilt rate and position, as printed",
                header=("signal", "false cues", "RMSE [m/s²]", "travel RMS [m]"),
                rows=tuple(other),
            ),
        ),
        reasons=REASONS,
    )


def _grows(by_signal: dict[str, Closed], signals: tuple[str, ...]) -> bool:
    errors = [by_signal[signal].rmse[PAIR] for signal in signals]
    return errors == sorted(errors)


def compared(answers: Answers) -> Outcome:
    """Build Table 5.4: one pair of constant weights for all signals against the adaptive weights."""
    printed = published("table-5.4")
    numbers: list[Number] = []
    better, cues = 0, {"constant": 0.0, "adaptive": 0.0}
    rows: list[tuple[Cell, ...]] = []
    for row in printed.rows:
        constant, as_printed = (answers[_shared(row["scenario"], reading)] for reading in READINGS)
        adaptive = answers[_adaptive(row["scenario"])]
        for column, ours in (
            ("constant_rmse", constant.rmse[PAIR]),
            ("constant_travel", constant.travel[PAIR]),
            ("false_cues", _cues(adaptive)),
            ("rmse", adaptive.rmse[PAIR]),
            ("travel", adaptive.travel[PAIR]),
        ):
            numbers += judged([_number(row, column, ours)])
        better += adaptive.rmse[PAIR] <= constant.rmse[PAIR]
        cues["constant"] += _cues(constant)
        cues["adaptive"] += _cues(adaptive)
        rows.append((row["scenario"], int(_cues(constant)), int(_cues(as_printed)), as_printed.rmse[PAIR]))
    in_print = sum(row["rmse"] <= row["constant_rmse"] for row in printed.rows)
    return Outcome(
        name="table-5.4",
        kind="table",
        title=printed.title,
        section=printed.section,
        text="Constant weights of 0.001 and 0.9 on every signal, against the adaptive ones.",
        numbers=tuple(numbers),
        claims=(
            Claim(
                text="Adaptive weights track better on most signals than one constant pair",
                holds=better > len(printed.rows) / 2,
                figures=f"ours: on {better} of {len(printed.rows)}; in print: on {in_print}",
            ),
            Claim(
                text="They make fewer false cues",
                holds=cues["adaptive"] < cues["constant"],
                figures=f"{cues['adaptive']:.0f} against {cues['constant']:.0f} over all signals",
            ),
        ),
        grids=(
            Grid(
                title="Constant weights: false cues, and the printed reading's",
                header=("signal", "false cues", "printed reading: false cues", "RMSE [m/s²]"),
                rows=tuple(rows),
            ),
        ),
        reasons=("study-weights", *REASONS),
    )
