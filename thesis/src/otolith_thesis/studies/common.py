"""Functions that the studies share: fits to a table, and its columns."""

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np

from otolith_thesis.jobs import Answers
from otolith_thesis.loop import Loop
from otolith_thesis.outcome import Bearing
from otolith_thesis.published import Row, published

PAIR: Final = "surge-pitch"
ERRORS: Final = ("table-5.7", "table-5.11", "table-5.12", "table-c.6")  # tables of errors of the four models
ITERATIONS: Final = ("table-5.5", "table-5.9", "table-c.4", "table-6.2")
PERCENTAGES: Final = ("table-5.6", "table-5.10", "table-c.5")
COUNTED: Final = (*ITERATIONS, *PERCENTAGES)
SMALL_SET: Final = ("sine-0.5", "sine-1", "step-sine-0.5")


def fit(ours: Sequence[float], printed: Sequence[float]) -> float:
    """Return the median of |ln(ours / published)|."""
    return float(np.median(np.abs(np.log(np.asarray(ours) / np.asarray(printed)))))


def rmse(answers: Answers, loops: Mapping[Any, Loop], pair: str = PAIR) -> list[float]:
    """Return the RMSE [m/s²] of every loop along an axis pair."""
    return [answers[loop].rmse[pair] for loop in loops.values()]


def column(table: str, key: str = "implicit") -> list[float]:
    """Return one column of a published table."""
    return [float(row[key]) for row in published(table).rows]


def bearing(tables: Sequence[str], found: bool, then: Bearing) -> dict[str, Bearing]:
    """Return a study's conclusion for its tables: `then` if `found`, otherwise "excluded"."""
    return dict.fromkeys(tables, then if found else Bearing.EXCLUDED)


def signals(table: str) -> list[str]:
    """Return the signals of a published table."""
    return [row["scenario"] for row in published(table).rows]


def cells(values: Sequence[float]) -> tuple[str, ...]:
    """Format with four digits after the point, as the thesis prints."""
    return tuple(f"{value:.4f}" for value in values)


def row_of(table: str, scenario: str) -> Row:
    """Return a published row by its signal."""
    return next(row for row in published(table).rows if row["scenario"] == scenario)
