"""`--road`: an earlier drive is foreseen, kept in the record, and refused where nothing would read it."""

from pathlib import Path

import numpy as np
import pytest

from otolith import files
from tests.cli.test_cli import done, refused

DENSE = ["--cueing", "implicit", "--solver", "dense", "--horizon", "20"]


def written(path: Path, speed: float, seconds: float = 4.0) -> Path:
    """A drive straight on at a constant speed, over a force that belongs to the place."""
    t = np.arange(0.0, seconds, 0.01)
    way = speed * t
    values = np.stack([t, 0.3 * np.sin(way / 10.0), 0.0 * t, 0.0 * t, way, 0.0 * t], axis=1)
    rows = "\n".join(",".join(f"{value:.6f}" for value in row) for row in values)
    path.write_text(f"t_s,fx_mps2,fy_mps2,yaw_rate_radps,x_m,y_m\n{rows}\n")
    return path


def test_a_run_with_a_road_is_made_again_from_its_file(tmp_path: Path) -> None:
    log, earlier = written(tmp_path / "now.csv", 20.0), written(tmp_path / "then.csv", 18.0)
    done(["run", "--log", str(log), "--road", str(earlier), *DENSE, "--out", str(tmp_path / "a")])
    plain = tmp_path / "plain"
    done(["run", "--log", str(log), *DENSE, "--out", str(plain)])
    run = files.read_run(tmp_path / "a" / "run.h5")
    assert run.settings["wanted"]["road"]["path"] == str(earlier)
    assert run.settings["design"]["mpc"]["prediction"]["name"] == "road"
    assert not np.array_equal(run.pose, files.read_run(plain / "run.h5").pose)
    moved = earlier.rename(tmp_path / "moved.csv")
    done(["rerun", str(tmp_path / "a" / "run.h5"), "--road", str(moved)])


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (["--prediction", "road"], "--prediction road is given alone, must be given with --road FILE"),
        (["--road", "LOG", "--prediction", "hold"], "--road is given, must be left out, or given with"),
        (["--road", "LOG", "--cueing", "classical"], "--road is given, but"),
    ],
)
def test_a_road_that_nothing_reads_is_refused(
    options: list[str], sentence: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = written(tmp_path / "now.csv", 20.0)
    options = [str(log) if option == "LOG" else option for option in options]
    given = options if "--cueing" in options else [*options, *DENSE]
    assert sentence in refused(["run", "--log", str(log), *given, "--out", str(tmp_path / "a")], capsys)
