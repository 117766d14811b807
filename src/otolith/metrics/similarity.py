"""The similarity of two signals in shape, delay and size, which their RMSE does not show.

Users of simulators value shape and delay above size, so Casas et al. judge motion by correlation, delay,
scale and absolute difference. Their formulas were not available, so the definitions here are our own. A
figure that is undefined, such as the correlation with a constant, is NaN.
"""

import numpy as np

from otolith.core.arrays import Vec

LARGEST_DELAY = 2.0  # [s] range that `delay` searches in both directions
STILL = 1e-12  # spread, relative to its size, below which a signal counts as constant


def correlation(wanted: Vec, felt: Vec) -> float:
    """Return Pearson's r of two series (n,), in [−1, 1]; NaN if one of them is constant."""
    w, f = wanted - np.mean(wanted), felt - np.mean(felt)
    if _still(w, wanted) or _still(f, felt):
        return float("nan")
    return float(w @ f / np.sqrt((w @ w) * (f @ f)))


def delay(wanted: Vec, felt: Vec, period: float, *, largest: float = LARGEST_DELAY) -> float:
    """Return the lag at which `felt` correlates most with `wanted` [s], positive if late.

    The means of both series (n,) are removed. The correlation at each lag is that of the overlapping stretch.
    A parabola through the maximum and its neighbours gives the fraction of a sample. For a periodic signal
    the delay is ambiguous by multiples of the period.

    Returns
    -------
    NaN if one series is constant, or if no lag within ±`largest` [s] is a maximum above 0.
    """
    w, f = wanted - np.mean(wanted), felt - np.mean(felt)
    n = len(w)
    reach = min(round(largest / period), n // 2)
    if _still(w, wanted) or _still(f, felt) or reach < 1:
        return float("nan")
    lags = np.arange(-reach, reach + 1)
    size = n + reach  # with zeros enough, no lag within reach meets the other end
    products = np.fft.irfft(np.fft.rfft(f, size) * np.fft.rfft(w, size).conj(), size)[lags]  # Σ w_i f_{i+lag}
    energy_w, energy_f = (np.concatenate([[0.0], np.cumsum(x * x)]) for x in (w, f))
    late, early = np.maximum(lags, 0), np.maximum(-lags, 0)
    known_w = energy_w[n - late] - energy_w[early]
    known_f = energy_f[n - early] - energy_f[late]
    both = np.sqrt(np.maximum(known_w * known_f, 0.0))
    alike = np.divide(products, both, out=np.full(len(lags), -1.0), where=both > STILL * (w @ w))
    best = int(np.argmax(alike))
    if best in (0, len(lags) - 1) or alike[best] <= 0.0:
        return float("nan")
    before, peak, after = alike[best - 1 : best + 2]
    curve = before - 2.0 * peak + after
    fraction = 0.5 * (before - after) / curve if curve < 0.0 else 0.0
    return float((lags[best] + fraction) * period)


def scale_ratio(wanted: Vec, felt: Vec) -> float:
    """Return mean |felt| over mean |wanted|, without unit: 1 is the same size; NaN if nothing is wanted."""
    size = float(np.mean(np.abs(wanted)))
    return float(np.mean(np.abs(felt))) / size if size > 0.0 else float("nan")


def mean_absolute_difference(wanted: Vec, felt: Vec) -> float:
    """Return the mean of |felt − wanted|, in the unit of the series."""
    return float(np.mean(np.abs(felt - wanted)))


def _still(centred: Vec, series: Vec) -> bool:
    """Return whether a series is constant apart from rounding."""
    return bool(np.max(np.abs(centred)) <= STILL * (1.0 + np.max(np.abs(series))))
