"""What every reader of a format gives: named columns of cells, before it is known what they mean."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

import numpy as np

from otolith.core.arrays import Ints, Vec
from otolith.core.errors import InputError
from otolith.recordings.channels import Layout

Cells = Vec | Sequence[str]  # numbers, NaN where there is none; or texts, empty where there is none


class Recorded(Protocol):
    """Named columns with units; one row per instant, or each column on a clock of its own."""

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
    def origins(self) -> Sequence[str]:
        """Where each column was measured (c,), as the file says it; or nothing at all."""

    @property
    def notes(self) -> tuple[str, ...]:
        """What the reader of the file had to assume or repair, a sentence each."""

    @property
    def layout(self) -> Layout:
        """Form of the file and place of the table in it."""

    @property
    def place(self) -> str:
        """What rows are called: "line", "sample", "record", "message"."""

    @property
    def clocked(self) -> bool:
        """Return whether every column has a clock of its own, so that none of them has to be the time."""

    def cells(self, indices: Sequence[int]) -> list[Cells]:
        """The cells of these columns, each (n,)."""

    def clock(self, index: int) -> Vec | None:
        """The clock (n,) [s] of a column where `clocked`; else None."""

    def rows(self, index: int) -> Ints:
        """The number in the file of each cell (n,) of a column, from 1."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Columns:
    """Columns that were read at once, as formats other than text allow."""

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
        """The clock of a column [s]."""
        return np.asarray(self.clocks[index], dtype=np.float64) if self.clocks else None

    def rows(self, index: int) -> Ints:
        """The place of each value, which is its number from 1 where nothing else is known."""
        return self.lines[index] if self.lines else np.arange(1, len(self.values[index]) + 1)


class Signal(NamedTuple):
    """One channel with a clock of its own, as binary formats hold it."""

    name: str
    unit: str
    t: Vec  # (n,) [s]
    values: Vec  # (n,), NaN where the file says that the sample is not valid


def with_own_clocks(
    source: str, signals: Sequence[Signal], layout: Layout, notes: tuple[str, ...] = ()
) -> Columns:
    """Signals as columns that keep their clocks.

    Raises
    ------
    InputError : none of them has two samples.
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
