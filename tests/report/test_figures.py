from pathlib import Path

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import StepPatch
from numpy.testing import assert_allclose

from otolith.core.errors import InputError
from otolith.core.frames import AXES, DOFS
from otolith.platforms import load
from otolith.report.figures import arranged, comparison_figure, cueing_figure, save_figure
from tests.report.conftest import MakeRun

BOTH = ("surge-pitch", "sway-roll")


def _line(figure: Figure, label: str) -> Line2D:
    return next(line for ax in figure.axes for line in ax.lines if line.get_label() == label)


def _axes(figure: Figure, label: str) -> Axes:
    return next(ax for ax in figure.axes if ax.get_ylabel() == label)


def _legends(figure: Figure) -> list[str]:
    shown = [legend for ax in figure.axes if (legend := ax.get_legend()) is not None]
    return [text.get_text() for legend in shown for text in legend.get_texts()]


@pytest.mark.parametrize("pair", BOTH)
def test_figure_shows_the_motion_of_its_pair(make_run: MakeRun, pair: str) -> None:
    run = make_run(dofs=BOTH)
    axes = DOFS[pair]
    i, j = axes.translation, axes.rotation
    figure = cueing_figure(run, pair)
    for label, expected in {
        "reference": run.reference_force[:, i],
        "felt": run.felt_force[:, i],
        f"from {AXES[i]}": run.acceleration[:, i],
        f"from {AXES[j]}": run.felt_force[:, i] - run.acceleration[:, i],
        "tilt": axes.sign * np.rad2deg(run.pose[:, j]),
        "tilt rate": axes.sign * np.rad2deg(run.twist[:, j]),
        "position": run.pose[:, i],
        "velocity": run.twist[:, i],
    }.items():
        line = _line(figure, label)
        assert_allclose(np.asarray(line.get_xdata()), run.time)
        assert_allclose(np.asarray(line.get_ydata()), expected, atol=1e-12, err_msg=label)


def test_figure_shows_effort_of_each_decision(make_run: MakeRun) -> None:
    run = make_run(120)
    figure = cueing_figure(run, "surge-pitch")
    (bars,) = _axes(figure, "changes").patches
    assert isinstance(bars, StepPatch)
    heights, edges, _ = bars.get_data()
    assert_allclose(heights, run.changes)
    assert_allclose(edges, np.append(run.command_time, 1.2))
    assert_allclose(np.asarray(_line(figure, "step").get_ydata()), 1e6 * run.step_time)
    assert any(text.startswith("p99 ") for text in _legends(figure))


def test_limits_stand_at_the_platforms_values(make_run: MakeRun) -> None:
    figure = cueing_figure(make_run(platform=load("davsi")), "surge-pitch")
    drawn = {
        label: sorted(
            float(np.asarray(line.get_ydata())[0])
            for line in _axes(figure, label).lines
            if str(line.get_label()).startswith("limit")
        )
        for label in ("position [m]", "velocity [m/s]", "tilt rate [deg/s]", "tilt [deg]")
    }
    assert_allclose(drawn["position [m]"], [-0.51, 0.63])
    assert_allclose(drawn["velocity [m/s]"], [-0.81, 0.81])
    assert_allclose(drawn["tilt rate [deg/s]"], [-3.0, 3.0])
    assert drawn["tilt [deg]"] == []
    assert "limit ±24.3 deg (off scale)" in _legends(figure)


def test_panels_share_the_time_axis(make_run: MakeRun) -> None:
    figure = cueing_figure(make_run(200), "surge-pitch")
    figure.axes[0].set_xlim(0.5, 1.0)
    assert {ax.get_xlim() for ax in figure.axes} == {(0.5, 1.0)}


def test_comparison_names_each_run_once_for_the_motion_and_once_for_the_effort(make_run: MakeRun) -> None:
    runs = [make_run(cueing=name, amplitude=a) for name, a in (("implicit", 1.0), ("_$x$", 0.8))]
    figure = comparison_figure(runs, "surge-pitch")
    legends = _legends(figure)
    assert legends.count("implicit") == legends.count("_$x$") == 1
    assert sum(text.startswith("_$x$: mean ") for text in legends) == 1


def test_nothing_is_drawn_outside_the_figure(make_run: MakeRun) -> None:
    status = ("uncertified", "limit", "infeasible", "invalid") * 25
    run = make_run(100, status=status)
    wordy = make_run(100, cueing="a-cueing-algorithm-with-settings-in-its-name-" * 3)
    for figure in (cueing_figure(run, "surge-pitch"), comparison_figure([run] * 5 + [wordy], "surge-pitch")):
        figure.draw_without_rendering()
        box = figure.get_tightbbox()
        width, height = figure.get_size_inches()
        assert box.x0 >= -0.01
        assert box.y0 >= -0.01
        assert box.x1 <= width + 0.01
        assert box.y1 <= height + 0.01


def test_legends_cover_no_panel(make_run: MakeRun) -> None:
    figure = cueing_figure(make_run(100, status=("limit", "optimal") * 50), "surge-pitch")
    figure.draw_without_rendering()
    panels = [ax.get_window_extent() for ax in figure.axes]
    for ax in figure.axes:
        if (legend := ax.get_legend()) is not None:
            assert not any(legend.get_window_extent().shrunk(0.95, 0.95).overlaps(panel) for panel in panels)


@pytest.mark.parametrize("steps", [0, 1, 2])
@pytest.mark.parametrize("suffix", [".png", ".pdf", ".svg"])
def test_very_short_runs_are_drawn_and_written(
    make_run: MakeRun, tmp_path: Path, steps: int, suffix: str
) -> None:
    run = make_run(steps)
    for k, figure in enumerate((cueing_figure(run, "surge-pitch"), comparison_figure([run], "surge-pitch"))):
        path = tmp_path / f"{k}{suffix}"
        save_figure(figure, path)
        assert path.stat().st_size > 1000


def test_equal_runs_give_equal_files(make_run: MakeRun, tmp_path: Path) -> None:
    for name in ("a.pdf", "b.pdf"):
        save_figure(cueing_figure(make_run(20), "surge-pitch"), tmp_path / name)
    assert (tmp_path / "a.pdf").read_bytes() == (tmp_path / "b.pdf").read_bytes()


def test_arranged_once_is_arranged_the_same(make_run: MakeRun, tmp_path: Path) -> None:
    figure = cueing_figure(make_run(20), "surge-pitch")
    engine = figure.get_layout_engine()
    with arranged(figure):
        save_figure(figure, tmp_path / "a.pdf")
        save_figure(figure, tmp_path / "a.png")
    assert figure.get_layout_engine() is engine
    save_figure(cueing_figure(make_run(20), "surge-pitch"), tmp_path / "b.png")
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_a_file_that_is_no_picture_is_refused(make_run: MakeRun, tmp_path: Path) -> None:
    with pytest.raises(
        InputError, match=r"figure file is run\.doc, must be a name that ends in \.pdf, \.png, \.svg"
    ):
        save_figure(Figure(), tmp_path / "run.doc")
