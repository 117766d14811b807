"""Channels of a recorded drive: what passes from the readers of files to the checks of physics.

Every reader of a format ends here, and every check begins here. Each channel keeps the clock of its own
sensor and only its valid samples; nothing is interpolated until `playback.log_scenario` resamples each
channel once, behind an anti-alias filter, or until a check asks for values at other times (`Channel.on`).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Final

import numpy as np

from otolith.core.arrays import Bools, Ints, Mat, Vec, freeze, frozen_array
from otolith.recordings.columns import Column

MAX_GAP: Final = 1.0  # [s] between two samples; what lies in a longer gap cannot be guessed
FORCE: Final = ("ax", "ay", "az")
RATE: Final = ("roll_rate", "pitch_rate", "yaw_rate")
FELT: Final = FORCE + RATE  # what a driver feels; every other quantity only serves checks and maps


@dataclass(frozen=True, kw_only=True, eq=False)
class Channel:
    """One quantity of a recorded drive, in SI units, on the clock of its own sensor.

    Values stand as the file states them, after the mapping's sign and unit: in x forward, y left, z up if
    the file or the user is right about it, which is for the checks to find out. Samples that the file leaves
    blank or marks as invalid are not here: a stretch without valid samples is a long step in `t`, see
    `holes`.
    """

    column: Column  # where it comes from: name, unit, factor, why this one
    t: Vec  # (n,) [s] since the start of the drive (negative before it), strictly increasing
    values: Vec  # (n,) in SI units
    rows: Ints  # (n,) number of each sample in the file, counted from 1 as `place` says
    place: str  # what `rows` counts: "line", "sample", "message", "record"
    source: str  # name of the file
    notes: tuple[str, ...] = ()  # what was repaired or looks odd, as ends of the sentence "ax: …"

    def __post_init__(self) -> None:
        n = len(self.t)
        freeze(self, t=(n,), values=(n,))
        object.__setattr__(self, "rows", frozen_array(self.rows, dtype=np.int64))

    @property
    def key(self) -> str:
        """The quantity, one of `columns.QUANTITIES`."""
        return self.column.key

    @cached_property
    def step(self) -> float:
        """Usual time between two samples [s]."""
        return float(np.median(np.diff(self.t))) if len(self.t) > 1 else float("inf")

    @cached_property
    def change(self) -> float:
        """Usual size of the change from one sample to the next, in SI units."""
        return float(np.median(np.abs(np.diff(self.values)))) if len(self.t) > 1 else 0.0

    @cached_property
    def held(self) -> float:
        """How long a value usually stands before it changes [s]; zero if it never does."""
        return held(np.diff(self.values) == 0.0, self.t)

    @property
    def holes(self) -> Mat:
        """Stretches without a valid sample that are longer than 1 s: beginning and end of each (k, 2) [s]."""
        wide = np.flatnonzero(np.diff(self.t) > MAX_GAP)
        return np.stack([self.t[wide], self.t[wide + 1]], axis=1)

    def on(self, t: Vec) -> Vec:
        """Values (k,) at times (k,) [s], joined by straight lines, constant beyond the ends.

        For looking and for checks: it does not guard against aliasing, as the resampling for a reference
        does.
        """
        if not len(t):
            return np.empty(0)
        near = self.within(float(t.min()), float(t.max()))  # np.interp copies all that is read-only
        about = slice(max(near.start - 1, 0), near.stop + 1)
        return np.interp(t, self.t[about], self.values[about])

    def within(self, start: float, end: float) -> slice:
        """The samples from `start` to `end` [s], both included."""
        return slice(int(np.searchsorted(self.t, start)), int(np.searchsorted(self.t, end, side="right")))

    def known(self, t: Vec) -> Bools:
        """Return whether the channel has a value at times (k,) [s]: not in holes, nor beyond its ends."""
        after = np.clip(np.searchsorted(self.t, t, side="left"), 1, len(self.t) - 1)
        inside = (t >= self.t[0]) & (t <= self.t[-1])
        return np.asarray(inside & (self.t[after] - self.t[after - 1] <= MAX_GAP), dtype=np.bool_)

    def where(self, index: int) -> str:
        """Where a sample stands in the file, for sentences: ``line 7 of drive.csv``."""
        return f"{self.place} {self.rows[index]} of {self.source}"


def held(same: Bools, t: Vec) -> float:
    """How long values at times (n,) usually stand [s], where (n - 1,) says which equal the one before."""
    changes = np.r_[0, np.flatnonzero(~same) + 1]
    return float(np.median(np.diff(t[changes]))) if len(changes) > 1 else 0.0


@dataclass(frozen=True, kw_only=True)
class Layout:
    """What a reader understood of a file's form; `otolith log check` prints it."""

    form: str  # "text, columns parted by commas", "MDF 4.10", "JSON array of records", …
    header: str = ""  # where the names stand, "line 15"; empty where the format says it
    units: str = ""  # where a row of units stands
    first: str = ""  # where the data begin
    rows: int = 0  # rows, samples or messages of data
    clock: str = ""  # how time was read: "column 'Time' as dates and clock times"
    clock_name: str = ""  # the column that holds time; empty where channels have their own clocks
    anew: tuple[int, ...] = ()  # rows at which the clock starts anew, as one that was restarted
    unused: tuple[str, ...] = ()  # names of columns that nothing uses


@dataclass(frozen=True, kw_only=True, eq=False)
class Recording:
    """All channels that were chosen in a file, before any check of what their numbers mean."""

    source: str
    channels: Mapping[str, Channel]  # by quantity; those that the file lacks are not in it
    layout: Layout
    needs: tuple[str, ...]  # quantities that will be cued; empty: nobody has said
    file_notes: tuple[str, ...] = ()  # a sentence each: what the reader of the file assumed or repaired
    notes: tuple[str, ...] = ()  # a sentence each: what was chosen of it
    others: Mapping[str, tuple[Channel, ...]] = field(default_factory=dict)  # second candidates, best first

    def needed(self, key: str) -> bool:
        """Return whether a fault in this quantity is refused and not only said.

        So it is for what will be cued; where nobody says what, for every force.
        """
        return key in (self.needs or FORCE)

    @cached_property
    def cued(self) -> Mapping[str, Channel]:
        """The channels that a driver feels and that the drive needs; all that are felt if it needs none."""
        felt = {key: one for key, one in self.channels.items() if key in FELT}
        return {key: one for key, one in felt.items() if self.needed(key)} or felt

    @property
    def end(self) -> float:
        """When the first of the channels that the drive needs ends [s]; there the drive ends."""
        return min(float(one.t[-1]) for one in self.cued.values())
