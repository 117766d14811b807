"""`otolith compare` over several scenarios, and washouts with a tuning of the user's."""

import json
from importlib.resources import files as package_files
from pathlib import Path

import pytest

from otolith import files
from tests.cli.test_cli import done, refused

SCENARIOS = ["sine:amplitude=0.5,frequency=0.2,duration=3", "step:amplitude=4,end=3,duration=3"]
WASHOUTS = ["--cueing", "classical", "--cueing", "adaptive"]


def test_several_scenarios_come_in_one_report_with_a_ranking(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    done(["compare", *SCENARIOS, *WASHOUTS, "--by", "perceived", "--out", str(tmp_path), "--json"])
    said = capsys.readouterr()
    told = json.loads(said.out)
    assert told == json.loads((tmp_path / "summary.json").read_text())
    assert list(told["scenarios"]) == SCENARIOS
    assert told["ranked_by"] == "perceived"
    assert {one["cueing"] for one in told["ranking"]} == {"classical", "adaptive"}
    assert [one["mean_rank"] for one in told["ranking"]] == sorted(
        one["mean_rank"] for one in told["ranking"]
    )
    for summaries in told["scenarios"].values():
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
    assert "mean rank" in said.err


def test_a_tuning_of_the_users_is_taken_and_recorded(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shipped = (package_files("otolith.platforms") / "tunings" / "thesis.toml").read_text(encoding="utf-8")
    softer = tmp_path / "softer.toml"
    softer.write_text(shipped.replace("slope = 1.0\n", "slope = 0.4\n"), encoding="utf-8")
    used = {}
    for name in ("thesis", str(softer)):
        done(["run", SCENARIOS[0], *WASHOUTS[:2], "--tuning", name, "--out", str(tmp_path / "o"), "--json"])
        summary = json.loads(capsys.readouterr().out)
        assert summary["settings"]["tuning"] == name
        used[name] = summary["workspace"]["surge"]["largest"]
    assert used[str(softer)] < 0.6 * used["thesis"]


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--by", "beauty"], "--by is 'beauty', must be one of rmse, perceived, false-cues"),
        (["--tuning", "rig"], "tuning is 'rig', must be one of davsi, thesis, or a file (.toml)"),
        (["--tuning", "absent.toml"], "tuning absent.toml is not readable"),
    ],
)
def test_bad_choices_are_one_sentence(
    arguments: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert sentence in refused(["compare", *SCENARIOS, *WASHOUTS, *arguments], capsys)
