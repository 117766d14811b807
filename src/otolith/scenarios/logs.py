"""A recorded drive: from the columns of a log to checked arrays in SI units, and what to know about them.

Axes x forward, y left, z up. A log in other axes is mapped with turned signs, for example
``{"ay": "-LatAcc", "yaw_rate": "-YawRate"}`` for y to the right.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

import numpy as np

from otolith.core.arrays import Bools, Ints, Mat, Vec, freeze, frozen_array
from otolith.core.errors import InputError
from otolith.scenarios.columns import OPTIONAL_CHECKS, QUANTITIES, STANDARD_GRAVITY, Column, choose
from otolith.scenarios.plausible import check
from otolith.scenarios.recorded import Recorded
from otolith.scenarios.table import split

MAX_GAP: Final = 1.0  # [s] between two rows; what lies in a longer gap cannot be guessed
WIDE_GAP: Final = 5.0  # in usual steps: a gap that is told
MAX_ACCELERATION: Final = 50.0  # [m/s²]
MAX_RATE: Final = 20.0  # [rad/s]
SAME: Final = 0.01  # RMS difference of two columns, as a share of their RMS, at which they are taken as one
FORCE: Final = ("ax", "ay", "az")
RATE: Final = ("roll_rate", "pitch_rate", "yaw_rate")
_NO_MAPPING: Final[Mapping[str, str]] = MappingProxyType({})


@dataclass(frozen=True, slots=True, kw_only=True)
class Log:
    """A recorded drive in SI units, in axes x forward, y left, z up; quantities it lacks are zero."""

    source: str
    t: Vec  # (n,) [s] from the first row, strictly increasing
    force: Mat  # (n, 3) [m/s²] specific force without the standing 1 g
    rate: Mat  # (n, 3) [rad/s] roll, pitch, yaw rate
    columns: Mapping[str, str]  # quantity -> name of its column in the file
    notes: tuple[str, ...]  # one sentence each: what was read, assumed, removed, and looks doubtful
    place: Mat | None = None  # (n, 2) [m] where the car was, on a map, if the log tells

    def __post_init__(self) -> None:
        n = len(self.t)
        freeze(self, t=(n,), force=(n, 3), rate=(n, 3))
        if self.place is not None:
            object.__setattr__(self, "place", frozen_array(self.place))

    @property
    def duration(self) -> float:
        """Time from the first row to the last [s]."""
        return float(self.t[-1])


def parse_log(text: str, source: str, *, columns: Mapping[str, str] = _NO_MAPPING) -> Log:
    """A recorded drive from delimited text with one line of column names; see `log_from`.

    Delimiter (comma, semicolon, tab, bar, white space), comma decimals, quotes, a row of units, comment
    lines before the header, byte order mark and line ends are recognised.
    """
    return log_from(split(text, source), columns=columns)


def log_from(recorded: Recorded, *, columns: Mapping[str, str] = _NO_MAPPING) -> Log:
    """A recorded drive, checked, in SI units.

    Column names tell quantity and unit (``ax_mps2``, ``AccX [g]``, ``yaw rate (deg/s)``, ``time_ms`` …); a
    unit that is not stated is taken as SI, which a note says. Time and ``ax`` are required. If ``az``
    averages about +1 g it holds gravity, which is removed with a note; so are rows written twice and what a
    sensor that is not level adds.

    Parameters
    ----------
    columns : where names do not tell: quantity (t, ax, ay, az, roll_rate, pitch_rate, yaw_rate, vx, x, y)
        -> ``NAME``, ``NAME:UNIT``, ``-NAME:UNIT`` to turn the sign, or ``none`` to leave it out.

    Raises
    ------
    InputError : missing or ambiguous columns, numbers that are none, time that does not increase or leaps
        by more than 1 s, magnitudes beyond 50 m/s² or 20 rad/s, z down, and what `plausible.check` refuses.
    """
    source = recorded.source
    chosen = choose(
        recorded.names, source, columns, recorded.units, differ=lambda a, b: _differ(recorded, a, b)
    )
    required = [column for column in chosen if column.key not in OPTIONAL_CHECKS]
    raw, repeated = _without_repeats(recorded.numbers(required))
    rows = np.flatnonzero(~repeated).astype(np.int64)  # of the file
    data = {column.key: raw[:, i] * column.factor for i, column in enumerate(required)}
    t = (raw[:, 0] - raw[0, 0]) * required[0].factor  # subtracted first: time stamps may be huge
    _check_time(t, recorded, required[0], rows)
    notes = [*recorded.notes, _summary(t, source), *map(str, required), *_about_time(t, repeated)]
    absent = [key for key in FORCE + RATE if key not in data]
    notes += [f"not in the log, taken as zero: {', '.join(absent)}"] if absent else []
    for column in required[1:]:
        _check_magnitude(data[column.key], column, recorded, rows)
    notes += _take_gravity_out(data, required, source)
    extra = _optional(recorded, chosen, ~repeated, notes)
    checked = check(t, data, extra.get("vx"), {column.key: column for column in chosen}, source)
    for key, offset in checked.offsets.items():
        data[key] = data[key] - offset
    zero = np.zeros(len(t))
    return Log(
        source=source,
        t=t,
        force=np.stack([data.get(key, zero) for key in FORCE], axis=1),
        rate=np.stack([data.get(key, zero) for key in RATE], axis=1),
        columns={column.key: column.name for column in required},
        notes=tuple(notes + checked.notes),
        place=np.stack([extra["x"], extra["y"]], axis=1) if {"x", "y"} <= set(extra) else None,
    )


def _differ(recorded: Recorded, one: Column, other: Column) -> bool:
    """Whether two columns hold different numbers; so taken where one holds any that is none."""
    try:
        values = recorded.numbers([one, other]) * np.array([one.factor, other.factor])
    except InputError:
        return True
    size = float(np.sqrt(np.mean(values**2)))
    return float(np.sqrt(np.mean((values[:, 0] - values[:, 1]) ** 2))) > SAME * size


def _optional(recorded: Recorded, chosen: list[Column], keep: Bools, notes: list[str]) -> dict[str, Vec]:
    """Speed and place where their columns are sound; a note where they are not."""
    found = {}
    for column in chosen:
        if column.key in OPTIONAL_CHECKS:
            try:
                found[column.key] = recorded.numbers([column])[keep, 0] * column.factor
            except InputError:
                notes.append(f"{column.key}: not used, it has cells that are no numbers")
    return found


def _without_repeats(raw: Mat) -> tuple[Mat, Bools]:
    """The rows that are not the same as the one before in all that is read, and which are (n,)."""
    repeated = np.r_[False, (np.diff(raw, axis=0) == 0.0).all(axis=1)]
    return raw[~repeated], repeated


def _summary(t: Vec, source: str) -> str:
    steps = np.diff(t)
    spread = "" if np.ptp(steps) < 0.05 * np.median(steps) else ", unevenly sampled"
    return f"{source}: {len(t)} rows, {t[-1]:.6g} s, {1.0 / np.median(steps):.5g} Hz{spread}"


def _about_time(t: Vec, repeated: Bools) -> list[str]:
    """Repeated rows that were left out, and gaps that straight lines bridge."""
    notes = [f"{int(repeated.sum())} rows were written twice and left out"] if repeated.any() else []
    steps = np.diff(t)
    wide = np.flatnonzero(steps > WIDE_GAP * np.median(steps))
    if len(wide):
        longest = wide[np.argmax(steps[wide])]
        notes.append(
            f"{len(wide)} gaps bridged by straight lines, the longest of {steps[longest]:.3g} s "
            f"at {t[longest]:.5g} s"
        )
    return notes


def _check_time(t: Vec, recorded: Recorded, column: Column, rows: Ints) -> None:
    if len(t) < 2:
        raise InputError(f"number of different rows in {recorded.source}", len(t), "at least 2")
    steps = np.diff(t)
    wrong = np.flatnonzero(~(steps > 0.0))
    if len(wrong):
        row = int(wrong[0]) + 1
        where = f"time in {recorded.where(int(rows[row]))}"
        raise InputError(
            where, f"{t[row]:.9g} s after the first row", f"after the row before, {t[row - 1]:.9g} s"
        )
    wide = np.flatnonzero(steps > MAX_GAP)
    if len(wide):
        row = int(wide[0]) + 1
        where = f"gap before {recorded.where(int(rows[row]))}, {t[row - 1]:.6g} s after the first row,"
        hint = f" (is time in ms? then map t={column.name}:ms)" if np.median(steps) > MAX_GAP else ""
        raise InputError(where, f"{steps[row - 1]:.6g} s", f"at most {MAX_GAP:g} s{hint}")


def _check_magnitude(values: Vec, column: Column, recorded: Recorded, rows: Ints) -> None:
    turning = QUANTITIES[column.key][0] == "rate"
    bound, unit = (MAX_RATE, "rad/s") if turning else (MAX_ACCELERATION, "m/s²")
    row = int(np.argmax(np.abs(values)))
    if abs(values[row]) <= bound:
        return
    if column.assumed:
        other = "deg/s" if turning else "mm/s² or counts of the sensor"
        question = f"no unit is stated: is it in {other}?"
    else:
        question = f"is it really in {column.unit}?"
    where = f"{column.key} in {recorded.where(int(rows[row]))}"
    raise InputError(where, f"{values[row]:.6g} {unit}", f"within ±{bound:g} {unit} ({question})")


def _take_gravity_out(data: dict[str, Vec], columns: list[Column], source: str) -> list[str]:
    """Remove the standing 1 g from az where its mean shows that it is there."""
    if "az" not in data:
        return []
    column = next(column for column in columns if column.key == "az")
    mean = float(np.mean(data["az"]))
    where = f"mean of az in {source}"
    if mean < -0.5 * STANDARD_GRAVITY:
        way = f"turn the signs of ay, az, pitch and yaw rate, az=-{column.name}, or leave it out, az=none"
        raise InputError(where, f"{mean:.4g} m/s²", f"about 0 or +9.81 m/s²: does z point down? ({way})")
    if column.assumed and 0.9 < abs(mean) < 1.1:
        question = f"no unit is stated: is it in g? then map az={column.name}:g, and ax, ay alike"
        raise InputError(where, f"{mean:.4g} m/s²", f"about 0 or +9.81 m/s² ({question})")
    if mean <= 0.5 * STANDARD_GRAVITY:
        return []
    data["az"] = data["az"] - STANDARD_GRAVITY
    return [f"az averages {mean:.4g} m/s²: it holds gravity, 1 g was removed"]
