"""The transcription of the thesis's numbers, checked by the arithmetic between its tables."""

import pytest

from otolith.core.errors import InputError
from otolith_thesis import ITEMS
from otolith_thesis.loop import MODELS
from otolith_thesis.published import Row, published

PERCENTAGES = [("table-5.5", "table-5.6"), ("table-5.9", "table-5.10"), ("table-c.4", "table-c.5")]
MEANS = {"table-6.4": {"implicit-trajectory": 5.1, "hybrid-first": 5.9, "hybrid-all": 9.0}}  # section 6.3


@pytest.mark.parametrize(("counts", "percent"), PERCENTAGES)
def test_printed_percentages_follow_from_printed_iterations(counts: str, percent: str) -> None:
    for row, of_row in zip(published(counts).rows, published(percent).rows, strict=True):
        assert row["scenario"] == of_row["scenario"]
        for model in MODELS[1:]:
            saved = abs(100.0 * (1.0 - row[model] / row["implicit"]))
            assert saved == pytest.approx(of_row[model], abs=0.011), (percent, row["scenario"], model)


@pytest.mark.parametrize("percent", [percent for _, percent in PERCENTAGES])
def test_printed_averages_follow_from_printed_percentages(percent: str) -> None:
    table = published(percent)
    for model, average in table.average.items():
        mean = sum(row[model] for row in table.rows) / len(table.rows)
        assert mean == pytest.approx(average, abs=0.011), model


def test_the_lap_saves_what_the_text_says() -> None:
    for model, stated in MEANS["table-6.4"].items():
        saved = [100.0 * (1.0 - row[model] / row["implicit"]) for row in published("table-6.4").rows]
        assert sum(saved) / len(saved) == pytest.approx(stated, abs=0.06)


def _cells(table: str, key: str) -> dict[str, float]:
    return {row["scenario"]: row[key] for row in published(table).rows}


def test_tables_that_print_the_same_runs_agree_but_for_three_numbers() -> None:
    """5.3 and C.6 without a guess are one set of runs; 5.4 and 5.7 as well, with two slips in print."""
    best, alone = _cells("table-5.3", "rmse"), _cells("table-c.6", "implicit")
    assert {s: best[s] for s in alone} == alone
    adaptive, models = _cells("table-5.4", "rmse"), _cells("table-5.7", "implicit")
    assert {s for s in models if adaptive[s] != models[s]} == {"sine-1", "step-2"}
    offline = next(row for row in published("table-6.2").rows if _is_slow_sine(row))
    earlier = next(row for row in published("table-5.5").rows if row["scenario"] == "sine-0.5")
    assert {m for m in MODELS if offline[m] != earlier[m]} == {"implicit-trajectory"}  # 0.8772, 0.8771


def _is_slow_sine(row: Row) -> bool:
    return bool(row["plant"] == "offline" and row["scenario"] == "sine-0.5")


def test_every_item_with_published_numbers_has_rows_to_print() -> None:
    for name in ITEMS:
        if name.startswith(("table", "benchmark")):
            table = published(name)
            assert table.rows
            assert table.section[0] in "56BC"


def test_an_unknown_table_is_refused_with_the_nearest_name() -> None:
    with pytest.raises(InputError, match=r"table-5\.5"):
        published("table-5.55")
