"""`otolith terminal`: sets are built, stored, read, proved and tried, and refused where they do not fit."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from otolith import files
from otolith.cli.app import run_program
from otolith.core.errors import CorruptFile
from otolith.core.hdf5 import read_sealed, write_sealed
from otolith.sealed import SETS_KIND, SETS_VERSION
from tests.mutilation import flipped

KIND: dict[str, Any] = {"kind": SETS_KIND, "version": SETS_VERSION}


def otolith(*words: str) -> int:
    """Exit code of a call of the program."""
    with pytest.raises(SystemExit) as ended:
        run_program([*words])
    return int(ended.value.code or 0)


@pytest.fixture(scope="module")
def stored(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("sets") / "thesis.h5"
    assert otolith("terminal", "build", "thesis", "-o", str(path)) == 0
    return path


def test_what_is_built_is_verified_from_its_file_alone(
    stored: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert otolith("terminal", "verify", str(stored), "--states", "60", "--steps", "20", "--json") == 0
    summary = json.loads(capsys.readouterr().out)
    assert summary["passed"] is True
    assert set(summary["proofs"]) == {"surge", "pitch", "sway", "roll"}
    assert set(summary["trials"]) == {"surge", "pitch", "sway", "roll", "circle"}
    assert summary["proofs"]["surge"]["ahead"] == pytest.approx(0.25 * 1.1**9, abs=1e-9)
    assert {one["infeasible"] + one["violations"] for one in summary["trials"].values()} == {0}


def test_a_platform_is_verified_without_a_file(capsys: pytest.CaptureFixture[str]) -> None:
    assert otolith("terminal", "verify", "benchmark", "--states", "0", "--braking", "none") == 0
    shown = capsys.readouterr()
    assert shown.err.count("proved") == 2
    assert "passed" not in shown.err
    assert shown.out == ""


def test_a_file_comes_back_equal_and_a_flipped_bit_is_refused(stored: Path) -> None:
    sets = files.read_sets(stored)
    assert sets.platform.name == "thesis"
    again = stored.with_name("again.h5")
    files.write_sets(sets, again)
    for name, one in files.read_sets(again).axes.items():
        arrays = sets.axes[name].to_arrays()
        for key, array in one.to_arrays().items():
            np.testing.assert_array_equal(array, arrays[key])
    for _ in flipped(again, count=150):
        with pytest.raises(CorruptFile, match="damaged"):
            files.read_sets(again)


def changed(stored: Path, attributes: dict[str, Any], arrays: dict[str, Any]) -> Path:
    """A soundly sealed file with other content."""
    content, path = read_sealed(stored, **KIND), stored.with_name("changed.h5")
    summary = {key: value for key, value in (content.attributes | attributes).items() if value is not None}
    kept = {key: value for key, value in (content.arrays | arrays).items() if value is not None}
    write_sealed(path, summary, kept, **KIND)
    return path


@pytest.mark.parametrize(
    ("attributes", "arrays", "reason"),
    [
        ({"platform_sha256": "0" * 64}, {}, "SHA-256"),
        ({"period": 0.0}, {}, "periods of 0 s"),
        ({"braking": "hard"}, {}, "hard"),
        ({"lag": None}, {}, "lacks"),
        ({}, {"surge/forms": None}, "lacks the array forms"),
        ({}, {"surge/upper": np.zeros(3)}, "shape"),
        ({}, {"heave/forms": np.zeros((1, 3))}, "lacks the array lower"),
    ],
)
def test_content_that_does_not_belong_together_is_refused(
    stored: Path, attributes: dict[str, Any], arrays: dict[str, Any], reason: str
) -> None:
    with pytest.raises(CorruptFile, match=reason):
        files.read_sets(changed(stored, attributes, arrays))


def test_a_proof_that_fails_is_told_with_exit_code_1(
    stored: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A file whose seal is sound, of the same platform, with one vertex fewer."""
    arrays = read_sealed(stored, **KIND).arrays
    fewer = {f"roll/cell-0/{name}": arrays[f"roll/cell-0/{name}"][1:] for name in ("vertices", "commands")}
    path = changed(stored, {}, fewer)
    capsys.readouterr()
    assert otolith("terminal", "verify", str(path), "--states", "0", "--json") == 1
    summary = json.loads(capsys.readouterr().out)
    assert summary["passed"] is False
    assert {name: one["missing"] for name, one in summary["proofs"].items() if one["missing"]} == {"roll": 1}


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("build", "nowhere"), "platform is 'nowhere'"),
        (("build", "thesis", "--braking", "hard"), "braking is 'hard'"),
        (("verify", "thesis", "--period", "2"), "--period is 2 s, must be from 0.0001 to 1 s"),
        (("verify", "gone.h5"), "file gone.h5 is absent"),
    ],
)
def test_bad_input_gets_one_sentence(
    arguments: tuple[str, ...],
    sentence: str,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert otolith("terminal", *arguments) == 2
    assert sentence in " ".join(capsys.readouterr().err.split())
    assert list(tmp_path.iterdir()) == []


def test_a_file_belongs_to_one_platform(stored: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """To every change of a platform's file, and it says itself what else it was built with."""
    verify = ("terminal", "verify", str(stored), "--states", "0")
    assert otolith(*verify, "--platform", "thesis") == 0
    assert otolith(*verify, "--platform", "davsi") == 2
    assert "that of davsi" in " ".join(capsys.readouterr().err.split())
    for option in (("--braking", "none"), ("--period", "0.02")):
        assert otolith(*verify, *option) == 2
        assert "for the file says it itself" in " ".join(capsys.readouterr().err.split())
    assert otolith("terminal", "verify", "thesis", "--platform", "thesis") == 2
