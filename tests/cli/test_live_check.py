"""`otolith live check` and `live axis`, with a base in software."""

import io
import json
from pathlib import Path

import pytest

from otolith.cli import main
from otolith.live.permits import why_untested
from tests.live.shell.rig import Rig


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.delenv("LOCALAPPDATA", raising=False)
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    return tmp_path / "otolith"


def ended(arguments: list[str]) -> int:
    with pytest.raises(SystemExit) as end:
        main(arguments)
    return int(end.value.code or 0)


def test_a_host_is_tested_by_a_session_and_the_result_is_kept(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    washout = ["--cueing", "classical", "--tuning", "davsi"]
    code = ended(["live", "check", "--seconds", "1", *washout, "--json"])
    output = capsys.readouterr()
    found = json.loads(output.out)
    assert code == (0 if found["punctual"] else 1)  # the machine decides
    assert 0.0 <= found["median"] <= found["p99"] <= found["p999"] <= found["largest"]
    assert 0.0 < found["step_median"] <= found["step_p99"] < 1.0
    assert "real-time scheduling" in output.err
    kept = json.loads((folder / "self-test.json").read_text())
    assert kept["p999"] == found["p999"]
    assert kept["real_time"] is found["real_time"]


def test_a_host_on_which_the_session_ends_at_once_is_not_tested(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("otolith.cli.live_run._converse", lambda *_: None)  # it ends before it is cued
    washout = ["--cueing", "classical", "--tuning", "davsi"]
    assert ended(["live", "check", "--seconds", "1", *washout, "--json"]) == 2
    output = capsys.readouterr()
    assert output.out == ""
    assert "the session ended before the platform was cued, so nothing was measured" in output.err
    assert not (folder / "self-test.json").exists()


def test_an_axis_that_a_person_did_not_see_move_is_not_kept_as_tested(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with Rig() as rig:
        for answers, code in (("n\n", 1), ("y\n", 0)):
            monkeypatch.setattr("sys.stdin", io.StringIO(answers))
            assert ended(["live", "axis", "surge", "--out", rig.urls[1]]) == code
        assert rig.farthest[0] == pytest.approx(10e-3, rel=0.05)
        assert rig.base.faults == 0
        assert "are not tested" in why_untested(rig.session())
    said = " ".join(capsys.readouterr().err.split())
    assert "surge: it was not seen to move forward by 10 mm" in said
    assert "nothing is kept: sway, roll, pitch were not tested" in said
