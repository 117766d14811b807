"""Files are found by name and by path, and written whole or not at all."""

import contextlib
import os
import struct
import subprocess
import sys
from collections.abc import Callable
from importlib import resources
from pathlib import Path

import numpy as np
import pytest

from otolith import files
from otolith.core.disk import NotWritten
from otolith.core.errors import InputError, OtolithError
from otolith.loop import Run
from tests.mutilation import flipped


def test_a_failure_while_writing_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "summary.json"
    files.write_json(path, {"a": 1})
    with pytest.raises(ValueError, match="not JSON compliant"):
        files.write_json(path, {"a": float("nan")})

    def interrupted(temporary: Path) -> None:
        temporary.write_text("half")
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        files.write_figure(path, interrupted)
    assert path.read_text() == '{\n  "a": 1\n}\n'
    assert [p.name for p in tmp_path.iterdir()] == ["summary.json"]


def test_an_unwritable_place_is_one_sentence(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(NotWritten, match=r"below.txt could not be written: (Not a directory|File exists)"):
        files.write_text(tmp_path / "file" / "below.txt", "x")


def test_platforms_are_found_by_name_and_by_path(tmp_path: Path) -> None:
    assert files.read_platform("davsi").name == "davsi"
    with pytest.raises(InputError, match=r"platform is 'davsy', must be a .toml file or one of"):
        files.read_platform("davsy")
    with pytest.raises(InputError, match="not readable"):
        files.read_platform(str(tmp_path / "rig.toml"))
    binary = tmp_path / "binary.toml"
    binary.write_bytes(b"name = '\xff'")
    with pytest.raises(InputError, match="not UTF-8 at byte 8, must be a UTF-8 text file"):
        files.read_platform(str(binary))


def hostile_text(path: Path, head: str, unit: str, size: int) -> Path:
    """A file that begins as it should and then repeats one unit until it has `size` bytes."""
    path.write_text(head + unit * (size // len(unit)))
    return path


@pytest.mark.parametrize(
    ("unit", "size", "sentence"),
    [
        ("a", 2_000_000, "more than 1,000,000 bytes, must be at most 1,000,000 bytes"),
        ("[", 200_000, "length of line 1 of rig.toml is 200,000 characters, must be at most 2,000"),
        ("a.", 200_000, "length of line 1 of rig.toml is 200,000 characters, must be at most 2,000"),
        ("[\n", 400_000, "a value in rig.toml is nested too deeply, must be a few levels deep"),
    ],
)
def test_settings_that_would_keep_the_parser_busy_are_one_sentence(
    tmp_path: Path, unit: str, size: int, sentence: str
) -> None:
    head = "x = " if unit.endswith("\n") else ""
    path = hostile_text(tmp_path / "rig.toml", head, unit, size)
    for read in (files.read_platform, files.read_tuning, files.read_car):
        with pytest.raises(InputError) as refused:
            read(str(path))
        assert sentence in str(refused.value)


@pytest.mark.parametrize("begin", ['<?xml version="1.0"?>\n<gpx', "\ufeff<kml", "\n<!DOCTYPE html"])
def test_a_track_of_places_is_no_log_and_the_sentence_says_what_it_is_for(begin: str, tmp_path: Path) -> None:
    (tmp_path / "way.gpx").write_text(f'{begin}><trkpt lat="50" lon="8"/></a>', encoding="utf-8")
    with pytest.raises(
        InputError, match=r"log way\.gpx is XML.*otolith drive .*way\.gpx makes a drive of it"
    ):
        files.read_log(tmp_path / "way.gpx", {})
    (tmp_path / "way.gpx").rename(tmp_path / "way.txt")
    with pytest.raises(InputError, match=r"must be a table or JSON$"):
        files.read_log(tmp_path / "way.txt", {})


def test_a_log_of_one_endless_line_is_refused(tmp_path: Path) -> None:
    path = hostile_text(tmp_path / "drive.csv", "t_s,ax_mps2\n0,0\n", "1,", 20_000_000)
    with pytest.raises(InputError, match=r"line of log .*drive.csv is more than 1 MiB"):
        files.read_log(path, {})
    path = hostile_text(tmp_path / "drive.csv", "t_s,ax_mps2\n0,0\n", "1,", 200_000)
    with pytest.raises(InputError, match=r"length of line 3 of drive.csv is 200,000 characters"):
        files.read_log(path, {})


def write_erg(folder: Path) -> Path:
    """Two seconds of a CarMaker result."""
    record = np.dtype([("t", "<f8"), ("ax", "<f4"), ("yaw", "<f8")])
    rows = np.zeros(200, dtype=record)
    rows["t"] = np.arange(200) / 100
    path = folder / "drive.erg"
    head = struct.pack("<8sBBH4x", b"CM-ERG", 1, 0, record.itemsize)
    path.write_bytes(head + rows.tobytes())
    named = (("Time", "Double"), ("Car.ax", "Float"), ("Car.YawRate", "Double"))
    lines = [
        f"File.At.{k}.Name = {name}\nFile.At.{k}.Type = {kind}" for k, (name, kind) in enumerate(named, 1)
    ]
    lines += ["Quantity.Car.ax.Unit = m/s^2", "Quantity.Car.ax.Factor = 1.0"]
    path.with_name("drive.erg.info").write_text("File.ByteOrder = LittleEndian\n" + "\n".join(lines) + "\n")
    return path


def write_csv(folder: Path) -> Path:
    path = folder / "drive.csv"
    path.write_text("t_s,ax_mps2,ay_mps2\n" + "".join(f"{k / 50:.2f},0.1,0.2\n" for k in range(200)))
    return path


@pytest.mark.parametrize(
    ("write", "name", "count"),
    [
        (write_erg, "drive.erg", 150),
        (write_csv, "drive.csv", 150),
    ],
)
def test_a_flipped_bit_in_a_log_is_read_or_refused_and_nothing_else(
    tmp_path: Path, write: Callable[[Path], Path], name: str, count: int
) -> None:
    drive = write(tmp_path)
    files.read_log(drive, {})
    for _ in flipped(tmp_path / name, count=count):
        with contextlib.suppress(OtolithError):
            files.read_log(drive, {})


MDF = """
import contextlib, sys
from pathlib import Path
import asammdf, numpy as np
from otolith import files
from otolith.core.errors import OtolithError
from tests.mutilation import flipped

path, t = Path(sys.argv[1]), np.arange(0.0, 2.0, 0.01)
with asammdf.MDF(version="4.10") as file:
    file.append([asammdf.Signal(np.sin(t), t, name="AccX", unit="m/s2", encoding="utf-8")])
    file.save(path, overwrite=True)
for _ in flipped(path, count=100):
    with contextlib.suppress(OtolithError):
        files.read_log(path, {})
print("done")
"""


def test_a_flipped_bit_in_mdf_is_read_or_refused_and_nothing_else(tmp_path: Path) -> None:
    """In a process of its own: what asammdf leaves behind of damaged files would disturb other tests."""
    pytest.importorskip("asammdf", exc_type=ImportError)
    root = Path(__file__).parents[1]
    line = [sys.executable, "-c", MDF, str(tmp_path / "drive.mf4")]
    assert subprocess.run(line, capture_output=True, text=True, check=False, cwd=root).stdout == "done\n"


@pytest.mark.parametrize("read", [files.read_platform, files.read_tuning])
def test_a_flipped_bit_in_settings_is_read_or_refused_and_nothing_else(
    tmp_path: Path, read: Callable[[str], object]
) -> None:
    path = tmp_path / "davsi.toml"
    of_platforms = read is files.read_platform
    package, folder_name = ("platforms", "catalog") if of_platforms else ("cueing.washout", "tunings")
    folder = resources.files(f"otolith.{package}") / folder_name
    path.write_text((folder / "davsi.toml").read_text(encoding="utf-8"))
    read(str(path))
    for _ in flipped(path, count=300):
        with contextlib.suppress(OtolithError):
            read(str(path))


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no full disk here")
def test_a_full_disk_is_one_sentence_for_every_kind_of_file(
    handmade: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whoever writes the temporary file writes, in truth, to the device that is always full."""

    def full(**options: object) -> tuple[int, str]:
        place = tmp_path / f"{options['prefix']}x{options['suffix']}"
        place.symlink_to("/dev/full")
        return os.open(place, os.O_RDWR), str(place)

    def drawn(path: Path) -> None:
        path.write_bytes(b"x")

    monkeypatch.setattr("otolith.core.disk.tempfile.mkstemp", full)
    for write in (
        lambda: files.write_run(handmade, tmp_path / "run.h5"),
        lambda: files.write_json(tmp_path / "summary.json", {"a": 1}),
        lambda: files.write_figure(tmp_path / "a.png", drawn),
    ):
        with pytest.raises(NotWritten, match="No space left on device; nothing half-written was left"):
            write()
        assert list(tmp_path.iterdir()) == []
