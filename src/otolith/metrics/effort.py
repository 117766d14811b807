"""The cost of the decisions, as distributions, because means hide the slowest steps."""

from collections import Counter
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from otolith.interfaces import Status
from otolith.loop import Run


def distribution(values: NDArray[Any], scale: float = 1.0) -> dict[str, float]:
    """Return mean, median, 99th percentile and maximum of `values` · `scale`."""
    scaled = np.asarray(values, dtype=np.float64) * scale
    return {
        "mean": float(np.mean(scaled)),
        "median": float(np.median(scaled)),
        "p99": float(np.percentile(scaled, 99)),
        "max": float(np.max(scaled)),
    }


def largest_residual(run: Run) -> float | None:
    """Return the largest certificate of the decisions that have one; None if none has."""
    certified = run.residual[np.isfinite(run.residual)]
    return float(np.max(certified)) if len(certified) else None


def decisions_by_status(run: Run) -> dict[str, int]:
    """Count the decisions by status, see `Run.outcomes`."""
    return dict(Counter(run.outcomes))


def decisions_failed(by_status: Mapping[str, int]) -> int:
    """Count the decisions in `decisions_by_status` that the algorithm did not make itself."""
    return sum(count for status, count in by_status.items() if status != Status.DECIDED)


def guesses_missed(run: Run) -> int:
    """Count the decisions for which the algorithm asked for a guess and got none."""
    return int(np.count_nonzero(run.guess_missed))
