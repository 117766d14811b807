"""MDF as asammdf writes it; skipped where the extra is not installed."""

import gc
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

asammdf = pytest.importorskip("asammdf", exc_type=ImportError)

from otolith import files  # noqa: E402
from otolith.core.errors import CorruptFile, InputError  # noqa: E402

FAST, SLOW = np.arange(0.0, 5.0, 0.01), np.arange(0.0, 5.0, 0.02)


def write(path: Path, **signals: tuple[np.ndarray, np.ndarray, str]) -> Path:
    with asammdf.MDF(version="4.10") as file:
        for name, (t, values, unit) in signals.items():
            file.append([asammdf.Signal(values, t, name=name, unit=unit, encoding="utf-8")])
        file.save(path, overwrite=True)
    return path


def test_channels_of_several_groups_are_read(tmp_path: Path) -> None:
    path = write(
        tmp_path / "d.mf4",
        AccX=(FAST, np.sin(FAST), "m/s2"),
        YawRate=(SLOW, 5.0 * np.cos(SLOW), "deg/s"),
        Label=(FAST, np.full(len(FAST), b"text"), ""),
    )
    log = files.read_log(path, {})
    assert_allclose(log.force[:, 0], np.sin(log.t), atol=1e-9)
    assert_allclose(
        log.rate[:-1, 2], np.radians(5.0 * np.cos(log.t[:-1])), atol=1e-4
    )  # it ends a step before


def test_a_channel_is_mapped_by_its_name(tmp_path: Path) -> None:
    path = write(tmp_path / "d.mf4", Sensor7=(FAST, np.sin(FAST), ""))
    log = files.read_log(path, {"ax": "-Sensor7:g"})
    assert_allclose(log.force[:, 0], -9.80665 * np.sin(log.t), atol=1e-9)
    with pytest.raises(InputError, match=r"d.mf4 is without a signal"):
        files.read_log(path, {})


def test_invalid_samples_are_a_gap_and_not_a_straight_line(tmp_path: Path) -> None:
    t = np.arange(0.0, 60.0, 0.01)
    invalid = (t >= 20.0) & (t < 40.0)
    with asammdf.MDF(version="4.10") as file:
        lost = asammdf.Signal(np.sin(t), t, name="AccX", unit="m/s2", invalidation_bits=invalid)
        file.append([lost, asammdf.Signal(np.cos(t), t, name="AccY", unit="m/s2")], common_timebase=True)
        file.save(tmp_path / "d.mf4", overwrite=True)
    with pytest.raises(
        InputError, match=r"gap in ax before sample 2001 of d.mf4, 19.99 s after .*, is 20.01 s"
    ):
        files.read_log(tmp_path / "d.mf4", {})
    log = files.read_log(tmp_path / "d.mf4", {}, needs=("ay",))
    assert log.duration == pytest.approx(59.99)
    assert any(
        note.startswith("ax: left out, taken as zero: it has no values from 19.99 s") for note in log.notes
    )


@pytest.mark.parametrize(("kind", "over"), [(2, "angle"), (3, "distance"), (4, "index")])
def test_channels_over_other_things_than_time_have_no_clock(tmp_path: Path, kind: int, over: str) -> None:
    def group(name: str, master: tuple[str, int]) -> list[Any]:
        return [asammdf.Signal(np.sin(FAST), FAST, name=name, unit="m/s2", master_metadata=master)]

    with asammdf.MDF(version="4.10") as file:
        file.append(group("AccX", (over, kind)))
        file.save(tmp_path / "d.mf4", overwrite=True)
    with pytest.raises(InputError, match=rf"channels of d.mf4 is recorded without time: 'AccX' over {over}"):
        files.read_log(tmp_path / "d.mf4", {})
    with asammdf.MDF(version="4.10") as file:
        file.append(group("AccX", ("time", 1)))
        file.append(group("AccY", (over, kind)))
        file.save(tmp_path / "d.mf4", overwrite=True)
    log = files.read_log(tmp_path / "d.mf4", {})
    assert f"d.mf4: 'AccY' runs over {over}, not over time: left out" in log.notes
    assert "ay" not in log.channels


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # asammdf's own clean-up
@pytest.mark.parametrize("kept", [40, 300, 2000])
def test_a_file_cut_off_is_refused(tmp_path: Path, kept: int) -> None:
    path = write(tmp_path / "d.mf4", AccX=(FAST, np.sin(FAST), "m/s2"))
    path.write_bytes(path.read_bytes()[:kept])
    with pytest.raises(CorruptFile, match=r"d.mf4 is damaged or no MDF file"):
        files.read_log(path, {})
    gc.collect()  # what asammdf leaves behind shall complain here, not in another test
