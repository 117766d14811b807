"""The similarity of two signals in shape, delay and size, which their RMSE does not show.

Users of simulators value shape and delay above size, so Casas et al. judge motion by correlation, delay,
scale and absolute difference. Their formulas were not available, so the definitions here are our own. A
figure that is undefined, such as the correlation with a constant, is NaN.
"""

from collections.abc import Iterable, Iterator

import numpy as np

from otolith.core.arrays import Ints, Vec
from otolith.metrics.parts import mean

LARGEST_DELAY = 2.0  # [s] range that `delay` searches in both directions
STILL = 1e-12  # spread, relative to its size, below which a signal counts as constant

Pairs = Iterable[tuple[Vec, Vec]]  # consecutive parts of a wanted and a felt signal, to be read repeatedly


def correlation(wanted: Vec, felt: Vec) -> float:
    """Return Pearson's r of two series (n,), in [−1, 1]; NaN if one of them is constant."""
    return correlation_in_parts([(wanted, felt)])


def delay(wanted: Vec, felt: Vec, period: float, *, largest: float = LARGEST_DELAY) -> float:
    """Return the lag at which `felt` correlates most with `wanted` [s], positive if late.

    The means of both series (n,) are removed. The correlation at each lag is that of the overlapping stretch.
    A parabola through the maximum and its neighbours gives the fraction of a sample. For a periodic signal
    the delay is ambiguous by multiples of the period.

    Returns
    -------
    NaN if one series is constant, or if no lag within ±`largest` [s] is a maximum above 0.
    """
    return delay_in_parts([(wanted, felt)], period, largest=largest)


def scale_ratio(wanted: Vec, felt: Vec) -> float:
    """Return mean |felt| over mean |wanted|, without unit: 1 is the same size; NaN if nothing is wanted."""
    return scale_in_parts([(wanted, felt)])


def mean_absolute_difference(wanted: Vec, felt: Vec) -> float:
    """Return the mean of |felt − wanted|, in the unit of the series."""
    return difference_in_parts([(wanted, felt)])


def correlation_in_parts(pairs: Pairs) -> float:
    """Return the `correlation` of signals that are given in parts."""
    centred = _Centred(pairs)
    products = np.array([(w @ f, w @ w, f @ f) for w, f in centred]).sum(axis=0)
    return float("nan") if centred.still else float(products[0] / np.sqrt(products[1] * products[2]))


def scale_in_parts(pairs: Pairs) -> float:
    """Return the `scale_ratio` of signals that are given in parts."""
    sizes = [(np.sum(np.abs(wanted)), np.sum(np.abs(felt)), len(wanted)) for wanted, felt in pairs]
    wanted, felt, samples = np.sum(sizes, axis=0)
    return float(felt / samples) / float(wanted / samples) if wanted > 0.0 else float("nan")


def difference_in_parts(pairs: Pairs) -> float:
    """Return the `mean_absolute_difference` of signals that are given in parts."""
    return float(mean(np.abs(felt - wanted) for wanted, felt in pairs))


def delay_in_parts(pairs: Pairs, period: float, *, largest: float = LARGEST_DELAY) -> float:
    """Return the `delay` of signals that are given in parts."""
    centred = _Centred(pairs)
    reach = min(round(largest / period), centred.samples // 2)
    if reach < 1:
        return float("nan")
    sums = _Sums(reach)
    for w, f in centred:
        sums.add(w, f)
    lags, alike = sums.lags, sums.alike()
    best = int(np.argmax(alike))
    if centred.still or best in (0, len(lags) - 1) or alike[best] <= 0.0:
        return float("nan")
    before, peak, after = alike[best - 1 : best + 2]
    curve = before - 2.0 * peak + after
    fraction = 0.5 * (before - after) / curve if curve < 0.0 else 0.0
    return float((lags[best] + fraction) * period)


class _Centred:
    """Two signals without their means, in parts; both are read once for the means and once for the rest."""

    def __init__(self, pairs: Pairs) -> None:
        self._pairs = pairs
        self._spread = np.zeros(2)
        sums, sizes, counts = [], [], []
        for pair in pairs:
            sums.append([np.sum(one) for one in pair])
            sizes.append([np.max(np.abs(one)) for one in pair])
            counts.append(len(pair[0]))
        self.samples = sum(counts)
        self._means, self._sizes = np.sum(sums, axis=0) / self.samples, np.max(sizes, axis=0)

    def __iter__(self) -> Iterator[tuple[Vec, Vec]]:
        """Yield the parts of both."""
        for wanted, felt in self._pairs:
            w, f = wanted - self._means[0], felt - self._means[1]
            self._spread = np.maximum(self._spread, [np.max(np.abs(w)), np.max(np.abs(f))])
            yield w, f

    @property
    def still(self) -> bool:
        """Return whether one of the two, which were iterated over, is constant apart from rounding."""
        return bool(np.any(self._spread <= STILL * (1.0 + self._sizes)))


class _Sums:
    """Sums over two signals w and f, which come in parts, for all lags from −reach to reach."""

    def __init__(self, reach: int) -> None:
        self.lags = np.arange(-reach, reach + 1)
        self._products = np.zeros(len(self.lags))  # Σ w_i f_{i+lag}
        self._size = 0.0  # Σ w_i²
        self._past = [np.zeros(0), np.zeros(0)]  # the last values of both, as many as the largest lag
        self._energies = [_Energy(reach), _Energy(reach)]

    def add(self, w: Vec, f: Vec) -> None:
        """Add the next part: its pairs with each other and with the values just before."""
        late, early = self.lags >= 0, self.lags < 0
        self._products[late] += self._of_part(w, f, self._past[0], self.lags[late], late=True)
        self._products[early] += self._of_part(w, f, self._past[1], self.lags[early], late=False)
        reach = self.lags[-1]
        self._past = [np.concatenate(pair)[-reach:] for pair in zip(self._past, (w, f), strict=True)]
        self._size += float(w @ w)
        for energy, x in zip(self._energies, (w, f), strict=True):
            energy.add(x)

    @staticmethod
    def _of_part(w: Vec, f: Vec, past: Vec, lags: Ints, *, late: bool) -> Vec:
        """Return the sums of a part at some lags; if late, the past is that of w, otherwise that of f."""
        w, f = (np.concatenate([past, w]), f) if late else (w, np.concatenate([past, f]))
        # with zeros enough, no lag meets the other end
        size = max(len(w), len(f)) + int(np.max(np.abs(lags)))
        shift = -len(past) if late else len(past)
        products: Vec = np.fft.irfft(np.fft.rfft(f, size) * np.fft.rfft(w, size).conj(), size)[lags + shift]
        return products

    def alike(self) -> Vec:
        """Return the correlation at each lag; −1 where one of the overlapping stretches is still."""
        late, early = np.maximum(self.lags, 0), np.maximum(-self.lags, 0)
        of_w, of_f = self._energies
        known = of_w.between(early, late) * of_f.between(late, early)
        both = np.sqrt(np.maximum(known, 0.0))
        alike = np.full(len(self.lags), -1.0)
        np.divide(self._products, both, out=alike, where=both > STILL * self._size)
        return alike


class _Energy:
    """The sum of squares from the start of a signal to each of its first and last values."""

    def __init__(self, reach: int) -> None:
        self._kept, self._first, self._last = reach + 1, np.zeros(1), np.zeros(1)

    def add(self, x: Vec) -> None:
        """Add the next part of the signal."""
        sums = np.cumsum(np.concatenate([self._last[-1:], x * x]))[1:]
        self._first = np.concatenate([self._first, sums[: self._kept]])[: self._kept]
        self._last = np.concatenate([self._last, sums])[-self._kept :]

    def between(self, first: Ints, left: Ints) -> Vec:
        """Return the energies without the `first` values and without the last `left` values."""
        return np.asarray(self._last[-1 - left] - self._first[first])
