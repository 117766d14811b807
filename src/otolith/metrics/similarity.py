"""How alike two signals are in shape, time and size, beside their RMSE.

Users of simulators weigh shape and delay above size, so Casas et al. judge motion by correlation, delay,
scale and absolute difference. Their formulas were not at hand: the definitions here are our own. What is
not defined for a signal, such as the correlation with a constant, is NaN.
"""

import numpy as np

from otolith.core.arrays import Vec

LARGEST_DELAY = 2.0  # [s] the range in which `delay` looks, either way
STILL = 1e-12  # spread, relative to size, below which a signal counts as constant


def correlation(wanted: Vec, felt: Vec) -> float:
    """Pearson's r of two series (n,), in [−1, 1], no unit; NaN when one of them is constant."""
    w, f = wanted - np.mean(wanted), felt - np.mean(felt)
    if _still(w, wanted) or _still(f, felt):
        return float("nan")
    return float(w @ f / np.sqrt((w @ w) * (f @ f)))


def delay(wanted: Vec, felt: Vec, period: float, *, largest: float = LARGEST_DELAY) -> float:
    """Lag at which `felt` correlates most with `wanted` [s], finer than the samples; positive when late.

    Both series (n,) lose their means. At each lag the correlation is that of the stretch on which both
    are known; a parabola through the largest value and its neighbours gives the fraction of a sample. A
    periodic signal has its period's ambiguity.

    Returns
    -------
    NaN when one series is constant, or when no lag within ±`largest` [s] is a maximum above 0.
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
    """Mean |felt| over mean |wanted|, no unit: 1 keeps the size; NaN when nothing is wanted."""
    size = float(np.mean(np.abs(wanted)))
    return float(np.mean(np.abs(felt))) / size if size > 0.0 else float("nan")


def mean_absolute_difference(wanted: Vec, felt: Vec) -> float:
    """Mean |felt − wanted|, in the unit of the series."""
    return float(np.mean(np.abs(felt - wanted)))


def _still(centred: Vec, series: Vec) -> bool:
    """Return whether a series is constant but for rounding."""
    return bool(np.max(np.abs(centred)) <= STILL * (1.0 + np.max(np.abs(series))))
