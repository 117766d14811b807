"""What the decisions cost: distributions, since means hide the steps that hurt."""

from collections import Counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from otolith.simulate import Run


def distribution(values: NDArray[Any], scale: float = 1.0) -> dict[str, float]:
    """Mean, median, 99th percentile and maximum of `values` · `scale`."""
    scaled = np.asarray(values, dtype=np.float64) * scale
    return {
        "mean": float(np.mean(scaled)),
        "median": float(np.median(scaled)),
        "p99": float(np.percentile(scaled, 99)),
        "max": float(np.max(scaled)),
    }


def effort(run: Run) -> dict[str, Any]:
    """Working-set changes, step time [µs, thread CPU], certificate and status of all decisions.

    `residual_max` is over the decisions that came with a certificate, None when none did.
    """
    certified = run.residual[np.isfinite(run.residual)]
    return {
        "changes": distribution(run.changes),
        "step_time_us": distribution(run.step_time, 1e6),
        "residual_max": float(np.max(certified)) if len(certified) else None,
        "status": dict(Counter(run.outcomes)),
        "guesses_missed": int(np.count_nonzero(run.guess_missed)),
    }
