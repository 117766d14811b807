"""A recorded drive: from the channels of a file to checked values in SI units, and what to know about them.

Axes x forward, y left, z up. A log in other axes is mapped with turned signs, for example
``{"ay": "-LatAcc", "yaw_rate": "-YawRate"}`` for y to the right.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError
from otolith.scenarios.channels import FELT, Channel, Layout
from otolith.scenarios.columns import QUANTITIES, STANDARD_GRAVITY, Column
from otolith.scenarios.plausible import check
from otolith.scenarios.reading import NO_MAPPING, recording
from otolith.scenarios.recorded import Recorded
from otolith.scenarios.span import rate, settled
from otolith.scenarios.table import split

MAX_ACCELERATION: Final = 50.0  # [m/s²]
MAX_RATE: Final = 20.0  # [rad/s]
UNEVEN: Final = 0.05  # spread of the steps, as a share of the usual one, at which sampling is called uneven


@dataclass(frozen=True, kw_only=True, eq=False)
class Log:
    """A recorded drive in SI units, in axes x forward, y left, z up; quantities it lacks are zero.

    Each channel keeps its own clock until `playback.log_scenario` resamples it. `t`, `force` and `rate` show
    the drive on the clock of its fastest channel, joined by straight lines, for looking and for checks.
    """

    source: str
    channels: Mapping[str, Channel]  # by quantity; t = 0 is where the drive begins
    duration: float  # [s]
    notes: tuple[str, ...] = ()  # one sentence each: what was read, assumed, removed, and looks doubtful
    layout: Layout | None = None  # the form of the file; None if there was none

    @cached_property
    def t(self) -> Vec:
        """The clock of the fastest channel that is felt, within the drive (n,) [s]."""
        fastest = min((one for key, one in self.channels.items() if key in FELT), key=lambda one: one.step)
        inside = fastest.t[(fastest.t >= 0.0) & (fastest.t <= self.duration)]
        return inside if len(inside) > 1 else np.array([0.0, self.duration])

    @cached_property
    def force(self) -> Mat:
        """Specific force without the standing 1 g at `t` (n, 3) [m/s²]."""
        return self.felt(self.t)[:, :3]

    @cached_property
    def rate(self) -> Mat:
        """Roll, pitch and yaw rate at `t` (n, 3) [rad/s]."""
        return self.felt(self.t)[:, 3:]

    @property
    def columns(self) -> Mapping[str, str]:
        """Quantity -> name of its column in the file."""
        return {key: one.column.name for key, one in self.channels.items() if key in FELT}

    @property
    def place(self) -> Mat | None:
        """Where the car was at `t` on a map (n, 2) [m], if the log tells."""
        if not {"x", "y"} <= self.channels.keys():
            return None
        return np.stack([self.channels["x"].on(self.t), self.channels["y"].on(self.t)], axis=1)

    def felt(self, t: Vec) -> Mat:
        """Specific force [m/s²] and angular rate [rad/s] at times (k,) [s]: (k, 6), by straight lines."""
        zero = np.zeros(len(t))
        return np.stack([self.channels[k].on(t) if k in self.channels else zero for k in FELT], axis=1)


def sampled_log(source: str, t: Vec, force: Mat, turning: Mat, *, place: Mat | None = None) -> Log:
    """A computed drive: force (n, 3) [m/s²], rate (n, 3) [rad/s] and place (n, 2) [m] at times (n,) [s]."""
    values = np.column_stack([force, turning, *([] if place is None else [place])])
    channels = {
        key: Channel(
            column=Column(key, index, key, 1.0, "", assumed=False),
            t=t - t[0],
            values=column,
            rows=np.arange(1, len(t) + 1),
            place="sample",
            source=source,
        )
        for index, (key, column) in enumerate(zip((*FELT, "x", "y"), values.T, strict=False))
    }
    return Log(source=source, channels=channels, duration=float(t[-1] - t[0]))


def parse_log(
    text: str, source: str, *, columns: Mapping[str, str] = NO_MAPPING, needs: Sequence[str] = ()
) -> Log:
    """A recorded drive from delimited text with a line of column names; see `log_from`, and `table.split`."""
    return log_from(split(text, source), columns=columns, needs=needs)


def log_from(
    recorded: Recorded, *, columns: Mapping[str, str] = NO_MAPPING, needs: Sequence[str] = ()
) -> Log:
    """A recorded drive, checked, in SI units.

    Time and what will be cued are required. If ``az`` averages about +1 g it holds gravity, which is removed
    with a note; so is what a sensor that is not level adds.

    Parameters
    ----------
    columns, needs : as in `reading.recording`.

    Raises
    ------
    InputError : what `reading.recording` and `span.settled` refuse, magnitudes beyond 50 m/s² or 20 rad/s,
        z down, and what `plausible.check` refuses.
    """
    read, duration = settled(recording(recorded, columns=columns, needs=needs))
    source, channels = read.source, dict(read.channels)
    felt = [one for key, one in channels.items() if key in FELT]
    for one in felt:
        _check_magnitude(one)
    notes = [*read.notes[: len(recorded.notes)], _summary(felt, duration, source)]
    notes += [*read.notes[len(recorded.notes) :], *(str(one.column) for one in felt)]
    notes += _grouped(felt)
    absent = [key for key in FELT if key not in channels]
    notes += [f"not in the log, taken as zero: {', '.join(absent)}"] if absent else []
    notes += _take_gravity_out(channels, source)
    drawn = Log(source=source, channels=channels, duration=duration)
    data = {key: one.on(drawn.t) for key, one in channels.items()}
    checked = check(
        drawn.t, {k: v for k, v in data.items() if k in FELT}, data.get("vx"),
        {key: one.column for key, one in channels.items()}, source,
    )  # fmt: skip
    for key, offset in checked.offsets.items():
        channels[key] = replace(channels[key], values=channels[key].values - offset)
    return Log(
        source=source,
        channels=channels,
        duration=duration,
        notes=tuple(notes + checked.notes),
        layout=read.layout,
    )


def _grouped(channels: Sequence[Channel]) -> list[str]:
    """The notes about channels, each with the names of all that it is about."""
    about: dict[str, list[str]] = {}
    for one in channels:
        for note in one.notes:
            about.setdefault(note, []).append(one.key)
    return [f"{', '.join(keys)}: {note}" for note, keys in about.items()]


def _summary(felt: Sequence[Channel], duration: float, source: str) -> str:
    """Rows, duration and the rate of each clock."""
    fastest = min(felt, key=lambda one: one.step)
    steps = np.diff(fastest.t)
    spread = "" if np.ptp(steps) < UNEVEN * np.median(steps) else ", unevenly sampled"
    others = sorted({f"{rate(one):.4g}" for one in felt} - {f"{rate(fastest):.4g}"})
    slower = f" (others {', '.join(others)} Hz)" if others else ""
    return f"{source}: {len(fastest.t)} rows, {duration:.6g} s, {rate(fastest):.5g} Hz{spread}{slower}"


def _check_magnitude(one: Channel) -> None:
    turning = QUANTITIES[one.key][0] == "rate"
    bound, unit = (MAX_RATE, "rad/s") if turning else (MAX_ACCELERATION, "m/s²")
    at = int(np.argmax(np.abs(one.values)))
    if abs(one.values[at]) <= bound:
        return
    if one.column.assumed:
        other = "deg/s" if turning else "mm/s² or counts of the sensor"
        question = f"no unit is stated: is it in {other}?"
    else:
        question = f"is it really in {one.column.unit}?"
    where = f"{one.key} in {one.where(at)}"
    raise InputError(where, f"{one.values[at]:.6g} {unit}", f"within ±{bound:g} {unit} ({question})")


def _take_gravity_out(channels: dict[str, Channel], source: str) -> list[str]:
    """Remove the standing 1 g from az where its mean shows that it is there."""
    if "az" not in channels:
        return []
    column, values = channels["az"].column, channels["az"].values
    mean = float(np.mean(values))
    where = f"mean of az in {source}"
    if mean < -0.5 * STANDARD_GRAVITY:
        way = f"turn the signs of ay, az, pitch and yaw rate, az=-{column.name}, or leave it out, az=none"
        raise InputError(where, f"{mean:.4g} m/s²", f"about 0 or +9.81 m/s²: does z point down? ({way})")
    if column.assumed and 0.9 < abs(mean) < 1.1:
        question = f"no unit is stated: is it in g? then map az={column.name}:g, and ax, ay alike"
        raise InputError(where, f"{mean:.4g} m/s²", f"about 0 or +9.81 m/s² ({question})")
    if mean <= 0.5 * STANDARD_GRAVITY:
        return []
    channels["az"] = replace(channels["az"], values=values - STANDARD_GRAVITY)
    return [f"az averages {mean:.4g} m/s²: it holds gravity, 1 g was removed"]
