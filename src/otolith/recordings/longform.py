"""Logs in long form: each row holds one value and, in another cell, the name of its signal."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from otolith.core.arrays import Ints, Vec
from otolith.core.errors import InputError
from otolith.recordings.cells import numbers, read_stamps
from otolith.recordings.channels import FELT
from otolith.recordings.columns import Header, candidates, missing
from otolith.recordings.recorded import Cells, Columns, Recorded
from otolith.recordings.words import words

NAMES: Final = frozenset({"name", "signal", "channel", "variable", "parameter", "key", "sensor", "metric"})
VALUES: Final = frozenset({"value", "val", "reading"})
UNITS: Final = frozenset({"unit", "units"})
# columns that name the owner of a row
WHOSE: Final = frozenset({"vehicle", "car", "driver", "device", "kart", "chassis"})
MOST: Final = 2000  # distinct signals


def widened(recorded: Recorded, mapping: Mapping[str, str]) -> Recorded:
    """Return a recording in long form with one column per signal; any other recording is returned unchanged.

    A recording in long form has a column of names and one of values (``telemetry_name``,
    ``telemetry_value``), and no column that is itself a felt quantity. Each signal gets its own clock.

    Parameters
    ----------
    mapping : states which column is the time, if its name does not.

    Raises
    ------
    InputError : a recording in long form has no time, or holds the rows of several vehicles.
    """
    if recorded.clocked:
        return recorded
    name, value = _column(recorded.names, NAMES), _column(recorded.names, VALUES)
    header = Header(recorded.source, recorded.names, recorded.units)
    found = candidates(header, {key: text for key, text in mapping.items() if key == "t"})
    if name is None or value is None or any(found.get(key) for key in FELT):
        return recorded
    if not found.get("t"):
        raise missing("t", header)
    _refuse_several(recorded)
    stamps = read_stamps(recorded, found["t"][0])
    labels, cells = recorded.cells([name, value])
    return _wide(recorded, (labels, cells), stamps.t, found["t"][0].name)


def _column(names: Sequence[str], wanted: frozenset[str]) -> int | None:
    """Return the first column whose last word is one of these."""
    for index, name in enumerate(names):
        parts = words(name)
        if parts and parts[-1] in wanted:
            return index
    return None


def _refuse_several(recorded: Recorded) -> None:
    for index, name in enumerate(recorded.names):
        if not WHOSE & set(words(name)):
            continue
        cells = recorded.cells([index])[0]
        owners = sorted({str(cell) for cell in cells} - {"", "nan"})
        if len(owners) > 1:
            value = f"{len(owners)} different ones, {owners[0]!r} and {owners[1]!r} among them"
            raise InputError(f"{name!r} in {recorded.source}", value, "one (keep the rows of one vehicle)")


def _wide(recorded: Recorded, table: tuple[Cells, Cells], t: Vec, clock: str) -> Columns:
    labels = np.array([str(label) for label in table[0]])
    values, _ = numbers(table[1])
    unit = _column(recorded.names, UNITS)
    beside = None if unit is None else recorded.cells([unit])[0]
    names, first = np.unique(labels, return_index=True)
    if len(names) > MOST:
        raise InputError(f"number of signals in {recorded.source}", len(names), f"at most {MOST}")
    names = names[np.argsort(first)]
    picked: list[Ints] = [np.flatnonzero((labels == name) & np.isfinite(values)) for name in names]
    kept = [(str(name), rows) for name, rows in zip(names, picked, strict=True) if len(rows) > 1]
    note = (
        f"{recorded.source}: long form, {len(kept)} signals by {clock!r}: {', '.join(n for n, _ in kept[:8])}"
    )
    return Columns(
        source=recorded.source,
        names=tuple(name for name, _ in kept),
        units=tuple("" if beside is None else str(beside[rows[0]]) for _, rows in kept),
        values=tuple(values[rows] for _, rows in kept),
        clocks=tuple(t[rows] for _, rows in kept),
        lines=tuple(recorded.rows(0)[rows] for _, rows in kept),
        layout=replace(recorded.layout, form=f"{recorded.layout.form}, long form", clock_name=clock),
        place=recorded.place,
        notes=(*recorded.notes, note),
    )
