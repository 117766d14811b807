"""The JSON of a summary is a public format: keys, order and values are what they were."""

import json
from pathlib import Path
from typing import Any

import pytest

from otolith import metrics
from tests.metrics.stored_runs import COMPARED, STORED

KEPT = json.loads((Path(__file__).parent / "data" / "summaries.json").read_text(encoding="utf-8"))


def leaves(value: Any, path: tuple[str, ...] = ()) -> list[tuple[tuple[str, ...], Any]]:
    """Every plain value inside a JSON value with the keys that lead to it, in order."""
    if not isinstance(value, dict) or not value:
        return [(path, value)]
    return [leaf for key, inner in value.items() for leaf in leaves(inner, (*path, key))]


def assert_same(found: dict[str, Any], kept: dict[str, Any]) -> None:
    found_leaves, known = leaves(json.loads(json.dumps(found, allow_nan=False))), leaves(kept)
    assert [path for path, _ in found_leaves] == [path for path, _ in known]
    for (path, value), (_, expected) in zip(found_leaves, known, strict=True):
        assert type(value) is type(expected), path
        near = pytest.approx(expected, rel=1e-9, abs=1e-12) if isinstance(expected, float) else expected
        assert value == near, path


@pytest.mark.parametrize("name", STORED)
def test_a_summary_is_what_it_was_before_measures_had_entries(name: str) -> None:
    assert_same(metrics.summarise(STORED[name]), KEPT[name])


def test_so_is_a_comparison() -> None:
    assert_same(metrics.compare(COMPARED), KEPT["compared"])


def test_the_stored_runs_reach_every_key_figure() -> None:
    """Some summary holds a value of each entry that is neither none nor zero; but for that of the optimum,
    which a run alone does not have: see test_against_best.py."""
    found_leaves: dict[str, bool] = {}
    for summary in [*(KEPT[name] for name in STORED), *KEPT["compared"].values()]:
        for name, value in summary.items():
            found_leaves[name] = found_leaves.get(name, False) or any(leaf for _, leaf in leaves(value))
    assert all(found_leaves[name] for name in metrics.MEASURES if name != "optimum")
