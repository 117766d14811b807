"""`otolith live faults` and `live bench`."""

import json

import pytest

from otolith.cli import main
from otolith.live.faults import CASES, matrix

WASHOUT = ["--cueing", "classical", "--tuning", "davsi"]


def ended(arguments: list[str]) -> int:
    with pytest.raises(SystemExit) as end:
        main(arguments)
    return int(end.value.code or 0)


def test_faults_are_played_by_row_and_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert ended(["live", "faults", "2", "13d", *WASHOUT, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [case["row"] for case in found["cases"]] == ["2a", "2b", "2c", "2d", "13d"]
    assert found["wrong"] == 0
    assert found["cases"][3]["seen"].startswith("holding after 0.0")


def test_a_wrong_answer_ends_with_exit_code_1(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("otolith.live.core.health.SILENT", 10**12)  # telemetry may be missing for ever
    assert ended(["live", "faults", "2c", *WASHOUT]) == 1
    output = capsys.readouterr()
    assert "WRONG" in output.out
    assert "0 of 1 as expected" in output.err


def test_what_cannot_be_played_is_one_sentence(capsys: pytest.CaptureFixture[str]) -> None:
    assert ended(["live", "faults", "99", *WASHOUT]) == 2
    assert ended(["live", "faults", "--platform", "thesis", *WASHOUT]) == 2
    output = " ".join(capsys.readouterr().err.split())
    assert "ROW is 99, must be numbers of the matrix" in output
    assert "--platform is thesis, must be a machine's" in output


def test_the_endurance_run_gives_an_account(capsys: pytest.CaptureFixture[str]) -> None:
    assert ended(["live", "bench", "--virtual", "6", *WASHOUT, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["seconds"] == pytest.approx(6.0)
    assert found["set_points"] > 5000
    assert found["violations"] == found["exceptions"] == []
    assert found["compilations"] == 0


def test_rows_are_told_apart() -> None:
    assert len({case.row for case in CASES}) == len(CASES)
    assert matrix.CASES is CASES
