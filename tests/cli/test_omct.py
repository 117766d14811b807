"""`otolith omct` from the command line, over a shortened procedure."""

import json
from functools import partial
from pathlib import Path

import pytest

from otolith.cli import main, omct
from otolith.metrics.frequency_response import Procedure
from otolith.scenarios.cueing_tests import TESTS, Sweep


@pytest.fixture
def brief(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two fast frequencies, settled for a moment: what is tested here is the way from words to files."""
    quick = partial(Procedure, frequencies=(6.31, 15.849), sweep=Sweep(settle=1.0, measured=1.0))
    monkeypatch.setattr(omct, "Procedure", quick)


def outcome(line: list[str]) -> int:
    try:
        main(line)
    except SystemExit as stop:
        return int(stop.code or 0)
    return 0


def test_a_washout_is_tested_and_written(
    brief: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bounds = tmp_path / "bounds.csv"
    bounds.write_text(
        "test,omega_radps,modulus_low,modulus_high,phase_low_deg,phase_high_deg\nheave,1,9,,,\nheave,20,9,,,\n"
    )
    line = ["omct", "--cueing", "classical", "--dofs", "heave,yaw", "--platform", "davsi"]
    line += ["--boundaries", str(bounds), "--out", str(tmp_path / "out"), "--json"]
    assert outcome(line) == 0
    printed = capsys.readouterr()
    summary = json.loads(printed.out)
    assert summary == json.loads((tmp_path / "out" / "omct.json").read_text())
    assert [test["name"] for test in summary["tests"]] == ["yaw", "heave"]
    assert all(len(test["modulus"]) == 2 for test in summary["tests"])
    assert set(summary["at_1_radps"]) == {"heave", "yaw"}
    assert 0.0 < summary["at_1_radps"]["yaw"]["gain"] < 1.0
    assert summary["tests"][1]["within_boundaries"] == [False, False]
    assert summary["not_cued"] == [test.name for test in TESTS if test.name not in ("yaw", "heave")]
    assert "not cued, hence not tested: pitch" in printed.err
    assert {file.name for file in (tmp_path / "out").iterdir()} == {
        ".otolith",
        "omct.json",
        "report.html",
        "figure.pdf",
        "figure.png",
    }


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (["--cueing", "clasical"], "did you mean classical"),
        (["--cueing", "classical", "--plant", "moon"], "--plant is 'moon'"),
        (["--cueing", "classical", "--dofs", "surge"], "--dofs is 'surge'"),
        (["--cueing", "explicit", "--dofs", "surge-pitch,yaw"], "yaw of platform thesis is missing"),
        (["--cueing", "classical", "--force", "0"], "--force is 0.0, must be greater than 0"),
        (["--cueing", "classical", "--boundaries", "nowhere.csv"], "boundaries nowhere.csv"),
    ],
)
def test_wrong_words_are_one_sentence(
    options: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert outcome(["omct", *options]) == 2
    assert sentence in capsys.readouterr().err
