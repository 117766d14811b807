"""How late what is felt comes after what telemetry says should be felt, measured while a session runs.

Every sample of telemetry is compared with what was felt from 0.2 s before its arrival to 0.5 s after it. Sums
over all samples give the correlation at each lag, in constant memory; the delay is the lag at which it is
largest, as `otolith.metrics.similarity.delay` finds it in a run. What is felt is that of the set-points: a
machine that follows them late adds its own delay.
"""

from collections import deque
from typing import Final

import numpy as np

from otolith.core.arrays import Mat, Vec

_STEP_NS: Final = 5_000_000
LAGS_NS: Final = np.arange(-200_000_000, 500_000_001, _STEP_NS)
ENOUGH: Final = 100  # samples below which nothing is said
ALIKE: Final = 0.5  # correlation below which the two have no common shape, and so no delay
_ROOM: Final = 512  # instants that are kept, of which the latest half at least covers all lags


class FeltDelay:
    """The delay of the horizontal specific force."""

    def __init__(self) -> None:
        self._times = np.zeros(_ROOM, dtype=np.int64)
        self._felt: Mat = np.zeros((_ROOM, 2))
        self._kept = 0
        self._waiting: deque[tuple[int, Vec]] = deque()
        self.samples = 0
        self._wanted, self._wanted_squared = np.zeros(2), np.zeros(2)
        # by lag and channel: sums of what was felt, of its square, of its product with what was wanted
        self._sum, self._squared, self._product = np.zeros((3, len(LAGS_NS), 2))

    def wanted(self, arrival_ns: int, force: Vec) -> None:
        """Take in what a sample of telemetry says should be felt (3,) [m/s²]."""
        self._waiting.append((arrival_ns, force[:2].copy()))

    def felt(self, now_ns: int, force: Vec) -> None:
        """Take in what is felt now (3,) [m/s²], and compare it with the samples that are old enough."""
        if self._kept == _ROOM:
            half = _ROOM // 2
            self._times[:half], self._felt[:half] = self._times[half:], self._felt[half:]
            self._kept = half
        self._times[self._kept], self._felt[self._kept] = now_ns, force[:2]
        self._kept += 1
        while self._waiting and self._waiting[0][0] + LAGS_NS[-1] <= now_ns:
            self._compare(*self._waiting.popleft())

    def pause(self) -> None:
        """Forget what waits, since nothing is cued; what was compared counts on."""
        self._waiting.clear()
        self._kept = 0

    def _compare(self, arrival_ns: int, wanted: Vec) -> None:
        times, at = self._times[: self._kept], arrival_ns + LAGS_NS
        if at[0] < times[0]:
            return  # what was felt that early is not known
        felt = np.stack([np.interp(at, times, self._felt[: self._kept, k]) for k in range(2)], axis=1)
        self.samples += 1
        self._wanted += wanted
        self._wanted_squared += wanted * wanted
        self._sum += felt
        self._squared += felt * felt
        self._product += felt * wanted

    def correlations(self) -> Vec:
        """Return the correlation of both channels together at each of `LAGS_NS`; NaN where nothing moved."""
        n = max(1, self.samples)
        together = (self._product - self._sum * self._wanted / n).sum(axis=1)
        wanted = (self._wanted_squared - self._wanted**2 / n).sum()
        felt = (self._squared - self._sum**2 / n).sum(axis=1)
        with np.errstate(invalid="ignore", divide="ignore"):
            found: Vec = together / np.sqrt(wanted * felt)
        return found

    def __str__(self) -> str:
        """Return the delay in words."""
        found = self.correlations()
        if self.samples < ENOUGH or not np.isfinite(found).all():
            return "delay of what is felt: not known, too little was asked for"
        k = int(np.argmax(found))
        if found[k] < ALIKE or k in (0, len(found) - 1):
            return f"delay of what is felt: none found, the correlation is {found[k]:.2f} at most"
        before, peak, after = found[k - 1 : k + 2]
        between = 0.5 * (before - after) / (before - 2.0 * peak + after)
        delay_ms = round(1e-6 * (LAGS_NS[k] + between * _STEP_NS))
        return f"delay of what is felt: {delay_ms} ms after telemetry (correlation {peak:.2f})"
