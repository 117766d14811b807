"""Logs in blocks: each channel has a small table of time and values, and the tables follow one another.

Pi Toolbox (Cosworth) exports this form as "versioned ASCII". A block is a line ``{ChannelBlock}``, a line of
names with units in brackets, separated by tabs, and rows up to a blank line. Each channel has its own
sampling rate.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np

from otolith.core.arrays import Vec
from otolith.core.errors import InputError
from otolith.recordings.cells import numbers
from otolith.recordings.channels import Layout
from otolith.recordings.recorded import Columns, Signal, with_own_clocks
from otolith.recordings.units import factor
from otolith.recordings.words import interpret, split_unit

MARK: Final = "{ChannelBlock}"


def has_blocks(text: str) -> bool:
    """Return whether a text holds several blocks; a single block is read as an ordinary table."""
    return sum(line.strip() == MARK for line in text.splitlines()) > 1


def parse_blocks(text: str, source: str, notes: tuple[str, ...] = ()) -> Columns:
    """Read the channels of all blocks, each on the clock in the first column of its block.

    Raises
    ------
    InputError : the first column of a block is not time, a row is wider or narrower than its block's line of
        names, a cell is not a number, or no channel is left.
    """
    lines = text.splitlines()
    starts = [i + 1 for i, line in enumerate(lines) if line.strip() == MARK]
    signals = [signal for start in starts for signal in _block(lines, start, source)]
    note = f"{source}: {len(starts)} blocks of channels: {', '.join(s.name for s in signals[:8])}"
    return with_own_clocks(source, signals, Layout(form="text, blocks of channels"), (*notes, note))


def _block(lines: Sequence[str], start: int, source: str) -> list[Signal]:
    """Read the channels of the block whose names stand in line `start`, counted from 0."""
    end = next((i for i in range(start, len(lines)) if lines[i].strip()[:1] in ("", "{")), len(lines))
    names, *rows = (line.rstrip("\r\n").split("\t") for line in lines[start:end] or [""])
    for line, row in enumerate(rows, start + 2):
        if len(row) != len(names):
            where = f"number of values in line {line} of {source}"
            raise InputError(where, len(row), f"{len(names)}, as many as names in line {start + 1}")
    clock, unit = split_unit(names[0].strip())
    scale, meaning = factor("time", unit or "s"), interpret(clock, unit)
    if scale is None or meaning is None or meaning.key != "t":
        raise InputError(
            f"first column in line {start + 1} of {source}", repr(names[0]), "time, in s or the like"
        )
    columns = [
        _values([row[i].strip().replace(",", ".") for row in rows], start + 2, source)
        for i in range(len(names))
    ]
    timed = np.isfinite(columns[0])
    return [
        Signal(*split_unit(name.strip()), scale * columns[0][timed], values[timed])
        for name, values in zip(names[1:], columns[1:], strict=True)
    ]


def _values(cells: Sequence[str], first: int, source: str) -> Vec:
    values, wrong = numbers(cells)
    if wrong is not None:
        raise InputError(f"cell in line {first + wrong} of {source}", repr(cells[wrong]), "a finite number")
    return values
