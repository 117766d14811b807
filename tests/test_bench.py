"""The benchmark times what it says it times: the same problems, the same answers."""

import sys
from itertools import product

import numpy as np
import pytest

from otolith.bench import ENGINES, FORMS, SPARSE, bench, installed_peers
from otolith.core.frames import SURGE_PITCH
from otolith.platforms import load
from otolith.report.timing import StepTimes, step_time_figure


def test_every_engine_answers_the_same_problems_alike() -> None:
    told: list[str] = []
    found = bench(load("thesis"), [(SURGE_PITCH,)], names=["step:duration=2"], passes=1, progress=told.append)
    assert [(f["form"], f["engine"]) for _, f in found] == list(product(FORMS, ENGINES))
    assert len(told) == len(FORMS) * (1 + len(ENGINES))
    for timing, figures in found:
        assert figures["steps"] == 200
        assert figures["certified"] == 1.0
        assert figures["residual_max"] < 1e-6
        assert figures["first_input_gap"] < 1e-5  # both certified to 1e-6 in stationarity, R is 1e-3
        assert 0 < figures["median_us"] <= figures["p99_us"] <= figures["max_us"]
        np.testing.assert_array_equal(timing.times > 0, True)
    assert found[-1][1]["times_faster_than_dense"] == pytest.approx(1.0)


def test_peers_answer_every_so_many_of_the_full_forms_problems() -> None:
    quick = {"dense": ENGINES["dense"]}
    found = bench(
        load("thesis"), [(SURGE_PITCH,)], names=["step:duration=2"], passes=1, engines=quick, peers=quick
    )
    assert [(f["form"], f["steps"]) for _, f in found] == [
        ("full", 200),
        ("full", 200 // SPARSE),
        ("blocked", 200),
    ]
    assert found[1][1]["first_input_gap"] < 1e-7  # beside its own answers to the same problems


def test_peers_that_are_absent_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "casadi", None)
    monkeypatch.delitem(sys.modules, "otolith.qp.casadi", raising=False)
    told: list[str] = []
    assert installed_peers(told.append) == {}
    assert [line.split(":")[0] for line in told] == ["without casadi-hpipm", "without casadi-qpoases"]


def test_the_figure_holds_every_step() -> None:
    times = np.array([1e-5, 2e-5, 4e-5])
    drawn = [
        ("2 DOF", "a", "full", times),
        ("2 DOF", "b", "full", 2 * times),
        ("4 DOF", "a", "blocked", times),
    ]
    upper, lower = step_time_figure([StepTimes(*one) for one in drawn]).axes
    lines = [line for line in upper.get_lines() if len(np.asarray(line.get_xdata())) == 3]
    np.testing.assert_allclose(np.asarray(lines[0].get_xdata()), [10, 20, 40])
    np.testing.assert_allclose(np.asarray(lines[1].get_ydata()), [1, 2 / 3, 1 / 3])
    (other,) = (line for line in lower.get_lines() if len(np.asarray(line.get_xdata())) == 3)
    assert other.get_color() == lines[0].get_color() != lines[1].get_color()  # a colour is an engine
    assert other.get_linestyle() != lines[0].get_linestyle()  # a kind of line is a form
    assert lower.get_xlabel() == "step time [µs], thread CPU"
