"""The program as its user meets it: what it prints, what it writes, how it refuses."""

import errno
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from otolith import cli, files

SHORT = "step-sine:amplitude=0.5,duration=6,sine_start=5.5"


def refused(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    """The one sentence that a refused command says; its exit code must be 2."""
    with pytest.raises(SystemExit) as stopped:
        cli.main(arguments)
    assert stopped.value.code == 2
    output = capsys.readouterr()
    assert output.out == ""
    assert "Traceback" not in output.err
    return output.err.strip()


def done(arguments: list[str]) -> None:
    """Run a command that must succeed."""
    with pytest.raises(SystemExit) as stopped:
        cli.main(arguments)
    assert stopped.value.code == 0


@pytest.mark.parametrize(
    ("kind", "name"),
    [
        ("cueing", "hybrid-all"),
        ("plants", "ideal-no-lag"),
        ("platforms", "davsi"),
        ("scenarios", "step-sine-0.5"),
        ("solvers", "dense"),
    ],
)
def test_list_knows_every_kind(kind: str, name: str, capsys: pytest.CaptureFixture[str]) -> None:
    done(["list", kind, "--json"])
    assert name in json.loads(capsys.readouterr().out)
    done(["list", kind])
    assert name in capsys.readouterr().out


def test_run_writes_its_results_and_prints_only_json(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    done(["run", SHORT, "--cueing", "hybrid-first", "--horizon", "50", "--out", str(tmp_path), "--json"])
    output = capsys.readouterr()
    summary = json.loads(output.out)
    assert summary["cueing"] == "hybrid-first"
    assert summary["violations"] == 0
    assert json.loads((tmp_path / "summary.json").read_text()) == summary
    assert "<html" in (tmp_path / "report.html").read_text()
    assert {path.name for path in tmp_path.iterdir()} == {
        ".otolith",
        "report.html",
        "run.h5",
        "summary.json",
    }
    run = files.read_run(tmp_path / "run.h5")
    assert run.settings["wanted"]["scenario"] == SHORT
    assert f"written to {tmp_path}" in output.err


def test_compare_puts_the_promised_figures_side_by_side(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    models = ["implicit", "implicit-trajectory", "hybrid-first", "hybrid-all"]
    chosen = [word for model in models for word in ("--cueing", model)]
    done(["compare", SHORT, *chosen, "--out", str(tmp_path), "--json"])
    summaries = json.loads(capsys.readouterr().out)
    assert list(summaries) == models
    for summary in summaries.values():
        assert {"rmse", "violations"} <= set(summary)
        assert {"mean", "p99", "max"} <= set(summary["changes"])
        assert summary["step_time_us"]["median"] > 0
        assert summary["violations"] == 0
    assert summaries["implicit"]["changes_against_implicit_percent"] == 0.0
    assert files.read_run(tmp_path / "hybrid-all.h5").cueing == "hybrid-all"


def test_inputs_are_held_over_blocks_when_asked_for(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    blocks = ["--blocks", "1,1,2,7,12,20,28,36,43"]
    done(["run", SHORT, "--cueing", "implicit", *blocks, "--out", str(tmp_path), "--json"])
    summary = json.loads(capsys.readouterr().out)
    assert summary["violations"] == 0
    assert summary["settings"]["design"]["mpc"]["blocks"] == [1, 1, 2, 7, 12, 20, 28, 36, 43]
    assert summary["status"] == {"decided": 600}


def write_drive(path: Path, header: str = "t_s,ax_mps2,ay_mps2") -> Path:
    """Four seconds at 50 Hz: a gentle pull to the front."""
    rows = [f"{k / 50:.2f},{0.4 if k > 50 else 0.0},0.1" for k in range(200)]
    path.write_text("\n".join([header, *rows]) + "\n")
    return path


def test_a_recorded_drive_is_cued(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    drive = write_drive(tmp_path / "drive.csv")
    done(
        [
            "run",
            "--log",
            str(drive),
            "--cueing",
            "implicit",
            "--lowpass",
            "5",
            "--out",
            str(tmp_path / "o"),
            "--json",
        ]
    )
    summary = json.loads(capsys.readouterr().out)
    assert summary["violations"] == 0
    assert 0.0 < summary["rmse"] < 0.4


def test_a_log_with_other_names_is_mapped(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    drive = write_drive(tmp_path / "drive.csv", "t_s,Sensor1,other")
    assert "Sensor1" in refused(["run", "--log", str(drive)], capsys)
    done(
        [
            "run",
            "--log",
            str(drive),
            "--column",
            "ax=Sensor1:mps2",
            "--cueing",
            "implicit",
            "--out",
            str(tmp_path / "o"),
        ]
    )


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["run", "sine-3"], "sine-3"),
        (
            ["run", "sine-1", "--cueing", "implicit", "--blocks", "1,x"],
            "--blocks is '1,x', must be numbers of steps with commas",
        ),
        (
            ["run", "sine-1", "--cueing", "implicit", "--blocks", "1,2", "--horizon", "4"],
            "must be of at least 1 step each, 4 in sum",
        ),
        (["run"], "the reference is absent, must be either a scenario's name or --log FILE"),
        (["run", "sine-1", "--log", "x.csv"], "the reference is given twice"),
        (["run", "--log", "absent.csv"], "log absent.csv is absent, must be an existing file"),
        (["run", "sine-1", "--lowpass", "5"], "must be used together with --log"),
        (["run", "sine-1", "--cueing", "best"], "--cueing is 'best', must be one of predictive, explicit"),
        (["run", "sine-1", "--plant", "moon"], "--plant is 'moon', must be one of ideal"),
        (["run", "sine-1", "--platform", "moon"], "platform is 'moon', must be a .toml file or one of"),
        (
            ["run", "sine-1", "--dofs", "pitch"],
            "--dofs is 'pitch', must be one of surge-pitch, sway-roll, heave, yaw, or several with commas",
        ),
        (
            ["run", "sine-1", "--cueing", "implicit", "--washout", "soap"],
            "washout is 'soap', must be one of printed",
        ),
        (
            ["run", "sine-1", "--cueing", "implicit", "--weight", "position"],
            "--weight is 'position', must be of the form NAME=VALUE",
        ),
        (
            ["run", "sine-1", "--cueing", "implicit", "--weight", "position=much"],
            "--weight position is 'much', must be a number",
        ),
        (
            ["run", "sine-1", "--cueing", "implicit", "--weight", "position=-1"],
            "weight position is -1, must be 0, or from 1e-12 to 1e+12",
        ),
        (
            ["run", "sine-1", "--braking", "hard"],
            "braking is 'hard', must be one of stopping, leading, position, printed, none",
        ),
        (
            ["run", "sine-1", "--cueing", "hybrid-all", "--guess-entry", "dual"],
            "guess entry is 'dual', must be one of reference",
        ),
        (
            ["run", "sine-1", "--cueing", "hybrid-all", "--law", "absent.h5"],
            "absent.h5 is absent, must be an existing file",
        ),
        (["run", "sine-1", "--scale", "nan"], "scale is nan, must be greater than 0 and at most 10"),
        (["list", "wheels"], "KIND is 'wheels', must be one of cueing"),
        (["run", "sine-1", "--no-such-option"], "No such option"),
        (["run", "sine-1", "--cueing", "implicit", "--cueing", "implicit"], "--cueing is given twice"),
        (["run", "sine-1", "--scale", "1", "--scale=2"], "--scale is given twice, must be given once"),
        (
            ["run", "sine-1", "--cueing", "implicit", "--weight", "tilt=1", "--weight", "tilt=2"],
            "--weight tilt is given twice",
        ),
        (["run", "--log", "x.csv", "--literal"], "--literal is given, must be left out with --log"),
        (["run", "sine-1", "--out", "/dev/null/out"], "output /dev/null/out is not writable"),
        (["run", "sine-1", "--out", "/dev/null"], "output /dev/null is a file, must be a folder"),
        (["drive", "circle", "--out", "/dev/null/lap.csv"], "output /dev/null is not writable"),
        (["explicit", "build", "--out", "/dev/null/law.h5"], "output /dev/null is not writable"),
        (["compare", "sine-1", "sine-1"], "SCENARIO is sine-1 twice, must be given once each"),
        (["compare", "sine-1", *2 * ["--cueing", "implicit"]], "--cueing is implicit twice, must be given"),
    ],
)
def test_bad_input_is_one_sentence_and_exit_code_2(
    arguments: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert sentence in refused(arguments, capsys)


IGNORED = {
    "classical": ["--weight", "position=3", "--horizon", "20", "--braking", "none", "--soft", "tilt=1"],
    "adaptive": ["--solver", "structured", "--washout", "thesis-fit", "--guess-entry", "reference"],
    "linear-mpc": ["--weight", "position=3"],
    "implicit": ["--tuning", "davsi"],
    "implicit-sensed": ["--soft", "tilt_rate=100"],
    "explicit": ["--prediction", "hold"],
    "predictive": ["--horizon", "20", "--weight", "position=3"],
    "hybrid-learned": ["--law", "law.h5"],
    "hybrid-all": ["--hint", "hint.h5"],
}


@pytest.mark.parametrize(
    ("cueing", "option"),
    [(cueing, n) for cueing, words in IGNORED.items() for n in range(0, len(words), 2)],
)
def test_an_option_that_the_algorithm_does_not_read_is_refused(
    cueing: str, option: int, capsys: pytest.CaptureFixture[str]
) -> None:
    """Even if its value is the default: what would have no effect shall not look as if it had one."""
    words = IGNORED[cueing][option : option + 2]
    message = refused(["run", "sine-1", "--cueing", cueing, *words], capsys)
    assert (
        f"{words[0]} is given, but {cueing} would ignore it, must be left out, or used with one of" in message
    )


def test_a_comparison_takes_what_one_of_its_algorithms_reads_and_records_it_with_that_one(
    tmp_path: Path,
) -> None:
    chosen = ["--cueing", "implicit", "--cueing", "classical", "--horizon", "20", "--tuning", "davsi"]
    chosen += ["--solver", "dense"]  # nothing is compiled for a horizon that no other test has
    done(["compare", "sine:duration=2", "--platform", "davsi", *chosen, "--out", str(tmp_path / "o")])
    records = {
        name: files.read_run(tmp_path / "o" / f"{name}.h5").settings["design"] for name in chosen[1:4:2]
    }
    assert records["implicit"]["mpc"]["horizon"] == 20
    assert "tuning" not in records["implicit"]
    assert records["classical"]["tuning"]["name"] == "davsi"
    assert not {"horizon", "washout", "engine", "soft"} & set(records["classical"]["mpc"])


def test_results_are_replaced_whole_and_other_files_are_not_touched(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "o"
    again = ["run", "sine:duration=2", "--cueing", "classical", "--out", str(out)]
    done([*again, "--dofs", "surge-pitch,sway-roll", "--figures"])
    figures = {f"figure-{dof}.{ending}" for dof in ("surge-pitch", "sway-roll") for ending in ("pdf", "png")}
    assert {path.name for path in out.glob("figure*")} == figures
    done(again)
    assert not list(out.glob("figure*"))
    (out / "notes.txt").write_text("mine")
    capsys.readouterr()
    assert "what 'otolith run' did not write (notes.txt)" in refused(again, capsys)
    done([*again, "--force"])
    assert not (out / "notes.txt").exists()


def test_a_full_disk_is_one_sentence_and_leaves_no_folder(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(_: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    out = tmp_path / "o"
    message = refused(["run", "sine:duration=2", "--cueing", "classical", "--out", str(out)], capsys)
    assert message.endswith(
        f"{out} could not be written: No space left on device; nothing half-written was left"
    )
    assert list(tmp_path.iterdir()) == []


def test_debug_shows_where_it_came_from(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        cli.main(["run", "sine-3", "--debug"])
    assert "Traceback" in capsys.readouterr().err


def test_nothing_is_written_when_the_input_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    refused(["run", "sine-1", "--weight", "sway=1", "--out", str(tmp_path / "o")], capsys)
    assert not (tmp_path / "o").exists()


def test_the_installed_program_answers() -> None:
    done = subprocess.run(
        [sys.executable, "-c", "from otolith.cli import main; main(['list', 'cueing'])"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert "hybrid-all" in done.stdout
