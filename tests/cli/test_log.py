"""`otolith log check`: what is understood of a file, whether or not it is accepted; mapping files."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from otolith import files
from otolith.cli import main
from tests.recordings.checks.drives import ALL, NAMES, SAE, text, written
from tests.recordings.vehicles import car

AIM = NAMES | {
    "ax": "InlineAcc (g)",
    "ay": "LateralAcc (g)",
    "az": "VerticalAcc (g)",
    "heading": "GPS Heading (deg)",
}
G = 9.80665


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def exported() -> str:
    """A logger's export in SAE axes, forces in g, with a heading."""
    data = written(car(), (*ALL, "heading"), SAE)
    return text({k: v / G if k in ("ax", "ay", "az") else v for k, v in data.items()}, AIM)


def run(*words: str) -> int:
    try:
        main(list(words))
    except SystemExit as stop:
        return int(stop.code or 0)
    return 0


def check_log(capsys: pytest.CaptureFixture[str], *words: str) -> dict[str, Any]:
    capsys.readouterr()  # what was said before
    run("log", "check", *words, "--json")
    value: dict[str, Any] = json.loads(capsys.readouterr().out)
    return value


def test_it_tells_table_columns_axes_proofs_and_draws_them(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "drive.csv").write_text(exported())
    assert run("log", "check", "drive.csv") == 0
    output = capsys.readouterr().out
    for words in (
        "names line 1; data from line 2; 6000 rows",
        "LateralAcc (g)",
        "turned",
        "left and right proven by 'GPS Heading (deg)'",
        "the change of speed",
        "speed × the turning of 'GPS Heading (deg)'",
        "agrees",
        "accepted",
    ):
        assert words in output
    picture = (folder / "out" / "drive-check.png").read_bytes()
    assert picture.startswith(b"\x89PNG")
    assert len(picture) > 50_000  # with curves in it


def test_json_holds_the_same_as_numbers(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "drive.csv").write_text(exported())
    output = check_log(capsys, "drive.csv")
    assert output["accepted"]
    assert output["refusal"] is None
    assert output["layout"]["names"] == "line 1"
    assert set(output["axes"]["turned"]) == set(SAE)
    assert output["channels"]["ay"]["sign"] == -1
    assert output["channels"]["ax"]["unit"] == "g"
    assert output["channels"]["vx"]["rate_hz"] == pytest.approx(50.0)
    found = {(r["quantity"], r["with"]): r for r in output["relations"]}
    assert found["ay", "speed × yaw rate"]["correlation"] == pytest.approx(1.0, abs=1e-3)
    assert found["ax", "the change of speed"]["slope"] == pytest.approx(1.0, abs=1e-3)


def test_a_refused_drive_is_shown_too_and_the_exit_code_says_so(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    data = written(car(), ("ax", "ay", "yaw_rate", "vx"), ("ay",))
    (folder / "drive.csv").write_text(text(data))
    assert run("log", "check", "drive.csv", "--out", "seen.png") == 2
    output = capsys.readouterr()
    assert "runs against" in output.out
    assert "refused in its present form" in output.out
    assert "otolith: ay in drive.csv is against speed × yaw rate" in output.err
    assert (folder / "seen.png").exists()
    assert check_log(capsys, "drive.csv")["refusal"].startswith("ay in drive.csv is against")


def test_a_saved_mapping_reads_the_drive_in_the_same_way(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The second file has no heading: what the first proved is stated for it."""
    (folder / "drive.csv").write_text(exported())
    assert run("log", "check", "drive.csv", "--save-mapping", "map.toml") == 0
    data = written(car(), ALL, SAE)
    data = {k: v / G if k in ("ax", "ay", "az") else v for k, v in data.items()}
    (folder / "second.csv").write_text(text(data, AIM))
    mapping = files.read_log_settings(folder / "map.toml")
    assert mapping.axes == "sae"
    del mapping.columns["heading"]  # type: ignore[attr-defined]
    first = files.read_log(folder / "drive.csv", {})
    second = files.read_log(folder / "second.csv", {}, settings=mapping)
    assert_allclose(second.force, first.force, atol=1e-9)
    assert_allclose(second.rate, first.rate, atol=1e-9)
    output = check_log(capsys, "drive.csv", "--mapping", "map.toml")
    assert output["accepted"]
    assert not any("not proven" in note for note in output["notes"])


def test_events_are_listed_and_cut(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    data = written(car(), ("ax", "ay", "yaw_rate", "vx"))
    data = {k: np.r_[v[:2050], np.full(150, v[2049]), v[2050:]] for k, v in data.items()}
    data["t"] = 0.02 * np.arange(len(data["vx"]), dtype=float)
    (folder / "drive.csv").write_text(text(data))
    refused = check_log(capsys, "drive.csv")
    assert [event["kind"] for event in refused["events"]] == ["pause"]
    assert refused["events"][0]["start_s"] == pytest.approx(40.98)
    cut = check_log(capsys, "drive.csv", "--events", "cut")
    assert cut["accepted"]
    assert cut["duration_s"] == pytest.approx(data["t"][-1] - 3.0, abs=0.03)


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("nothing.csv",), "log nothing.csv is absent"),
        (("drive.csv", "--axes", "nautical"), "--axes is 'nautical'"),
        (("drive.csv", "--events", "drop"), "--events is 'drop'"),
        (("drive.csv", "--mapping", "absent.toml"), "mapping absent.toml is not readable"),
        (("drive.csv", "--column", "ax"), "--column is 'ax', must be of the form NAME=VALUE"),
    ],
)
def test_a_wrong_word_is_one_sentence(
    words: tuple[str, ...], sentence: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "drive.csv").write_text(text(written(car(), ("ax", "ay"))))
    assert run("log", "check", *words) == 2
    assert sentence in capsys.readouterr().err


def test_options_for_logs_are_refused_without_one(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("run", "sine-1", "--axes", "sae", "--events", "cut") == 2
    assert "--axes and --events is given, must be used together with --log" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("option", "name", "endings"),
    [("--out", "picture", ".pdf or .png or .svg"), ("--save-mapping", "map.csv", ".toml")],
)
def test_a_name_with_the_wrong_ending_is_refused_before_the_log_is_read(
    folder: Path, capsys: pytest.CaptureFixture[str], option: str, name: str, endings: str
) -> None:
    assert run("log", "check", "absent.csv", option, name) == 2
    assert f"name of the output is {name}, must be a name that ends in {endings}" in capsys.readouterr().err
