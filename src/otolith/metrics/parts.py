"""Figures of a run from its parts, one after the other, so that a long run need not be in memory.

Sums are those of the parts, added. For a run of one part they are numpy's own, to the last bit.
"""

from collections.abc import Callable, Iterable, Iterator

import numpy as np
from numpy.typing import NDArray

from otolith.core.arrays import Mat, Vec
from otolith.core.filter import Filter
from otolith.loop import Run

OfPart = Callable[[Run], Vec]  # a part -> values, time along axis 0


def mean(parts: Iterable[NDArray[np.float64]]) -> Vec:
    """Return the mean along axis 0 of consecutive parts of a series."""
    total, count = np.zeros(()), 0
    for values in parts:
        total = np.sum(values, axis=0) if count == 0 else total + np.sum(values, axis=0)
        count += len(values)
    return np.asarray(total / count)


def root_mean_square(run: Run, of: OfPart) -> Vec:
    """Return the RMS along time of a series, given by part."""
    rms: Vec = np.sqrt(mean(of(part) ** 2 for part in run.parts()))
    return rms


def filtered(run: Run, organ: Filter, of: OfPart) -> Iterator[Mat]:
    """Yield what a filter makes of a series (n, k), by part; it keeps its state from part to part."""
    return (organ.simulate(of(part)) for part in run.parts())
