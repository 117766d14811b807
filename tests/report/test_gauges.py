"""Six figures, each between two facts."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from otolith.metrics import Reading, summarise
from otolith.platforms import load
from otolith.report.gauges import DOCS, gauges, gauges_html
from tests.report.conftest import MakeRun


def by_title(summary: dict[str, Any]) -> dict[str, Reading]:
    return {gauge.scale.title: gauge.reading for gauge in gauges(summary)}


def test_a_platform_that_stands_still_is_at_the_end_of_the_scale(make_run: MakeRun) -> None:
    """Nothing is felt: the error is all of what was wanted, whatever was wanted."""
    still = np.zeros((4000, 6))
    for amplitude in (0.1, 1.0):
        run = make_run(
            400, amplitude=amplitude, pose=still, twist=still, acceleration=still, felt_force=still[:, :3]
        )
        found = by_title(summarise(run))
        assert found["Tracking error"].share == pytest.approx(1.0)
        assert found["Reach used"].share == 0.0


def test_what_is_felt_as_wanted_is_at_its_beginning(make_run: MakeRun) -> None:
    run = make_run(400)
    found = by_title(summarise(make_run(400, felt_force=run.reference_force)))
    assert found["Tracking error"].share == 0.0
    assert found["Same shape"].value == "1.00"
    assert found["Same shape"].share == pytest.approx(0.0, abs=1e-9)
    assert found["Misled"].share == 0.0


def test_the_worst_degree_of_freedom_is_named(make_run: MakeRun) -> None:
    summary = summarise(make_run(400, dofs=("surge-pitch", "sway-roll")))
    summary["correlation"] = {"surge-pitch": 0.9, "sway-roll": -0.25}
    shape = by_title(summary)["Same shape"]
    assert (shape.value, shape.share) == ("−0.25", 1.25)
    assert "sway-roll" in shape.words


def test_beyond_its_scale_a_figure_says_so() -> None:
    summary = {
        "period_s": 0.01,
        "step_time_us": {"max": 2.5e4, "median": 100.0},
        "workspace": {"surge": {"largest": 0.2}, "pitch": {"largest": 1.5}},
    }
    found = by_title(summary)
    assert found["Slowest decision"].share == pytest.approx(2.5)
    assert found["Reach used"].value == "150 % of pitch"
    text = gauges_html(summary)
    assert text.count('class="scale beyond"') == 2
    assert text.count("width: 100.0%") == 2


def test_yaw_alone_is_measured_by_its_rate_in_degrees(make_run: MakeRun) -> None:
    rate = np.zeros((600, 3))
    rate[:, 2] = 0.1
    run = make_run(60, dofs=("yaw",), platform=load("davsi"), reference_rate=rate)
    error = by_title(summarise(run))["Tracking error"]
    assert error.value == "5.73 deg/s"
    assert error.share == pytest.approx(1.0)


def test_every_figure_points_to_a_heading_of_its_page(make_run: MakeRun) -> None:
    page = Path(__file__).parents[2] / DOCS
    headings = {
        line.lstrip("# ").strip() for line in page.read_text(encoding="utf-8").splitlines() if line[:1] == "#"
    }
    found = gauges(summarise(make_run(400)))
    assert len(found) == 5
    assert {gauge.section for gauge in found} <= headings


def test_what_a_summary_does_not_hold_has_no_gauge() -> None:
    assert gauges({}) == []
    nothing_wanted = {"rmse_per_pair": {"surge-pitch": 0.0}, "wanted_rms": {"surge-pitch": 0.0}}
    assert gauges(nothing_wanted) == []
