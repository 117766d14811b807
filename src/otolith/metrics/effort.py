"""What the decisions cost: distributions, since means hide the steps that hurt."""

from collections import Counter
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from otolith.interfaces import Status
from otolith.loop import Run


def distribution(values: NDArray[Any], scale: float = 1.0) -> dict[str, float]:
    """Mean, median, 99th percentile and maximum of `values` · `scale`."""
    scaled = np.asarray(values, dtype=np.float64) * scale
    return {
        "mean": float(np.mean(scaled)),
        "median": float(np.median(scaled)),
        "p99": float(np.percentile(scaled, 99)),
        "max": float(np.max(scaled)),
    }


def largest_residual(run: Run) -> float | None:
    """Largest certificate of the decisions that came with one; None when none did."""
    certified = run.residual[np.isfinite(run.residual)]
    return float(np.max(certified)) if len(certified) else None


def decisions_by_status(run: Run) -> dict[str, int]:
    """How many decisions ended how, see `Run.outcomes`."""
    return dict(Counter(run.outcomes))


def decisions_failed(by_status: Mapping[str, int]) -> int:
    """Decisions that are not the algorithm's own, of `decisions_by_status`."""
    return sum(count for status, count in by_status.items() if status != Status.DECIDED)


def guesses_missed(run: Run) -> int:
    """Decisions for which there was no guess, although the algorithm asked for one."""
    return int(np.count_nonzero(run.guess_missed))
