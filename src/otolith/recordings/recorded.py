"""The result of every reader of a format: named columns of cells, whose meaning is not yet known."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

import numpy as np

from otolith.core.arrays import Ints, Vec
from otolith.core.errors import InputError
from otolith.recordings.channels import Layout

Cells = Vec | Sequence[str]  # numbers, NaN where a cell is blank; or texts, empty where a cell is blank


class Recorded(Protocol):
    """Named columns with units: one row per instant, or each column on its own clock."""

    @property
    def source(self) -> str:
        """Return the name of the file, for errors and notes."""

    @property
    def names(self) -> Sequence[str]:
        """Return the names of the columns (c,)."""

    @property
    def units(self) -> Sequence[str]:
        """Return the units of the columns (c,), empty where the file states none next to the name."""

    @property
    def origins(self) -> Sequence[str]:
        """Return where each column was measured (c,), in the file's words; empty if the file does not say."""

    @property
    def notes(self) -> tuple[str, ...]:
        """Return sentences about what the reader of the file assumed or repaired."""

    @property
    def layout(self) -> Layout:
        """Return the form of the file and the place of the table in it."""

    @property
    def place(self) -> str:
        """Return the word for rows: "line", "sample", "record", "message"."""

    @property
    def clocked(self) -> bool:
        """Return whether every column has its own clock, so that none of them has to be the time."""

    def cells(self, indices: Sequence[int]) -> list[Cells]:
        """Return the cells of these columns."""

    def clock(self, index: int) -> Vec | None:
        """Return the clock (n,) [s] of a column if `clocked`; otherwise None."""

    def rows(self, index: int) -> Ints:
        """Return the number in the file of each cell (n,) of a column, from 1."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Columns:
    """Columns that are held in memory, as formats other than text are read."""

    source: str
    names: tuple[str, ...]  # (c,)
    units: tuple[str, ...]  # (c,)
    values: tuple[Cells, ...]  # (c,) of (n,) each; n may differ where there are clocks
    clocks: tuple[Vec, ...] = ()  # (c,) of (n,) [s]; empty where one of the columns is the time of all
    lines: tuple[
        Ints, ...
    ] = ()  # (c,) of (n,): place of each value in the file; empty where it is its number
    layout: Layout = field(default_factory=lambda: Layout(form="numbers"))
    place: str = "sample"
    notes: tuple[str, ...] = ()
    origins: tuple[str, ...] = ()

    @property
    def clocked(self) -> bool:
        """Return whether every column has a clock of its own."""
        return bool(self.clocks)

    def cells(self, indices: Sequence[int]) -> list[Cells]:
        """The cells of these columns."""
        return [self.values[index] for index in indices]

    def clock(self, index: int) -> Vec | None:
        """Return the clock of a column [s]; None if columns have no clocks of their own."""
        return np.asarray(self.clocks[index], dtype=np.float64) if self.clocks else None

    def rows(self, index: int) -> Ints:
        """Return the place of each value in the file, or its number from 1 if the place is unknown."""
        return self.lines[index] if self.lines else np.arange(1, len(self.values[index]) + 1)


class Signal(NamedTuple):
    """One channel with its own clock, as binary formats hold it."""

    name: str
    unit: str
    t: Vec  # (n,) [s]
    values: Vec  # (n,), NaN where the file marks the sample as invalid


def with_own_clocks(
    source: str, signals: Sequence[Signal], layout: Layout, notes: tuple[str, ...] = ()
) -> Columns:
    """Turn signals into columns that keep their clocks.

    Raises
    ------
    InputError : no signal has two samples.
    """
    usable = [signal for signal in signals if len(signal.t) > 1]
    if not usable:
        raise InputError(source, "without a signal of at least 2 samples", "a recorded drive")
    return Columns(
        source=source,
        names=tuple(signal.name for signal in usable),
        units=tuple(signal.unit for signal in usable),
        values=tuple(np.asarray(signal.values, dtype=np.float64) for signal in usable),
        clocks=tuple(np.asarray(signal.t, dtype=np.float64) for signal in usable),
        layout=layout,
        notes=notes,
    )
