"""CarMaker's results, written here byte by byte as its readers describe them."""

import struct
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from otolith import files
from otolith.core.errors import CorruptFile, InputError, OtolithError
from otolith.recordings import log_from
from otolith.recordings.erg import parse_erg

T = np.arange(0.0, 4.0, 0.01)
AX, YAW, STATE = np.sin(T), 0.1 * np.cos(T), np.arange(len(T)) % 7
INFO = """#INFOFILE1.1 - Do not remove this line!
File.Format = erg
File.ByteOrder = {order}
File.At.1.Name = Time
File.At.1.Type = Double
File.At.2.Name = Car.ax
File.At.2.Type = Float
File.At.3.Name = DM.State
File.At.3.Type = Short
File.At.4.Name = $none$
File.At.4.Type = 2 Bytes
File.At.5.Name = Car.YawRate
File.At.5.Type = Double
File.At.6.Name = Car.YawVel
File.At.6.Type = Float
Quantity.Time.Unit = s
Quantity.Car.ax.Unit = m/s^2
Quantity.DM.State.Unit = -
Quantity.Car.YawRate.Unit = rad/s
Quantity.Car.YawVel.Unit = rad/s
"""


def made(order: str = "LittleEndian", info: str = INFO, version: int = 1) -> tuple[str, bytes]:
    mark, code = ("<", 0) if order == "LittleEndian" else (">", 1)
    record = struct.Struct(f"{mark}dfh2xdf")
    header = b"CM-ERG\0\0" + bytes([version, code]) + struct.pack(f"{mark}H", record.size) + bytes(4)
    rows = zip(T, AX, STATE, YAW, YAW, strict=True)
    return info.format(order=order), header + b"".join(record.pack(*row) for row in rows)


@pytest.mark.parametrize("order", ["LittleEndian", "BigEndian"])
def test_a_result_is_read_in_either_byte_order(order: str) -> None:
    channels = parse_erg(*made(order), "lap.erg")
    assert channels.names == ("Time", "Car.ax", "DM.State", "Car.YawRate", "Car.YawVel")
    assert_allclose(np.asarray(channels.values[2], dtype=float), STATE)
    log = log_from(channels)
    assert_allclose(log.t, T)
    assert_allclose(log.force[:, 0], AX, atol=1e-7)
    assert_allclose(log.rate[:, 2], YAW)
    assert any("(the same as 'Car.YawVel')" in note for note in log.notes)


def test_factor_and_offset_are_applied() -> None:
    info = INFO + "Quantity.Car.ax.Factor = 2\nQuantity.Car.ax.Offset = 0.5\n"
    scaled = parse_erg(*made(info=info), "lap.erg").values[1]
    assert_allclose(np.asarray(scaled, dtype=float), 2.0 * AX + 0.5, atol=1e-6)


def test_an_incomplete_last_record_is_dropped_and_said() -> None:
    info, data = made()
    channels = parse_erg(info, data[:-5], "lap.erg")
    assert len(channels.values[0]) == len(T) - 1
    assert "lap.erg: the last record is incomplete and was dropped" in log_from(channels).notes


INFO_, DATA = made()


@pytest.mark.parametrize(
    ("info", "data", "error", "sentence"),
    [
        (INFO_, b"CM-E", CorruptFile, "lap.erg is cut off: it has 4 bytes"),
        (INFO_, b"RIFF" + DATA[4:], CorruptFile, "does not begin with CM-ERG"),
        (*made(version=3), CorruptFile, "has version 3 of its format, this program reads 1"),
        (
            made("BigEndian")[0],
            DATA,
            CorruptFile,
            "lap.erg does not belong to its .info: records of 28 bytes",
        ),
        (INFO_.replace("Float", "Double"), DATA, CorruptFile, "described are 36 bytes"),
        (INFO_.replace("= erg", "= fortran_binary_data"), DATA, InputError, "File.Format of lap.erg.info"),
        (INFO_.replace("LittleEndian", "Middle"), DATA, InputError, "File.ByteOrder of lap.erg.info"),
        (INFO_.replace("Short", "Shor"), DATA, InputError, "type of 'DM.State' in lap.erg.info is 'Shor'"),
        ("", DATA, InputError, "File.At.1.Name of lap.erg.info is missing"),
    ],
)
def test_a_result_that_does_not_fit_its_description_is_refused(
    info: str, data: bytes, error: type[OtolithError], sentence: str
) -> None:
    with pytest.raises(error) as caught:
        parse_erg(info, data, "lap.erg")
    assert sentence in str(caught.value)


def test_a_result_and_its_description_are_read_from_their_files(tmp_path: Path) -> None:
    result = tmp_path / "lap.erg"
    result.write_bytes(DATA)
    with pytest.raises(InputError, match=r"description of the log .*lap\.erg\.info is not readable"):
        files.read_log(result, {})
    result.with_name("lap.erg.info").write_text(INFO_)
    assert_allclose(files.read_log(result, {}).force[:, 0], AX, atol=1e-7)


def test_a_folder_or_a_file_that_is_absent_is_said(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"absent\.erg is absent, must be an existing file"):
        files.read_log(tmp_path / "absent.erg", {})
