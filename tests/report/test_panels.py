import numpy as np
import pytest
from numpy.testing import assert_allclose

from otolith.loop import Run
from otolith.platforms import load
from otolith.report import texts
from otolith.report.motion import motion_comparison, motion_panels
from otolith.report.overview import false_cue_panel, overview_panels, trade_panel, use_panel
from otolith.report.panels import Panel, changes_panel, comparison_panels, effort_panels, run_panels
from otolith.report.ranking import criterion_named
from otolith.report.series import MAX_POINTS
from tests.report.conftest import MakeRun


def _by_key(panels: tuple[Panel, ...]) -> dict[str, Panel]:
    return {panel.key: panel for panel in panels}


def test_limits_near_the_curve_are_drawn_and_far_ones_told(make_run: MakeRun) -> None:
    tilt, position = (_by_key(run_panels(make_run(), "surge-pitch"))[k] for k in ("tilt", "position"))
    assert [(b.label, b.far) for b in (*tilt.bounds, *position.bounds)] == [
        ("limit ±30 deg (off scale)", True),
        ("limit ±3 deg/s", False),
        ("limit ±0.5 m", False),
        ("limit ±7.2 m/s (off scale)", True),
    ]
    assert tilt.axes[0].span[1] < 15  # not squashed by 30 deg
    assert position.axes[0].span[0] < -0.5 < 0.5 < position.axes[0].span[1]


def test_one_sided_limits_name_both_sides(make_run: MakeRun) -> None:
    run = make_run(platform=load("davsi"))
    position = _by_key(run_panels(run, "surge-pitch"))["position"]
    assert position.bounds[0].label == "limit −0.51 to 0.63 m"
    assert_allclose(position.bounds[0].values, (-0.51, 0.63))


def test_both_curves_of_a_panel_share_their_zero_line(make_run: MakeRun) -> None:
    for panel in run_panels(make_run(), "surge-pitch")[1:]:
        assert len(panel.axes) == 2
        assert all(axis.span[0] == -axis.span[1] for axis in panel.axes)


@pytest.mark.parametrize("steps", [0, 1, 2])
def test_runs_too_short_to_mean_anything_still_have_every_panel(make_run: MakeRun, steps: int) -> None:
    run = make_run(steps)
    panels = (*run_panels(run, "surge-pitch"), *effort_panels(run), changes_panel([run]))
    assert [panel.key for panel in panels][:5] == ["force", "tilt", "position", "changes", "step-time"]
    for panel in panels:
        assert panel.x_span[0] < panel.x_span[1]
        assert all(axis.span[0] < axis.span[1] for axis in panel.axes)


def test_a_platform_that_stood_still_has_all_its_limits_told(make_run: MakeRun) -> None:
    still = np.zeros((40, 6))
    run = make_run(4, pose=still, twist=still, acceleration=still)
    assert all(bound.far for panel in run_panels(run, "surge-pitch") for bound in panel.bounds)


def test_decisions_of_the_fallback_are_marked_where_they_stand(make_run: MakeRun) -> None:
    status = ["decided"] * 50
    status[7] = status[9] = "refused"
    run = make_run(50, status=tuple(status))
    marks = [c for c in _by_key(effort_panels(run))["changes"].curves if c.kind == "marks"]
    assert [c.label for c in marks] == ["refused, ×2"]
    assert_allclose(marks[0].x, [0.075, 0.095])  # mid of their bars
    assert_allclose(marks[0].y, run.changes[[7, 9]])


def test_limits_of_both_axes_do_not_fall_on_each_other(make_run: MakeRun) -> None:
    tilt = _by_key(run_panels(make_run(amplitude=4.0, platform=load("davsi")), "surge-pitch"))["tilt"]
    tilt_height, rate_height = (
        bound.values[1] / axis.span[1] for bound, axis in zip(tilt.bounds, tilt.axes, strict=True)
    )
    assert abs(tilt_height - rate_height) > 0.1


def test_step_times_say_median_and_tail_in_microseconds(make_run: MakeRun) -> None:
    run = make_run(100, step_time=1e-6 * np.arange(1.0, 101.0))
    panel = _by_key(effort_panels(run))["step-time"]
    assert [bound.values[0] for bound in panel.bounds] == pytest.approx([50.5, 99.01])
    assert [bound.label for bound in panel.bounds] == ["median 50.5 µs", "p99 99 µs"]
    assert not panel.axes[0].log


def test_a_step_time_far_above_the_others_makes_the_axis_logarithmic(make_run: MakeRun) -> None:
    times = np.full(100, 50e-6)
    times[3] = 20e-3
    axis = _by_key(effort_panels(make_run(100, step_time=times)))["step-time"].axes[0]
    assert axis.log
    assert 0 < axis.span[0] < 50 < 20_000 < axis.span[1]


def test_no_curve_has_more_points_than_a_page_can_bear(make_run: MakeRun) -> None:
    run = make_run(6_000, status=("fallback",) * 6_000)
    for panel in (*run_panels(run, "surge-pitch"), *effort_panels(run)):
        assert all(len(curve.x) == len(curve.y) <= MAX_POINTS + 1 for curve in panel.curves)


def test_comparison_overlays_every_run_on_the_reference(make_run: MakeRun) -> None:
    runs = [make_run(cueing="a"), make_run(cueing="b", amplitude=0.5)]
    force, tilt, position = comparison_panels(runs, "surge-pitch")
    assert [curve.label for curve in force.curves] == ["reference", "a", "b"]
    assert_allclose(force.curves[2].y, runs[1].felt_force[:, 0])
    assert_allclose(position.curves[1].y, runs[1].pose[:, 0])
    assert_allclose(tilt.curves[0].y, -np.rad2deg(runs[0].pose[:, 4]))


def test_runs_on_different_platforms_show_the_limits_of_each(make_run: MakeRun) -> None:
    runs = [make_run(), make_run(platform=load("davsi"))]
    assert len(comparison_panels(runs, "surge-pitch")[2].bounds) == 2


def test_only_runs_of_one_scenario_are_compared(make_run: MakeRun) -> None:
    with pytest.raises(ValueError, match=r"one scenario, got \['a', 'b'\]"):
        comparison_panels([make_run(2, scenario="b"), make_run(2, scenario="a")], "surge-pitch")
    with pytest.raises(ValueError, match=r"one scenario, got \[\]"):
        comparison_panels([], "surge-pitch")


def test_every_panel_is_explained(make_run: MakeRun) -> None:
    run = make_run(10, dofs=("surge-pitch", "heave", "yaw"), platform=load("davsi"))
    panels = (
        *motion_panels(on_tripod(make_run), "yaw"),
        *(panel for dof in run.dofs for panel in motion_panels(run, dof)),
        *effort_panels(run),
        *(panel for dof in run.dofs for panel in motion_comparison([run], dof)),
        changes_panel([run]),
        false_cue_panel([run], "surge-pitch"),
        use_panel([run]),
        *overview_panels({"one": {"only": {}}}),
        trade_panel({"only": {}}, criterion_named("rmse")),
    )
    assert {panel.key for panel in panels if not panel.words} | {"trade-up"} == set(texts.PANELS)


def on_tripod(make_run: MakeRun) -> Run:
    base = np.zeros((4000, 18))
    base[:, 0], base[:, 6], base[:, 12], base[:, 5] = 0.3, 0.1, 0.7, 0.2
    commands, tripod = np.zeros((400, 6)), load("tripod")
    return make_run(dofs=("surge-pitch", "yaw"), base=base, base_command=commands, platform=tripod)


def test_a_base_has_a_panel_of_its_own_and_a_part_of_the_force(make_run: MakeRun) -> None:
    run = on_tripod(make_run)
    rail, turn = motion_panels(run, "surge-pitch")[-1], motion_panels(run, "yaw")[-1]
    assert (rail.key, turn.key) == ("base", "base")
    assert [curve.y[0] for curve in rail.curves] == [0.3, 0.1]
    assert_allclose(turn.curves[0].y, np.rad2deg(0.2))
    assert turn.bounds[0].label == "limit ±20 deg"
    (part,) = (c for c in motion_panels(run, "surge-pitch")[0].curves if c.label == "from the base")
    assert_allclose(part.y, 0.7)
    assert not any(c.label == "from the base" for c in motion_panels(make_run(), "surge-pitch")[0].curves)


def test_who_has_no_solver_has_no_curve_of_changes(make_run: MakeRun) -> None:
    washout = make_run(30, cueing="classical", residual=np.zeros(30), changes=np.zeros(30, dtype=np.int64))
    none, some = changes_panel([washout, make_run(30, cueing="implicit")]).curves
    assert none.label == "classical: no solver"
    assert len(none.x) == 0
    assert some.label.startswith("implicit: mean")


@pytest.mark.parametrize("dof", ["surge-pitch", "yaw"])
def test_the_best_possible_is_drawn_dashed_beside_what_is_felt(make_run: MakeRun, dof: str) -> None:
    run = make_run(100, dofs=(dof,), platform=load("davsi"))
    best = make_run(100, dofs=(dof,), platform=load("davsi"), amplitude=0.5)
    for panel in (motion_panels(run, dof, best)[0], motion_comparison([run], dof, best)[0]):
        curve = panel.curves[-1]
        assert (curve.label, curve.dash) == ("best possible", "dash")
        felt = best.felt_force[:, 0] if dof == "surge-pitch" else np.degrees(best.felt_rate[:, 2])
        assert_allclose(curve.y, felt)
        assert panel.axes[0].span[1] >= curve.y.max()
    plain = (motion_panels(run, dof)[0], motion_comparison([run], dof)[0])
    assert all(curve.label != "best possible" for panel in plain for curve in panel.curves)
