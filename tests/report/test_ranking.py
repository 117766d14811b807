import math
from typing import Any

import pytest

from otolith.core.errors import InputError
from otolith.metrics import Better, Column, Measure
from otolith.report.comparison import ranking_table
from otolith.report.overview import USE, trade_panel
from otolith.report.ranking import (
    Criterion,
    criteria,
    criterion_named,
    standings,
)
from otolith.report.reasons import why

RMSE = criterion_named("rmse")


def summary(rmse: float, violations: int = 0) -> dict[str, object]:
    return {"rmse": rmse, "violations": violations}


def test_who_breaks_a_limit_comes_after_all_who_keep_them() -> None:
    ranked = standings({"one": {"a": summary(0.1, 3), "b": summary(0.9), "c": summary(0.2)}}, RMSE)
    assert [(one.cueing, one.ranks) for one in ranked] == [("c", (1,)), ("b", (2,)), ("a", (3,))]
    assert [one.wins for one in ranked] == [1, 0, 0]


def test_equal_measures_share_a_rank_and_the_next_is_left_out() -> None:
    ranked = standings({"one": {"a": summary(0.1), "b": summary(0.1), "c": summary(0.2)}}, RMSE)
    assert {one.cueing: one.ranks for one in ranked} == {"a": (1,), "b": (1,), "c": (3,)}


def test_the_mean_rank_decides_then_the_distance_to_the_best() -> None:
    by_hand = {
        "x": {"a": summary(1.0), "b": summary(2.0), "c": summary(4.0)},
        "y": {"a": summary(2.0), "b": summary(1.0), "c": summary(3.0)},
        "z": {"a": summary(1.0), "b": summary(1.0), "c": summary(1.5)},
    }
    ranked = standings(by_hand, RMSE)
    assert [one.cueing for one in ranked] == ["a", "b", "c"]
    assert [one.mean_rank for one in ranked] == pytest.approx([4 / 3, 4 / 3, 3.0])
    by_hand["x"]["a"] = summary(1.9)  # a's advantage in x is now less than b's in y
    assert [one.cueing for one in standings(by_hand, RMSE)] == ["b", "a", "c"]


def test_a_ranking_needs_the_same_algorithms_everywhere() -> None:
    with pytest.raises(ValueError, match="same algorithms"):
        standings({"x": {"a": summary(1.0)}, "y": {"b": summary(1.0)}}, RMSE)
    with pytest.raises(ValueError, match="at least one"):
        standings({}, RMSE)


def test_measures_add_up_what_the_summary_says() -> None:
    kinds = {kind: {"duration_s": 1.0} for kind in ("inverted", "unwanted", "missing", "scaled")}
    summaries = {
        "false_cues": {"surge-pitch": kinds, "sway-roll": kinds},
        "perceived_rmse": {"surge-pitch": 3.0, "sway-roll": 4.0},
        "workspace": {"surge": {"largest": 0.4}, "pitch": {"largest": 1.2}},
    }
    assert criterion_named("false-cues").of(summaries) == 6.0
    assert criterion_named("perceived").of(summaries) == 5.0
    assert USE.of(summaries) == pytest.approx(120.0)
    assert all(math.isnan(one.of({})) for one in criteria().values())


def test_an_unknown_measure_says_which_there_are() -> None:
    assert isinstance(criterion_named("perceived"), Criterion)
    with pytest.raises(InputError, match="one of rmse, perceived, false-cues"):
        criterion_named("beauty")


def test_a_limit_that_is_soft_for_one_is_held_against_none() -> None:
    def with_limit(error: float, *, soft: bool, travel: int = 0) -> dict[str, object]:
        rate = {"soft": soft, "nodes_beyond": 7}
        position = {"soft": False, "nodes_beyond": travel}
        return {"rmse": error, "violations": travel + 7 * (not soft), "limits": {"r": rate, "p": position}}

    washout, mpc = with_limit(1.0, soft=False), with_limit(2.0, soft=True)
    best, second = standings({"x": {"washout": washout, "mpc": mpc}}, RMSE)
    assert (best.cueing, best.broken, second.broken) == ("washout", (0,), (0,))
    far = with_limit(1.0, soft=False, travel=2)
    best, second = standings({"x": {"washout": far, "mpc": mpc}}, RMSE)
    assert (best.cueing, second.broken) == ("mpc", (2,))
    hard = with_limit(2.0, soft=False)
    assert {one.broken for one in standings({"x": {"a": hard, "b": washout}}, RMSE)} == {(7,)}


def greater() -> Criterion:
    """A number of which more is better."""
    column = Column("Grip", by="grip", words="Grip")
    measure = Measure(
        name="grip", words="Grip", unit="", of=None, better=Better.HIGHER, columns=(column,), section=""
    )
    return Criterion(measure, column)


def test_where_greater_is_better_the_order_turns_and_limits_still_come_first() -> None:
    by_hand = {
        "x": {"a": {"grip": 4.0}, "b": {"grip": 2.0}, "c": {"grip": 8.0, "violations": 1}},
        "y": {"a": {"grip": 2.0}, "b": {"grip": 3.0}, "c": {"grip": -1.0}},
    }
    ranked = standings(by_hand, greater())
    assert {one.cueing: one.ranks for one in ranked} == {"a": (1, 2), "b": (2, 1), "c": (3, 3)}
    # both have rank 1.5: a is behind the best by 8/4 + 3/2, b by 8/2 + 3/3
    assert [one.cueing for one in ranked] == ["a", "b", "c"]
    by_hand["y"]["a"] = {"grip": 0.5}
    assert [one.cueing for one in standings(by_hand, greater())] == ["b", "a", "c"]


def test_the_reason_says_less_where_greater_is_better() -> None:
    scenarios = {"x": {"a": {"grip": 4.0}, "b": {"grip": 3.0}, "c": {"grip": 8.0, "violations": 1}}}
    (text,) = why(scenarios, standings(scenarios, greater()), greater())
    assert text == (
        "x: a is best, grip 4; b has 25 % less. c has a greater one, 8, and is ruled out: a hard limit was "
        "passed."
    )


def test_what_turns_is_ranked_in_radians_and_told_in_degrees() -> None:
    rate = criterion_named("rate", ["yaw"])
    scenarios: Any = {"x": {"a": {"rate_rmse": {"yaw": 0.1}}, "b": {"rate_rmse": {"yaw": 0.2}}}}
    ranked = standings(scenarios, rate)
    assert ranked[0].as_json()["values"] == [pytest.approx(0.1)]
    assert why(scenarios, ranked, rate) == [
        "x: a is best, yaw rate error (RMSE) 5.73 deg/s; b has 100 % more."
    ]
    page = ranking_table(ranked, scenarios, rate)
    assert "11.46" in page
    assert "Yaw rate error (RMSE) [deg/s] in each cell, smaller is better." in page
    assert "the best" not in page
    scenarios["x"]["a"]["optimum"] = {"times": 1.25}
    assert "<small>rank 1, 1.25 × the best</small>" in ranking_table(ranked, scenarios, rate)
    panel = trade_panel(scenarios["x"], rate)
    assert panel.axes[0].label == "Yaw rate error (RMSE) [deg/s]"
    assert [float(curve.y[0]) for curve in panel.curves[:2]] == pytest.approx([5.729578, 11.459156])
