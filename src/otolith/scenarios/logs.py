"""A recorded drive: from the text of a log to checked arrays in SI units, and what to know about them.

Axes x forward, y left, z up. A log in other axes is mapped with turned signs, for example
``{"ay": "-LatAcc", "yaw_rate": "-YawRate"}`` for y to the right.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

import numpy as np

from otolith.core.arrays import Mat, Vec, freeze
from otolith.core.errors import InputError
from otolith.scenarios.columns import QUANTITIES, STANDARD_GRAVITY, Column, choose
from otolith.scenarios.table import Table, split

MAX_GAP: Final = 1.0  # [s] between two rows; what lies in a longer gap cannot be guessed
MAX_ACCELERATION: Final = 50.0  # [m/s²]
MAX_RATE: Final = 20.0  # [rad/s]
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

    def __post_init__(self) -> None:
        n = len(self.t)
        freeze(self, t=(n,), force=(n, 3), rate=(n, 3))

    @property
    def duration(self) -> float:
        """Time from the first row to the last [s]."""
        return float(self.t[-1])


def parse_log(text: str, source: str, *, columns: Mapping[str, str] = _NO_MAPPING) -> Log:
    """A recorded drive from delimited text with one line of column names.

    Delimiter (comma, semicolon, tab, bar, white space), comma decimals, quotes, a row of units, comment
    lines before the header, byte order mark and line ends are recognised. Column names tell quantity and
    unit (``ax_mps2``, ``AccX [g]``, ``yaw rate (deg/s)``, ``time_ms`` …); a unit that is not stated is
    taken as SI, which a note says. Time and ``ax`` are required. If ``az`` averages about +1 g it holds
    gravity, which is removed with a note.

    Parameters
    ----------
    source : name of the file, for error sentences and notes.
    columns : where names do not tell: quantity (t, ax, ay, az, roll_rate, pitch_rate, yaw_rate, vx) ->
        ``NAME``, ``NAME:UNIT``, ``-NAME:UNIT`` to turn the sign, or ``none`` to leave it out.

    Raises
    ------
    InputError : missing or ambiguous columns, cells that are no finite numbers, ragged rows, time that
        does not increase or leaps by more than 1 s, magnitudes beyond 50 m/s² or 20 rad/s, z down.
    """
    table = split(text, source)
    chosen = choose(table.names, source, columns, table.units)
    required = [column for column in chosen if column.key != "vx"]
    raw = table.numbers(required)
    data = {column.key: raw[:, i] * column.factor for i, column in enumerate(required)}
    t = (raw[:, 0] - raw[0, 0]) * required[0].factor  # subtracted first: time stamps may be huge
    _check_time(t, table, required[0])
    notes = [_summary(t, source), *map(str, required)]
    absent = [key for key in FORCE + RATE if key not in data]
    notes += [f"not in the log, taken as zero: {', '.join(absent)}"] if absent else []
    for column in required[1:]:
        _check_magnitude(data[column.key], column, table)
    notes += _take_gravity_out(data, required, source)
    notes += _doubts(t, data, table, chosen)
    zero = np.zeros(len(t))
    return Log(
        source=source,
        t=t,
        force=np.stack([data.get(key, zero) for key in FORCE], axis=1),
        rate=np.stack([data.get(key, zero) for key in RATE], axis=1),
        columns={column.key: column.name for column in required},
        notes=tuple(notes),
    )


def _summary(t: Vec, source: str) -> str:
    steps = np.diff(t)
    spread = "" if np.ptp(steps) < 0.05 * np.median(steps) else ", unevenly sampled"
    return f"{source}: {len(t)} rows, {t[-1]:.6g} s, {1.0 / np.median(steps):.5g} Hz{spread}"


def _check_time(t: Vec, table: Table, column: Column) -> None:
    steps = np.diff(t)
    wrong = np.flatnonzero(~(steps > 0.0))
    if len(wrong):
        row = int(wrong[0]) + 1
        where = f"time in {table.where(row)}"
        raise InputError(
            where, f"{t[row]:.9g} s after the first row", f"after the row before, {t[row - 1]:.9g} s"
        )
    wide = np.flatnonzero(steps > MAX_GAP)
    if len(wide):
        row = int(wide[0]) + 1
        where = f"gap before {table.where(row)}, {t[row - 1]:.6g} s after the first row,"
        hint = f" (is time in ms? then map t={column.name}:ms)" if np.median(steps) > MAX_GAP else ""
        raise InputError(where, f"{steps[row - 1]:.6g} s", f"at most {MAX_GAP:g} s{hint}")


def _check_magnitude(values: Vec, column: Column, table: Table) -> None:
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
    where = f"{column.key} in {table.where(row)}"
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


def _doubts(t: Vec, data: dict[str, Vec], table: Table, columns: list[Column]) -> list[str]:
    """What speed says about signs and units of the other columns, where the log has a usable speed."""
    speed = next((column for column in columns if column.key == "vx"), None)
    if speed is None:
        return []
    try:
        v = table.numbers([speed])[:, 0] * speed.factor
    except InputError:
        return ["vx: not used, it has cells that are no numbers"]
    second = t.astype(np.int64)
    occupied = np.bincount(second)
    means = {
        key: np.bincount(second, values) / np.maximum(occupied, 1)
        for key, values in {**data, "vx": v}.items()
    }
    slow = means["vx"]  # (seconds,) means over whole seconds: vibration averages out
    notes = []
    if len(slow) > 10:
        gained = np.gradient(slow)
        notes += _doubt(
            "ax", "the change of speed", np.convolve(means["ax"], [0.25, 0.5, 0.25], "same"), gained
        )
    if len(slow) > 10 and "ay" in means and "yaw_rate" in means:
        notes += _doubt("ay", "speed × yaw rate", means["ay"], slow * means["yaw_rate"])
    return notes


def _doubt(key: str, other: str, values: Vec, expected: Vec) -> list[str]:
    """A note where `values` follow `expected` [m/s²] with the wrong sign or by a wrong factor."""
    if np.std(expected) == 0.0 or np.std(values) == 0.0:
        return []
    correlation = float(np.corrcoef(values, expected)[0, 1])
    factor = float(np.std(values) / np.std(expected))
    if correlation < -0.6:
        return [f"doubtful: {key} runs against {other} (correlation {correlation:.2f}); is a sign turned?"]
    if correlation > 0.8 and not 1.0 / 3.0 < factor < 3.0:
        return [f"doubtful: {key} is {factor:.2g} times {other}; are the units right (g, deg/s)?"]
    return []
