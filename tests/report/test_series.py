import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose, assert_array_equal

from otolith.core.arrays import Vec
from otolith.core.frames import GRAVITY, PAIRS
from otolith.platforms import load
from otolith.report.series import decimate, effort, extent, labels, pair_series, stairs, survival
from tests.report.conftest import MakeRun

ANY = st.floats(-1e6, 1e6) | st.just(np.nan)
COUNTS = arrays(np.int64, st.integers(0, 200), elements=st.integers(0, 30))


@given(y=arrays(float, st.integers(0, 400), elements=ANY), limit=st.integers(4, 60))
def test_decimation_keeps_extremes_ends_and_order(y: Vec, limit: int) -> None:
    x = np.arange(float(len(y)))
    x_kept, y_kept = decimate(x, y, limit)
    assert len(x_kept) == len(y_kept) <= max(limit, 0)
    assert_array_equal(y_kept, y[x_kept.astype(int)])
    assert np.all(np.diff(x_kept) > 0)
    if len(y):
        assert (x_kept[0], x_kept[-1]) == (x[0], x[-1])
        assert extent(y_kept) == extent(y)


def test_decimation_keeps_a_single_spike_among_millions() -> None:
    y = np.zeros(3_600_000)
    y[1_234_567] = 1.0
    x_kept, y_kept = decimate(np.arange(3.6e6), y)
    assert len(y_kept) <= 5_000
    assert x_kept[y_kept == 1.0] == 1_234_567


def test_short_series_are_not_touched() -> None:
    x, y = np.arange(5.0), np.arange(5.0)
    assert decimate(x, y, 5) == (x, y)


def test_decimation_needs_room_for_ends_and_extremes() -> None:
    with pytest.raises(ValueError, match="limit is 3, must be at least 4"):
        decimate(np.zeros(9), np.zeros(9), 3)


@given(counts=COUNTS, limit=st.integers(1, 40))
def test_stairs_show_the_maximum_of_each_stretch(counts: Vec, limit: int) -> None:
    edges, heights = stairs(np.arange(float(len(counts))), counts, 1.0, limit)
    assert len(edges) == len(heights) <= limit + 1
    for low, high, height in zip(edges[:-1], edges[1:], heights[:-1], strict=True):
        assert height == counts[int(low) : int(high)].max()
    if len(counts):
        assert (edges[0], edges[-1]) == (0, len(counts))


@given(counts=COUNTS)
def test_survival_is_the_share_of_counts_at_least_k(counts: Vec) -> None:
    k, share = survival(counts)
    assert_allclose(share, [np.mean(counts >= value) for value in k])
    assert len(k) == (counts.max() + 1 if len(counts) else 0)


@pytest.mark.parametrize("pair", sorted(PAIRS))
def test_the_two_parts_add_up_to_the_felt_force(make_run: MakeRun, pair: str) -> None:
    run = make_run(100, dofs=("surge-pitch", "sway-roll"))
    s = pair_series(run, pair)
    assert_allclose(s.translation.y + s.gravity.y, s.felt.y, atol=1e-12)
    assert np.abs(s.gravity.y).max() > 0.1


def test_tilt_has_the_sign_of_its_own_force(make_run: MakeRun) -> None:
    run = make_run(100)
    s = pair_series(run, "surge-pitch")
    assert_allclose(s.gravity.y, GRAVITY * np.sin(np.deg2rad(s.tilt_deg.y)), atol=1e-12)
    assert_allclose(s.tilt_deg.y, -np.rad2deg(run.pose[:, 4]))
    assert_allclose(s.tilt_rate_deg.y, -np.rad2deg(run.twist[:, 4]))
    assert_array_equal(s.position.y, run.pose[:, 0])
    assert_array_equal(s.velocity.y, run.twist[:, 0])


def test_limits_are_the_platform_files(make_run: MakeRun) -> None:
    s = pair_series(make_run(10, platform=load("davsi")), "surge-pitch")
    assert_allclose(s.position_band, (-0.51, 0.63))
    assert_allclose(s.velocity_band, (-0.81, 0.81))
    assert_allclose(s.tilt_band_deg, (-24.3, 24.3))
    assert_allclose(s.tilt_rate_band_deg, (-3.0, 3.0))


def test_troubled_decisions_are_told_apart_by_status(make_run: MakeRun) -> None:
    run = make_run(4, status=("decided", "refused", "decided", "invalid"))
    troubled = effort(run).troubled()
    assert {name: list(where) for name, where in troubled.items()} == {"invalid": [3], "refused": [1]}


def test_runs_of_one_cueing_get_distinct_labels(make_run: MakeRun) -> None:
    names = [make_run(2, cueing=name) for name in ("a", "b", "a", "a")]
    assert labels(names) == ("a", "b", "a (2)", "a (3)")
