"""Key figures of a run made by hand, against values worked out by hand."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy import signal

from otolith import metrics
from otolith.loop import Run
from otolith.perception import canals
from otolith.platforms import load


def test_rmse_and_travel_of_constants_are_the_constants(handmade: Run) -> None:
    np.testing.assert_allclose(metrics.tracking_rmse(handmade), [0.2, 0.0, 0.0])
    # ∫ (0.1 t)² over samples k/100: 0.1 √(Σ k²/100³) = 0.1 √(338350/1e6)
    assert metrics.travel_rms(handmade)[0] == pytest.approx(0.1 * np.sqrt(338350 / 1e6))


def test_effort_gives_the_distribution_and_counts_what_failed(handmade: Run) -> None:
    effort = metrics.summarise(handmade)
    assert effort["changes"] == {"mean": 1.0, "median": 0.0, "p99": pytest.approx(7.46), "max": 8.0}
    assert effort["step_time_us"]["max"] == pytest.approx(10.0)
    assert effort["status"] == {"decided": 9, "fallback (infeasible)": 1}
    assert effort["residual_max"] == 1e-12
    assert effort["guesses_missed"] == 1


def test_a_run_within_limits_has_no_excess(handmade: Run) -> None:
    assert all(e.violations == 0 and e.between_nodes == 0.0 for e in metrics.excesses(handmade))


@pytest.mark.parametrize(
    ("series", "axis", "value", "quantity", "excess"),
    [
        ("pose", 0, -0.6, "position", 0.1),
        ("pose", 4, np.deg2rad(31), "tilt", np.deg2rad(1)),
        ("twist", 0, 7.3, "velocity", 0.1),
        ("twist", 4, np.deg2rad(-3.5), "tilt_rate", np.deg2rad(0.5)),
        ("acceleration", 0, 10.0, "acceleration", 0.19),
        ("pose", 0, np.nan, "position", np.inf),
    ],
)
def test_an_excess_is_found_where_it_is(
    handmade: Run, series: str, axis: int, value: float, quantity: str, excess: float
) -> None:
    damaged = getattr(handmade, series).copy()
    damaged[[39, 42], axis] = value  # sample 39 is a controller's node (t = 0.4 s), 42 is not
    found = {e.quantity: e for e in metrics.excesses(replace(handmade, **{series: damaged}))}
    hit = found.pop(f"surge-pitch {quantity}")
    assert hit.violations == 1
    assert hit.at_nodes == pytest.approx(excess)
    assert all(e.violations == 0 for e in found.values())


def test_between_nodes_is_reported_but_no_violation(handmade: Run) -> None:
    pose = handmade.pose.copy()
    pose[42, 0] = 0.55
    (position, *_) = metrics.excesses(replace(handmade, pose=pose))
    assert (position.violations, position.at_nodes) == (0, 0.0)
    assert position.between_nodes == pytest.approx(0.05)


def test_commands_are_held_to_their_own_limit(handmade: Run) -> None:
    command = handmade.command.copy()
    command[3, 0] = 5.5
    found = {e.quantity: e for e in metrics.excesses(replace(handmade, command=command))}
    assert found["surge-pitch command"].violations == 1


def test_tilting_is_judged_by_the_machines_angular_acceleration_where_the_file_has_one(handmade: Run) -> None:
    run = replace(handmade, platform=load("davsi"))
    acceleration, command = run.acceleration.copy(), run.command.copy()
    acceleration[39, 4], command[3, 4] = np.deg2rad(-261.0), np.deg2rad(262.0)
    found = {
        e.quantity: e for e in metrics.excesses(replace(run, acceleration=acceleration, command=command))
    }
    assert found["surge-pitch tilt_acceleration"].at_nodes == pytest.approx(np.deg2rad(1.0))
    assert found["surge-pitch tilt_command"].at_nodes == pytest.approx(np.deg2rad(2.0))
    assert "surge-pitch tilt_command" not in {e.quantity for e in metrics.excesses(handmade)}  # it has none


def test_a_run_without_decisions_has_no_excess(handmade: Run) -> None:
    names = ("time", "reference_force", "reference_rate", "felt_force", "pose", "twist", "acceleration")
    empty = {name: getattr(handmade, name)[:0] for name in (*names, "command_time", "command")}
    assert all(
        e.violations == 0 and e.between_nodes == 0.0 for e in metrics.excesses(replace(handmade, **empty))
    )


def test_the_summary_is_plain_json_with_the_promised_keys(handmade: Run) -> None:
    summary = json.loads(json.dumps(metrics.summarise(handmade), allow_nan=False))
    assert summary["rmse"] == pytest.approx(0.2)
    assert summary["rmse_per_pair"] == {"surge-pitch": pytest.approx(0.2)}
    assert {"mean", "p99", "max"} <= set(summary["changes"])
    assert summary["step_time_us"]["median"] == pytest.approx(5.5)
    assert summary["violations"] == 0


def test_percentages_are_against_the_implicit_mpc(handmade: Run) -> None:
    base = replace(handmade, cueing="implicit")
    half = replace(handmade, cueing="hybrid-all", changes=handmade.changes // 2)
    summaries = metrics.compare([base, half])
    assert summaries["implicit"]["changes_against_implicit_percent"] == 0.0
    assert summaries["hybrid-all"]["changes_against_implicit_percent"] == pytest.approx(-50.0)
    assert "changes_against_implicit_percent" not in metrics.compare([half])["hybrid-all"]


def test_the_summary_says_beyond_rmse_how_the_motion_feels(handmade: Run) -> None:
    summary = json.loads(json.dumps(metrics.summarise(handmade), allow_nan=False))
    assert summary["correlation"] == {"surge-pitch": None}  # a constant correlates with nothing
    assert summary["delay_s"] == {"surge-pitch": None}
    assert summary["scale_ratio"] == {"surge-pitch": 0.0}
    assert summary["mean_absolute_difference"] == {"surge-pitch": pytest.approx(0.2)}
    assert summary["false_cues"]["surge-pitch"]["missing"]["duration_s"] == pytest.approx(1.0)
    assert summary["workspace"]["surge"]["largest"] == pytest.approx(0.2)
    assert summary["mismatch_rating"]["max"] > summary["mismatch_rating"]["mean"] > 0.0
    assert summary["sickness_dose"] == {"surge-pitch": 0.0}
    assert 0.0 < summary["perceived_rmse"]["surge-pitch"] < 0.2


@pytest.fixture
def six(handmade: Run) -> Run:
    """The run by hand on a platform that heaves and yaws, which it was asked to do as well."""
    return replace(handmade, platform=load("davsi"), dofs=("surge-pitch", "heave", "yaw"))


@pytest.mark.parametrize(
    ("series", "axis", "value", "quantity", "excess"),
    [
        ("pose", 2, 0.5, "heave position", 0.08),
        ("pose", 5, np.deg2rad(-27.0), "yaw position", np.deg2rad(2.0)),
        ("twist", 2, -0.71, "heave velocity", 0.1),
        ("twist", 5, np.deg2rad(43.0), "yaw velocity", np.deg2rad(2.0)),
        ("acceleration", 2, 10.5, "heave acceleration", 0.5),
        ("acceleration", 5, np.nan, "yaw acceleration", np.inf),
        ("command", 5, np.deg2rad(-511.0), "yaw command", np.deg2rad(1.0)),
    ],
)
def test_heave_and_yaw_are_judged_by_the_platform_file(
    six: Run, series: str, axis: int, value: float, quantity: str, excess: float
) -> None:
    values = getattr(six, series).copy()
    values[-1, axis] = value
    found = {e.quantity: e for e in metrics.excesses(replace(six, **{series: values}))}
    assert found[quantity].at_nodes == pytest.approx(excess, abs=1e-12)
    assert found[quantity].violations == 1
    assert sum(e.violations for e in found.values()) == 1


def test_a_rate_is_judged_where_yaw_is_cued_and_only_there(handmade: Run, six: Run) -> None:
    turning = np.zeros((100, 3))
    turning[:, 2] = 0.3
    wanted = replace(six, reference_rate=turning)
    summary = metrics.summarise(wanted)
    assert summary["dofs"] == "surge-pitch,heave,yaw"
    assert summary["rate_rmse"] == {"yaw": pytest.approx(0.3)}  # it stands still
    assert 0.0 < summary["perceived_rate_rmse"]["yaw"] < 0.3
    assert set(summary["rmse_per_pair"]) == {"surge-pitch", "heave"}
    assert set(summary["travel_rms"]) == {"surge", "pitch", "heave", "yaw"}
    assert summary["scale_ratio"]["yaw"] == 0.0
    assert json.dumps(summary, allow_nan=False)
    assert not {"rate_rmse", "perceived_rate_rmse"} & set(metrics.summarise(handmade))


def test_yaw_alone_has_no_error_of_force(six: Run) -> None:
    summary = metrics.summarise(replace(six, dofs=("yaw",)))
    assert summary["rmse"] is None
    assert summary["rmse_per_pair"] == {}
    assert summary["mismatch_rating"] == {"mean": 0.0, "max": 0.0}


def test_a_constant_rate_is_sensed_as_the_canals_step_response(six: Run) -> None:
    """Against scipy's step response of Telban's canals, which begin at rest."""
    organ = canals.telban()
    wanted = np.zeros((100, 3))
    wanted[:, 2] = -0.2
    _, step = signal.step((organ.A, organ.B, organ.C, organ.D), T=six.time)
    expected = 0.2 * np.sqrt(np.mean(step**2))
    errors = metrics.perceived_rate_rmse(replace(six, reference_rate=wanted))
    assert errors[2] == pytest.approx(expected, rel=0.02)
    assert errors[0] == 0.0
