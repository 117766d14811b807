"""From a file's columns to the channels of a drive: which column is used, on which clock, in which unit."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Final

import numpy as np

from otolith.core.errors import InputError
from otolith.recordings import derived
from otolith.recordings.cells import Samples, read_stamps, samples
from otolith.recordings.channels import FELT, FORCE, Channel, Layout, Recording
from otolith.recordings.clocks import UNKNOWN, Stamps, even_rows, resumed
from otolith.recordings.columns import EVERY, QUANTITIES, Column, Header, candidates, missing
from otolith.recordings.longform import widened
from otolith.recordings.recorded import Recorded
from otolith.recordings.rivals import choose

NO_MAPPING: Final[Mapping[str, str]] = MappingProxyType({})


def recording(
    recorded: Recorded, *, columns: Mapping[str, str] = NO_MAPPING, needs: Sequence[str] = ()
) -> Recording:
    """Choose the channels of a drive, each on its own clock, in SI units; physics is not yet checked.

    Column names state quantity and unit (``ax_mps2``, ``AccX [g]``, ``yaw rate (deg/s)``, ``time_ms`` …). A
    unit that is not stated is taken as SI, or as degrees for latitude, longitude and heading. Of several
    columns for one quantity the better is taken, see `rivals.choose`.

    Parameters
    ----------
    columns : for names without known meaning: quantity -> ``NAME``, ``NAME:UNIT``, ``-NAME:UNIT`` to turn the
        sign, ``NAME#2`` for the second column of that name, ``none`` to leave the quantity out;
        ``t=every:0.05s`` for evenly spaced rows; ``ax=from-speed`` and ``ay=from-yaw-rate`` to derive what
        was not measured.
    needs : quantities that will be cued and must be present; if empty, any felt quantity suffices.

    Raises
    ------
    InputError : a needed quantity is missing or holds cells that are not numbers; there is no time, or time
        does not increase; two columns of equal quality contradict each other; or the mapping is impossible.
    """
    recorded = widened(recorded, columns)
    if recorded.clocked:
        columns = _without_clock(columns, recorded)
    header = Header(recorded.source, recorded.names, recorded.units, recorded.origins, recorded.clocked)
    found = candidates(header, columns)
    made = derived.asked(columns)
    try:
        needed = _needed(found, made, needs, header)
    except InputError as error:
        raise _explained(error, recorded.notes) from None
    stamps, layout = _stamps(recorded, found.get("t", []), columns, header)
    wanted = [column for key in QUANTITIES if key != "t" for column in found.get(key, [])]
    read = samples(recorded, wanted, None if stamps is None else stamps.t)
    choice = choose(read, {*needed, *(other for some in made.values() for other in some)}, recorded.source)
    derived.check_sources(choice.chosen, columns, recorded.source)
    zero = _start(choice.chosen, [*needed, *made])
    channels = {key: _channel(one, recorded, zero) for key, one in choice.chosen.items()}
    channels = derived.with_derived(channels, columns)
    return Recording(
        source=recorded.source,
        channels={key: channels[key] for key in QUANTITIES if key in channels},
        layout=replace(layout, unused=_unused(recorded, [*choice.chosen.values()])),
        needs=tuple(needs),
        file_notes=recorded.notes,
        notes=(*(() if stamps is None else (f"t: {layout.clock}", *stamps.notes)), *choice.notes),
        others={key: tuple(_channel(o, recorded, zero) for o in some) for key, some in choice.others.items()},
    )


def _explained(error: InputError, notes: Sequence[str]) -> InputError:
    """Add the notes of the file's reader to an error, because they may state its cause."""
    return InputError(error.field, f"{error.value} ({'; '.join(notes)})", error.bound) if notes else error


def _needed(
    found: Mapping[str, list[Column]], made: Mapping[str, object], needs: Sequence[str], header: Header
) -> list[str]:
    """Return the quantities that must be sound, the cued ones or all forces; refuse if one is missing."""
    for key in needs:
        if not found.get(key) and key not in made:
            raise missing(key, header)
    there = [key for key in FELT if found.get(key) or key in made]
    if not there:
        raise missing("ax", header)
    return list(needs) or [key for key in there if key in FORCE] or there


def _without_clock(columns: Mapping[str, str], recorded: Recorded) -> dict[str, str]:
    """Remove time from the mapping, because every signal of the recording already has a clock."""
    asked = columns.get("t", "")
    if asked and recorded.layout.clock_name not in (asked, asked.rpartition(":")[0]):
        bound = f"left out: every signal of {recorded.source} has a clock of its own"
        raise InputError("t", f"mapped to {asked!r}", bound)
    return {key: text for key, text in columns.items() if key != "t"}


def _stamps(
    recorded: Recorded, clocks: Sequence[Column], columns: Mapping[str, str], header: Header
) -> tuple[Stamps | None, Layout]:
    """Return the time of all rows, from the first column whose stamps increase, and a layout naming it."""
    asked = columns.get("t", "")
    if recorded.clocked:
        return None, replace(recorded.layout, clock="")
    if asked.strip().lower().startswith(f"{EVERY}:"):
        stamps = even_rows(asked, len(recorded.rows(0)))
        return stamps, replace(recorded.layout, clock=stamps.how)
    if not clocks:
        raise missing("t", header)
    faults: list[InputError] = []
    usable: list[tuple[bool, int, int, Stamps, Column]] = []
    for column in clocks:
        try:
            stamps = read_stamps(recorded, column)
        except InputError as error:
            faults.append(error)
            continue
        steps = np.diff(stamps.t[np.isfinite(stamps.t)])
        usable.append(
            (
                bool((steps < 0.0).any() or not steps.any()),
                int((steps == 0.0).sum()),
                len(usable),
                stamps,
                column,
            )
        )
    if not usable:
        raise faults[0]
    _, _, _, stamps, column = min(usable, key=lambda one: one[:3])
    stamps, anew = _resumed(stamps, recorded, column)
    how = f"column {column.name!r} {stamps.how}"
    return stamps, replace(recorded.layout, clock=how, clock_name=column.name, anew=anew)


def _resumed(stamps: Stamps, recorded: Recorded, column: Column) -> tuple[Stamps, tuple[int, ...]]:
    """Return the stamps as one clock, and the rows at which it restarts if the recorder was restarted."""
    found = resumed(stamps.t)
    if found is None:
        return stamps, ()
    rows = recorded.rows(column.index)[found[1]]
    places = " and ".join(f"{recorded.place} {row}" for row in rows[:3])
    more = f" and {len(rows) - 3} more" if len(rows) > 3 else ""
    note = (
        f"t: {column.name!r} starts anew in {places}{more}: how long the recorder paused is not known, "
        f"{UNKNOWN:g} s stand for it"
    )
    return stamps._replace(t=found[0], notes=(*stamps.notes, note)), tuple(map(int, rows))


def _start(chosen: Mapping[str, Samples], needed: Sequence[str]) -> float:
    """Return the time [s] at which the last needed channel begins, which is the start of the drive."""
    starts = [float(chosen[key].t[0]) for key in needed if key in chosen]
    return max(starts or [float(one.t[0]) for one in chosen.values()])


def _channel(one: Samples, recorded: Recorded, zero: float) -> Channel:
    return Channel(
        column=one.column,
        t=one.t - zero,
        values=one.values * one.column.factor,
        rows=one.rows,
        place=recorded.place,
        source=recorded.source,
        notes=one.notes,
    )


def _unused(recorded: Recorded, used: Sequence[Samples]) -> tuple[str, ...]:
    read = {one.column.index for one in used}
    return tuple(name for index, name in enumerate(recorded.names) if index not in read)
