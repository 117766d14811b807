"""The explicit tables of the thesis, those that take seconds."""

import pytest

from otolith.reproduce import TABLES, reproduce
from otolith.reproduce.published import published


def test_every_table_has_published_rows_and_a_case() -> None:
    for name in TABLES:
        title, rows = published(name)
        assert title.lower().startswith(name.replace("-", " ", 1))
        assert rows


def test_table_c1_agrees_where_regions_are_a_partition() -> None:
    """Without limits on the inputs many active sets share a law; the published counts then hold overlaps.

    Ours are partitions (`otolith.mpqp.verify` finds no overlap and nothing missing), so they are smaller.
    """
    told: list[str] = []
    table = reproduce("table-c.1", told.append)
    assert len(told) == len(table.rows) == 5
    for row in table.rows[:3]:
        assert row["our_regions"] == pytest.approx(row["regions"], rel=0.03), row["constraints"]
    for row in table.rows[3:]:
        assert 0.7 * row["regions"] < row["our_regions"] < row["regions"]


def test_table_c2_shows_what_braking_rows_bring() -> None:
    for row in reproduce("table-c.2", lambda _: None).rows:
        assert row["our_rmse_with"] < row["our_rmse_without"]
        assert row["our_rmse_with"] == pytest.approx(row["rmse_with"], rel=0.2)


def test_the_benchmark_controller_uses_its_rail_and_stays_on_it() -> None:
    rows = reproduce("benchmark-c.2", lambda _: None).rows
    for row in rows:
        assert row["our_violations"] == 0
        assert 0.1 < row["our_travel"] <= 2.6
        assert row["our_rmse"] < 0.4
