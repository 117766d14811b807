"""Gaps in a recorded drive: the recorder paused, or a sensor failed, for too long to interpolate."""

from typing import Final

from otolith.recordings.channels import Recording
from otolith.recordings.events.event import Event
from otolith.recordings.events.jumps import BRIDGE

TOUCHING: Final = 0.1  # [s] longest distance of two gaps that count as one


def find_gaps(recording: Recording) -> list[Event]:
    """Find stretches of more than 1 s without a sample of a needed channel."""
    end = recording.end
    holes = [
        (max(float(a), 0.0), min(float(b), end), key)
        for key, one in recording.cued.items()
        for a, b in one.holes
        if b > 0.0 and a < end
    ]
    joined: list[tuple[float, float, dict[str, None]]] = []  # names in the order of their gaps
    for first, last, key in sorted(holes):
        if joined and first <= joined[-1][1] + TOUCHING:
            before = joined.pop()
            joined.append((before[0], max(before[1], last), before[2] | {key: None}))
        else:
            joined.append((first, last, {key: None}))
    return [
        Event("gap", first, last, f"no {' and '.join(keys)} for {last - first:.4g} s", bridge=BRIDGE)
        for first, last, keys in joined
    ]
