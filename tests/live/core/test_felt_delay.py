"""The delay of what is felt, for motions whose delay is known."""

import numpy as np
import pytest

from otolith.live.core.felt_delay import LAGS_NS, FeltDelay

MS = 1_000_000


def signal(t: float) -> np.ndarray:
    """A force that does not repeat itself."""
    return np.array([np.sin(2.1 * t) + 0.6 * np.sin(5.3 * t + 1.0), 0.8 * np.sin(3.7 * t + 0.4), 0.0])


def played(late: float, size: float = 1.0, *, seconds: float = 20.0, share: float = 0.5) -> FeltDelay:
    """Telemetry at 60 Hz; felt, `late` [s] after it and of another size, at decisions at uneven times."""
    delay, rng = FeltDelay(), np.random.default_rng(3)
    arrivals = [round(k * 1e9 / 60) for k in range(round(60 * seconds))]
    decisions = np.cumsum(rng.integers(5 * MS, 10 * MS, round(seconds / 0.0075)))
    events = sorted([(t, 0) for t in arrivals] + [(int(t), 1) for t in decisions])
    for now, kind in events:
        if kind == 0:
            delay.wanted(now, signal(1e-9 * now) + 0.3)  # a slope under the wheels is no delay
        else:
            delay.felt(now, size * signal(1e-9 * now - late))
    return delay


@pytest.mark.parametrize(
    ("late", "words"), [(0.0, "0 ms"), (0.037, "37 ms"), (0.31, "310 ms"), (-0.05, "-50 ms")]
)
def test_a_known_delay_is_found_whatever_the_size(late: float, words: str) -> None:
    for size in (1.0, 0.4):
        assert f": {words} after telemetry (correlation 1.00)" in str(played(late, size))


def test_the_correlation_of_one_lag_is_pearsons() -> None:
    """At decisions every millisecond, by numpy, over all samples that have been compared."""
    delay = FeltDelay()
    rng = np.random.default_rng(5)
    times = [k * 5 * MS for k in range(400)]
    wanted, felt = rng.normal(size=(2, 400, 3))
    for t, w, f in zip(times, wanted, felt, strict=True):
        delay.wanted(t, w)
        delay.felt(t, f)
    ahead, after = int(-LAGS_NS[0] // (5 * MS)), int(LAGS_NS[-1] // (5 * MS))
    w = wanted[ahead : len(times) - after, :2]
    f = felt[ahead + 10 : len(times) - after + 10, :2]  # 50 ms later
    w, f = w - w.mean(axis=0), f - f.mean(axis=0)
    expected = np.sum(w * f) / np.sqrt(np.sum(w * w) * np.sum(f * f))
    at = int(np.flatnonzero(LAGS_NS == 50 * MS)[0])
    assert delay.samples == len(w)
    assert delay.correlations()[at] == pytest.approx(expected, abs=1e-12)


def test_nothing_is_claimed_where_nothing_moves_or_nothing_fits() -> None:
    assert "too little" in str(FeltDelay())
    still = FeltDelay()
    for k in range(400):
        still.wanted(k * 10 * MS, np.zeros(3))
        still.felt(k * 10 * MS, np.zeros(3))
    assert "too little" in str(still)
    other, rng = FeltDelay(), np.random.default_rng(1)
    for k in range(2000):
        other.wanted(k * 10 * MS, rng.normal(size=3))
        other.felt(k * 10 * MS, rng.normal(size=3))
    assert "none found" in str(other)


def test_a_pause_is_not_bridged() -> None:
    delay = played(0.05)
    before = delay.samples
    delay.pause()
    late = 60_000 * MS
    delay.wanted(late, np.ones(3))
    delay.felt(late + 600 * MS, np.ones(3))
    assert delay.samples == before
