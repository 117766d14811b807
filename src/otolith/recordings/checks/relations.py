"""Relations of physics between the channels of a recorded drive, measured over windows of two seconds.

For a car on a level road, the mean of a_x over any window is the change of speed divided by the window's
length, the mean of a_y is that of v r, and the mean yaw rate is the turning of the course over ground. Means
over windows need no common clock, and they average vibration out. A relation that does not hold is not yet a
fault: on banks and slopes, and in vehicles that lean, forces differ by the share of gravity that the driver
feels (f_y = v r - g sin(bank)). Other modules decide what a deviation means (`remedies`, `orientation`,
`plausibility`).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from otolith.core.arrays import Bools, Vec
from otolith.recordings.channels import Channel

WINDOW: Final = 2.0  # [s]
LEAST: Final = 10  # least number of windows that shows a sign
# Least correlation of related quantities; a quiet minute recorded by a phone showed 0.77 in a_y
AGREE: Final = 0.7
# Slopes of agreement: body roll adds a tenth, a delayed or coarse speed reduces it
SLOPES: Final = (0.6, 1.6)
# Least spread of the expected values; a drive with less is too quiet to decide. It is half a degree of slope.
QUIET: Final = {"ax": 0.1, "ay": 0.1, "yaw_rate": 0.005, "vx": 0.5}  # [m/s², m/s², rad/s, m/s]
# Offsets that a sensor may have; means far beyond them are signal.
OFFSETS: Final = {"ax": 0.85, "ay": 0.85, "yaw_rate": 0.02, "vx": 0.5}


@dataclass(frozen=True, slots=True, eq=False)
class Relation:
    """How one quantity follows what others predict: measured ≈ slope · expected + constant."""

    key: str  # the quantity that is compared
    other: str  # the prediction it is compared with, in words
    by: str  # name of the witness that gives the prediction, or the same words
    start: Vec  # (k,) [s] beginnings of the windows
    measured: Vec  # (k,) means of the quantity
    expected: Vec  # (k,) what the other quantities predict
    powers: Mapping[str, int]  # quantity -> power with which its factor enters measured/expected

    @property
    def informative(self) -> bool:
        """Return whether there are enough windows, with enough motion, for a comparison."""
        if len(self.start) < LEAST:
            return False
        return self._size(self.expected) > QUIET[self.key]

    @property
    def correlation(self) -> float:
        """Return the correlation of the deviations from the means; in a long steady turn, of the values."""
        a, b = self._deviations(self.measured), self._deviations(self.expected)
        size = float(np.linalg.norm(a) * np.linalg.norm(b))
        return float(a @ b) / size if size > 0.0 else 0.0

    @property
    def slope(self) -> float:
        """Return the slope by least squares; noise in `measured` does not bias it."""
        a, b = self._deviations(self.measured), self._deviations(self.expected)
        return float(a @ b) / float(b @ b) if float(b @ b) > 0.0 else 0.0

    @property
    def slopes(self) -> tuple[float, float]:
        """Return the range of the true slope's size, for noise only in `measured` or only in `expected`."""
        low, share = abs(self.slope), max(self.correlation**2, 1e-12)
        return low, low / share

    @property
    def constant(self) -> float:
        """Return the mean of the quantity at `expected` = 0, with a slope of 1 if the relation is weak."""
        slope = self.slope if self.correlation > AGREE else 1.0
        return float(np.mean(self.measured - slope * self.expected))

    @property
    def strong(self) -> bool:
        """Return whether the two are clearly related, with either sign and any factor."""
        return self.informative and abs(self.correlation) >= AGREE

    @property
    def agrees(self) -> bool:
        """Return whether sign and size are those of a level car."""
        return self.strong and self.fits(1.0, SLOPES)

    def fits(self, factor: float, slopes: tuple[float, float]) -> bool:
        """Return whether the slope lies within `slopes` after `measured` is multiplied by `factor`."""
        low, high = (abs(factor) * size for size in self.slopes)
        return factor * self.correlation > 0.0 and low <= slopes[1] and high >= slopes[0]

    def factor(self, changes: Mapping[str, float]) -> float:
        """Return the factor on measured/expected after quantities are multiplied by `changes`."""
        result = 1.0
        for key, power in self.powers.items():
            result *= changes.get(key, 1.0) ** power
        return result

    def _size(self, values: Vec) -> float:
        return float(np.sqrt(np.mean(self._deviations(values) ** 2)))

    def _deviations(self, values: Vec) -> Vec:
        if len(values) == 0:
            return values
        mean = float(np.mean(self.expected))
        steady = abs(mean) > 2.0 * OFFSETS[self.key] and float(np.std(self.expected)) < 0.5 * abs(mean)
        return values if steady else values - np.mean(values)


def relation(
    key: str, other: str, start: Vec, measured: Vec, expected: Vec, powers: Mapping[str, int]
) -> Relation:
    """Make the relation over those windows in which both sides are known."""
    both = np.isfinite(measured) & np.isfinite(expected)
    return Relation(key, other, other, start[both], measured[both], expected[both], powers)


def windows(begin: float, end: float) -> Vec:
    """Return the starts (k,) [s] of windows of two seconds, one per second, within a drive."""
    count = int(np.floor(end - begin - WINDOW)) + 1
    return begin + np.arange(max(count, 0), dtype=np.float64)


def window_means(channel: Channel, start: Vec) -> Vec:
    """Return the means (k,) over the windows by the trapezoidal rule; NaN where the channel has a hole."""
    t, x = channel.t, channel.values
    area = np.r_[0.0, np.cumsum(0.5 * (x[1:] + x[:-1]) * np.diff(t))]

    def until(at: Vec) -> Vec:
        i = np.clip(np.searchsorted(t, at, side="right") - 1, 0, len(t) - 1)
        return np.asarray(area[i] + 0.5 * (x[i] + channel.on(at)) * (at - t[i]), dtype=np.float64)

    means = (until(start + WINDOW) - until(start)) / WINDOW
    return np.where(_covered(channel, start), means, np.nan)


def window_changes(channel: Channel, start: Vec) -> Vec:
    """Return the mean rates of change (k,) [1/s] over the windows; NaN where the channel has a hole."""
    changes = (channel.on(start + WINDOW) - channel.on(start)) / WINDOW
    return np.where(_covered(channel, start), changes, np.nan)


def _covered(channel: Channel, start: Vec) -> Bools:
    """Return which windows contain no hole, including the samples next to both ends."""
    if len(channel.t) < 2:
        return np.zeros(len(start), dtype=np.bool_)
    covered = channel.known(start) & channel.known(start + WINDOW)
    for begin, end in channel.holes:
        covered &= (start + WINDOW <= begin) | (start >= end)
    return np.asarray(covered, dtype=np.bool_)
