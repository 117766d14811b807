"""`otolith export fmu` and `otolith export ros2` as their user meets them."""

import json
import shutil
import zipfile
from pathlib import Path

import pytest

from otolith.cli import main
from otolith.export.fmu_binary import COMPILERS

NO_LEGS = """
name = "thesis"
description = "a small surge-pitch rig"
[surge]
position_m = 0.2
velocity_mps = 0.5
acceleration_mps2 = 4.0
[pitch]
angle_deg = 12.0
rate_degps = 20.0
"""


def otolith(*words: str) -> int:
    """Exit code of the program."""
    try:
        main(["export", *words])
    except SystemExit as stop:
        return int(stop.code or 0)
    return 0


def test_an_fmu_is_written_and_named_after_its_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "washout.fmu"
    words = ["--cueing", "classical", "--fmi", "3.0", "--sources-only", "--out", str(out), "--json"]
    assert otolith("fmu", *words) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["bytes"] == out.stat().st_size
    assert (said["fmi"], said["kind"], said["period_s"]) == ("3.0", "platform", 0.01)
    assert said["inputs"][0] == "wanted_force_x"
    with zipfile.ZipFile(out) as archive:
        assert "sources/washout.h" in archive.namelist()
        assert not [name for name in archive.namelist() if name.startswith("binaries")]
        assert 'modelName="washout"' in archive.read("modelDescription.xml").decode()
    before = out.read_bytes()
    assert otolith("fmu", *words) == 0
    assert out.read_bytes() == before


def test_a_decision_alone_takes_the_measured_motion_and_is_shown_at_once(tmp_path: Path) -> None:
    out = tmp_path / "washout.fmu"
    assert (
        otolith("fmu", "--cueing", "classical", "--kind", "command", "--sources-only", "--out", str(out)) == 0
    )
    with zipfile.ZipFile(out) as archive:
        described = archive.read("modelDescription.xml").decode()
        assert "#define SHOWN_AT_ONCE 1" in archive.read("sources/model.h").decode()
    assert 'name="velocity_pitch" valueReference="17"' in described
    assert 'name="command_surge"' in described


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["fmu", "--out", "a.zip"], "name of the output is a.zip, must be a name that ends in .fmu"),
        (["fmu", "--out", "9a.fmu"], "name of the program is '9a', must be letters"),
        (["fmu", "--fmi", "1.0", "--out", "a.fmu"], "--fmi is '1.0', must be one of 2.0, 3.0"),
        (["fmu", "--kind", "plant", "--out", "a.fmu"], "--kind is 'plant', must be one of command, platform"),
        (["fmu", "--compiler", "nocc", "--out", "a.fmu"], "--compiler is nocc, must be the command of an"),
        (
            ["fmu", "--compiler", "cc", "--sources-only", "--out", "a.fmu"],
            "--compiler is given with --sources-only, must be left out",
        ),
        (
            ["fmu", "--sources-only", "--cueing", "classical", "--horizon", "9", "--out", "a.fmu"],
            "--horizon is given, but classical would ignore it",
        ),
        (
            ["fmu", "--sources-only", "--cueing", "explicit", "--out", "a.fmu"],
            "--cueing is 'explicit', must be one that decides without Python",
        ),
        (
            ["fmu", "--sources-only", "--cueing", "linear-mpc", "--period", "0.0105", "--out", "a.fmu"],
            "period of the controller is 0.0105 s, must be a multiple of 0.001 s",
        ),
        (
            ["fmu", "--sources-only", "--out", "status.fmu"],
            "name of the program is 'status', must be no word of the code that goes around it",
        ),
        (["ros2", "--out", "rclcpp"], "'rclcpp', must be no word of the code that goes around it"),
        (["ros2", "--out", "Motion"], "name of the ROS package is 'Motion', must be lower-case letters"),
        (["ros2", "--out", "float"], "name of the program is 'float', must be one that has no meaning yet"),
        (["ros2", "--out", "taken"], "a folder with what 'otolith export ros2' did not write (mine.txt)"),
    ],
)
def test_what_cannot_be_is_one_sentence_and_leaves_nothing(
    words: list[str],
    sentence: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "taken").mkdir()
    (tmp_path / "taken" / "mine.txt").write_text("mine")
    assert otolith(*words) == 2
    captured = capsys.readouterr()
    last = captured.err.strip().splitlines()[-1]
    assert sentence in last
    assert captured.out == ""
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["mine.txt", "taken"]


def test_without_a_compiler_it_says_what_to_do(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("otolith.export.fmu_binary.which", lambda name: None)
    assert otolith("fmu", "--cueing", "classical", "--out", str(tmp_path / "a.fmu")) == 2
    assert f"no C compiler ({', '.join(COMPILERS)}) is on this machine" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_a_ros_package_has_the_legs_of_its_platform(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with_legs, without = tmp_path / "with_legs", tmp_path / "without"
    words = ["--cueing", "classical", "--platform", "davsi", "--out", str(with_legs)]
    assert otolith("ros2", *words, "--json") == 0
    said = json.loads(capsys.readouterr().out)
    assert (said["package"], said["legs"]) == ("with_legs", "m")
    assert sorted(said["files"]) == sorted(
        str(path.relative_to(with_legs))
        for path in with_legs.rglob("*")
        if path.is_file() and path.name[0] != "."
    )
    assert "#define HAS_LEGS 1" in (with_legs / "include" / "program.hpp").read_text()
    assert otolith("ros2", *words) == 0  # what it wrote itself it may replace
    shutil.rmtree(with_legs)
    rig = tmp_path / "rig.toml"
    rig.write_text(NO_LEGS)
    assert otolith("ros2", "--cueing", "classical", "--platform", str(rig), "--out", str(without)) == 0
    assert "#define HAS_LEGS 0" in (without / "include" / "program.hpp").read_text()
