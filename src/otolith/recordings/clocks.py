"""Time stamps of recorded drives: read in the forms that loggers write, and refined where they are coarse.

The forms are: numbers in a unit, epochs whose magnitude shows their unit, clock times packed as HHMMSS.sss,
and dates and clock times in words (ISO 8601 and the like). Only differences of time matter. So a date is used
only to recognise a change of day, and a time zone only has to stay the same.
"""

import re
from collections.abc import Callable, Sequence
from typing import Final, NamedTuple

import numpy as np

from otolith.core.arrays import Ints, Vec
from otolith.core.errors import InputError
from otolith.recordings.columns import EVERY, Column
from otolith.recordings.units import READABLE, factor

DAY: Final = 86400.0  # [s]
EPOCH: Final = (6.3e8, 4.1e9)  # [s] since 1970: from 1990 to 2100
FASTEST: Final = 1e-5  # [s] between two rows; no sensor of a vehicle is faster
JITTER: Final = 0.01  # [s] by which a stamp of fine resolution may be late
_CLOCK: Final = re.compile(
    r"(\d{1,3}):(\d{2})(?::(\d{2}(?:[.,:]\d+)?)|([.,]\d+))?\s*([AaPp]\.?[Mm]\.?)?\s*(Z|UTC|GMT|[+-]\d\d:?\d\d)?"
)
_PACKED: Final = re.compile(r"(?<=[T ])(\d{2})(\d{2})(\d{2}(?:[.,]\d+)?)(Z|[+-]\d\d:?\d\d)?$")
_DATE: Final = re.compile(
    r"(?:\d{4}[-/.]\d{1,2}[-/.]\d{1,2}|\d{1,2}[-/. ](?:\d{1,2}|[A-Za-z]{3,9})[-/. ]\d{2,4}|\d{8}"
    r"|(?:[A-Za-z]{3,9},? )?[A-Za-z]{3,9} \d{1,2},?|\d+ days?)?[T ,]*"
)


RESTART: Final = 1.0  # [s] by which a clock that restarts jumps back, at least …
RUN: Final = 10  # … and rows that follow before the next restart, at least
UNKNOWN: Final = 1.5  # [s] assumed for a pause of unknown length: longer than gaps that are bridged silently


class Stamps(NamedTuple):
    """Time stamps of a file's rows."""

    t: Vec  # (n,) [s] from the first one; NaN where a cell is blank
    how: str  # how they were read, in words, for a note
    notes: tuple[str, ...] = ()
    zero: float = 0.0  # [s] first stamp on the file's own clock, which relates several tables to each other


def even_rows(mapping: str, count: int) -> Stamps:
    """Make stamps for evenly spaced rows: ``every:0.05s``, ``every:50ms`` or ``every:20Hz``.

    Raises
    ------
    InputError : the step is missing, or is not between 0.01 ms and 1 s.
    """
    text = mapping.strip()[len(EVERY) + 1 :].strip()
    found = re.fullmatch(r"([0-9.eE+-]+)\s*([A-Za-zµ]*)", text)
    try:
        value = float(found.group(1)) if found else 0.0
    except ValueError:
        value = 0.0
    unit = found.group(2) if found else ""
    step = (
        1.0 / value if unit.lower() == "hz" and value > 0.0 else value * (factor("time", unit or "s") or 0.0)
    )
    if not FASTEST <= step <= 1.0:
        bound = f"such as {EVERY}:0.05s or {EVERY}:20Hz, between {FASTEST:g} s and 1 s"
        raise InputError("t", repr(mapping), bound)
    return Stamps(
        step * np.arange(count, dtype=np.float64),
        f"rows taken as evenly spaced, {step:.6g} s, as the mapping says",
    )


def numeric_stamps(values: Vec, column: Column) -> Stamps:
    """Read the stamps in a column of numbers, which are NaN where a cell is blank.

    Raises
    ------
    InputError : the unit cannot be right, because rows would be less than 0.01 ms apart.
    """
    return _numeric(np.asarray(values, dtype=np.float64), column)


def clock_times(cells: Sequence[str], column: Column, where: Callable[[int], str]) -> Stamps:
    """Read the stamps in a column of clock times, such as ``2026-05-05T10:00:00.05Z`` or ``10:00:00.05``.

    Raises
    ------
    InputError : a cell is neither blank nor a clock time, or the time zone changes.
    """
    t = np.full(len(cells), np.nan)
    days: dict[str, int] = {}
    zones = set()
    for i, cell in enumerate(cells):
        if not cell:
            continue
        read = _clock_time(cell)
        if read is None:
            bound = "a number or a clock time such as 10:00:00.05 or 2026-05-05T10:00:00.05Z"
            raise InputError(f"{column.name!r} in {where(i)}", repr(cell), bound)
        date, seconds, zone = read
        t[i] = DAY * days.setdefault(date, len(days)) + seconds
        zones.add(zone)
    if len(zones) > 1:
        raise InputError(f"time zone in {column.name!r}", " and ".join(sorted(map(repr, zones))), "one zone")
    dated, zero = any(days), float(t[np.isfinite(t)][0]) if np.isfinite(t).any() else 0.0
    how = f"as {'dates and ' if dated else ''}clock times"
    return Stamps(t - zero if dated else _over_midnight(t), how, zero=zero)


def _numeric(values: Vec, column: Column) -> Stamps:
    known = values[np.isfinite(values)]
    if len(known) < 2:
        return Stamps(values * column.factor, f"in {column.unit}")
    packed = _packed(values)
    if packed is not None and (column.assumed or column.unit in ("s", "hhmmss")):
        return Stamps(*packed)
    unit, scale = _epoch(known) if column.assumed else (column.unit, column.factor)
    values, wrapped = _unwrapped(values, scale)
    known = values[np.isfinite(values)]
    t = (values - known[0]) * scale  # the first stamp is subtracted before scaling: stamps may be huge
    step = float(np.median(np.abs(np.diff(known)))) * scale
    if 0.0 < step < FASTEST:
        where = f"usual step of {column.name!r}, read in {unit},"
        bound = f"at least {FASTEST:g} s (map t={column.name}:UNIT, UNIT one of {READABLE['time']})"
        raise InputError(where, f"{step:.3g} s", bound)
    notes = [] if unit == column.unit else [f"t: numbers of this size are {unit} since 1970, taken as that"]
    notes += [] if wrapped is None else [f"t: {column.name!r} begins anew at {wrapped:.10g}, taken to go on"]
    return Stamps(t, f"in {unit}", tuple(notes), zero=float(known[0]) * scale)


def _unwrapped(values: Vec, scale: float) -> tuple[Vec, float | None]:
    """Undo the overflow of a counter of 16 or 32 bits, a day or a week.

    Returns
    -------
    The continuous stamps (n,), and the number at which the counter overflows, None if it does not.
    """
    at = np.flatnonzero(np.isfinite(values))
    steps = np.diff(values[at])
    back, usual = steps < 0.0, float(np.median(np.abs(steps)))
    for full in (2.0**16, 2.0**32, DAY / scale, 7.0 * DAY / scale):
        late = steps[back] + full  # the true steps if the counter overflows at this number
        if back.any() and usual < 0.01 * full and (late > 0.0).all() and (late < 10.0 * usual).all():
            out = values.copy()
            out[at] += full * np.r_[0.0, np.cumsum(back)]
            return out, full
    return values, None


def _epoch(values: Vec) -> tuple[str, float]:
    """Return the unit, and its factor, in which stamps of this size lie in 1990 to 2100; else seconds."""
    size = float(np.median(values))
    for unit, scale in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)):
        if EPOCH[0] < size * scale < EPOCH[1]:
            return unit, scale
    return "s", 1.0


def _packed(values: Vec) -> tuple[Vec, str, tuple[str, ...]] | None:
    """Read clock times written as HHMMSS.sss, if only this form explains the leaps at full minutes.

    Returns
    -------
    Times (n,) [s], the form in words, and no notes; None if the numbers are something else.
    """
    known = values[np.isfinite(values)]
    if known.min() < 0.0 or known.max() >= 240000.0:
        return None
    minutes, seconds = np.divmod(values, 100.0)
    hours, minutes = np.divmod(minutes, 100.0)
    if np.nanmax(seconds) >= 60.0 or np.nanmax(minutes) >= 60.0:
        return None
    t = _over_midnight(3600.0 * hours + 60.0 * minutes + seconds)
    leaps = np.abs(np.diff(known)) > 39.0
    if not leaps.any() or (np.abs(np.diff(t[np.isfinite(t)])[leaps]) > 2.0).any():
        return None
    return t, "as clock times HHMMSS.sss", ()


def _clock_time(cell: str) -> tuple[str, float, str] | None:
    """Return the date as written, the second of the day, and the zone; None if it is not a clock time."""
    found = _CLOCK.search(cell)
    if found is None:
        packed = _PACKED.search(cell)
        if packed is None or not _DATE.fullmatch(cell[: packed.start()]):
            return None
        hours, minutes, seconds, zone = packed.groups()
        date = cell[: packed.start()]
        return date, 3600.0 * int(hours) + 60.0 * int(minutes) + float(seconds.replace(",", ".")), zone or ""
    date, rest = cell[: found.start()], cell[found.end() :]
    if not _DATE.fullmatch(date) or not re.fullmatch(r"\s*(\d{4})?\s*", rest):
        return None
    first, second, third, fraction, half, zone = found.groups()
    if third is None and fraction is not None:  # minutes and seconds: 1:23.450
        return date, 60.0 * int(first) + float(second + fraction.replace(",", ".")), zone or ""
    hours = int(first) % 12 + 12 * (half[0] in "pP") if half else int(first)
    seconds = float(re.sub("[,:]", ".", third or "0"))
    return date, 3600.0 * hours + 60.0 * int(second) + seconds, zone or ""


def _over_midnight(t: Vec) -> Vec:
    """Return clock times (n,) [s] that continue to increase after midnight."""
    known = np.isfinite(t)
    steps = np.diff(t[known], prepend=t[known][:1])
    days = np.cumsum(steps < -0.5 * DAY)
    out = t.copy()
    out[known] += DAY * days
    return out - out[known][0] if known.any() else out


def even_out(t: Vec) -> Vec | None:
    """Return evenly spaced times (n,) for stamps (n,) [s] coarser than their rows; None for other stamps.

    Stamps that were rounded lie within one of their steps from a straight line, and fine stamps that arrive
    late lie within 10 ms of it. Where they do not, rows are missing or the rate has changed, and the times in
    between are unknown.
    """
    steps = np.diff(t)
    if (steps < 0.0).any() or not (steps > 0.0).any():
        return None
    resolution = float(np.median(steps[steps > 0.0]))
    n = len(t)
    slope, start = np.polyfit(np.arange(n), t, 1)
    line = start + slope * np.arange(n)
    if slope <= 0.0 or float(np.abs(line - t).max()) >= max(resolution, JITTER):
        return None
    return np.asarray(line, dtype=np.float64)


def resumed(t: Vec) -> tuple[Vec, Ints] | None:
    """Join the clock (n,) [s] of a recorder that was restarted; None if stamps go back for another reason.

    The length of the pause is unknown, so 1.5 s are left open. A restart returns to about the first stamp and
    continues for at least 10 rows. Stamps that go back in another way belong to rows out of order.

    Returns
    -------
    The continuous times (n,) [s], and the rows at which the clock restarts.
    """
    known = np.flatnonzero(np.isfinite(t))
    steps = np.diff(t[known])
    back = np.flatnonzero(steps < 0.0)
    runs = np.diff(np.r_[-1, back, len(known) - 1])
    if not len(back) or (steps[back] > -RESTART).any() or (runs < RUN).any():
        return None
    leaps = any((steps[k + 1 : k + RUN] > RESTART).any() for k in back)
    if leaps or (t[known[back + 1]] > t[known[0]] + RESTART).any():
        return None
    steps[back] = UNKNOWN
    out = t.copy()
    out[known] = t[known[0]] + np.r_[0.0, np.cumsum(steps)]
    return out, known[back + 1]
