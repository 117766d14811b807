"""`otolith compare` over several scenarios, and washouts with a tuning of the user's."""

import json
from importlib.resources import files as package_files
from pathlib import Path

import pytest

from otolith import files
from otolith.experiment import differences
from tests.cli.test_cli import done, refused

SCENARIOS = ["sine:amplitude=0.5,frequency=0.2,duration=3", "step:amplitude=4,end=3,duration=3"]
WASHOUTS = ["--cueing", "classical", "--cueing", "adaptive"]


def test_several_scenarios_come_in_one_report_with_a_ranking(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    done(
        ["compare", *SCENARIOS, *WASHOUTS, "--by", "perceived", "--out", str(tmp_path), "--figures", "--json"]
    )
    output = capsys.readouterr()
    summary = json.loads(output.out)
    assert summary == json.loads((tmp_path / "summary.json").read_text())
    assert list(summary["scenarios"]) == SCENARIOS
    assert summary["ranked_by"] == "perceived"
    assert {one["cueing"] for one in summary["ranking"]} == {"classical", "adaptive"}
    assert [one["mean_rank"] for one in summary["ranking"]] == sorted(
        one["mean_rank"] for one in summary["ranking"]
    )
    for summaries in summary["scenarios"].values():
        assert list(summaries) == ["classical", "adaptive"]
    page = (tmp_path / "report.html").read_text()
    assert page.count("Plotly.newPlot") >= 1
    assert "2 algorithms on 2 scenarios" in page
    names = {path.name for path in tmp_path.iterdir()}
    assert {"figure.pdf", "figure.png", "report.html", "summary.json"} <= names
    runs = [files.read_run(tmp_path / name) for name in names if name.endswith(".h5")]
    assert {(run.scenario, run.cueing) for run in runs} == {
        (scenario, cueing) for scenario in SCENARIOS for cueing in ("classical", "adaptive")
    }
    assert "mean rank" in output.err


def test_a_tuning_of_the_users_is_taken_and_recorded(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shipped = (package_files("otolith.cueing.washout") / "tunings" / "thesis.toml").read_text(
        encoding="utf-8"
    )
    softer = tmp_path / "softer.toml"
    softer.write_text(shipped.replace("slope = 1.0\n", "slope = 0.4\n"), encoding="utf-8")
    used, slopes = {}, list[str]()
    for name in ("thesis", str(softer)):
        done(["run", SCENARIOS[0], *WASHOUTS[:2], "--tuning", name, "--out", str(tmp_path / "o"), "--json"])
        summary = json.loads(capsys.readouterr().out)
        slopes.append(json.dumps(summary["settings"]["design"]["tuning"]))
        used[name] = summary["workspace"]["surge"]["largest"]
    assert slopes[0] != slopes[1] == slopes[0].replace('"slope": 1.0', '"slope": 0.4')
    assert used[str(softer)] < 0.6 * used["thesis"]


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--by", "beauty"], "--by is 'beauty', must be one of rmse, perceived, false-cues"),
        (
            ["--by", "rate"],
            "must be one of rmse, perceived, false-cues, lag, rebound where surge-pitch is cued",
        ),
        (["--dofs", "heave"], "heave of platform thesis is missing, must be in its file for it to be cued"),
        (["--dofs", "pitch"], "one of surge-pitch, sway-roll, heave, yaw, or several with commas"),
        (["--tuning", "rig"], "tuning is 'rig', must be one of davsi, thesis, or a file (.toml)"),
        (["--tuning", "absent.toml"], "tuning absent.toml is not readable"),
    ],
)
def test_bad_choices_are_one_sentence(
    arguments: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert sentence in refused(["compare", *SCENARIOS, *WASHOUTS, *arguments], capsys)


def test_six_degrees_of_freedom_are_run_judged_and_shown(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    small = ["--solver", "dense", "--horizon", "20", "--platform", "davsi"]
    dofs = ["--dofs", "yaw,heave,sway-roll,surge-pitch"]  # in any order
    cueing = ["--cueing", "classical", "--cueing", "implicit"]
    done(["compare", SCENARIOS[0], *small, *dofs, *cueing, "--figures", "--out", str(tmp_path), "--json"])
    summary = json.loads(capsys.readouterr().out)
    assert summary["implicit"]["dofs"] == "surge-pitch,sway-roll,heave,yaw"
    assert summary["implicit"]["violations"] == 0
    assert set(summary["implicit"]["status"]) == {"decided"}
    assert 0.0 < summary["implicit"]["rate_rmse"]["yaw"] < summary["classical"]["rate_rmse"]["yaw"]
    run = files.read_run(tmp_path / "implicit.h5")
    assert run.dofs[-2:] == ("heave", "yaw")
    assert abs(run.command).max(axis=0).min() > 0.0
    page = (tmp_path / "report.html").read_text()
    assert "6 (surge-pitch, sway-roll, heave, yaw)" in page
    for name in ("heave-compare-heave", "yaw-compare-yaw-place", "sway-roll-compare-tilt"):
        assert f'id="{name}"' in page
    assert {f"figure-{dof}.png" for dof in run.dofs} <= {path.name for path in tmp_path.iterdir()}


def test_yaw_alone_is_ranked_by_its_rate(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    yaw = ["--dofs", "yaw", "--platform", "davsi"]
    done(["compare", *SCENARIOS, *WASHOUTS, *yaw, "--out", str(tmp_path), "--json"])
    result = json.loads(capsys.readouterr().out)
    assert result["ranked_by"] == "rate"
    for summaries in result["scenarios"].values():
        assert all(summary["rmse"] is None for summary in summaries.values())
    page = (tmp_path / "report.html").read_text()
    assert "all-overview-rate" in page
    assert "all-overview-rmse" not in page


def test_a_drive_brings_its_own_heave_and_yaw(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = ["time,ax,az,yaw_rate"] + [
        f"{0.01 * k:.2f},0.1,{0.3 * (k > 100)},{0.2 * (k > 50)}" for k in range(201)
    ]
    log = tmp_path / "drive.csv"
    log.write_text("\n".join(rows) + "\n")
    options = ["--dofs", "heave,yaw", "--platform", "davsi", "--cueing", "classical"]
    done(["run", "--log", str(log), *options, "--out", str(tmp_path / "o")])
    run = files.read_run(tmp_path / "o" / "run.h5")
    assert run.reference_force[-2, 2] == pytest.approx(0.3)
    assert run.reference_rate[700, 2] == pytest.approx(0.2)
    assert abs(run.twist[:, 5]).max() > 0.01
    assert not run.pose[:, [0, 1, 3, 4]].any()
    capsys.readouterr()


def test_two_processes_make_what_one_makes_and_refuse_alike(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    made = []
    for jobs in ("1", "2"):
        out = tmp_path / jobs
        done(["compare", *SCENARIOS, *WASHOUTS, "--no-optimum", "--jobs", jobs, "--out", str(out), "--json"])
        text = capsys.readouterr().out
        made.append(json.loads(text)["scenarios"])
        assert list(made[-1]) == SCENARIOS
        for of_one in made[-1].values():
            assert list(of_one) == ["classical", "adaptive"]
            for summary in of_one.values():
                del summary["step_time_us"]
    assert made[0] == made[1]
    names = sorted(path.name for path in (tmp_path / "1").glob("*.h5"))
    assert len(names) == 4
    for name in names:
        with files.open_run(tmp_path / "1" / name) as one, files.open_run(tmp_path / "2" / name) as two:
            assert differences(one, two) == []
    assert "--jobs is 0, must be at least 1" in refused(
        ["compare", *SCENARIOS, "--jobs", "0", "--out", str(tmp_path / "o")], capsys
    )
