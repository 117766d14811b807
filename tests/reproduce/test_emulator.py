"""The laboratory of section 6.2, on its shortest signal."""

import pytest

from otolith.report import comparison_figure
from otolith.reproduce import emulator
from otolith.reproduce.published import published


def test_rows_are_in_the_tables_order_and_hold_every_models_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(emulator, "MODELS", ("implicit",))
    monkeypatch.setattr(emulator, "SCENARIOS", {"Step signal": "step-0.1"})
    told: list[str] = []
    rows = list(emulator.table_rows(told.append))
    assert [(row["scenario"], row["plant"]) for row in rows] == [
        ("step-0.1", "emulator"),
        ("step-0.1", "offline"),
    ]
    assert told == ["implicit on step-0.1, emulator", "implicit on step-0.1, offline"]
    on, off = (row["implicit"] for row in rows)
    assert on["unsolved"] == off["unsolved"] == 0
    assert off["rmse"] < on["rmse"] < 2 * off["rmse"]


def test_the_scenarios_are_those_of_the_published_rows() -> None:
    """The combined signal apart, which the emulator runs after a longer rest."""
    names = {row["scenario"] for row in published("table-6.3").rows}
    assert names - {"combined-fast"} == set(emulator.SCENARIOS.values()) - {"combined-emulator"}


def test_a_figure_has_both_runs_under_their_names(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(emulator.FIGURES, "figure-c.8", "step:amplitude=0.1,end=2,duration=3")
    runs = emulator.figure_runs("figure-c.8")
    assert [run.cueing for run in runs] == ["offline", "emulator"]
    assert comparison_figure(runs, "surge-pitch").axes
