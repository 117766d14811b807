"""`otolith optimum`, and `--optimum` of `run` and `compare`."""

import json
import sys
from pathlib import Path
from typing import Any

import pytest

from otolith import files
from otolith.cueing.optimum import NoOptimum
from tests.cli.test_cli import done, refused

SHORT = "step:amplitude=2,start=1,end=5,duration=6"


CURVE = '"best possible"'  # the name of the curve on a page
STEEP = ["--cueing", "classical", "--cueing", "optimal"]


def kept(folder: Path) -> Any:
    return json.loads((folder / "summary.json").read_text(encoding="utf-8"))


def test_the_optimum_is_written_as_a_run_and_repeated_from_its_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    done(["optimum", SHORT, "--scale", "0.9", "--out", str(tmp_path / "o")])
    assert "certified to" in capsys.readouterr().err
    run = files.read_run(tmp_path / "o" / "run.h5")
    assert run.cueing == "optimum"
    assert kept(tmp_path / "o")["optimum"]["times"] == 1.0
    page = (tmp_path / "o" / "report.html").read_text(encoding="utf-8")
    assert SHORT in page  # how it was made
    assert CURVE not in page  # it is that
    done(["rerun", str(tmp_path / "o" / "run.h5"), "--json"])
    assert json.loads(capsys.readouterr().out)["equal"] is True


def test_every_run_says_how_far_it_is_from_the_best(tmp_path: Path) -> None:
    done(["run", SHORT, "--cueing", "classical", "--out", str(tmp_path / "o")])
    entry = kept(tmp_path / "o")["optimum"]
    assert entry["times"] > 1.5
    assert entry["certificate"] < 1e-4
    page = (tmp_path / "o" / "report.html").read_text(encoding="utf-8")
    assert f"Its error is {entry['times']:.2f} times the best that is possible on this drive" in page
    assert CURVE in page


def test_a_comparison_says_how_far_each_is_from_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    done(["compare", SHORT, *STEEP, "--out", str(tmp_path / "o")])
    assert capsys.readouterr().err.count("times the best that is possible on this drive (") == 2
    page = (tmp_path / "o" / "report.html").read_text(encoding="utf-8")
    assert "Times the least possible error on this drive: " in page
    assert '<th scope="col">Times the best</th>' in page
    done(["compare", SHORT, "step-1", *STEEP, "--out", str(tmp_path / "two")])
    page = (tmp_path / "two" / "report.html").read_text(encoding="utf-8")
    assert "A perfect answer is within reach of the platform on this drive." in page
    assert page.count(CURVE) == 2
    each = kept(tmp_path / "two")["scenarios"]
    assert [one["classical"]["optimum"]["times"] is None for one in each.values()] == [False, True]


def test_where_it_is_not_computed_a_page_says_how_to_get_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    done(["run", SHORT, "--cueing", "classical", "--no-optimum", "--out", str(tmp_path / "o")])
    assert kept(tmp_path / "o")["optimum"] == {"not_computed": "add --optimum"}
    page = (tmp_path / "o" / "report.html").read_text(encoding="utf-8")
    assert "the best that is possible is not computed; add --optimum" in page
    assert "best that is possible" not in capsys.readouterr().err
    long = "step:amplitude=2,start=1,end=5,duration=61"
    done(["run", long, "--cueing", "classical", "--out", str(tmp_path / "long")])
    reason = kept(tmp_path / "long")["optimum"]["not_computed"]
    assert reason == "the drive lasts 61 s, more than 60 s: add --optimum"


def test_what_cannot_be_certified_costs_nobody_a_run(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys.modules[NoOptimum.__module__], "ACCEPTED", 0.0)
    done(["run", SHORT, "--cueing", "classical", "--out", str(tmp_path / "o")])
    assert kept(tmp_path / "o")["optimum"]["not_computed"].endswith("must be at most 0")
    assert "is not known: the optimum of step" in capsys.readouterr().err
    assert "is not certified" in (tmp_path / "o" / "report.html").read_text(encoding="utf-8")


def test_a_plant_without_lag_is_measured_by_one(tmp_path: Path) -> None:
    done(
        ["run", SHORT, "--cueing", "classical", "--plant", "ideal-no-lag", "--out", str(tmp_path / "o")],
    )
    assert kept(tmp_path / "o")["optimum"]["plant"] == "ideal-no-lag"
    done(["run", SHORT, "--cueing", "classical", "--plant", "actuator", "--out", str(tmp_path / "a")])
    page = (tmp_path / "a" / "report.html").read_text(encoding="utf-8")
    assert ", measured on the plant ideal" in page


@pytest.mark.parametrize(
    ("option", "sentence"),
    [
        (["--horizon", "5"], "--horizon is given, but the optimum would ignore it, must be left out"),
        (["--plant", "ideal"], "--plant is given, but the optimum would ignore it, must be left out"),
    ],
)
def test_what_has_no_effect_is_refused(
    option: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert sentence in refused(["optimum", SHORT, *option], capsys)


def test_warming_up_compiles_it_in_advance(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("otolith.cli.bench._USUAL", [])  # minutes of compiling, which other tests do
    done(["warmup"])
    assert "optimum: ready after" in capsys.readouterr().err
