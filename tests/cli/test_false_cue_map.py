"""`otolith map`: false cues of a run, on the map of its drive."""

import json
from pathlib import Path

import pytest

from otolith import files
from otolith.metrics.false_cues import false_cues
from tests.cli.test_cli import done, refused


@pytest.fixture(scope="module")
def run_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A short hard stop, cued, its drive beside it."""
    folder = tmp_path_factory.mktemp("misled")
    done(["drive", "braking:run=30,stop=80", "--speed", "60", "--out", str(folder / "lap.csv")])
    lap = ["--log", str(folder / "lap.csv"), "--column", "az=none"]
    done(["run", *lap, "--cueing", "implicit", "--out", str(folder / "out")])
    return folder / "out" / "run.h5"


def test_false_cues_are_found_on_the_map_the_gravest_first(
    run_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    done(["map", str(run_file), "--json"])
    output = capsys.readouterr()
    found = json.loads(output.out)["false_cues"]
    assert len(found) == len(false_cues(files.read_run(run_file)))
    integrals = [cue["integral_mps"] for cue in found]
    assert integrals == sorted(integrals, reverse=True)
    assert all(0.0 <= cue["way_m"] <= 80.0 and cue["x_m"] == pytest.approx(cue["way_m"]) for cue in found)
    assert found[0]["way_m"] > 20.0  # it is the stop that misleads
    assert run_file.with_name("map.png").read_bytes().startswith(b"\x89PNG")
    assert "map written to" in output.err


def test_a_drive_that_moved_is_named_anew(run_file: Path, tmp_path: Path) -> None:
    moved = tmp_path / "elsewhere.csv"
    moved.write_bytes((run_file.parents[1] / "lap.csv").read_bytes())
    done(["map", str(run_file), "--log", str(moved), "--out", str(tmp_path / "m.pdf"), "--threshold", "9"])
    assert (tmp_path / "m.pdf").read_bytes().startswith(b"%PDF")


def test_without_a_place_there_is_no_map(
    run_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bare = tmp_path / "bare.csv"
    bare.write_text("t_s,ax_mps2\n" + "\n".join(f"{k / 50},0.1" for k in range(100)))
    assert "place of bare.csv is missing" in refused(["map", str(run_file), "--log", str(bare)], capsys)
    done(
        [
            "run",
            "step-sine:amplitude=0.5,duration=6,sine_start=5.5",
            "--cueing",
            "implicit",
            "--out",
            str(tmp_path / "s"),
        ]
    )
    capsys.readouterr()
    assert "the run is not of a recorded drive" in refused(["map", str(tmp_path / "s" / "run.h5")], capsys)
