"""What every recorded drive offers, whatever the format of its file; and channels of binary formats."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError
from otolith.scenarios.columns import Column


class Recorded(Protocol):
    """Named columns of numbers with units, one row per instant."""

    @property
    def source(self) -> str:
        """Name of the file, for errors and notes."""

    @property
    def names(self) -> Sequence[str]:
        """Names of the columns (c,)."""

    @property
    def units(self) -> Sequence[str]:
        """Their units (c,), empty where the file states none beside the name."""

    @property
    def notes(self) -> tuple[str, ...]:
        """What the reader of the file had to assume or repair, a sentence each."""

    def where(self, row: int) -> str:
        """Where a row stands in the file, for error sentences."""

    def numbers(self, columns: Sequence[Column]) -> Mat:
        """The chosen columns as they stand in the file, (n, len(columns)), all finite, or an `InputError`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Channels:
    """Columns of a binary file, sampled at the same instants."""

    source: str
    names: tuple[str, ...]  # (c,)
    units: tuple[str, ...]  # (c,)
    values: tuple[Vec, ...]  # (c,) arrays of (n,), of any numeric type
    notes: tuple[str, ...] = ()

    def where(self, row: int) -> str:
        """Where a row stands, for error sentences."""
        return f"sample {row + 1} of {self.source}"

    def numbers(self, columns: Sequence[Column]) -> Mat:
        """The chosen columns without conversion (n, len(columns)).

        Raises
        ------
        InputError : there are fewer than two samples, or a value is not finite.
        """
        chosen = [np.asarray(self.values[column.index], dtype=np.float64) for column in columns]
        table = np.stack(chosen, axis=1)
        if len(table) < 2:
            raise InputError(f"number of samples in {self.source}", len(table), "at least 2")
        bad = np.argwhere(~np.isfinite(table))
        if len(bad):
            row, place = bad[0]
            where = f"{columns[place].name!r} in {self.where(int(row))}"
            raise InputError(where, repr(float(table[row, place])), "a finite number")
        return table


class Signal(NamedTuple):
    """One channel with a clock of its own."""

    name: str
    unit: str
    t: Vec  # (n,) [s]
    values: Vec  # (n,)


def on_one_clock(source: str, signals: Sequence[Signal], notes: tuple[str, ...] = ()) -> Channels:
    """Signals on the clock of the fastest one, the others joined by straight lines, where all of them run.

    Raises
    ------
    InputError : there is no signal with two samples, a clock runs backwards, or they have no time in common.
    """
    usable = [signal for signal in signals if len(signal.t) > 1]
    if not usable:
        raise InputError(source, "without a signal of at least 2 samples", "a recorded drive")
    for signal in usable:
        if (np.diff(signal.t) < 0.0).any():
            raise InputError(f"time of {signal.name!r} in {source}", "running backwards", "increasing")
    master = max(usable, key=lambda signal: len(signal.t)).t
    start = max(float(signal.t[0]) for signal in usable)
    end = min(float(signal.t[-1]) for signal in usable)
    t = master[(master >= start) & (master <= end)]
    if len(t) < 2:
        raise InputError(f"time that the signals of {source} have in common", "none", "at least 2 samples")
    clocks = {signal.t.tobytes() for signal in usable}
    if len(clocks) > 1:
        notes += (f"{source}: {len(clocks)} clocks, all signals put on the fastest by straight lines",)
    values = [np.interp(t, s.t, np.asarray(s.values, dtype=np.float64)) for s in usable]
    return Channels(
        source=source,
        names=("time", *(signal.name for signal in usable)),
        units=("s", *(signal.unit for signal in usable)),
        values=(t, *values),
        notes=notes,
    )
