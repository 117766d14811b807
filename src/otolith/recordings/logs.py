"""A recorded drive: the channels of a file become checked values in SI units, with notes on what was found.

Axes are x forward, y left, z up. A log in other axes is mapped with turned signs, for example ``{"ay":
"-LatAcc", "yaw_rate": "-YawRate"}`` where y points right.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.recordings.channels import FELT, Channel, Layout, Recording
from otolith.recordings.checks.drive import Checked, checked
from otolith.recordings.columns import QUANTITIES, Column
from otolith.recordings.reading import NO_MAPPING, recording
from otolith.recordings.recorded import Recorded
from otolith.recordings.settings import PLAIN, LogSettings
from otolith.recordings.span import rate, settled
from otolith.recordings.table import split
from otolith.recordings.units import factor

# spread of the time steps, relative to their median, above which sampling is called uneven
UNEVEN: Final = 0.05


@dataclass(frozen=True, kw_only=True, eq=False)
class Log:
    """A recorded drive in SI units, in axes x forward, y left, z up; quantities that it lacks are zero.

    Each channel keeps its own clock until `playback.log_scenario` resamples it. For plots and checks, `t`,
    `force` and `rate` give the drive on the clock of its fastest channel, by linear interpolation.
    """

    source: str
    channels: Mapping[str, Channel]  # by quantity; t = 0 is where the drive begins
    duration: float  # [s]
    notes: tuple[str, ...] = ()  # sentences: what was read, assumed or removed, and what looks doubtful
    layout: Layout | None = None  # the form of the file; None if the drive was computed
    found: Checked | None = None  # what the checks found; None if nothing was checked

    @cached_property
    def t(self) -> Vec:
        """Return the clock of the fastest felt channel within the drive (n,) [s]."""
        fastest = min((one for key, one in self.channels.items() if key in FELT), key=lambda one: one.step)
        inside = fastest.t[(fastest.t >= 0.0) & (fastest.t <= self.duration)]
        return inside if len(inside) > 1 else np.array([0.0, self.duration])

    @cached_property
    def force(self) -> Mat:
        """Return the specific force at `t` (n, 3) [m/s²], without the standing 1 g."""
        return self.felt(self.t)[:, :3]

    @cached_property
    def rate(self) -> Mat:
        """Return roll, pitch and yaw rate at `t` (n, 3) [rad/s]."""
        return self.felt(self.t)[:, 3:]

    @property
    def columns(self) -> Mapping[str, str]:
        """Return for each felt quantity the name of its column in the file."""
        return {key: one.column.name for key, one in self.channels.items() if key in FELT}

    @property
    def place(self) -> Mat | None:
        """Return the position of the car at `t` on a map (n, 2) [m]; None if the log holds no positions."""
        if not {"x", "y"} <= self.channels.keys():
            return None
        return np.stack([self.channels["x"].on(self.t), self.channels["y"].on(self.t)], axis=1)

    def felt(self, t: Vec) -> Mat:
        """Interpolate specific force [m/s²] and angular rate [rad/s] linearly at times (k,) [s]: (k, 6)."""
        zero = np.zeros(len(t))
        return np.stack([self.channels[k].on(t) if k in self.channels else zero for k in FELT], axis=1)


def sampled_log(source: str, t: Vec, force: Mat, turning: Mat, *, place: Mat | None = None) -> Log:
    """Make a log from computed values.

    Parameters
    ----------
    t : (n,) [s] times, strictly increasing.
    force : (n, 3) [m/s²] specific force without the standing 1 g.
    turning : (n, 3) [rad/s] roll, pitch and yaw rate.
    place : (n, 2) [m] position on a map, if known.
    """
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
    text: str,
    source: str,
    *,
    columns: Mapping[str, str] = NO_MAPPING,
    needs: Sequence[str] = (),
    settings: LogSettings = PLAIN,
) -> Log:
    """Read a recorded drive from delimited text with a line of names; see `log_from` and `table.split`."""
    return log_from(split(text, source), columns=columns, needs=needs, settings=settings)


def log_from(
    recorded: Recorded,
    *,
    columns: Mapping[str, str] = NO_MAPPING,
    needs: Sequence[str] = (),
    settings: LogSettings = PLAIN,
) -> Log:
    """Read and check a recorded drive; the result is in SI units and in axes x forward, y left, z up.

    Time and the quantities that will be cued are required. Signs are turned only where the file or the user
    proves that the file has other axes. If ``az`` averages about +1 g, it holds gravity, which is removed.
    Notes report both.

    Parameters
    ----------
    columns, needs : as in `reading.recording`; they are added to those in `settings`.
    settings : what the user states about the drive's axes, events and offsets.

    Raises
    ------
    InputError : `reading.recording` or `played` refuses the drive.
    """
    mapping = {**settings.columns, **columns}
    stated = recording(recorded, columns=mapping, needs=[*settings.needs, *needs])
    return played(stated, replace(settings, columns=mapping))


def played(stated: Recording, settings: LogSettings = PLAIN) -> Log:
    """Check a drive whose columns are already chosen, as `log_from` describes.

    Raises
    ------
    InputError : `span.settled` or `checks.drive.checked` refuses the drive.
    """
    read, duration = settled(stated, events=settings.events)
    felt = [one for key, one in read.channels.items() if key in FELT]
    notes = [*read.file_notes, _summary(felt, duration, read.source)]
    notes += [*read.notes, *(str(one.column) for one in felt)]
    notes += _grouped(felt)
    absent = [key for key in FELT if key not in read.channels]
    notes += [f"not in the log, taken as zero: {', '.join(absent)}"] if absent else []
    found = checked(
        read,
        duration,
        axes=settings.axes,
        events=settings.events,
        offsets=settings.offsets,
        stated_units=[key for key, text in settings.columns.items() if _states_unit(key, text)],
    )
    return Log(
        source=read.source,
        channels=found.recording.channels,
        duration=found.duration,
        notes=(*notes, *found.notes),
        layout=read.layout,
        found=found,
    )


def _states_unit(key: str, text: str) -> bool:
    """Return whether a mapping states a unit, as ``LongAcc:g`` does."""
    return factor(QUANTITIES[key][0], text.rpartition(":")[2]) is not None if ":" in text else False


def _grouped(channels: Sequence[Channel]) -> list[str]:
    """Return the notes about channels, each with the names of all channels that it concerns."""
    about: dict[str, list[str]] = {}
    for one in channels:
        for note in one.notes:
            about.setdefault(note, []).append(one.key)
    return [f"{', '.join(keys)}: {note}" for note, keys in about.items()]


def _summary(felt: Sequence[Channel], duration: float, source: str) -> str:
    """Return a sentence with the rows, the duration and the rate of each clock."""
    fastest = min(felt, key=lambda one: one.step)
    steps = np.diff(fastest.t)
    spread = "" if np.ptp(steps) < UNEVEN * np.median(steps) else ", unevenly sampled"
    others = sorted({f"{rate(one):.4g}" for one in felt} - {f"{rate(fastest):.4g}"})
    slower = f" (others {', '.join(others)} Hz)" if others else ""
    return f"{source}: {len(fastest.t)} rows, {duration:.6g} s, {rate(fastest):.5g} Hz{spread}{slower}"
