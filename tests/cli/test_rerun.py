"""`otolith rerun`: a run of the command line is made again from its file alone."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from otolith import cli, files
from otolith.cli.example import _SAMPLES
from otolith.core.hdf5 import read_sealed, write_sealed
from otolith.stored import RUN_KIND, RUN_VERSION
from tests.cli.test_cli import done, refused

WANTED = "sine:amplitude=0.8,frequency=0.5,duration=2"


@pytest.mark.parametrize(
    "options",
    [
        [
            "--cueing",
            "implicit",
            "--horizon",
            "20",
            "--soft",
            "tilt_rate=100",
            "--weight",
            "position=0.9",
            "--prediction",
            "oracle:time=0.2",
            "--solver",
            "dense",
        ],
        ["--cueing", "hybrid-first", "--scale", "0.7", "--platform", "davsi"],
        [
            "--cueing",
            "classical",
            "--dofs",
            "surge-pitch,sway-roll,yaw",
            "--platform",
            "davsi",
            "--plant",
            "actuator",
        ],
    ],
    ids=lambda options: options[1],
)
def test_a_run_is_equal_bit_for_bit(
    options: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    done(["run", WANTED, *options, "--out", str(tmp_path / "a")])
    capsys.readouterr()
    done(["rerun", str(tmp_path / "a" / "run.h5"), "--out", str(tmp_path / "b"), "--json"])
    assert json.loads(capsys.readouterr().out)["equal"] is True
    a, b = (files.read_run(tmp_path / name / "run.h5") for name in "ab")
    np.testing.assert_array_equal(a.pose, b.pose)
    assert a.settings == b.settings


def test_an_algorithm_and_a_drive_of_ones_own_are_found_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    shutil.copy(str(_SAMPLES / "washout.py"), "mine.py")
    done(["example", "--out", "ex"])
    log = ["--log", "ex/drive.csv", "--column", "az=none", "--lowpass", "5", "--platform", "ex/rig.toml"]
    done(["run", *log, "--cueing", "mine.py:HighPass", "--out", "a"])
    Path("ex/rig.toml").unlink()  # the run holds its platform
    assert "--cueing is absent, must be given" in refused(["rerun", "a/run.h5"], capsys)
    assert "--figures is given without --out" in refused(["rerun", "a/run.h5", "--figures"], capsys)
    again = ["rerun", "a/run.h5", "--cueing", "mine.py:HighPass"]
    done(again)
    assert "equal bit for bit" in capsys.readouterr().err
    Path("ex/drive.csv").rename("ex/other.csv")
    assert "log ex/drive.csv is no longer there" in refused(again, capsys)
    Path("mine.py").unlink()
    assert "a file 'mine.py' that does not exist" in refused([*again, "--log", "ex/other.csv"], capsys)


def test_what_differs_is_named_and_the_exit_code_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    done(["run", WANTED, "--cueing", "classical", "--out", str(tmp_path / "a")])
    path = tmp_path / "a" / "run.h5"
    content = read_sealed(path, kind=RUN_KIND, version=RUN_VERSION)
    content.arrays["command"][3, 0] += 1e-15
    write_sealed(path, content.attributes, content.arrays, kind=RUN_KIND, version=RUN_VERSION)
    with pytest.raises(SystemExit) as stopped:
        cli.main(["rerun", str(path)])
    assert stopped.value.code == 1
    assert "differs in command" in capsys.readouterr().err
