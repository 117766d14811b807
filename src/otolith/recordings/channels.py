"""Channels of a recorded drive: the form in which readers of files hand data to the checks of physics.

Every reader of a format ends here, and every check begins here. Each channel keeps the clock of its own
sensor and only its valid samples. Nothing is interpolated until `playback.log_scenario` resamples each
channel once, behind an anti-alias filter, or until a check asks for values at other times (`Channel.on`).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Final

import numpy as np

from otolith.core.arrays import Bools, Ints, Mat, Vec, freeze, frozen_array
from otolith.recordings.columns import Column

MAX_GAP: Final = 1.0  # [s] between two samples; no value is interpolated in a longer gap
FORCE: Final = ("ax", "ay", "az")
RATE: Final = ("roll_rate", "pitch_rate", "yaw_rate")
FELT: Final = FORCE + RATE  # what a driver feels; all other quantities only serve checks and maps


@dataclass(frozen=True, kw_only=True, eq=False)
class Channel:
    """One quantity of a recorded drive, in SI units, on the clock of its own sensor.

    Values have the sign and the unit that the mapping gives them. They are in axes x forward, y left, z up if
    the file or the user states the axes correctly, which the checks examine. Samples that the file leaves
    blank or marks as invalid are dropped, so a stretch without valid samples is a long step in `t`, see
    `holes`.
    """

    column: Column  # the column it comes from: name, unit, factor, why it was chosen
    t: Vec  # (n,) [s] since the start of the drive (negative before it), strictly increasing
    values: Vec  # (n,) in SI units
    rows: Ints  # (n,) number of each sample in the file, counted from 1 as `place` says
    place: str  # what `rows` counts: "line", "sample", "message", "record"
    source: str  # name of the file
    # what was repaired or looks odd; each completes a sentence that begins "ax: "
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        n = len(self.t)
        freeze(self, t=(n,), values=(n,))
        object.__setattr__(self, "rows", frozen_array(self.rows, dtype=np.int64))

    @property
    def key(self) -> str:
        """Return the quantity, one of `columns.QUANTITIES`."""
        return self.column.key

    @cached_property
    def step(self) -> float:
        """Return the median time between two samples [s]."""
        return float(np.median(np.diff(self.t))) if len(self.t) > 1 else float("inf")

    @cached_property
    def change(self) -> float:
        """Return the median absolute difference of consecutive samples, in SI units."""
        return float(np.median(np.abs(np.diff(self.values)))) if len(self.t) > 1 else 0.0

    @cached_property
    def held(self) -> float:
        """Return for how long a value usually stays the same before it changes [s]; zero if it never does."""
        return held(np.diff(self.values) == 0.0, self.t)

    @property
    def holes(self) -> Mat:
        """Return begin and end (k, 2) [s] of each stretch of more than 1 s without a valid sample."""
        wide = np.flatnonzero(np.diff(self.t) > MAX_GAP)
        return np.stack([self.t[wide], self.t[wide + 1]], axis=1)

    def on(self, t: Vec) -> Vec:
        """Return the values (k,) at times (k,) [s] by linear interpolation, constant beyond both ends.

        This serves plots and checks. It does not guard against aliasing, as the resampling of a reference
        does.
        """
        if not len(t):
            return np.empty(0)
        near = self.within(float(t.min()), float(t.max()))  # np.interp would copy the whole read-only array
        about = slice(max(near.start - 1, 0), near.stop + 1)
        return np.interp(t, self.t[about], self.values[about])

    def within(self, start: float, end: float) -> slice:
        """Return the slice of the samples from `start` to `end` [s], both included."""
        return slice(int(np.searchsorted(self.t, start)), int(np.searchsorted(self.t, end, side="right")))

    def known(self, t: Vec) -> Bools:
        """Return whether the channel has values at times (k,) [s]: not in a hole and not beyond its ends."""
        after = np.clip(np.searchsorted(self.t, t, side="left"), 1, len(self.t) - 1)
        inside = (t >= self.t[0]) & (t <= self.t[-1])
        return np.asarray(inside & (self.t[after] - self.t[after - 1] <= MAX_GAP), dtype=np.bool_)

    def where(self, index: int) -> str:
        """Describe where a sample stands in the file, for messages: ``line 7 of drive.csv``."""
        return f"{self.place} {self.rows[index]} of {self.source}"


def held(same: Bools, t: Vec) -> float:
    """Return for how long values at times (n,) usually stay the same [s].

    Parameters
    ----------
    same : (n - 1,) whether each value equals the one before it.
    """
    changes = np.r_[0, np.flatnonzero(~same) + 1]
    return float(np.median(np.diff(t[changes]))) if len(changes) > 1 else 0.0


@dataclass(frozen=True, kw_only=True)
class Layout:
    """What a reader understood of a file's form; `otolith log check` prints it."""

    form: str  # "text, columns separated by commas", "MDF 4.10", "JSON array of records", …
    header: str = ""  # where the names stand, "line 15"; empty where the format fixes it
    units: str = ""  # where a row of units stands
    first: str = ""  # where the data begin
    rows: int = 0  # rows, samples or messages of data
    clock: str = ""  # how time was read: "column 'Time' as dates and clock times"
    clock_name: str = ""  # the column that holds time; empty where channels have their own clocks
    anew: tuple[int, ...] = ()  # rows at which the clock restarts
    unused: tuple[str, ...] = ()  # names of the columns that are not used


@dataclass(frozen=True, kw_only=True, eq=False)
class Recording:
    """All channels that were chosen from a file, before any check of what their numbers mean."""

    source: str
    channels: Mapping[str, Channel]  # by quantity; quantities that the file lacks are absent
    layout: Layout
    needs: tuple[str, ...]  # quantities that will be cued; empty if unknown
    file_notes: tuple[str, ...] = ()  # sentences: what the reader of the file assumed or repaired
    notes: tuple[str, ...] = ()  # sentences: which columns were chosen and why
    # columns that were not chosen, best first
    others: Mapping[str, tuple[Channel, ...]] = field(default_factory=dict)

    def needed(self, key: str) -> bool:
        """Return whether a fault in this quantity is an error and not merely a note.

        Quantities that will be cued are needed; if it is unknown what will be cued, all forces are.
        """
        return key in (self.needs or FORCE)

    @cached_property
    def cued(self) -> Mapping[str, Channel]:
        """Return the felt channels that the drive needs; all felt channels if it needs none of them."""
        felt = {key: one for key, one in self.channels.items() if key in FELT}
        return {key: one for key, one in felt.items() if self.needed(key)} or felt

    @property
    def end(self) -> float:
        """Return the time [s] at which the first needed channel ends, which is the end of the drive."""
        return min(float(one.t[-1]) for one in self.cued.values())
