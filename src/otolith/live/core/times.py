"""Durations by the million in constant memory: counts in bins whose widths grow with the duration.

A process that must wake in time can note every tick of hours without asking for memory. Sixteen bins per
octave tell a percentile to 4.5 %; it is rounded up.
"""

import math
from dataclasses import dataclass, field
from typing import Final

PER_OCTAVE: Final = 16
_BINS: Final = 40 * PER_OCTAVE  # up to 2⁴⁰ ns, 18 minutes


@dataclass(slots=True)
class Times:
    """Durations [ns]; one that is not positive counts as 1 ns."""

    count: int = 0
    largest: int = 0
    bins: list[int] = field(default_factory=lambda: [0] * _BINS)

    def note(self, duration: int) -> None:
        """Take in one duration [ns]."""
        self.count += 1
        self.largest = max(self.largest, duration)
        self.bins[min(_BINS - 1, int(PER_OCTAVE * math.log2(max(1, duration))))] += 1

    def share(self, share: float) -> float:
        """Return the duration [ns] that a share of all does not exceed; NaN where there are none."""
        if self.count == 0:
            return math.nan
        left = share * self.count
        for k, count in enumerate(self.bins):
            left -= count
            if left <= 1e-9 * self.count:
                edge: float = 2.0 ** ((k + 1) / PER_OCTAVE)
                return min(float(self.largest), edge)
        return float(self.largest)

    def __str__(self) -> str:
        """Return median, p99, p99.9 and the largest in milliseconds."""
        if self.count == 0:
            return "none"
        figures = (self.share(0.5), self.share(0.99), self.share(0.999), float(self.largest))
        words = ("median", "p99", "p99.9", "most")
        return ", ".join(f"{word} {1e-6 * ns:.3g}" for word, ns in zip(words, figures, strict=True)) + " ms"
