"""The loops of section 6.2, on its shortest signal."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from otolith.cueing.mpc.washout_weights import PRESETS
from otolith.metrics import tracking_rmse
from otolith.report import comparison_figure
from otolith_thesis import emulator
from otolith_thesis.published import published


def test_rows_are_in_the_tables_order_and_hold_every_models_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(emulator, "MODELS", ("implicit",))
    monkeypatch.setattr(emulator, "SCENARIOS", {"Step signal": "step-0.1"})
    reports: list[str] = []
    rows = list(emulator.table_rows(reports.append))
    assert [(row["scenario"], row["plant"]) for row in rows] == [
        ("step-0.1", "emulator"),
        ("step-0.1", "offline"),
    ]
    assert reports == ["implicit on step-0.1, emulator", "implicit on step-0.1, offline"]
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


def test_recorded_commands_move_a_platform_as_they_did(monkeypatch: pytest.MonkeyPatch) -> None:
    """On the plant they were made on, bit for bit; on the servos, worse."""
    run = emulator.Case(scenario="step-0.1", where="offline", cueing="implicit", solver="structured").run()
    on_legs = emulator.in_open_loop(run)
    monkeypatch.setitem(emulator.PLANT_OF, "emulator", "ideal")
    again = emulator.in_open_loop(run)
    assert_array_equal(again.felt_force, run.felt_force)
    assert tracking_rmse(on_legs)[0] > tracking_rmse(run)[0]


def test_the_servos_and_the_feedback_each_take_their_part(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(emulator.SCENARIOS, "Combined sine wave", "combined:start=0.1,duration=2")
    errors = emulator.servo_errors()
    assert errors["offline"] < errors["servos"] < errors["emulator"]


def test_weights_are_compared_on_every_signal_and_plant(monkeypatch: pytest.MonkeyPatch) -> None:
    """Softer weights pull the platform home less and track better."""
    monkeypatch.setattr(emulator, "SCENARIOS", {"Step signal": "step-0.1"})
    names = ("thesis-fit", "thesis-fit times 0.2")
    monkeypatch.setattr(emulator, "WEIGHTS", {name: emulator.WEIGHTS[name] for name in names})
    full, fifth = emulator.weight_rows()
    assert (full["weights"], fifth["weights"]) == names
    for where in emulator.PLANT_OF:
        assert fifth["step-0.1"][where] < full["step-0.1"][where]


def test_weights_times_one_are_the_weights() -> None:
    assert emulator.scaled(1.0) == PRESETS["thesis-fit"]
    (on_velocity, _), (half, _) = emulator.scaled(1.0), emulator.scaled(0.5)
    x = np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    assert half.at(x) == 0.5 * on_velocity.at(x)


def test_a_guess_that_only_starts_hardly_changes_the_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    short = "step:amplitude=0.1,start=0.1,end=0.4,duration=0.6"
    monkeypatch.setitem(emulator.SCENARIOS, "Combined sine wave", short)
    monkeypatch.setattr(emulator, "MODELS", ("implicit", "implicit-trajectory"))
    apart = {}
    for row in emulator.entry_rows():
        apart[row["plant"], row["entry"]] = abs(row["implicit-trajectory"]["rmse"] - row["implicit"]["rmse"])
    for where in emulator.PLANT_OF:
        assert apart[where, "primal"] < 0.1 * apart[where, "reference"]
