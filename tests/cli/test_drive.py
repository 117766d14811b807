"""`otolith drive`: what it writes can be cued, and what cannot be driven is refused."""

import json
from pathlib import Path

import h5py
import numpy as np
import pytest

from otolith import cli, files
from otolith.vehicle import Driver, drive, load_car, road
from otolith.vehicle.lap import COLUMNS
from tests.cli.test_cli import done, refused


def test_a_drive_is_written_with_a_map_and_told_as_json(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lap = tmp_path / "lap.csv"
    done(["drive", "slalom:cones=2", "--speed", "50", "--out", str(lap), "--json"])
    output = capsys.readouterr()
    summary = json.loads(output.out)
    assert summary["road"] == "slalom"
    assert summary["estimated"]
    assert {"time_s", "ax_mps2", "ay_mps2", "limit_excess_percent"} <= set(summary)
    assert lap.read_text().splitlines()[0] == ",".join(COLUMNS)
    data = np.loadtxt(lap, delimiter=",", skiprows=1)
    assert data[1, 0] - data[0, 0] == pytest.approx(0.01)
    assert data[-1, 0] == pytest.approx(summary["time_s"])
    assert (tmp_path / "lap-map.png").read_bytes().startswith(b"\x89PNG")
    assert str(lap) in output.err


def test_hdf5_holds_the_same_columns(tmp_path: Path) -> None:
    for name in ("lap.csv", "lap.h5"):
        done(["drive", "slalom:cones=2", "--speed", "50", "--rate", "200", "--out", str(tmp_path / name)])
    table = np.loadtxt(tmp_path / "lap.csv", delimiter=",", skiprows=1)
    with h5py.File(tmp_path / "lap.h5") as file:
        assert file.attrs["kind"] == "otolith-lap"
        assert np.allclose(np.stack([file[name][()] for name in COLUMNS], axis=1), table, atol=1e-6)
    assert table[1, 0] == pytest.approx(0.005)


def test_a_centreline_and_a_car_of_ones_own_are_driven(tmp_path: Path) -> None:
    from importlib.resources import files as resources

    car = tmp_path / "mine.toml"
    car.write_text((resources("otolith.vehicle") / "data" / "tesla-model-s.toml").read_text("utf-8"))
    angle = np.linspace(0.0, 2.0 * np.pi, 60)[:-1]
    road = tmp_path / "ring.csv"
    rows = [f"{80 * np.cos(a):.4f},{80 * np.sin(a):.4f},5,5" for a in angle]
    road.write_text("\n".join(["# x_m,y_m,w_tr_right_m,w_tr_left_m", *rows]))
    options = ["--car", str(car), "--roughness", "A", "--standing", "--gg", "1.5", "--speed", "60"]
    done(["drive", str(road), *options, "--out", str(tmp_path / "o.csv")])
    assert (tmp_path / "o.csv").exists()


def test_what_was_made_of_a_file_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A GPX track goes in; the notes stand on the terminal and in the JSON."""
    angle = np.linspace(0.0, 2.0 * np.pi, 60)[:-1]
    points = "".join(
        f'<trkpt lat="{48.1 + 7e-4 * np.sin(a):.7f}" lon="{11.6 + 1e-3 * np.cos(a):.7f}"/>' for a in angle
    )
    road = tmp_path / "ring.gpx"
    road.write_text(f"<gpx><trk><trkseg>{points}</trkseg></trk></gpx>")
    options = ["--speed", "40", "--closed", "--smoothing", "0.05"]
    done(["drive", str(road), *options, "--out", str(tmp_path / "o.csv"), "--json"])
    output = capsys.readouterr()
    (note,) = json.loads(output.out)["notes"]
    assert note.startswith("x east, y north of latitude 48.1")
    assert f"note: ring.gpx: {note}" in output.err


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (
            ["drive", "slalom", "--smoothing", "1"],
            "--smoothing is given, must be left out, for 'slalom' is not",
        ),
        (["drive", "slalom", "--open"], "--closed or --open is given, must be left out, for 'slalom' is not"),
        (["drive", "x.csv", "--smoothing", "-1"], "--smoothing is -1 m, must be between 0 and 20 m"),
        (["drive", "x.gpx"], "GPX file x.gpx is not readable"),
        (["drive", "nordschleife"], "road is 'nordschleife', must be one of hockenheim"),
        (["drive", "slalom", "--speed", "0"], "--speed is 0 km/h, must be between 1 and 500 km/h"),
        (["drive", "slalom", "--out", "lap.txt"], "lap.txt, must be a name that ends in .csv or .h5"),
        (["drive", "slalom", "--car", "beetle"], "car is 'beetle', must be one of tesla-model-s"),
        (["drive", "slalom", "--roughness", "Q"], "roughness is 'Q', must be one of A, B, C, D, E"),
        (["drive", "absent.csv"], "centreline absent.csv is not readable"),
        (["drive", "slalom", "--brake", "40"], "driver's brake limit is 40, must be between 0.5 and 20"),
        (["drive", "circle:radius=30", "--speed", "200", "--lateral", "18"], "off the path at"),
        (["drive", "slalom", "--rate", "300"], "rate is 300 Hz, must be 1000 Hz or a whole fraction of it"),
    ],
)
def test_what_cannot_be_driven_is_one_sentence(
    arguments: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert sentence in refused(arguments, capsys)


def test_roads_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        cli.main(["list", "roads", "--json"])
    roads = json.loads(capsys.readouterr().out)
    assert "cones=8" in roads["slalom"]
    assert "thesis section 6.3" in roads["hockenheim"]


@pytest.mark.parametrize("ending", ["csv", "h5"])
def test_a_lap_is_a_log_without_doubts(tmp_path: Path, ending: str) -> None:
    """Force, rates and place come back; no check finds fault with a drive of our own."""
    lap = tmp_path / f"lap.{ending}"
    done(["drive", "slalom:cones=4", "--speed", "50", "--out", str(lap)])
    log = files.read_log(lap, {})
    driven = drive(road("slalom:cones=4").limited(50 / 3.6), load_car(), Driver())
    assert np.allclose(log.force, driven.force, atol=1e-6)
    assert np.allclose(log.rate, driven.rate, atol=1e-6)
    assert log.place is not None
    assert np.allclose(log.place, driven.position[:, :2], atol=1e-4)
    assert len(log.notes) == 10  # the rows, where each of seven quantities stands, left and right, and:
    assert log.notes[-1].startswith("the sign of roll_rate is not proven")  # 24 s are too short to tell


def test_a_lap_is_cued_through_an_otolith(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lap = tmp_path / "lap.csv"
    done(["drive", "braking:run=30,stop=70", "--speed", "40", "--out", str(lap)])
    capsys.readouterr()
    options = ["--through", "telban", "--cueing", "implicit", "--out", str(tmp_path / "o"), "--json"]
    done(["run", "--log", str(lap), *options])
    assert json.loads(capsys.readouterr().out)["violations"] == 0
    run = files.read_run(tmp_path / "o" / "run.h5")
    driven = files.read_log(lap, {})
    felt = np.interp(run.time, driven.t, driven.force[:, 0])
    share = np.dot(run.reference_force[:, 0], felt) / np.dot(felt, felt)
    assert 0.6 < share < 0.8  # 0.8 at once, 0.4 in the end, with 5 s between them
    assert "must be one of otolith-telban" in refused(["run", "sine-1", "--through", "nose"], capsys)
