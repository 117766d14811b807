"""Stray packets in a recorded drive: a few rows of zeros, or a row that leaps far off and returns."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Final

import numpy as np

from otolith.core.arrays import Bools, Mat, Vec
from otolith.recordings.channels import Channel
from otolith.recordings.events.event import Event, stretches, together

STRAY: Final = 0.3  # [s] longest duration of a stray packet
BREAK: Final = 0.5  # [m/s²] least deviation of its rows …
SHARE: Final = 4.0  # … also as a multiple of the change from the row before to the row after
SPIKE: Final = 20.0  # [m/s²] a leap that returns within SPIKE_ROWS rows is not motion of a vehicle
SPIKE_ROWS: Final = 3
AROUND: Final = 10  # rows on either side that show how the drive continues


def find_strays(felt: Sequence[Channel]) -> list[Event]:
    """Find a few rows in which all forces and rates are zero, or in which a_x or a_y leaps and returns."""
    t, table = together(felt)
    if len(t) < 3:
        return []
    zero = (table == 0.0).all(axis=1)
    runs = [run for run in stretches(zero) if _alone(zero, run)]
    found = [_stray(t, table, run, "packet of zeros") for run in runs]
    for i, channel in enumerate(felt[: table.shape[1]]):
        if channel.key in ("ax", "ay"):
            spikes = [run for run in _spikes(table[:, i]) if run[0] >= AROUND and run[1] + AROUND <= len(t)]
            found += [_stray(t, table, run, f"spike of {channel.key}") for run in spikes]
    return [event for event in found if event is not None]


def _alone(zero: Bools, run: tuple[int, int]) -> bool:
    """Return whether zeros are the exception around these rows: enough rows before and after hold others."""
    first, last = run
    around = zero[max(first - AROUND, 0) : first], zero[last : last + AROUND]
    return all(len(side) == AROUND and not side.any() for side in around)


def _spikes(values: Vec) -> list[tuple[int, int]]:
    """Return first row and end of leaps that return within a few rows."""
    step = np.diff(values)
    out = np.flatnonzero(np.abs(step) > SPIKE)
    return [
        (int(a) + 1, int(b) + 1) for a, b in pairwise(out) if b - a <= SPIKE_ROWS and step[a] * step[b] < 0.0
    ]


def _stray(t: Vec, table: Mat, run: tuple[int, int], what: str) -> Event | None:
    """Return the rows [first, last) as a stray packet if the drive continues after them as before."""
    first, last = run
    if first < 1 or last >= len(t) or t[last] - t[first - 1] > STRAY + 1e-9:
        return None
    before, inside, after = table[first - 1], table[first:last], table[last]
    out = float(np.abs(inside - before).max())
    on = float(np.abs(after - before).max())
    if out < BREAK or out < SHARE * on:
        return None
    rows = f"{last - first} row{'s' if last - first > 1 else ''}"
    start, end = float(t[first - 1]), float(t[last])
    return Event("stray packet", start, end, f"{what}, {rows}, {out:.3g} m/s² off", bridge=end - start)
