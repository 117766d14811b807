import re
from pathlib import Path

import pytest

from otolith.loop import Run
from otolith.metrics import compare
from otolith.report import criterion_named, render_contest, save_figure
from otolith.report.figures import overview_figure
from otolith.report.overview import false_cue_panel, overview_panels, use_panel
from otolith.report.ranking import ByCueing
from tests.report.conftest import MakeRun
from tests.report.test_html import Page

Contest = dict[str, tuple[list[Run], ByCueing]]  # by scenario

pytestmark = pytest.mark.usefixtures("light")


@pytest.fixture
def contest(make_run: MakeRun) -> Contest:
    """Two algorithms, of which the second leaves the reach, on two scenarios."""
    found: Contest = {}
    for k, scenario in enumerate(("gentle", "hard")):
        calm = make_run(300, cueing="calm", scenario=scenario, amplitude=0.3)
        bold = make_run(300, cueing="bold", scenario=scenario, amplitude=1.0 + 4.0 * k)
        found[scenario] = ([calm, bold], compare([calm, bold]))
    return found


def test_one_page_ranks_every_algorithm_on_every_scenario(contest: Contest) -> None:
    page = Page(render_contest(contest, date="today"))
    assert set(page.plots) <= set(page.ids)
    assert len(page.ids) == len(set(page.ids))
    for number in (0, 1):
        for key in ("force", "tilt", "position", "false-cues"):
            assert f"s{number}-surge-pitch-compare-{key}" in page.plots
        assert f"s{number}-reach-compare-use" in page.plots
    assert {"all-overview-rmse", "all-overview-workspace"} <= set(page.plots)
    for words in ("2 algorithms on 2 scenarios", "gentle", "hard", "Mean rank", "mean rank decides"):
        assert words in page.text
    assert page.fetched == []


def test_a_broken_limit_stands_in_the_table_and_costs_the_rank(contest: Contest) -> None:
    text = render_contest(contest, by=criterion_named("false-cues"))
    table = text[text.index("Who is best") : text.index("At a glance")]
    broken = contest["hard"][1]["bold"]["violations"]
    assert broken > 0
    assert re.search(r"hard limits passed [\d\s\u202f]+×", table)
    assert table.index(">calm<") < table.index(">bold<")


def test_false_cues_are_marked_where_they_are(contest: Contest) -> None:
    from otolith.metrics import false_cues

    runs, _ = contest["hard"]
    panel = false_cue_panel(runs, "surge-pitch")
    assert panel.over_time
    assert panel.axes[0].ticks == ("calm", "bold")
    for row, run in enumerate(runs):
        for cue in false_cues(run):
            (curve,) = [c for c in panel.curves if c.label.startswith(cue.kind)]
            drawn = curve.x.reshape(-1, 3)[curve.y.reshape(-1, 3)[:, 0] == row]
            assert any(bar[0] == cue.start and bar[1] == cue.end for bar in drawn)


def test_use_beyond_the_reach_crosses_the_line(contest: Contest) -> None:
    panel = use_panel(contest["hard"][0])
    surge = next(curve for curve in panel.curves if curve.label == "surge")
    assert surge.x[4] > 100.0 > surge.x[1]
    assert panel.x_span[1] > surge.x[4]


def test_the_overview_is_a_figure_too(contest: Contest, tmp_path: Path) -> None:
    summaries = {name: of_one for name, (_, of_one) in contest.items()}
    panels = overview_panels(summaries)
    assert panels[0].curves[1].x[0] == summaries["hard"]["calm"]["rmse"]
    save_figure(overview_figure(summaries), tmp_path / "overview.png")
    assert (tmp_path / "overview.png").stat().st_size > 10_000
