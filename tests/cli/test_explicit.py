"""`otolith explicit` as its user meets it."""

import json
from pathlib import Path

import pytest

from otolith import cli


def done(arguments: list[str], code: int = 0) -> None:
    with pytest.raises(SystemExit) as stopped:
        cli.main(arguments)
    assert stopped.value.code == code


@pytest.fixture(scope="module")
def law(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("laws") / "law.h5"
    done(["explicit", "build", "--block-from", "2", "--out", str(path)])
    return path


def test_build_accounts_for_what_it_built(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "four.h5"
    done(["explicit", "build", "--dofs", "surge-pitch,sway-roll", "--horizon", "2", "--period", "0.25",
          "--out", str(out), "--json"])  # fmt: skip
    account = json.loads(capsys.readouterr().out)
    assert account["regions"] == account["parts"][0] * account["parts"][1]
    assert account["tolerance"] == 1e-7
    assert account["bytes"] / sum(account["parts"]) < 350
    assert {"seconds", "compile_seconds"} <= set(account)
    done(["explicit", "show", str(out), "--json"])
    assert [part["regions"] for part in json.loads(capsys.readouterr().out)["parts"]] == account["parts"]


def test_verify_proves_a_law_and_fails_a_wrong_one(law: Path, capsys: pytest.CaptureFixture[str]) -> None:
    done(["explicit", "verify", str(law), "--samples", "2000", "--json"])
    account = json.loads(capsys.readouterr().out)
    assert account["passed"]
    assert account["missing"] == account["false_hits"] == account["max_overlap"] == 0
    assert account["max_law_error"] <= 1e-8
    assert account["continuity"] <= 1e-8


def test_a_stored_law_serves_the_controllers_it_was_built_for_only(
    law: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    done(
        [
            "run",
            "step:duration=3,end=2",
            "--cueing",
            "explicit",
            "--law",
            str(law),
            "--out",
            str(tmp_path / "o"),
        ]
    )
    capsys.readouterr()
    done(["run", "step-1", "--cueing", "explicit", "--platform", "davsi", "--law", str(law)], code=2)
    assert "the stored law's model is" in capsys.readouterr().err


def test_export_writes_a_pair_of_files(law: Path, tmp_path: Path) -> None:
    done(["explicit", "export", str(law), "--out", str(tmp_path), "--name", "surge", "--outputs", "2"])
    assert {path.name for path in tmp_path.iterdir()} == {"surge.c", "surge.h"}
    assert '#include "surge.h"' in (tmp_path / "surge.c").read_text()


def test_show_prints_a_table(law: Path, capsys: pytest.CaptureFixture[str]) -> None:
    done(["explicit", "show", str(law)])
    assert "953" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--horizon", "0"], "explicit horizon is 0, must be from 1 to 1000 steps"),
        (["--block-from", "9"], "block-from is 9, must be from 1 to the horizon of 5 steps"),
        (["--tolerance", "0"], "--tolerance is 0.0, must be greater than 0"),
        (["--dofs", "pitch"], "--dofs is 'pitch', must be one of surge-pitch"),
        (["--control-weight", "0"], "control weight is 0, must be from 1e-12 to 1e+12"),
    ],
)
def test_wrong_options_are_one_sentence(
    arguments: list[str], sentence: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    done(["explicit", "build", "--out", str(tmp_path / "law.h5"), *arguments], code=2)
    assert sentence in capsys.readouterr().err
    assert not (tmp_path / "law.h5").exists()


@pytest.mark.parametrize("command", ["explicit", "hint"])
def test_a_law_or_hint_that_could_not_be_read_by_its_name_is_refused(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    done([command, "build", "--out", str(tmp_path / "law.txt")], code=2)
    assert "law.txt, must be a name that ends in .h5" in capsys.readouterr().err
