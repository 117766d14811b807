"""The measurement of STOP in a live session: the order comes before what it causes."""

from pathlib import Path

from otolith.cli.commander import _live_stops
from otolith.commander.bench_live import WAYS, live_table


def test_the_order_is_in_memory_before_set_points_return(tmp_path: Path) -> None:
    found = _live_stops(tmp_path, 2)
    assert found["count"] == 2
    for way in WAYS:
        assert 0.0 < found[f"{way}_order_p50_ms"] <= found[f"{way}_return_p50_ms"] + 1.0  # [ms] of a report
        assert found[f"{way}_return_p99_ms"] < 5_000.0
    lines = live_table(found)
    assert len(lines) == 4
    assert all(" ms" in figure for _, figure, _ in lines)
