"""`otolith hint` from the outside: what it prints, what it refuses, and how a run goes on without."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from otolith import files
from otolith.cli import main
from otolith.core.errors import CorruptFile
from otolith.core.hdf5 import read_sealed, write_sealed
from otolith.sealed import HINT_KIND, HINT_VERSION
from tests.cueing.hints.training.tiny import tiny_hint
from tests.mutilation import flipped


@pytest.fixture
def stored(tmp_path: Path) -> Path:
    path = tmp_path / "hint.h5"
    files.write_hint(tiny_hint(), path)
    return path


def otolith(*words: str) -> int:
    """Exit code of the program."""
    try:
        main(list(words))
    except SystemExit as stop:
        return int(stop.code or 0)
    return 0


def alter(path: Path) -> None:
    """Change one bit, as a broken disk would."""
    next(flipped(path, count=1))


def test_a_hint_is_built_stored_and_verified(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = str(tmp_path / "hint.h5")
    assert otolith("hint", "build", "--quick", "--json", "--out", path) == 0
    built = json.loads(capsys.readouterr().out)
    assert built["training"]["steps"] > 1000
    out = tmp_path / "judged"
    assert otolith("hint", "verify", path, "--quick", "--json", "--out", str(out)) == 0
    summary = json.loads(capsys.readouterr().out)
    assert json.loads((out / "hint.json").read_text()) == summary
    assert (out / "unseen.png").stat().st_size > 1000
    assert summary["model"] == built["model"]
    assert summary["passed"] is True
    unseen = summary["references"]["unseen"]
    assert set(unseen["schemes"]) == {"cold", "previous", "learned", "law", "table"}
    for scheme in unseen["schemes"].values():
        assert scheme["first_input_gap"] < 1e-6


def test_a_stale_or_altered_hint_is_refused_by_verify_in_one_sentence(
    stored: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert otolith("hint", "verify", str(stored), "--platform", "davsi") == 2
    assert "they differ in" in capsys.readouterr().err
    alter(stored)
    assert otolith("hint", "verify", str(stored)) == 2
    assert "was altered: its content does not match its SHA-256" in capsys.readouterr().err


def test_a_run_takes_a_hint_and_goes_on_without_one_that_it_refuses(
    stored: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["run", "sine:duration=2", "--cueing", "hybrid-learned", "--hint", str(stored), "--json"]
    assert otolith(*words, "--out", str(tmp_path / "with")) == 0
    with_hint = json.loads(capsys.readouterr().out)
    assert with_hint["guesses_missed"] == 0
    alter(stored)
    assert otolith(*words, "--out", str(tmp_path / "without")) == 0
    out, err = capsys.readouterr()
    without = json.loads(out)
    assert "note: hint refused, running without it" in err
    assert "altered" in without["settings"]["hint_refused"]
    assert 0 < without["guesses_missed"] < 200  # only where the remembered set did not settle
    assert without["rmse"] == pytest.approx(with_hint["rmse"], abs=1e-9)


def test_a_flipped_bit_anywhere_is_refused(stored: Path) -> None:
    for _ in flipped(stored, count=200):
        with pytest.raises(CorruptFile, match="damaged"):
            files.read_hint(stored)
    assert files.read_hint(stored).model == tiny_hint().model


@pytest.mark.parametrize("array", ["table.sets", "table.deviation", "law.lengths", "network-0.sizes"])
def test_arrays_that_do_not_belong_together_are_refused(stored: Path, array: str) -> None:
    kind: dict[str, Any] = {"kind": HINT_KIND, "version": HINT_VERSION}
    content = read_sealed(stored, **kind)
    write_sealed(stored, content.attributes, content.arrays | {array: np.zeros((0,))}, **kind)
    with pytest.raises(CorruptFile, match="hint"):
        files.read_hint(stored)


def test_a_hybrid_without_a_hint_asks_for_one(capsys: pytest.CaptureFixture[str]) -> None:
    assert otolith("run", "sine-1", "--cueing", "hybrid-law") == 2
    assert "--hint is absent" in capsys.readouterr().err
