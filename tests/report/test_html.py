import base64
import json
from dataclasses import replace
from html.parser import HTMLParser
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from otolith.core.arrays import Vec
from otolith.loop import Run
from otolith.loop.run import SAMPLED
from otolith.metrics import compare, summarise
from otolith.platforms import load
from otolith.report import render, render_comparison, render_contest
from otolith.report.series import MAX_POINTS
from tests.report.conftest import MakeRun

EVIL = '</script><script>alert("1")</script><b>&amp;$x$'
VOID = {"meta", "link", "img", "br", "hr", "input"}
FETCHING = {"src", "href", "data", "action", "poster", "srcset", "background"}


class Page(HTMLParser):
    """Well-formedness, texts, scripts and everything that a browser would fetch."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.fetched: list[str] = []
        self.links: list[str] = []
        self.ids: list[str] = []
        self.plots: dict[str, Any] = {}
        self.text = ""
        self.scripts = 0
        self._plot = ""
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = dict(attrs)
        self.links += [value[1:] for name, value in attrs if name == "href" and value]
        self.fetched += [
            value or "" for name, value in attrs if name in FETCHING and not (value or "").startswith("#")
        ]
        self.ids += [value or "" for name, value in attrs if name == "id"]
        self.scripts += tag == "script"
        self._plot = values.get("data-plot") or ""
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag
        self._plot = ""

    def handle_data(self, data: str) -> None:
        if self._plot:
            self.plots[self._plot] = json.loads(data)
        elif self.open[-1:] not in (["script"], ["style"]):
            self.text += data


def _values(array: Any) -> Vec:
    if isinstance(array, list):
        return np.array(array, dtype=float)
    return np.frombuffer(base64.b64decode(array["bdata"]), dtype=np.dtype(array["dtype"])).astype(float)


def test_page_is_well_formed_and_needs_nothing_from_outside(make_run: MakeRun) -> None:
    run = make_run(50, dofs=("surge-pitch", "sway-roll"))
    text = render(run, summarise(run), date="1 March 2025")
    page = Page(text)
    assert page.fetched == []
    assert "@import" not in text.split("</style>")[0]
    assert "url(" not in text.split("</style>")[0]
    assert len(page.plots) == 8
    assert set(page.plots) <= set(page.ids)
    assert len(page.ids) == len(set(page.ids))
    assert "1 March 2025" in page.text
    assert len(text.encode()) < 2e6
    licence, script = "Licensed under the MIT license", "plotly.js (basic - minified)"
    assert licence in text
    assert script in text


@pytest.mark.usefixtures("light")
def test_page_shows_the_run(make_run: MakeRun) -> None:
    run = make_run(80)
    page = Page(render(run, summarise(run)))
    curves = {curve["name"]: curve for curve in page.plots["surge-pitch-force"]["data"]}
    assert_allclose(_values(curves["felt"]["x"]), run.time)
    assert_allclose(_values(curves["felt"]["y"]), run.felt_force[:, 0], rtol=1e-6, atol=1e-6)
    rate = next(c for c in page.plots["surge-pitch-tilt"]["data"] if c["name"] == "limit ±3 deg/s")
    assert sorted({y for y in rate["y"] if y is not None}) == pytest.approx([-3.0, 3.0])
    for words in ("step-sine-1", "hybrid-all", "thesis", "ideal", "surge-pitch", "10 ms", '"horizon": 50'):
        assert words in page.text
    assert "All 80 decisions are optimal; all limits were kept at every node." in page.text


@pytest.mark.usefixtures("light")
def test_strings_of_users_stay_text(make_run: MakeRun) -> None:
    run = make_run(5, scenario=EVIL, cueing=EVIL, plant=EVIL, settings={EVIL: EVIL}, status=(EVIL,) * 5)
    scripts = Page(render(make_run(5), {})).scripts
    text = render(run, summarise(run) | {EVIL: EVIL}, date=EVIL)
    page = Page(text)
    assert page.scripts == scripts
    assert page.text.count(EVIL) > 8
    assert "<script>alert" not in text
    names = [curve["name"] for curve in page.plots["effort-changes"]["data"]]
    assert "<b>" not in "".join(names)  # plotly would read it as bold
    compared = Page(render_comparison([run, run], [{}, {EVIL: 1}]))
    assert EVIL in compared.text
    assert compared.scripts == 7 + 3


@pytest.mark.usefixtures("light")
def test_decisions_of_the_fallback_are_said_first(make_run: MakeRun) -> None:
    twist = np.zeros((40, 6))
    twist[9, 4] = np.deg2rad(3.5)
    run = make_run(
        4,
        status=("fallback", "decided", "decided", "fallback"),
        solver=("limit", "optimal", "optimal", "infeasible"),
        twist=twist,
    )
    page = Page(render(run, summarise(run)))
    words = (
        "1 of 4 decisions fell back to braking: the solver ended without a solution; "
        "1 of 4 decisions fell back to braking: the problem had no solution; "
        "hard comfort threshold exceeded: pitch rate by up to 0.5 deg/s beyond ±3 deg/s, at 1 of 4 nodes."
    )
    assert words in page.text


@pytest.mark.usefixtures("light")
def test_long_drives_make_small_pages_and_say_so(make_run: MakeRun) -> None:
    run = make_run(7_000)
    text = render(run, {})
    page = Page(text)
    assert "up to 70\u202f000 samples, of which at most 5\u202f000 are drawn" in page.text
    for plot in page.plots.values():
        assert all(len(_values(curve["x"])) <= MAX_POINTS + 1 for curve in plot["data"])
    assert len(text) < 0.9e6
    force = {curve["name"]: _values(curve["y"]) for curve in page.plots["surge-pitch-force"]["data"]}
    assert force["felt"].max() == pytest.approx(run.felt_force[:, 0].max(), rel=1e-6)
    assert "are drawn" not in Page(render(make_run(100), {})).text


@pytest.mark.usefixtures("light")
@pytest.mark.parametrize("steps", [0, 1, 2])
def test_very_short_runs_have_a_page(make_run: MakeRun, steps: int) -> None:
    run = make_run(steps)
    Page(render(run, {}))
    Page(render_comparison([run], [{}]))


@pytest.mark.usefixtures("light")
def test_equal_runs_give_equal_pages(make_run: MakeRun) -> None:
    assert render(make_run(20), {}, date="x") == render(make_run(20), {}, date="x")


@pytest.mark.usefixtures("light")
def test_comparison_has_tables_and_diagrams_of_what_the_runs_share(make_run: MakeRun) -> None:
    both = make_run(60, cueing="implicit", dofs=("surge-pitch", "sway-roll"))
    one = make_run(60, cueing="hybrid-all", amplitude=0.7)
    page = Page(render_comparison([both, one], [summarise(both), summarise(one)], date="today"))
    assert set(page.plots) == {
        "surge-pitch-compare-force",
        "surge-pitch-compare-tilt",
        "surge-pitch-compare-position",
        "surge-pitch-compare-false-cues",
        "reach-compare-use",
        "effort-compare-changes",
        "ranking-trade",
    }
    names = [curve["name"] for curve in page.plots["surge-pitch-compare-force"]["data"]]
    assert names == ["reference", "implicit", "hybrid-all"]
    assert "Against implicit [%]" in page.text


@pytest.mark.usefixtures("light")
def test_summaries_of_a_comparison_may_come_by_name(make_run: MakeRun) -> None:
    runs = [make_run(20, cueing=name) for name in ("implicit", "hybrid-all")]
    by_name = compare(runs)
    assert render_comparison(runs, by_name) == render_comparison(runs, list(by_name.values()))
    with pytest.raises(ValueError, match="2 runs need as many summaries, got 1"):
        render_comparison(runs, {"implicit": {}, "unknown": {}})


def test_a_comparison_needs_a_summary_for_each_run(make_run: MakeRun) -> None:
    with pytest.raises(ValueError, match="2 runs need as many summaries, got 1"):
        render_comparison([make_run(2), make_run(2)], [{}])


@pytest.mark.usefixtures("light")
def test_a_page_of_six_degrees_of_freedom_draws_what_each_axis_did(make_run: MakeRun) -> None:
    """Every diagram holds its run's numbers in the units of its axis, and the limits of the file."""
    t = 1e-3 * np.arange(1, 601)
    rate, pose, twist = np.zeros((600, 3)), np.zeros((600, 6)), np.zeros((600, 6))
    rate[:, 2] = 0.1 * np.sin(t)
    pose[:, 2], pose[:, 5], twist[:, 5] = 0.2 * t, 0.1 * t, 0.1
    run = make_run(
        60,
        dofs=("surge-pitch", "heave", "yaw"),
        platform=load("davsi"),
        reference_rate=rate,
        pose=pose,
        twist=twist,
        felt_force=np.tile([0.0, 0.0, 0.3], (600, 1)),
    )
    text = render(run, summarise(run))
    page = Page(text)
    drawn = {name: {c["name"]: c for c in plot["data"]} for name, plot in page.plots.items()}
    axes = {name: plot["layout"]["yaxis"]["title"]["text"] for name, plot in page.plots.items()}
    assert_allclose(_values(drawn["yaw-yaw"]["reference"]["y"]), np.rad2deg(rate[:, 2]), rtol=1e-6)
    assert_allclose(_values(drawn["yaw-yaw"]["felt"]["y"]), np.rad2deg(0.1), rtol=1e-6)
    assert_allclose(_values(drawn["yaw-yaw-place"]["yaw angle"]["y"]), np.rad2deg(0.1 * t), rtol=1e-6)
    assert_allclose(_values(drawn["heave-heave"]["felt"]["y"]), 0.3, rtol=1e-6)
    assert_allclose(_values(drawn["heave-heave-place"]["height"]["y"]), 0.2 * t, rtol=1e-6)
    assert axes["yaw-yaw"] == "yaw rate [deg/s]"
    assert axes["heave-heave-place"] == "height [m]"
    assert "limit ±0.42 m" in {name.replace(" (off scale)", "") for name in drawn["heave-heave-place"]}
    assert "limit ±25 deg" in {name.replace(" (off scale)", "") for name in drawn["yaw-yaw-place"]}
    assert "4 (surge-pitch, heave, yaw)" in page.text
    places = [text.index(f"<h2>{title}: how") for title in ("Surge and pitch", "Heave", "Yaw")]
    assert places == sorted(places)


@pytest.mark.usefixtures("light")
def test_a_contest_names_the_axis_of_every_group_of_diagrams(make_run: MakeRun) -> None:
    runs = {name: [make_run(20, scenario=name, dofs=("surge-pitch", "sway-roll"))] for name in ("a", "b")}
    page = render_contest({name: (of_one, compare(of_one)) for name, of_one in runs.items()})
    for title in ("Surge and pitch", "Sway and roll", "The platform’s reach"):
        assert page.count(f'<h3 class="dof">{title}</h3>') == 2


@pytest.mark.usefixtures("light")
def test_the_picture_comes_first_then_five_figures_and_the_rest_is_folded(make_run: MakeRun) -> None:
    run = make_run(60, dofs=("surge-pitch", "sway-roll"), amplitude=0.1)
    text = render(run, summarise(run))
    order = ["Wanted and felt", "surge-pitch-force", "sway-roll-force", "Key figures", "What it says"]
    places = [text.index(words) for words in order]
    assert places == sorted(places)
    assert text.count('class="gauge"') == 5
    folded = text[text.index('<details class="part"') :]
    for title in ("Limits", "The solver’s effort", "All figures", "How it was made"):
        assert f"<h2>{title}</h2>" in folded
    assert '<section class="part"' not in folded


@pytest.mark.usefixtures("light")
def test_limits_are_open_where_one_was_passed(make_run: MakeRun) -> None:
    twist = np.zeros((40, 6))
    twist[9, 4] = np.deg2rad(3.5)
    run = make_run(4, twist=twist)
    assert '<details class="part" id="limits">' in render(make_run(4), summarise(make_run(4)))
    assert '<section class="part" id="limits">' in render(run, summarise(run))


@pytest.mark.usefixtures("light")
def test_the_banner_and_the_table_say_the_same(make_run: MakeRun) -> None:
    """Soft and hard, at nodes and between: what the one counts stands in the other."""
    twist = np.zeros((40, 6))
    twist[[9, 13], 4] = np.deg2rad([3.5, 4.25])
    hard, soft = make_run(4, twist=twist), make_run(4, twist=twist, soft=("surge-pitch tilt_rate",))
    for run, mood, words in ((hard, "warn", "hard"), (soft, "mild", "soft")):
        text = render(run, summarise(run))
        banner = text[text.index(f'<p class="{mood}">') :].partition("</p>")[0]
        row = text[text.index('<th scope="row">pitch rate</th>') :].partition("</tr>")[0]
        assert f"{words} comfort threshold" in banner
        assert f">{words} comfort threshold<" in row
        assert "0.5 deg/s" in banner
        assert [">0.5 deg/s<" in row, ">1.25 deg/s<" in row, ">1</td>" in row] == [True] * 3


@pytest.mark.usefixtures("light")
def test_figures_are_in_the_units_of_the_diagrams(make_run: MakeRun) -> None:
    run = make_run(60)
    summary = summarise(run) | {"travel_rms": {"surge": 0.1, "pitch": np.pi / 180.0}}
    page = Page(render(run, summary))
    assert "Travel used (RMS) [m, deg]" in page.text
    assert "pitch1" in page.text[page.text.index("Travel used") :]


@pytest.mark.usefixtures("light")
def test_a_page_of_many_curves_draws_fewer_points_of_each(make_run: MakeRun) -> None:
    """Ten algorithms on a drive of a minute: without a budget the curves alone would be some 4 MB."""
    runs = [make_run(6_000, cueing=f"model-{k}", seed=k) for k in range(10)]
    text = render_comparison(runs, [{} for _ in runs])
    assert len(text.encode()) < 0.8e6
    curves = {c["name"]: _values(c["y"]) for c in Page(text).plots["surge-pitch-compare-force"]["data"]}
    assert curves["model-3"].max() == pytest.approx(runs[3].felt_force[:, 0].max(), rel=1e-6)


@pytest.mark.usefixtures("light")
def test_every_link_leads_to_a_part_of_the_page_and_many_parts_are_listed(make_run: MakeRun) -> None:
    runs = [make_run(20, cueing=name, dofs=("surge-pitch", "sway-roll")) for name in ("implicit", "other")]
    contest = {f"scenario {k}": (runs, compare(runs)) for k in range(4)}
    single, many = render_comparison(runs, compare(runs)), render_contest(contest)
    for text in (render(runs[0], summarise(runs[0])), single, many):
        page = Page(text)
        assert page.links
        assert set(page.links) <= set(page.ids)
        assert len(page.ids) == len(set(page.ids))
    assert '<nav class="contents"' in many
    assert '<a href="#scenario-3">scenario 3</a>' in many


def test_a_lap_on_six_legs_is_a_page_of_less_than_2_mb(make_run: MakeRun) -> None:
    """Four minutes in four degrees of freedom, with the moving platform."""
    run = make_run(24_000, dofs=("surge-pitch", "sway-roll"), platform=load("davsi"), plant="hexapod")
    assert len(render(run, summarise(run)).encode()) < 2e6


def test_a_page_does_not_grow_with_the_drive(make_run: MakeRun, light: None) -> None:
    """Curves have so many points, however many samples these stand for."""
    short = make_run(3_000, dofs=("surge-pitch", "sway-roll"))

    def repeated(times: int) -> Run:
        series: dict[str, Any] = {
            name: np.tile(getattr(short, name), (times, *[1] * (np.ndim(getattr(short, name)) - 1)))
            for name in (*SAMPLED, "command", "changes", "residual", "guess_missed", "step_time")
            if getattr(short, name) is not None
        }
        series["time"] = np.arange(1, times * short.samples + 1) * short.plant_period
        series |= {name: getattr(short, name) * times for name in ("status", "solver")}
        series["command_time"] = np.arange(times * short.decisions) * short.period
        return replace(short, **series)

    sizes = [len(render(run, summarise(run))) for run in map(repeated, (2, 12))]
    assert sizes[1] < 1.1 * sizes[0]
