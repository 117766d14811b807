"""Percentiles of bins, against numpy's of the durations themselves."""

import math

import numpy as np
import pytest

from otolith.live.core.times import Times


def test_percentiles_are_those_of_all_durations_rounded_up_by_a_bin() -> None:
    rng = np.random.default_rng(0)
    durations = rng.lognormal(11.0, 1.5, 20_000).astype(int)
    times = Times()
    for duration in durations:
        times.note(int(duration))
    for share in (0.01, 0.5, 0.99, 0.999):
        true = float(np.quantile(durations, share, method="inverted_cdf"))
        assert true <= times.share(share) <= true * 2 ** (1 / 16) * (1 + 1e-12)
    assert times.share(1.0) == times.largest == durations.max()


@pytest.mark.parametrize("duration", [-5, 0, 1, 2**50])
def test_any_duration_has_a_bin(duration: int) -> None:
    times = Times()
    times.note(duration)
    assert sum(times.bins) == times.count == 1


def test_without_durations_there_is_no_percentile() -> None:
    assert math.isnan(Times().share(0.5))
    assert str(Times()) == "none"
