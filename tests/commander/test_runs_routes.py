"""What is stored in the folder of results, as the page of all runs gets it."""

import json
import os
from pathlib import Path
from typing import Any

import pytest

from otolith.commander import runs_routes
from otolith.commander.runs_routes import stored_runs
from tests.commander.client import Page
from tests.commander.conftest import until
from tests.commander.test_server import LONG

ONE: dict[str, Any] = {"scenario": "step-1", "cueing": "classical", "platform": "davsi", "rmse": 0.5}


def keep(folder: Path, name: str, summary: Any, at: float) -> None:
    made = folder / name
    made.mkdir(parents=True)
    path = made / "summary.json"
    path.write_text(summary if isinstance(summary, str) else json.dumps(summary))
    os.utime(path, (at, at))


def test_one_run_and_several_are_listed_the_newest_first(tmp_path: Path) -> None:
    keep(tmp_path, "one", ONE | {"settings": {"secret": 1}}, 100.0)
    keep(tmp_path, "two", {"classical": ONE, "optimal": ONE | {"cueing": "optimal"}}, 200.0)
    (tmp_path / "one" / "report.html").write_text("")
    (tmp_path / "empty").mkdir()
    found = stored_runs(tmp_path)
    assert [(run["folder"], run["cueing"], run["time"]) for run in found["runs"]] == [
        ("two", "classical", 200.0),
        ("two", "optimal", 200.0),
        ("one", "classical", 100.0),
    ]
    assert found["runs"][2]["files"] == ["report.html", "summary.json"]
    assert found["runs"][2]["summary"] == ONE
    assert (found["refused"], found["left_out"]) == ([], 0)
    assert stored_runs(tmp_path / "nowhere")["runs"] == []


@pytest.mark.parametrize("damaged", ["", "[1]", "3", '{"scenario": 1}', '{"a": 1}', "\x00", "[" * 100_000])
def test_a_damaged_summary_is_a_sentence_and_hides_no_other(damaged: str, tmp_path: Path) -> None:
    keep(tmp_path, "good", ONE, 100.0)
    keep(tmp_path, "bad", damaged, 200.0)
    found = stored_runs(tmp_path)
    assert [run["folder"] for run in found["runs"]] == ["good"]
    (sentence,) = found["refused"]
    assert sentence.startswith("bad: its summary.json is none of a run")


def test_only_the_newest_are_listed_and_huge_ones_are_not_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for k in range(5):
        keep(tmp_path, f"run-{k}", ONE, float(k))
    monkeypatch.setattr(runs_routes, "MOST", 3)
    found = stored_runs(tmp_path)
    assert [run["folder"] for run in found["runs"]] == ["run-4", "run-3", "run-2"]
    assert found["left_out"] == 2
    monkeypatch.setattr(runs_routes, "LARGEST", 10)
    assert len(stored_runs(tmp_path)["refused"]) == 3


def test_a_run_of_the_real_server_is_listed_with_its_files_and_nothing_else_is(page: Page) -> None:
    generation = page.run(**LONG, speed=0.0)
    with page.stream() as stream:
        stream.until("done", generation=generation)
    newest = page.ask("/api/runs").json["runs"][0]
    assert newest["cueing"] == "classical"
    assert newest["summary"]["rmse"] == page.ask("/api/result").json["summary"]["rmse"]
    report = page.ask(f"/api/runs/{newest['folder']}/report.html")
    assert (report.status, b"<html" in report.body.lower()) == (200, True)
    assert "sandbox" in report.headers["content-security-policy"]
    for path in (
        f"{newest['folder']}/.otolith",
        f"{newest['folder']}/nothing.h5",
        "nowhere/run.h5",
        "..%2Fpresets/a.json",
        "../presets/a.json",
        "%2e%2e/summary.json",
        f"{newest['folder']}/..%2f..%2fdrives%2fdrive.csv",
    ):
        assert page.ask(f"/api/runs/{path}").status in (404, 422), path
    until(lambda: page.ask("/api/runs").status == 200, 5.0)
    assert 429 in {page.ask("/api/runs").status for _ in range(60)}
