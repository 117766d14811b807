"""Writes one virtual drive in the many forms, units, axes, clocks and preambles of other people's logs.

`Truth` is a stretch of a lap that the package drove itself; `write` puts it into a file as a `Form` says,
with the mapping that a user would have to state; `judge` compares what was read with the truth.
"""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any, Final

import numpy as np

from otolith.core.arrays import Vec
from otolith.recordings import Log
from otolith.recordings.columns import STANDARD_GRAVITY
from otolith.vehicle import Driver, Lap, drive, load_car, road
from otolith.vehicle.profile import Limits

EARTH: Final = 6371000.0  # [m]
SET_OUT: Final = (50.0, 8.0)  # latitude and longitude [deg] at which the drive's map has its origin
EPOCH: Final = 1771754400.0  # [s] since 1970 of the first row
FELT: Final = ("ax", "ay", "az", "roll_rate", "pitch_rate", "yaw_rate")
TOLERANCE: Final = 0.01  # of the largest value of a quantity
DIGITS: Final = {"ax": 5e-4, "ay": 5e-4, "az": 5e-4, "roll_rate": 5e-5, "pitch_rate": 5e-5, "yaw_rate": 5e-5}


@dataclass(frozen=True)
class Truth:
    """A drive in SI units, x forward, y left, z up, without the standing 1 g."""

    t: Vec
    data: Mapping[str, Vec]  # felt quantities, vx, x, y


def truth(lap: Lap, start: float, end: float, rate: float) -> Truth:
    """A stretch of a lap at `rate` [Hz]."""
    t = np.arange(start, end, 1.0 / rate)

    def at(values: Vec) -> Vec:
        sampled: Vec = np.interp(t, lap.time, values)
        return sampled

    columns = [*lap.force.T, *lap.rate.T, lap.velocity[:, 0], lap.position[:, 0], lap.position[:, 1]]
    names = (*FELT, "vx", "x", "y")
    return Truth(t - start, {name: at(values) for name, values in zip(names, columns, strict=True)})


def hockenheim() -> Lap:
    """The lap of which everything here is made."""
    return drive(road("hockenheim").limited(120 / 3.6), load_car(), Driver(limits=Limits()))


# names of each quantity in the vocabularies of several tools; {} takes the unit, or nothing
VOCABULARIES: Final[Mapping[str, Mapping[str, str]]] = {
    "plain": {
        "t": "time", "ax": "ax", "ay": "ay", "az": "az", "vx": "speed", "lat": "latitude", "lon": "longitude",
        "roll_rate": "roll_rate", "pitch_rate": "pitch_rate", "yaw_rate": "yaw_rate", "heading": "heading",
    },
    "motec": {
        "t": "Time", "ax": "G Force Long", "ay": "G Force Lat", "az": "G Force Vert", "vx": "Ground Speed",
        "roll_rate": "Gyro Roll Velocity", "pitch_rate": "Gyro Pitch Velocity",
        "yaw_rate": "Gyro Yaw Velocity", "lat": "GPS Latitude", "lon": "GPS Longitude",
        "heading": "GPS Heading",
    },
    "aim": {
        "t": "Time", "ax": "InlineAcc", "ay": "LateralAcc", "az": "VerticalAcc", "vx": "GPS Speed",
        "roll_rate": "RollRate", "pitch_rate": "PitchRate", "yaw_rate": "YawRate",
        "lat": "GPS Latitude", "lon": "GPS Longitude", "heading": "GPS Heading",
    },
    "carmaker": {
        "t": "Time", "ax": "Car.ax", "ay": "Car.ay", "az": "Car.az", "vx": "Car.v",
        "roll_rate": "Car.RollVel", "pitch_rate": "Car.PitchVel", "yaw_rate": "Car.YawRate",
        "lat": "Latitude", "lon": "Longitude", "heading": "Heading",
    },
    "phone": {
        "t": "timestamp", "ax": "accelX", "ay": "accelY", "az": "accelZ", "vx": "speed",
        "roll_rate": "gyroX", "pitch_rate": "gyroY", "yaw_rate": "gyroZ",
        "lat": "locationLatitude", "lon": "locationLongitude", "heading": "course",
    },
    "sim": {
        "t": "SessionTime", "ax": "LongAccel", "ay": "LatAccel", "az": "VertAccel", "vx": "Speed",
        "roll_rate": "RollRate", "pitch_rate": "PitchRate", "yaw_rate": "YawRate",
        "lat": "Lat", "lon": "Lon", "heading": "Heading",
    },
    "german": {
        "t": "Zeit", "ax": "Längsbeschleunigung", "ay": "Querbeschleunigung", "az": "Hochbeschleunigung",
        "vx": "Geschwindigkeit", "roll_rate": "Wankrate", "pitch_rate": "Nickrate", "yaw_rate": "Gierrate",
        "lat": "Breite", "lon": "Länge", "heading": "Kurs",
    },
}  # fmt: skip
FORCE_UNITS: Final = {"m/s^2": 1.0, "m/s²": 1.0, "g": STANDARD_GRAVITY, "mg": 1e-3 * STANDARD_GRAVITY}
RATE_UNITS: Final = {"rad/s": 1.0, "deg/s": np.pi / 180, "°/s": np.pi / 180}
SPEED_UNITS: Final = {"m/s": 1.0, "km/h": 1 / 3.6, "mph": 0.44704}
SUFFIX: Final = {
    "m/s^2": "mps2", "m/s²": "m_s2", "g": "g", "mg": "mg", "rad/s": "radps", "deg/s": "degps", "°/s": "dps",
    "m/s": "mps", "km/h": "kmh", "mph": "mph", "s": "s", "ms": "ms", "us": "us", "ns": "ns", "deg": "deg",
}  # fmt: skip
AXES: Final[Mapping[str, tuple[str, ...]]] = {  # quantities whose sign is turned
    "iso": (),
    "sae": ("ay", "az", "pitch_rate", "yaw_rate"),
    "lateral": ("ay",),
    "right-handed yaw": ("yaw_rate",),
    "backward": ("ax",),
}
FORMS: Final = (
    "comma", "semicolon", "semicolon-decimal-comma", "tab", "blanks", "bars", "quoted", "long",
    "json", "json-lines", "json-arrays", "json-nested", "utf-16", "cp1252", "erg", "crlf", "trailing",
)  # fmt: skip
STATED: Final = ("brackets", "suffix", "row", "parentheses", "unstated")
CLOCKS: Final = (
    "s", "ms", "us", "epoch-s", "epoch-ms", "epoch-us", "epoch-ns", "iso8601", "iso-blank", "clock", "hhmmss",
    "coarse", "twice", "jitter", "offset", "midnight",
)  # fmt: skip
PREAMBLES: Final = ("none", "comments", "motec", "aim", "racechrono", "title", "vbo", "types", "blank")
SPARSE: Final = ("none", "speed", "interleaved")
WITNESSES: Final = ("none", "heading", "place")


@dataclass(frozen=True, kw_only=True)
class Form:
    """One way to write a drive."""

    form: str = "comma"
    vocabulary: str = "plain"
    axes: str = "iso"
    stated: str = "brackets"  # how units are stated
    force: str = "m/s^2"
    rate: str = "rad/s"
    speed: str = "m/s"
    clock: str = "s"
    preamble: str = "none"
    sparse: str = "none"
    witness: str = "none"
    gravity: bool = True  # az holds the standing 1 g
    vertical: bool = True  # az and the rates of roll and pitch are there
    turning: bool = True  # speed and yaw rate are there


def random_form(rng: np.random.Generator) -> Form:
    """A combination that a logger might write."""

    def one(of: Sequence[str] | Mapping[str, Any]) -> str:
        return str(rng.choice(list(of)))

    form = Form(
        form=one(FORMS),
        vocabulary=one(VOCABULARIES),
        axes=one(AXES) if rng.random() < 0.4 else "iso",
        stated=one(STATED),
        force=one(FORCE_UNITS),
        rate=one(RATE_UNITS),
        speed=one(SPEED_UNITS),
        clock=one(CLOCKS),
        preamble=one(PREAMBLES),
        sparse=one(SPARSE),
        witness=one(WITNESSES),
        gravity=bool(rng.random() < 0.7),
        vertical=bool(rng.random() < 0.7),
        turning=bool(rng.random() < 0.8),
    )
    return possible(form)


def possible(form: Form) -> Form:
    """The nearest form that can be written: text has preambles, numbers have no dates."""
    textual = not form.form.startswith("json") and form.form not in ("erg", "long")
    if not textual:
        form = replace(form, preamble="none", sparse="none")
        form = replace(form, stated="brackets" if form.form in ("long", "erg") else "suffix")
    if form.form == "erg" and form.clock not in ("s", "ms", "epoch-s", "twice", "jitter", "offset"):
        form = replace(form, clock="s")
    if form.form == "long" and form.clock in ("coarse", "twice"):
        form = replace(form, clock="s")
    if form.form == "blanks":
        stated = form.stated if form.stated in ("suffix", "row") else "unstated"
        preamble = "none" if form.preamble == "racechrono" else form.preamble
        form = replace(form, vocabulary="carmaker", stated=stated, preamble=preamble, sparse="none")
        form = replace(form, clock="s" if form.clock in ("iso-blank",) else form.clock)
    if form.preamble in ("motec", "aim", "racechrono", "types") and form.stated != "unstated":
        form = replace(form, stated="row")
    if form.preamble == "vbo":
        form = replace(
            form, form="blanks", vocabulary="carmaker", stated="unstated", sparse="none", clock="hhmmss"
        )
    if form.stated == "unstated":  # nothing can tell g from m/s² but speed and yaw rate
        form = replace(form, turning=True)
    if form.clock == "coarse":
        form = replace(form, sparse="none")
    return form


@dataclass(frozen=True)
class Written:
    """A file, and what a user has to state to read it."""

    name: str
    files: Mapping[str, bytes]  # by name
    columns: Mapping[str, str]
    form: Form
    turned: tuple[str, ...] = ()  # quantities whose sign is turned against x forward, y left, z up
    missing: tuple[str, ...] = ()  # felt quantities that are not in the file
    units: Mapping[str, str] = field(default_factory=dict)


def write(drive_: Truth, form: Form, rng: np.random.Generator) -> Written:
    """The drive as a file of that form."""
    if form.clock == "jitter":
        drive_ = _jittered(drive_, rng)
    names, unit_of, data = _columns(drive_, form)
    stamps = _stamps(drive_.t, form.clock)
    turned = tuple(key for key in AXES[form.axes] if key in data)
    labels = {key: _label(names[key], unit_of[key], form.stated) for key in ("t", *data)}
    columns = {} if form.vocabulary != "german" else {key: labels[key] for key in ("t", *data)}
    if form.form == "erg":
        files_ = _erg(labels, {key: unit_of[key] for key in labels}, stamps, data)
        name = "drive.erg"
    elif form.form.startswith("json"):
        files_, name = {"drive.json": _json(form.form, labels, stamps, data)}, "drive.json"
    else:
        name = "drive.csv"
        files_ = {name: _text(form, labels, unit_of, stamps, data)}
    if form.form == "long" and columns:
        columns = {**columns, "t": "meta time"}
    missing = tuple(key for key in FELT if key not in data)
    return Written(name, files_, columns, form, turned, missing, unit_of)


def _jittered(drive_: Truth, rng: np.random.Generator) -> Truth:
    """The same drive, sampled at uneven instants."""
    t = drive_.t + np.r_[0.0, 0.2 * drive_.t[1] * rng.uniform(-1.0, 1.0, len(drive_.t) - 2), 0.0]
    t = np.round(t, 4)
    return Truth(t, {key: np.interp(t, drive_.t, values) for key, values in drive_.data.items()})


def _columns(drive_: Truth, form: Form) -> tuple[dict[str, str], dict[str, str], dict[str, Vec]]:
    keys = ["ax", "ay"]
    keys += ["az", "roll_rate", "pitch_rate"] if form.vertical else []
    keys += ["yaw_rate", "vx"] if form.turning else []
    unit_of = {
        "t": "ms" if form.clock in ("ms", "epoch-ms") else "us" if form.clock in ("us", "epoch-us") else "s"
    }
    unit_of["t"] = "ns" if form.clock == "epoch-ns" else unit_of["t"]
    if form.clock in ("iso8601", "iso-blank", "clock", "hhmmss", "midnight"):
        unit_of["t"] = ""
    scales = {**FORCE_UNITS, **RATE_UNITS, **SPEED_UNITS, "deg": 1.0}
    data: dict[str, Vec] = {}
    for key in keys:
        unit_of[key] = form.force if key in ("ax", "ay", "az") else form.speed if key == "vx" else form.rate
        lifted = drive_.data[key] + (STANDARD_GRAVITY if key == "az" and form.gravity else 0.0)
        data[key] = lifted * (-1.0 if key in AXES[form.axes] else 1.0) / scales[unit_of[key]]
    if form.witness == "place":
        data["lat"] = SET_OUT[0] + np.degrees(drive_.data["y"] / EARTH)
        data["lon"] = SET_OUT[1] + np.degrees(drive_.data["x"] / EARTH / np.cos(np.radians(SET_OUT[0])))
    if form.witness == "heading":
        course = np.arctan2(np.gradient(drive_.data["x"]), np.gradient(drive_.data["y"]))
        data["heading"] = np.degrees(course) % 360.0
    unit_of |= dict.fromkeys(("lat", "lon", "heading"), "deg")
    return dict(VOCABULARIES[form.vocabulary]), unit_of, data


def _label(name: str, unit: str, stated: str) -> str:
    if not unit or stated in ("row", "unstated"):
        return name
    if stated == "suffix":
        return f"{name}_{SUFFIX[unit]}"
    return f"{name} [{unit}]" if stated == "brackets" else f"{name} ({unit})"


def _stamps(t: Vec, clock: str) -> list[str]:
    scale = {"ms": 1e3, "us": 1e6, "epoch-ms": 1e3, "epoch-us": 1e6, "epoch-ns": 1e9}.get(clock, 1.0)
    if clock in ("ms", "us"):
        return [f"{scale * one:.0f}" for one in t]
    if clock in ("epoch-ms", "epoch-us", "epoch-ns"):
        return [f"{round(1e3 * (EPOCH + one)) * round(scale / 1e3)}" for one in t]
    if clock == "epoch-s":
        return [f"{EPOCH + one:.3f}" for one in t]
    if clock == "coarse":
        return [f"{one:.1f}" for one in t]
    late = 86400.0 - 9.0 - EPOCH % 86400.0 if clock == "midnight" else 0.0

    def dated(one: float) -> datetime:
        return datetime.fromtimestamp(EPOCH + late, UTC) + timedelta(milliseconds=round(1e3 * one))

    forms = {
        "iso8601": lambda one: dated(one).strftime("%Y-%m-%dT%H:%M:%S.%f")[:-3] + "Z",
        "iso-blank": lambda one: dated(one).strftime("%Y-%m-%d %H:%M:%S.%f")[:-3],
        "clock": lambda one: dated(one).strftime("%H:%M:%S.%f")[:-3],
        "midnight": lambda one: dated(one).strftime("%H:%M:%S.%f")[:-3],
        "hhmmss": lambda one: dated(one).strftime("%H%M%S.%f")[:-4],
    }
    if clock in forms:
        return [forms[clock](float(one)) for one in t]
    return [f"{one + (1200.0 if clock == 'offset' else 0.0):.4f}" for one in t]


def _rows(form: Form, stamps: list[str], data: Mapping[str, Vec]) -> list[list[str]]:
    digits = {"lat": 8, "lon": 8}
    cells = [[f"{value:.{digits.get(key, 6)}f}" for value in values] for key, values in data.items()]
    for column, key in zip(cells, data, strict=True):
        if (form.sparse == "speed" and key in ("vx", "lat", "lon", "heading")) or (
            form.sparse == "interleaved" and key in ("yaw_rate", "vx", "lat", "lon", "heading")
        ):
            first = 1 if form.sparse == "interleaved" else 0
            column[:] = [cell if i % 4 == first else "" for i, cell in enumerate(column)]
    rows = [list(row) for row in zip(stamps, *cells, strict=True)]
    if form.clock == "twice":
        rows = [row for i, row in enumerate(rows) for _ in range(2 if i % 7 == 3 else 1)]
    return rows


_DELIMITER: Final = {
    "semicolon": ";", "semicolon-decimal-comma": ";", "trailing": ";", "tab": "\t", "blanks": " ",
    "bars": "|",
}  # fmt: skip


def _text(
    form: Form,
    labels: Mapping[str, str],
    unit_of: Mapping[str, str],
    stamps: list[str],
    data: Mapping[str, Vec],
) -> bytes:
    if form.form == "long":
        rows = ["meta id,meta time,signal name,signal unit,signal value"]
        rows += [
            f"7,{stamp},{labels[key]},,{values[i]:.6f}"
            for i, stamp in enumerate(stamps)
            for key, values in data.items()
        ]
        return "\n".join(rows).encode()
    mark = _DELIMITER.get(form.form, ",")
    quote = '"' if form.form == "quoted" else ""

    def line(cells: Sequence[str]) -> str:
        return mark.join(f"{quote}{cell}{quote}" for cell in cells) + (
            mark if form.form == "trailing" else ""
        )

    head = [line(list(labels.values()))]
    if form.stated == "row":
        head.append(line([unit_of[key] for key in labels]))
    body = [line(row) for row in _rows(form, stamps, data)]
    if form.form == "semicolon-decimal-comma":
        body = [row.replace(".", ",") for row in body]
    text = "\n".join([*_preamble(form.preamble, head, line, len(labels)), *body]) + "\n"
    if form.form == "crlf":
        text = text.replace("\n", "\r\n")
    encoding = {"utf-16": "utf-16", "cp1252": "cp1252"}.get(form.form, "utf-8")
    return text.encode(encoding)


def _preamble(kind: str, head: list[str], line: Callable[[Sequence[str]], str], width: int) -> list[str]:
    if kind == "comments":
        return ["# made for a test", "# Vehicle: none, 4", "", *head]
    if kind == "motec":
        preamble = [
            line(["Format", "A Logger"]),
            line(["Sample Rate", "20.000", "Hz"]),
            line(["Beacon Markers", ""]),
        ]
        return [*preamble, "", "", *head, "", ""]
    if kind == "aim":
        preamble = [line(["Format", "Other"]), line(["Duration", "28"]), line(["Beacon Markers", "28"])]
        return [*preamble, line(["Date", "5 May"]), "", *head, ""]
    if kind == "racechrono":
        sources = [f"10{i}: acc" if i else "" for i in range(width)]
        return ["This file was made by a test", line(["Format", "3"]), "", *head, line(sources)]
    if kind == "title":
        return ["Run 12", "Track: Hockenheim", *head]
    if kind == "vbo":
        return ["File created on 05/05/2026 at 10:00:00", "", "[header]", "time", "", "[column names]", *head,
                "", "[data]"]  # fmt: skip
    if kind == "types":
        return ["# " + head[0], "# " + line(["C1"] * width), *["# " + row for row in head[1:]]]
    return ["", "", *head] if kind == "blank" else head


def _number(text: str) -> Any:
    try:
        return float(text)
    except ValueError:
        return text


def _json(kind: str, labels: Mapping[str, str], stamps: list[str], data: Mapping[str, Vec]) -> bytes:
    rows = [
        [_number(stamp), *(round(float(v[i]), 8) for v in data.values())] for i, stamp in enumerate(stamps)
    ]
    names = list(labels.values())
    records = [dict(zip(names, row, strict=True)) for row in rows]
    if kind == "json-lines":
        return "\n".join(json.dumps(record) for record in records).encode()
    if kind == "json-arrays":
        return json.dumps({name: [row[i] for row in rows] for i, name in enumerate(names)}).encode()
    if kind == "json-nested":
        return json.dumps({"session": {"driver": "nobody", "samples": records}}).encode()
    return json.dumps(records).encode()


def _erg(
    labels: Mapping[str, str], unit_of: Mapping[str, str], stamps: list[str], data: Mapping[str, Vec]
) -> dict[str, bytes]:
    import struct

    names = list(labels.values())
    info = ["#INFOFILE1.1", "File.Format = erg", "File.ByteOrder = LittleEndian"]
    for place, (key, name) in enumerate(labels.items(), 1):
        info += [f"File.At.{place}.Name = {name}", f"File.At.{place}.Type = Double"]
        info += [f"Quantity.{name}.Unit = {unit_of[key]}"]
    table = np.column_stack([[float(stamp) for stamp in stamps], *data.values()])
    header = b"CM-ERG\0\0" + bytes([1, 0]) + struct.pack("<H", 8 * len(names)) + bytes(4)
    return {"drive.erg": header + table.astype("<f8").tobytes(), "drive.erg.info": "\n".join(info).encode()}


def put(written: Written, folder: Path) -> Path:
    """Write the files; the path of the log."""
    for name, data in written.files.items():
        (folder / name).write_bytes(data)
    return folder / written.name


def judge(log: Log, drive_: Truth, written: Written) -> str:
    """How the log was read: ``right``, ``mirrored`` (every turned sign kept), or ``wrong: …``."""
    wrong: dict[str, float] = {}
    mirrored: dict[str, float] = {}
    t = drive_.t[(drive_.t > 0.5) & (drive_.t < min(log.duration, drive_.t[-1]) - 0.5)]
    if len(t) < 0.8 * len(drive_.t):
        return f"wrong: {log.duration:.3g} s of {drive_.t[-1]:.3g} s"
    read = log.felt(t)
    for place, key in enumerate(FELT):
        true = np.interp(t, drive_.t, drive_.data[key])
        size = float(np.abs(true).max())
        bound = TOLERANCE * size + DIGITS[key] + _blur(drive_, key, written)
        if key in written.missing:
            continue
        if float(np.abs(read[:, place] - true).max()) > bound:
            wrong[key] = float(np.abs(read[:, place] - true).max()) / size
        sign = -1.0 if key in written.turned else 1.0
        if float(np.abs(read[:, place] - sign * true).max()) > bound:
            mirrored[key] = 1.0
    if not wrong:
        return "right"
    if not mirrored:
        return "mirrored"
    return "wrong: " + ", ".join(f"{key} by {100 * share:.0f} %" for key, share in wrong.items())


def _blur(drive_: Truth, key: str, written: Written) -> float:
    """What a coarse or sparse clock takes from a quantity: its slope times the time that is lost."""
    step = float(drive_.t[1] - drive_.t[0])
    slope = float(np.abs(np.diff(drive_.data[key])).max()) / step
    bend = float(np.abs(np.diff(drive_.data[key], 2)).max()) / step**2
    lost = {"coarse": 0.05, "hhmmss": 0.01, "jitter": 0.001}.get(written.form.clock, 0.0005)
    sparse = 4.0 * step if written.form.sparse == "interleaved" and key == "yaw_rate" else step
    return slope * lost + 0.125 * bend * sparse**2
