"""One event of a recorded drive, and what its finders share."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from otolith.core.arrays import Bools, Mat, Vec
from otolith.scenarios.channels import Channel


@dataclass(frozen=True, slots=True)
class Event:
    """A stretch of a recorded drive that is not driving."""

    kind: str  # "pause", "held", "frozen sensor", "stray packet", "stray speed", "jump", "replay", "chatter"
    start: float  # [s] last sample before it
    end: float  # [s] first sample after it
    size: str  # what happened, in numbers and words
    sure: bool = True  # otherwise it may well be driving, and is only named
    bridge: float = 0.0  # [s] what it is cut down to: a straight line from the sample before to that after

    def __str__(self) -> str:
        return f"{self.kind} from {self.start:.5g} s to {self.end:.5g} s ({self.size})"


def overlap(event: Event, others: Iterable[Event]) -> bool:
    """Whether an event shares time with one of the others."""
    return any(event.start < other.end and other.start < event.end for other in others)


def together(felt: Sequence[Channel]) -> tuple[Vec, Mat]:
    """Channels as a table (n, k) with its clock (n,): the first one, and those that share its clock."""
    clock = felt[0].t
    shared = [c.values for c in felt if len(c.t) == len(clock) and np.array_equal(c.t, clock)]
    return clock, np.stack(shared, axis=1)


def stretches(mask: Bools) -> list[tuple[int, int]]:
    """Beginning and end (exclusive) of each stretch in which a mask holds."""
    edges = np.flatnonzero(np.diff(np.r_[False, mask, False].astype(np.int8)))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]
