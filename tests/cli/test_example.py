"""`otolith example`: what it writes is accepted by the commands that the README shows, and never lost."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from otolith import files
from otolith.cli.example import drive
from tests.cli.test_cli import done, refused


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("example") / "example"
    done(["example", "--out", str(out)])
    return out


def test_the_drive_is_read_without_a_doubt_and_its_relations_hold(folder: Path) -> None:
    log = files.read_log(folder / "drive.csv", {})
    t, speed, ax, ay, yaw_rate = drive().T
    np.testing.assert_allclose(log.force[:, 0], ax, atol=1e-5)
    np.testing.assert_allclose(log.force[:, 1], ay, atol=1e-5)
    np.testing.assert_allclose(ay, speed * yaw_rate)
    np.testing.assert_allclose(np.gradient(speed, t), ax, atol=0.01)
    assert speed.min() > 5.0


def test_the_rig_and_the_tuning_cue_the_drive_within_the_rigs_limits(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["--log", str(folder / "drive.csv"), "--platform", str(folder / "rig.toml")]
    washout = ["--cueing", "classical", "--tuning", str(folder / "tuning.toml")]
    done(["run", *words, *washout, "--out", str(tmp_path / "o"), "--json"])
    assert json.loads(capsys.readouterr().out)["violations"] == 0


def test_the_washout_runs_as_it_stands(folder: Path) -> None:
    line = [sys.executable, "-W", "error", str(folder / "washout.py")]
    assert "RMSE 0.5" in subprocess.run(line, capture_output=True, text=True, check=True).stdout


def test_files_that_someone_may_have_edited_are_not_replaced_without_a_word(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert "a folder with files, which may be yours" in refused(["example", "--out", str(folder)], capsys)
    done(["example", "--out", str(folder), "--force"])
