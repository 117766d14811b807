"""Key figures of a run. They read a `Run` and know no algorithm."""

from otolith.metrics.effort import distribution, effort
from otolith.metrics.limits import Excess, excesses
from otolith.metrics.summary import compare, summarise
from otolith.metrics.tracking import tracking_rmse, travel_rms

__all__ = [
    "Excess",
    "compare",
    "distribution",
    "effort",
    "excesses",
    "summarise",
    "tracking_rmse",
    "travel_rms",
]
