"""Exports of many tools: their forms as public files show them, the numbers from the package's own lap.

The truth is that lap, in SI units, x forward, y left, z up; where an export is in other axes, its documentation
or public files of it say so. What is expected of each stands in its test's name.
"""
# ruff: noqa: E501 - the headers of other tools are as long as they are

import json
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from otolith import files
from otolith.core.arrays import Vec
from otolith.core.errors import InputError
from otolith.recordings import Log
from otolith.recordings.settings import LogSettings
from tests.recordings.mutilated import EARTH, Truth, hockenheim, truth

G = 9.80665
DEG = np.degrees(1.0)


@pytest.fixture(scope="module")
def drive() -> Truth:
    """From 72 s to 94 s of a flying lap: braking for the hairpin, and the hairpin."""
    return truth(hockenheim(), 72.0, 94.0, 20.0)


@pytest.fixture
def read(tmp_path: Path) -> Callable[..., Log]:
    def reading(text: str, name: str = "export.csv", **columns: str) -> Log:
        (tmp_path / name).write_text(text, encoding="utf-8")
        settings = LogSettings(columns=columns)
        return files.read_log(tmp_path / name, {}, settings=settings)

    return reading


def table(*columns: tuple[Vec, int] | Sequence[str], mark: str = ",", quote: str = "") -> str:
    """Rows of text: numbers with so many digits, or texts as they are."""
    cells = [c if isinstance(c[0], str) else [f"{v:.{c[1]}f}" for v in c[0]] for c in columns]
    return "\n".join(mark.join(f"{quote}{cell}{quote}" for cell in row) for row in zip(*cells, strict=True))


def assert_read(log: Log, drive: Truth, *keys: str, digits: float = 0.006) -> None:
    """Within 1 % of the largest value, and what the written digits leave out; the rest is zero."""
    t = drive.t[(drive.t > 0.2) & (drive.t < drive.t[-1] - 0.2)]
    felt = log.felt(t)
    for place, key in enumerate(("ax", "ay", "az", "roll_rate", "pitch_rate", "yaw_rate")):
        true = np.interp(t, drive.t, drive.data[key])
        if key not in keys:
            assert not felt[:, place].any(), key
            continue
        rounding = digits if place < 3 else 0.002
        assert_allclose(felt[:, place], true, atol=0.01 * float(np.abs(true).max()) + rounding, err_msg=key)


def place_deg(drive: Truth) -> tuple[Vec, Vec]:
    """Latitude and longitude [deg]."""
    x, y = drive.data["x"], drive.data["y"]
    return 50.0 + np.degrees(y / EARTH), 8.0 + np.degrees(x / EARTH / np.cos(np.radians(50.0)))


def heading_deg(drive: Truth) -> Vec:
    x, y = (np.gradient(drive.data[key]) for key in ("x", "y"))
    return np.degrees(np.arctan2(x, y)) % 360.0


def stamps(drive: Truth, form: str) -> list[str]:
    start = np.datetime64("2026-05-05T10:00:00.400")
    times = [start + np.timedelta64(round(1000 * t), "ms") for t in drive.t]
    return [np.datetime_as_string(t) + "Z" if form == "iso" else str(t.astype("int64")) for t in times]


CARMAKER = """# "Time","Car.ax","Car.ay","Car.YawRate","Car.v","Car.vy","Driver.Steer.Ang","Vhcl.PoI.ay"
# "C1","C1","C1","C1","C1","C1","C1","C1"
# "s","m/s^2","m/s^2","rad/s","m/s","m/s","rad","m/s^2"
"""


def test_carmakers_three_lines_of_comment_are_names_types_and_units(
    drive: Truth, read: Callable[..., Log]
) -> None:
    d, zero = drive.data, (np.zeros(len(drive.t)), 0)
    rows = table((drive.t + 14.271, 3), (d["ax"], 6), (d["ay"], 6), (d["yaw_rate"], 6), (d["vx"], 4), zero, zero,
                 (d["ay"] + 9.0, 6))  # fmt: skip
    log = read(CARMAKER + rows)
    assert_read(log, drive, "ax", "ay", "yaw_rate")
    assert log.layout is not None
    assert (log.layout.header, log.layout.units, log.layout.first) == ("line 1", "line 3", "line 4")


def test_only_what_is_cued_is_needed(drive: Truth, tmp_path: Path) -> None:
    rows = table((drive.t, 3), (drive.data["ay"], 6), (drive.data["yaw_rate"], 6), (drive.data["vx"], 4))
    path = tmp_path / "no-ax.csv"
    path.write_text(f"Time,Car.ay,Car.YawRate,Car.v\ns,m/s^2,rad/s,m/s\n{rows}")
    assert_read(files.read_log(path, {}, needs=("ay",)), drive, "ay", "yaw_rate")
    with pytest.raises(InputError, match=r"\(ax\) in no-ax.csv is missing.*or derived with ax=from-speed"):
        files.read_log(path, {}, needs=("ax",))


def test_a_missing_acceleration_is_derived_on_request_and_its_noise_is_said(
    drive: Truth, tmp_path: Path
) -> None:
    rows = table((drive.t, 3), (drive.data["yaw_rate"], 6), (3.6 * drive.data["vx"], 2))
    path = tmp_path / "no-force.csv"
    path.write_text(f"time_s,yaw_rate_radps,speed_kmh\n{rows}")
    log = files.read_log(path, {"ax": "from-speed", "ay": "from-yaw-rate"}, needs=("ax", "ay"))
    v, r = drive.data["vx"], drive.data["yaw_rate"]
    slope = np.gradient(v, drive.t)
    inner = slice(20, -20)
    assert_allclose(log.channels["ay"].on(drive.t)[inner], (v * r)[inner], atol=0.01)
    assert float(np.sqrt(np.mean((log.channels["ax"].on(drive.t) - slope)[inner] ** 2))) < 0.2
    assert any(
        note.startswith("ax: derived from 'speed_kmh'") and "noise about" in note for note in log.notes
    )
    assert any(note.startswith("ay: derived, 'speed_kmh' × 'yaw_rate_radps'") for note in log.notes)
    with pytest.raises(InputError, match=r"ay=from-yaw-rate in no-force.csv is without yaw_rate"):
        files.read_log(path, {"ay": "from-yaw-rate", "yaw_rate": "none"}, needs=("ay",))


MOTEC = """"Format","MoTeC CSV File",,,"Workbook",""
"Venue","A Track",,,"Worksheet",""
"Driver","Nobody",,,"Engine ID",""
"Device","ADL"
"Log Date","05/05/2026",,,"Origin Time","0.000","s"
"Sample Rate","20.000","Hz",,"End Time","22.000","s"
"Beacon Markers",""


"Time","Distance","Ground Speed","G Force Long","G Force Lat","G Force Vert","Gyro Yaw Velocity","Steering Angle"
"s","m","km/h","G","G","G","deg/s","deg"


"""


@pytest.mark.parametrize("left_out", ["", "preamble", "blank lines"])
def test_motecs_preamble_blank_lines_and_units(left_out: str, drive: Truth, read: Callable[..., Log]) -> None:
    d, zero = drive.data, (np.zeros(len(drive.t)), 4)
    rows = table((drive.t, 4), zero, (3.6 * d["vx"], 4), (d["ax"] / G, 4), (d["ay"] / G, 4), (d["az"] / G + 1, 4),
                 (DEG * d["yaw_rate"], 4), zero, quote='"')  # fmt: skip
    head = MOTEC[MOTEC.index('"Time"') :] if left_out else MOTEC
    head = head.replace("\n\n\n", "\n") if left_out == "blank lines" else head
    log = read(head + rows)
    assert_read(log, drive, "ax", "ay", "az", "yaw_rate")
    assert any("not proven" in note for note in log.notes)


AIM = """"Format","AiM CSV File"
"Session","A"
"Comment",""
"Date","Tuesday, May 5, 2026"
"Time","11:49 AM"
"Sample Rate","20"
"Duration","28"
"Beacon Markers","28"
"Segment Times","0:28.000"

"Time","GPS Speed","GPS LatAcc","GPS LonAcc","GPS Heading","InlineAcc","LateralAcc","VerticalAcc","RollRate","PitchRate","YawRate"
"s","km/h","g","g","deg","g","g","g","deg/s","deg/s","deg/s"

"""


def test_aims_axes_of_sae_are_turned_and_its_sensor_goes_before_its_satellites(
    drive: Truth, read: Callable[..., Log]
) -> None:
    """y to the right and z down: in public files a right turn has growing heading and positive LateralAcc."""
    d, noise = drive.data, np.random.default_rng(3).normal(0.0, 0.02, (2, len(drive.t)))
    rows = table((drive.t, 3), (3.6 * d["vx"], 3), (-d["ay"] / G + noise[0], 3), (d["ax"] / G + noise[1], 3),
                 (heading_deg(drive), 3), (d["ax"] / G, 3), (-d["ay"] / G, 3), (-d["az"] / G - 1, 3),
                 (DEG * d["roll_rate"], 3), (-DEG * d["pitch_rate"], 3), (-DEG * d["yaw_rate"], 3), quote='"')  # fmt: skip
    log = read(AIM + rows)
    assert_read(log, drive, "ax", "ay", "az", "roll_rate", "pitch_rate", "yaw_rate")
    assert any("taken before 'GPS LatAcc'" in note and "measured, not derived" in note for note in log.notes)


RACECHRONO = """This file is created using RaceChrono v9 ( http://example.org/ ).
Format,3
Session title,"A session"
Created,22/02/2026,10:00
Note,

timestamp,fragment_id,elapsed_time,latitude,longitude,speed,device_update_rate,lateral_acc,longitudinal_acc,speed,x_acc,y_acc,z_acc,device_update_rate,z_rate_of_rotation
unix time,,s,deg,deg,m/s,Hz,G,G,m/s,G,G,G,Hz,deg/s
,,,100: gps,100: gps,100: gps,100: gps,calc,calc,calc,101: acc,101: acc,101: acc,101: acc,102: gyro
"""


def racechrono(drive: Truth) -> str:
    """Every second row has no satellites; the phone lies with its x to the left and its y backward."""
    d, (lat, lon), n = drive.data, place_deg(drive), len(drive.t)
    seldom = [
        [f"{v:.7f}" if i % 2 == 0 else "" for i, v in enumerate(values)] for values in (lat, lon, d["vx"])
    ]
    return table((1771754400 + drive.t, 3), ["0"] * n, (drive.t, 3), *seldom, ["10"] * n, (-d["ay"] / G, 3),
                 (d["ax"] / G, 3), (d["vx"], 3), (d["ay"] / G, 3), (-d["ax"] / G, 3), (d["az"] / G + 1, 3),
                 ["20"] * n, (DEG * d["yaw_rate"], 2))  # fmt: skip


def test_racechronos_lateral_acceleration_to_the_right_is_refused_with_the_mapping_that_is_right(
    drive: Truth, read: Callable[..., Log]
) -> None:
    with pytest.raises(InputError, match=r"ay in export.csv is against .*map ay=-lateral_acc"):
        read(RACECHRONO + racechrono(drive))
    log = read(RACECHRONO + racechrono(drive), ay="-lateral_acc")
    assert_read(log, drive, "ax", "ay", "az", "yaw_rate", digits=0.012)
    assert log.layout is not None
    assert (log.layout.header, log.layout.units, log.layout.first) == ("line 7", "line 8", "line 10")
    assert (
        read(RACECHRONO + racechrono(drive), ay="-lateral_acc", vx="speed#2").channels["vx"].column.index == 9
    )


def test_telemetry_overlays_rival_columns_are_judged_by_speed_and_yaw_rate(
    drive: Truth, read: Callable[..., Log]
) -> None:
    """``accel y`` points left, ``g_lat`` right, in one file."""
    d, (lat, lon) = drive.data, place_deg(drive)
    header = "utc (ms),lat (deg),lon (deg),speed (m/s),accel x (m/s²),accel y (m/s²),gyro z (deg/s),turn rate (deg/s),g_lon,g_lat,speed (km/h)"
    rows = table(stamps(drive, "ms"), (lat, 7), (lon, 7), (d["vx"], 2), (d["ax"], 3), (d["ay"], 3),
                 (DEG * d["yaw_rate"], 2), (DEG * d["yaw_rate"], 2), (d["ax"] / G, 3), (-d["ay"] / G, 3),
                 (3.6 * d["vx"], 1))  # fmt: skip
    log = read(f"{header}\n{rows}")
    assert_read(log, drive, "ax", "ay", "yaw_rate", digits=0.012)
    assert log.columns["ay"] == "accel y (m/s²)"


def test_raceboxs_dates_are_read_and_units_that_it_does_not_state_are_mapped(
    drive: Truth, read: Callable[..., Log]
) -> None:
    d, (lat, lon) = drive.data, place_deg(drive)
    header = "Record,Time,Latitude,Longitude,Altitude,Speed,GForceX,GForceY,GForceZ,Lap,GyroX,GyroY,GyroZ"
    n = [str(i) for i in range(len(drive.t))]
    rows = table(n, stamps(drive, "iso"), (lat, 7), (lon, 7), ["100.0"] * len(n), (3.6 * d["vx"], 2),
                 (d["ax"] / G, 3), (d["ay"] / G, 3), (d["az"] / G + 1, 3), ["0"] * len(n), (DEG * d["roll_rate"], 2),
                 (DEG * d["pitch_rate"], 2), (DEG * d["yaw_rate"], 2))  # fmt: skip
    with pytest.raises(
        InputError, match=r"map .*yaw_rate=GyroZ:deg/s and vx=Speed:km/h, which makes this file agree"
    ):
        read(f"{header}\n{rows}")
    units = {
        "vx": "Speed:km/h",
        "roll_rate": "GyroX:deg/s",
        "pitch_rate": "GyroY:deg/s",
        "yaw_rate": "GyroZ:deg/s",
    }
    log = read(f"{header}\n{rows}", **units)
    assert_read(log, drive, "ax", "ay", "az", "roll_rate", "pitch_rate", "yaw_rate")


def test_gopros_vector_of_three_columns_has_one_unit(drive: Truth, read: Callable[..., Log]) -> None:
    d, n = drive.data, len(drive.t)
    text = '"cts","date","Accelerometer [g]","1","2","temperature [°C]"\n' + table(
        (1000 * drive.t, 3),
        stamps(drive, "iso"),
        (d["az"] / G + 1, 5),
        (d["ay"] / G, 5),
        (d["ax"] / G, 5),
        ["41.5"] * n,
    )
    with pytest.raises(InputError, match=r"\(ax\) in export.csv is missing.*'Accelerometer \[g\]', '1', '2'"):
        read(text)
    assert_read(read(text, ax="2", ay="1", az="Accelerometer [g]"), drive, "ax", "ay", "az")


def test_iracings_channels_are_read(drive: Truth, read: Callable[..., Log]) -> None:
    d = drive.data
    rows = table((1200 + drive.t, 4), (d["vx"], 4), (d["ax"], 4), (d["ay"], 4), (d["az"] + G, 4),
                 (d["roll_rate"], 5), (d["pitch_rate"], 5), (d["yaw_rate"], 5))  # fmt: skip
    header = "SessionTime,Speed,LongAccel,LatAccel,VertAccel,RollRate,PitchRate,YawRate"
    assert_read(read(f"{header}\n{rows}"), drive, "ax", "ay", "az", "roll_rate", "pitch_rate", "yaw_rate")


@pytest.mark.parametrize("form", ["array", "lines"])
def test_nuscenes_records_of_vectors_are_read(form: str, drive: Truth, read: Callable[..., Log]) -> None:
    d = drive.data
    records = [
        {
            "utime": 1531883530449377 + round(1e6 * t),
            "linear_accel": [round(d["ax"][i], 5), round(d["ay"][i], 5), round(d["az"][i] + G, 5)],
            "rotation_rate": [round(float(d[key][i]), 6) for key in ("roll_rate", "pitch_rate", "yaw_rate")],
            "q": [1.0, 0.0, 0.0, 0.0],
        }
        for i, t in enumerate(drive.t)
    ]
    text = json.dumps(records) if form == "array" else "\n".join(map(json.dumps, records))
    assert_read(read(text, "ms_imu.json"), drive, "ax", "ay", "az", "roll_rate", "pitch_rate", "yaw_rate")


def test_sensor_loggers_bare_letters_have_to_be_mapped(drive: Truth, read: Callable[..., Log]) -> None:
    d = drive.data
    ns = [str(1771754400000000000 + round(1e9 * t)) for t in drive.t]
    text = "time,seconds_elapsed,z,y,x\n" + table(ns, (drive.t, 6), (d["az"], 5), (d["ax"], 5), (-d["ay"], 5))
    with pytest.raises(InputError, match=r"\(ax\) in export.csv is missing.*'z', 'y', 'x'"):
        read(text)
    assert_read(read(text, ax="y", ay="-x", az="z"), drive, "ax", "ay", "az")


def test_a_log_in_long_form_is_read_by_its_names_of_signals(drive: Truth, read: Callable[..., Log]) -> None:
    d, iso = drive.data, stamps(drive, "iso")
    signals = {"accx_can": d["ax"] / G, "accy_can": d["ay"] / G, "speed": 3.6 * d["vx"]}
    rows = [
        f",2,{iso[i]},GR86-002,{name},{values[i]:.4f},{iso[i]},0"
        for i in range(0, len(iso), 2)
        for name, values in signals.items()
    ]
    header = "expire_at,lap,meta_time,vehicle_id,telemetry_name,telemetry_value,timestamp,vehicle_number"
    text = "\n".join([header, *rows])
    log = read(text, ax="accx_can:g", ay="accy_can:g", vx="speed:km/h")
    assert_read(log, drive, "ax", "ay", digits=0.04)  # straight lines between samples 0.1 s apart
    assert any("long form, 3 signals" in note for note in log.notes)
    mixed = text.replace("GR86-002,speed", "GR86-003,speed")
    with pytest.raises(InputError, match=r"'vehicle_id' in export.csv is 2 different ones, 'GR86-002'"):
        read(mixed, ax="accx_can:g")


def test_units_in_brackets_count_for_mapped_columns(drive: Truth, read: Callable[..., Log]) -> None:
    d = drive.data
    rows = table((drive.t, 2), (d["ax"] / G, 4), (d["ay"] / G, 4), mark=";").replace(".", ",")
    text = f"Zeit [s];Längsbeschleunigung [g];Querbeschleunigung [g]\n{rows}"
    log = read(text, t="Zeit [s]", ax="Längsbeschleunigung [g]", ay="Querbeschleunigung [g]")
    assert_read(log, drive, "ax", "ay")


def test_channels_that_are_blank_between_their_updates_keep_their_rate(
    drive: Truth, read: Callable[..., Log]
) -> None:
    d, even = drive.data, np.arange(len(drive.t)) % 2 == 0
    felt = [[f"{v:.3f}" if e else "" for v, e in zip(values, even, strict=True)]
            for values in (d["ax"] / G, d["ay"] / G, DEG * d["yaw_rate"])]  # fmt: skip
    speed = ["" if e else f"{v:.2f}" for v, e in zip(d["vx"] / 0.44704, even, strict=True)]
    header = "time_ms,accel_x (g),accel_y (g),yaw rate (deg/s),speed (mph)"
    log = read(f"{header}\n" + table((1000 * drive.t, 0), *felt, speed))
    assert_read(log, drive, "ax", "ay", "yaw_rate", digits=0.04)
    assert len(log.channels["ax"].t) == int(even.sum())
    assert len(log.channels["vx"].t) == int((~even).sum())
    assert log.notes[0].endswith("22 s, 10 Hz") or log.notes[0].endswith("10 Hz")


def test_racecaptures_names_with_units_and_ranges(drive: Truth, read: Callable[..., Log]) -> None:
    d, (lat, lon) = drive.data, place_deg(drive)
    header = 'Interval|"ms"|0|0|1,Utc|"ms"|0|0|1,AccelX|"G"|-3.0|3.0|25,AccelY|"G"|-3.0|3.0|25,Yaw|"Deg/Sec"|-120|120|25,Latitude|"Degrees"|-180|180|10,Longitude|"Degrees"|-180|180|10,Speed|"MPH"|0|150|10'
    seldom = [[f"{v:.6f}" if i % 3 == 0 else "" for i, v in enumerate(values)]
              for values in (lat, lon, d["vx"] / 0.44704)]  # fmt: skip
    rows = table((1000 * drive.t, 0), stamps(drive, "ms"), (d["ax"] / G, 4), (d["ay"] / G, 4),
                 (DEG * d["yaw_rate"], 2), *seldom)  # fmt: skip
    assert_read(read(f"{header}\n{rows}"), drive, "ax", "ay", "yaw_rate")


def test_stamps_coarser_than_the_rows_are_spread_evenly(drive: Truth, read: Callable[..., Log]) -> None:
    d = drive.data
    rows = table((drive.t, 1), (d["ax"], 4), (d["ay"], 4), (d["yaw_rate"], 5), (d["vx"], 3))
    log = read(f"time_s,ax_mps2,ay_mps2,yaw_rate_radps,speed_mps\n{rows}")
    assert_read(log, drive, "ax", "ay", "yaw_rate")
    assert any("stamps are coarser than the rows" in note for note in log.notes)


VBO = """File created on 05/05/2026 at 10:00:00

[header]
satellites
time
velocity kmh

[comments]
made for a test

[column names]
sats time velocity Longacc Latacc YawRate

[data]
"""


def test_a_vbox_file_has_names_in_a_section_and_packed_clock_times(
    drive: Truth, read: Callable[..., Log]
) -> None:
    d, n = drive.data, len(drive.t)
    packed = [
        f"{seconds // 3600:02.0f}{seconds // 60 % 60:02.0f}{seconds % 60:05.2f}"
        for seconds in (round(43190 + float(t), 2) for t in drive.t)
    ]
    text = VBO + table(["009"] * n, packed, (3.6 * d["vx"], 3), (d["ax"] / G, 4), (d["ay"] / G, 4),
                       (DEG * d["yaw_rate"], 3), mark=" ")  # fmt: skip
    mapping = {"vx": "velocity:km/h", "ax": "Longacc:g", "ay": "Latacc:g", "yaw_rate": "YawRate:deg/s"}
    log = read(text, "run.vbo", **mapping)
    assert_read(log, drive, "ax", "ay", "yaw_rate")
    assert any("HHMMSS" in note for note in log.notes)


def test_trackaddicts_comments_and_held_speed(drive: Truth, read: Callable[..., Log]) -> None:
    d = drive.data
    head = '# RaceRender Data: an app (Mode: 0)\n# End Point: 50.1, 8.2  @ -1.00 deg\n"Time","UTC Time","Lap","Speed (MPH)","Heading","Accuracy (m)","Accel X","Accel Y","Accel Z"\n'
    n = len(drive.t)
    held = np.repeat(d["vx"][::20], 20)[:n] / 0.44704
    rows = table((drive.t, 3), (1.75e9 + drive.t, 3), ["0"] * n, (held, 1), (heading_deg(drive), 1), ["5.0"] * n,
                 (d["ax"] / G, 4), (d["ay"] / G, 4), (d["az"] / G, 4))  # fmt: skip
    log = read(
        f"{head}{rows}\n# Lap 0: 00:00:22.000\n# Session End\n",
        ax="Accel X:g",
        ay="Accel Y:g",
        az="Accel Z:g",
    )
    assert_read(log, drive, "ax", "ay", "az")


def test_a_games_axes_with_y_up_and_z_forward_are_refused(drive: Truth, read: Callable[..., Log]) -> None:
    """As Forza sends them: x right, y up, z forward, without gravity."""
    d = drive.data
    header = "TimestampMS,AccelerationX,AccelerationY,AccelerationZ,Speed"
    text = header + "\n" + table((1000 * drive.t, 0), (-d["ay"], 4), (d["az"], 4), (d["ax"], 4), (d["vx"], 4))
    with pytest.raises(
        InputError, match=r"the axis of az in .* is that along which the speed changes.*map ax=Acc"
    ):
        read(text)
    assert_read(
        read(text, ax="AccelerationZ", ay="-AccelerationX", az="AccelerationY"), drive, "ax", "ay", "az"
    )


def vbox(drive: Truth, *, left: float = 1.0, west: float = -1.0) -> str:
    """As a VBOX writes it: titles with units, coordinates in minutes, west positive, and a heading."""
    d, (lat, lon), n = drive.data, place_deg(drive), len(drive.t)
    titles = (
        "satellites",
        "time",
        "latitude",
        "longitude",
        "velocity kmh",
        "heading",
        "Long accel g",
        "Lat accel g",
    )
    names = "sats time lat long velocity heading Longacc Latacc"
    packed = [
        f"{seconds // 3600:02.0f}{seconds // 60 % 60:02.0f}{seconds % 60:05.2f}"
        for seconds in (round(43190 + float(t), 2) for t in drive.t)
    ]
    rows = table(["009"] * n, packed, (60 * lat, 6), (60 * west * lon, 6), (3.6 * d["vx"], 3), (heading_deg(drive), 2),
                 (d["ax"] / G, 4), (left * d["ay"] / G, 4), mark=" ")  # fmt: skip
    head = (
        "[header]\n" + "\n".join(titles) + "\n\n[comments]\nmade\n\n[column names]\n" + names + "\n\n[data]\n"
    )
    return head + rows


@pytest.mark.parametrize("left", [1.0, -1.0])
def test_a_vbox_file_with_titles_needs_nothing_and_proves_left_and_right(
    left: float, drive: Truth, read: Callable[..., Log]
) -> None:
    log = read(vbox(drive, left=left), "run.vbo")
    assert_read(log, drive, "ax", "ay")
    assert log.found is not None
    assert log.found.proof == "latitude and longitude"


def test_longitudes_that_count_east_in_a_vbox_file_are_against_its_heading(
    drive: Truth, read: Callable[..., Log]
) -> None:
    with pytest.raises(InputError, match=r"'heading' in run.vbo is against .*map lon=-long:arcmin west"):
        read(vbox(drive, west=1.0), "run.vbo")
    assert_read(read(vbox(drive, west=1.0), "run.vbo", lon="-long:arcmin west"), drive, "ax", "ay")


def test_a_derivation_without_its_source_is_refused_also_where_nothing_else_is_felt(
    drive: Truth, read: Callable[..., Log]
) -> None:
    rows = table((drive.t, 2), (drive.data["vx"], 3))
    with pytest.raises(InputError, match=r"ax=from-speed in export.csv is without vx"):
        read(f"t_s,rpm\n{rows}", ax="from-speed")


def test_trackaddicts_telephone_axes_are_refused_with_the_mapping_that_is_right(
    drive: Truth, read: Callable[..., Log]
) -> None:
    """In g without saying so, its x to the right and its y forward: three changes at once."""
    d, (lat, lon) = drive.data, place_deg(drive)
    rows = table((drive.t, 3), (lat, 7), (lon, 7), (d["vx"] / 0.44704, 1), (-d["ay"] / G, 3), (d["ax"] / G, 3),
                 (d["az"] / G, 3))  # fmt: skip
    text = (
        f'"Time","Latitude","Longitude","Speed (MPH)","Accel X","Accel Y","Accel Z"\n{rows}\n# Session End\n'
    )
    with pytest.raises(InputError, match=r"map ax=Accel Y:g and ay=-Accel X:g and az alike"):
        read(text)
    assert_read(read(text, ax="Accel Y:g", ay="-Accel X:g", az="Accel Z:g"), drive, "ax", "ay", "az")


def test_accelerations_along_a_devices_x_and_y_are_told_where_no_speed_judges_them(
    drive: Truth, read: Callable[..., Log]
) -> None:
    d = drive.data
    rows = table((drive.t, 4), (d["ax"], 5), (d["ay"], 5), (d["az"] + G, 5))
    log = read(f"Time (s),Acceleration x (m/s^2),Acceleration y (m/s^2),Acceleration z (m/s^2)\n{rows}")
    assert_read(log, drive, "ax", "ay", "az")
    assert any("may be a device's own axes, which nothing in the file" in note for note in log.notes)


def test_a_games_whole_record_with_y_up_is_judged_by_its_speed_and_not_its_sideways_velocity(
    drive: Truth, read: Callable[..., Log]
) -> None:
    d, n = drive.data, len(drive.t)
    header = "TimestampMS,AccelerationX,AccelerationY,AccelerationZ,VelocityX,VelocityY,VelocityZ,Speed"
    zero = ["0.0"] * n
    rows = table(
        (1000 * drive.t, 0), (-d["ay"], 4), (d["az"], 4), (d["ax"], 4), zero, zero, (d["vx"], 4), (d["vx"], 4)
    )
    with pytest.raises(InputError, match=r"axes of a game, y up\? map ax=AccelerationZ"):
        read(f"{header}\n{rows}")


def test_a_lone_rate_about_a_games_y_is_no_pitch_rate(drive: Truth, read: Callable[..., Log]) -> None:
    d = drive.data
    rows = table(
        (drive.t, 3), (3.6 * d["vx"], 3), (d["ay"] / G, 4), (d["ax"] / G, 4), (DEG * d["yaw_rate"], 3)
    )
    log = read(f"time,SPEED,G_LAT,G_LON,ROTY\ns,km/h,G,G,deg/s\n{rows}")
    assert_read(log, drive, "ax", "ay")


def test_durations_as_pandas_writes_them_are_clock_times(drive: Truth, read: Callable[..., Log]) -> None:
    d, start = drive.data, 86395.0
    times = [f"{int((start + t) // 86400)} days 00:00:{t - 5.0:09.6f}" if t >= 5.0 else f"0 days 23:59:{55.0 + t:09.6f}"
             for t in drive.t]  # fmt: skip
    log = read("time,ax_mps2,ay_mps2\n" + table(times, (d["ax"], 4), (d["ay"], 4)))
    assert_read(log, drive, "ax", "ay")


@pytest.mark.parametrize("footer", ["End of file,,", "\nNumber of rows: 440", "Total,n/a text,ok", ",,\n,,"])
def test_text_below_the_table_is_left_out_and_said(
    footer: str, drive: Truth, read: Callable[..., Log]
) -> None:
    d = drive.data
    log = read("t_s,ax_mps2,ay_mps2\n" + table((drive.t, 3), (d["ax"], 4), (d["ay"], 4)) + f"\n{footer}\n")
    assert_read(log, drive, "ax", "ay")
    assert any("of text below the table left out" in note for note in log.notes)


@pytest.mark.parametrize("spelling", ["1.#QNAN", "-nan(ind)", "#N/A", "NULL", "?", "<NA>", "NaT", "---"])
def test_each_spelling_of_no_value_is_blank(spelling: str, drive: Truth, read: Callable[..., Log]) -> None:
    d = drive.data
    ax = [spelling if i == 50 else f"{v:.4f}" for i, v in enumerate(d["ax"])]
    log = read("t_s,ax_mps2,ay_mps2\n" + table((drive.t, 3), ax, (d["ay"], 4)))
    assert len(log.channels["ax"].t) == len(drive.t) - 1
    assert_read(log, drive, "ax", "ay", digits=0.05)


def test_sentences_of_a_receiver_are_named_for_what_they_are(read: Callable[..., Log]) -> None:
    line = "$GPRMC,100000.40,A,5000.00000,N,00800.00000,E,40.00,12.0,050526,,,A*00"
    with pytest.raises(InputError, match=r"x\.nmea is NMEA 0183, places of a receiver without forces"):
        read("\n".join([line] * 5), "x.nmea")


def test_g_forces_of_three_letters_are_read(drive: Truth, read: Callable[..., Log]) -> None:
    d = drive.data
    rows = table((drive.t, 4), (d["ax"] / G, 4), (d["ay"] / G, 4), (d["az"] / G + 1, 4), mark=";")
    assert_read(read(f"time;gFx;gFy;gFz\n{rows}"), drive, "ax", "ay", "az")


def test_a_games_rates_with_y_up_beside_forces_named_in_words_are_refused(
    drive: Truth, read: Callable[..., Log]
) -> None:
    """As the F1 games send them: speed in km/h, lateral force to the right, angular velocity about y up."""
    d = drive.data
    header = "m_sessionTime,m_speed,m_gForceLateral,m_gForceLongitudinal,m_angularVelocityX,m_angularVelocityY,m_angularVelocityZ"
    rows = table((drive.t, 3), (3.6 * d["vx"], 1), (-d["ay"] / G, 4), (d["ax"] / G, 4), (-d["pitch_rate"], 5),
                 (-d["yaw_rate"], 5), (d["roll_rate"], 5))  # fmt: skip
    with pytest.raises(InputError, match=r"or yaw_rate=-m_angularVelocityY where y points right"):
        read(f"{header}\n{rows}", vx="m_speed:km/h")
    mapping = {"vx": "m_speed:km/h", "ay": "-m_gForceLateral", "yaw_rate": "-m_angularVelocityY",
               "pitch_rate": "-m_angularVelocityX", "roll_rate": "m_angularVelocityZ"}  # fmt: skip
    log = read(f"{header}\n{rows}", **mapping)
    assert_read(log, drive, "ax", "ay", "roll_rate", "pitch_rate", "yaw_rate")


def test_a_folder_of_arrays_is_named_for_what_it_is(drive: Truth, tmp_path: Path) -> None:
    folder = tmp_path / "accelerometer"
    folder.mkdir()
    np.save(folder / "t.npy", drive.t)
    with pytest.raises(
        InputError, match=r"log accelerometer is a folder of numpy's arrays, must be one table"
    ):
        files.read_log(folder, {})


@pytest.mark.parametrize(
    ("name", "full", "start", "unit"),
    [("time_ms", 2**16, 60000, 1e3), ("time_us", 2**32, 2**32 - 9e6, 1e6), ("time_s", 86400, 86390, 1.0),
     ("tow_s", 604800, 604790, 1.0)],
)  # fmt: skip
def test_counters_go_on_where_they_are_full(
    name: str, full: float, start: float, unit: float, drive: Truth, read: Callable[..., Log]
) -> None:
    d = drive.data
    counted = np.mod(start + np.round(unit * drive.t, 3), full)
    log = read(f"{name},ax_mps2,ay_mps2\n" + table((counted, 3), (d["ax"], 4), (d["ay"], 4)), t=name)
    assert_read(log, drive, "ax", "ay")
    assert any(f"begins anew at {full}" in note for note in log.notes)


def test_names_that_stand_again_among_the_rows_are_left_out(drive: Truth, read: Callable[..., Log]) -> None:
    """Believed for the beginning of the table, they would take away all that was before."""
    d, names = drive.data, "t_s,ax_mps2,ay_mps2"
    rows = table((drive.t, 3), (d["ax"], 4), (d["ay"], 4)).split("\n")
    log = read("\n".join([names, *rows[:150], names, *rows[150:]]))
    assert_read(log, drive, "ax", "ay")
    assert "export.csv: the names stand again in line 152: left out" in log.notes


def test_decimal_commas_in_quotes_and_typographic_minus_signs_are_numbers(
    drive: Truth, read: Callable[..., Log]
) -> None:
    d = drive.data
    rows = table((drive.t, 2), (d["ax"], 4), (d["ay"], 4), mark=";").replace(".", ",").split("\n")
    quoted = "\n".join(",".join(f'"{cell}"' for cell in row.split(";")) for row in rows)
    assert_read(read(f'"t [s]","ax [m/s2]","ay [m/s2]"\n{quoted}'), drive, "ax", "ay")
    plain = table((drive.t, 2), (d["ax"], 4), (d["ay"], 4)).replace("-", "\u2212")
    assert_read(read(f"t_s,ax_mps2,ay_mps2\n{plain}"), drive, "ax", "ay")
    with pytest.raises(InputError, match="'1,234', must be a finite number"):
        read('t_s,ax_mps2,ay_mps2\n0.0,"1,234",1\n0.1,"1,235",1\n0.2,"1,236",1\n')
