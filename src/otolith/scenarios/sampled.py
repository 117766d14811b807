"""Signals that are given by samples."""

from dataclasses import dataclass

import numpy as np

from otolith.core.arrays import Mat, Vec, freeze


@dataclass(frozen=True, slots=True, eq=False)
class Sampled:
    """Samples at 0, period, 2 period, …, linear in between; the first and last extend beyond them."""

    period: float  # [s]
    values: Mat  # (n, 3)

    def __post_init__(self) -> None:
        freeze(self, values=(len(self.values), 3))

    def __call__(self, t: Vec) -> Mat:
        """Return the values (k, 3) at times (k,) [s]."""
        nodes = np.arange(len(self.values), dtype=np.float64) * self.period
        return on_lines(np.asarray(t, dtype=np.float64), nodes, self.values)


def on_lines(t: Vec, nodes: Vec, values: Mat) -> Mat:
    """Interpolate (n, c) values linearly at (k,) times, constant beyond the ends."""
    return np.stack([np.interp(t, nodes, column) for column in values.T], axis=1)
