"""One event of a recorded drive, and functions that all finders of events share."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from otolith.core.arrays import Bools, Mat, Vec
from otolith.recordings.channels import Channel


@dataclass(frozen=True, slots=True)
class Event:
    """A stretch of a recorded drive that is not driving."""

    # "gap", "pause", "held", "frozen sensor", "stray packet", "stray speed", "stray position", "jump",
    # "replay", "chatter"
    kind: str
    start: float  # [s] time of the last sample before it
    end: float  # [s] time of the first sample after it
    size: str  # what happened, in words and numbers
    sure: bool = True  # otherwise it may be driving, and is only reported
    # [s] duration that remains after a cut, as a straight line between the samples before and after
    bridge: float = 0.0

    def __str__(self) -> str:
        return f"{self.kind} from {self.start:.5g} s to {self.end:.5g} s ({self.size})"


def apart(events: Sequence[Event], others: Sequence[Event]) -> list[Event]:
    """Return the events that share no time with any of the others."""
    by_start = sorted(others, key=lambda event: event.start)
    starts = [event.start for event in by_start]
    latest = np.maximum.accumulate([-np.inf, *(event.end for event in by_start)])  # latest end of the first k
    # number of others that begin before each event ends
    before = np.searchsorted(starts, [event.end for event in events])
    return [event for event, k in zip(events, before, strict=True) if latest[k] <= event.start]


def inside(t: Vec, events: Sequence[Event]) -> Bools:
    """Return which of the times (n,) [s] lie within an event, between its first and its last sample."""
    spans = [(event.start, event.end) for event in events if event.end > event.start]
    starts, ends = np.sort(np.reshape(spans, (-1, 2)), axis=0).T
    begun, over = np.searchsorted(starts, t), np.searchsorted(ends, t, side="right")
    return np.asarray(begun > over, dtype=np.bool_)


def without(channel: Channel, events: Sequence[Event]) -> Channel:
    """Return the channel without its samples inside the events, unchanged if fewer than two would remain."""
    keep = ~inside(channel.t, events)
    if keep.all() or keep.sum() < 2:
        return channel
    return replace(channel, t=channel.t[keep], values=channel.values[keep], rows=channel.rows[keep])


def together(felt: Sequence[Channel]) -> tuple[Vec, Mat]:
    """Return the first channel, and those that share its clock, as a table (n, k), with the clock (n,)."""
    clock = felt[0].t
    shared = [c.values for c in felt if len(c.t) == len(clock) and np.array_equal(c.t, clock)]
    return clock, np.stack(shared, axis=1)


def stretches(mask: Bools) -> list[tuple[int, int]]:
    """Return start and end (exclusive) of each stretch in which a mask is true."""
    edges = np.flatnonzero(np.diff(np.r_[False, mask, False].astype(np.int8)))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]
