"""The thesis's statements, asked of numbers for which the answer is plain, and of the published ones."""

from otolith_thesis import claims
from otolith_thesis.loop import MODELS
from otolith_thesis.published import published


def _in_print(table: str) -> claims.Values:
    return {row["scenario"]: {model: float(row[model]) for model in MODELS} for row in published(table).rows}


def _holds(asked: list[claims.Asked]) -> list[bool]:
    return [holds for _, holds, _ in asked]


def test_the_published_counts_bear_out_what_is_said_about_them() -> None:
    assert _holds(claims.fewest(_in_print("table-5.5"))) == [True, True, True]
    assert _holds(claims.least_mean(_in_print("table-c.4"))) == [True, True]


def test_one_signal_on_which_another_model_is_best_refutes_every_signal() -> None:
    table = _in_print("table-5.5")
    table["sine-1"]["implicit"] = 0.0
    assert _holds(claims.fewest(table)) == [False, False, True]


def test_losing_the_least_is_not_saving_the_most() -> None:
    lost = {"sine-0.5": {"implicit-trajectory": -9.0, "hybrid-first": -5.0, "hybrid-all": -1.0}}
    assert _holds(claims.savings(lost)) == [False, False]
    saved = {"sine-0.5": {"implicit-trajectory": 1.0, "hybrid-first": 2.0, "hybrid-all": 3.0}}
    assert _holds(claims.savings(saved)) == [True, True]


def test_both_tells_ours_and_the_printed_figures_and_judges_ours() -> None:
    printed = _in_print("table-c.4")
    ours = {scenario: {model: 1.0 + place for place, model in enumerate(MODELS)} for scenario in printed}
    first, _ = claims.both(printed, ours, claims.least_mean)
    assert not first.holds
    assert first.figures.startswith("ours: implicit 1.00")
    assert "in print: hybrid-first" in first.figures


def test_tracking_that_a_guess_moves_far_is_not_hardly_changed() -> None:
    rows = ("sine-0.5", "sine-1", "step-1", "step-2")
    table = {row: dict.fromkeys(MODELS, 0.1 * (1 + place % 2)) for place, row in enumerate(rows)}
    assert _holds(claims.tracking(table))[1:] == [True, True]
    table["sine-1"]["hybrid-all"] += 0.05
    assert _holds(claims.tracking(table))[1] is False
