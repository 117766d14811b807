"""What the studies share: fits to a table, and its columns."""

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np

from otolith.reproduce.laboratory import Answers
from otolith.reproduce.loop import Loop
from otolith.reproduce.published import Row, published

PAIR: Final = "surge-pitch"
SMALL_SET: Final = ("sine-0.5", "sine-1", "step-sine-0.5")


def fit(ours: Sequence[float], printed: Sequence[float]) -> float:
    """Median of |ln(ours / published)|."""
    return float(np.median(np.abs(np.log(np.asarray(ours) / np.asarray(printed)))))


def rmse(answers: Answers, loops: Mapping[Any, Loop], pair: str = PAIR) -> list[float]:
    """RMSE [m/s²] of every loop along an axis pair."""
    return [answers[loop].rmse[pair] for loop in loops.values()]


def column(table: str, key: str = "implicit") -> list[float]:
    """One column of a published table."""
    return [float(row[key]) for row in published(table).rows]


def signals(table: str) -> list[str]:
    """The signals of a published table."""
    return [row["scenario"] for row in published(table).rows]


def cells(values: Sequence[float]) -> tuple[str, ...]:
    """Four digits after the point, as the thesis prints."""
    return tuple(f"{value:.4f}" for value in values)


def row_of(table: str, scenario: str) -> Row:
    """A published row by its signal."""
    return next(row for row in published(table).rows if row["scenario"] == scenario)
