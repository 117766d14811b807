"""A good drive, mutilated in every way that real logs have shown: each is refused or repaired, and said."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from otolith.core.arrays import Vec
from otolith.core.errors import InputError
from otolith.recordings import Log, parse_log
from otolith.recordings.columns import STANDARD_GRAVITY
from otolith.recordings.settings import LogSettings

G = 9.80665
T = np.round(np.arange(0.0, 60.0, 0.02), 4)
V = 18.0 + 6.0 * np.sin(0.3 * T) + 2.0 * np.sin(0.11 * T)
R = 0.12 * np.sin(0.2 * T) + 0.08 * np.sin(0.47 * T)
NOISE = np.random.default_rng(5).normal(0.0, 0.2, (3, len(T)))

Drive = dict[str, Vec]
UNITS = {"t": "s", "ax": "mps2", "ay": "mps2", "az": "mps2", "yaw_rate": "radps", "vx": "mps"}


def good() -> Drive:
    ax = np.gradient(V, T) + NOISE[0]
    return {"t": T, "ax": ax, "ay": 1.1 * V * R + NOISE[1], "az": NOISE[2], "yaw_rate": R, "vx": V}


def written(drive: Drive, *, units: bool = True) -> str:
    header = ",".join(f"{name}_{UNITS[name]}" if units and name in UNITS else name for name in drive)
    rows = (",".join(f"{value:.6g}" for value in row) for row in zip(*drive.values(), strict=True))
    return "\n".join([header, *rows]) + "\n"


def read(drive: Drive, *, units: bool = True, **columns: str) -> Log:
    return parse_log(written(drive, units=units), "log.csv", columns=columns)


def changed(**changes: Callable[[Drive], Vec]) -> Drive:
    drive = good()
    return drive | {name: change(drive) for name, change in changes.items()}


def without(*names: str, drive: Drive | None = None) -> Drive:
    return {name: values for name, values in (drive or good()).items() if name not in names}


def test_a_good_drive_is_taken_as_it_is() -> None:
    log = read(good())
    # the summary, columns but speed, what is not there, left and right, the sign of a_z, the road of a_x
    assert len(log.notes) == 1 + 6 - 1 + 4
    assert_allclose(log.force[:, 1], good()["ay"], atol=1e-4)


REFUSED = {
    "ay in y right": (
        changed(ay=lambda d: -d["ay"]),
        "nothing in it shows which: map ay=-ay_mps2; or map yaw_rate=-yaw_rate_radps",
    ),
    "ay turned, no speed": (
        without("vx", drive=changed(ay=lambda d: -d["ay"])),
        "ay in log.csv is against yaw rate",
    ),
    "ax backwards": (changed(ax=lambda d: -d["ax"]), "map ax=-ax_mps2"),
    "yaw rate turned": (changed(yaw_rate=lambda d: -d["yaw_rate"]), "ay in log.csv is against speed × yaw"),
    "ay in g": (changed(ay=lambda d: d["ay"] / G), "is ay in g? then map ay=ay_mps2:g"),
    "ax in g": (changed(ax=lambda d: d["ax"] / G), "is ax in g? then map ax=ax_mps2:g"),
    "yaw rate in deg/s": (
        changed(yaw_rate=lambda d: np.degrees(d["yaw_rate"])),
        "is yaw_rate in deg/s? then map yaw_rate=yaw_rate_radps:deg/s",
    ),
    "gentle yaw rate in deg/s": (
        changed(yaw_rate=lambda d: np.degrees(0.15 * d["yaw_rate"]), ay=lambda d: 0.15 * d["ay"]),
        "is yaw_rate in deg/s? then map yaw_rate=yaw_rate_radps:deg/s",
    ),
    "speed in km/h": (changed(vx=lambda d: 3.6 * d["vx"]), "is vx in km/h? then map vx=vx_mps:km/h"),
    "z down": (changed(az=lambda d: d["az"] - G), "does z point down?"),
    "az in g, unit unsaid": (changed(az=lambda d: d["az"] / G + 1.0), "is it in g? then map az=az:g"),
    "vertical axis as ax": (changed(ax=lambda d: d["az"] + G), "is this the vertical axis?"),
    "x and y exchanged": (
        changed(ax=lambda d: d["ay"], ay=lambda d: d["ax"]),
        "map ax=ay_mps2 and ay=ax_mps2, which makes this file agree",
    ),
    "frozen sensor": (
        changed(
            ax=lambda d: np.where((T > 20) & (T < 25), 0.5, d["ax"]),
            ay=lambda d: np.where((T > 20) & (T < 25), 0.5, d["ay"]),
        ),
        "frozen sensor from 20.02 s to 25 s (all forces unchanged for 4.96 s while the speed changes",
    ),
    "tilted sensor, no speed": (
        without("vx", drive=changed(ax=lambda d: d["ax"] + 2.0)),
        "speed gained by ax in log.csv is 116.3 m/s",
    ),
    "a gap": ({name: np.r_[v[:900], v[1000:]] for name, v in good().items()}, "gap in ax before line 902"),
    "not a number": (
        changed(ay=lambda d: np.where(T == 3.0, np.inf, d["ay"])),
        "line 152 of log.csv is inf",
    ),
    "time running back": (changed(t=lambda d: np.where(T == 3.0, 1.0, T)), "time in line 152"),
    "time in ms": (changed(t=lambda d: 1000.0 * T), "is time in ms?"),
    "a spike": (changed(ax=lambda d: np.where(T == 3.0, 1e3, d["ax"])), "stray packet from 2.98 s to 3.02 s"),
    "no time": (without("t"), "time (t) in log.csv is missing"),
    "another column of the same quantity": (
        good() | {"AccX [m/s2]": 2.0 * good()["ax"]},
        "ax in log.csv is given by 'ax_mps2' (column 2) and 'AccX [m/s2]' (column 7)",
    ),
}


@pytest.mark.parametrize("kind", REFUSED)
def test_a_mutilated_drive_is_refused_with_the_remedy(kind: str) -> None:
    drive, sentence = REFUSED[kind]
    with pytest.raises(InputError) as caught:
        read(drive, units="unsaid" not in kind)
    assert sentence in str(caught.value)
    assert "\n" not in str(caught.value)


REPAIRED = {
    "gravity in az": (changed(az=lambda d: d["az"] + G), "it holds gravity, 1 g was removed", "az"),
    "clock that jitters": (
        changed(t=lambda d: T + 0.004 * np.sin(7.0 * T) ** 2),
        "unevenly sampled",
        "ay",
    ),
    "rows lost": ({name: np.r_[v[:900], v[920:]] for name, v in good().items()}, "1 gaps bridged", ""),
    "rows doubled": ({n: np.repeat(v, 2) for n, v in good().items()}, "3000 rows were written twice", "ay"),
    "a column twice": (good() | {"AccX": good()["ax"]}, "(the same as 'AccX')", "ax"),
    "stamps since 1970": (changed(t=lambda d: T + 1.7e9), "59.98 s", "ay"),
}


@pytest.mark.parametrize("kind", REPAIRED)
def test_what_can_be_repaired_is_and_a_note_says_so(kind: str) -> None:
    drive, note, key = REPAIRED[kind]
    if kind == "stamps since 1970":
        header, *rows = written(drive).splitlines()
        exact = [f"{t:.4f},{row.split(',', 1)[1]}" for t, row in zip(drive["t"], rows, strict=True)]
        log = parse_log("\n".join([header, *exact]), "log.csv")
    else:
        log = read(drive)
    assert any(note in text for text in log.notes)
    if key:
        column = {"ax": 0, "ay": 1, "az": 2}[key]
        assert_allclose(log.force[:, column], good()[key], atol=0.06)


def test_there_are_enough_kinds() -> None:
    assert len(REFUSED) + len(REPAIRED) >= 24


@pytest.mark.parametrize(
    ("drive", "columns"),
    [
        (REFUSED["ay in y right"][0], {"ay": "-ay_mps2"}),
        (REFUSED["ay in g"][0], {"ay": "ay_mps2:g"}),
        (REFUSED["gentle yaw rate in deg/s"][0], {"yaw_rate": "yaw_rate_radps:deg/s"}),
        (REFUSED["speed in km/h"][0], {"vx": "vx_mps:km/h"}),
        (REFUSED["x and y exchanged"][0], {"ax": "ay_mps2", "ay": "ax_mps2"}),
    ],
)
def test_the_remedy_that_a_refusal_names_works(drive: Drive, columns: dict[str, Any]) -> None:
    assert not [note for note in read(drive, **columns).notes if "doubtful" in note or "constant" in note]


def test_without_the_speed_nothing_is_checked_against_it() -> None:
    log = read(changed(ax=lambda d: -d["ax"]), vx="none")
    assert_allclose(log.force[:, 0], -good()["ax"], atol=1e-4)


def test_a_likely_contradiction_is_noted() -> None:
    noisy = np.random.default_rng(2).normal(0.0, 1.0, 60)[T.astype(int)]
    notes = read(changed(ax=lambda d: -np.gradient(V, T) + 3.0 * noisy)).notes
    assert any(note.startswith("doubtful: ax runs against the change of speed") for note in notes)
    notes = read(changed(ay=lambda d: 0.1 * (d["ay"] + 2.3 * noisy))).notes
    assert any(note.startswith("doubtful: ay is 0.1") and "is ay in g? then map ay" in note for note in notes)


def test_small_forces_of_an_unstated_unit_may_be_in_g_and_the_note_says_what_to_do() -> None:
    t = np.arange(0.0, 60.0, 0.05)
    force = 3.0 * np.sin(0.2 * np.pi * t)
    rows = "\n".join(f"{a:.2f},{b / STANDARD_GRAVITY:.9f},0" for a, b in zip(t, force, strict=True))
    doubt = (
        "doubtful: no unit is stated of ax and ay, nothing in the file confirms one, and 0.31 m/s² at most"
    )
    log = parse_log(f"time,ax,ay\n{rows}", "log.csv")
    assert [note for note in log.notes if note.startswith(doubt) and note.endswith("map ax=ax:g and ay=ay:g")]
    stated_g = LogSettings(columns={"ax": "ax:g", "ay": "ay:g"})
    log = parse_log(f"time,ax,ay\n{rows}", "log.csv", settings=stated_g)
    assert_allclose(log.force[:, 0], np.interp(log.t, t, force), atol=1e-4)
    stated = parse_log(f"time,ax_mps2,ay_mps2\n{rows}", "log.csv")
    assert not any("doubtful" in note for note in [*log.notes, *stated.notes])


OFFSETS = {"sensor rolled": ("ay", 0.6), "sensor pitched": ("ax", -0.4)}


@pytest.mark.parametrize("kind", OFFSETS)
def test_a_constant_is_told_and_stays_unless_the_user_says_otherwise(kind: str) -> None:
    """A sensor out of level and a long slope look the same, and what a driver on a slope feels must stay."""
    key, value = OFFSETS[kind]
    drive, column = changed(**{key: lambda d: d[key] + value}), {"ax": 0, "ay": 1}[key]
    log = read(drive)
    assert any(note.startswith(f"{key}: a constant {value:+.1f}") for note in log.notes)
    assert_allclose(log.force[:, column], drive[key], atol=1e-4)
    level = parse_log(written(drive), "log.csv", settings=LogSettings(offsets="remove"))
    assert_allclose(level.force[:, column], good()[key], atol=0.06)


@settings(max_examples=20, deadline=None)
@given(tilt=st.floats(-4.5, 4.5))
def test_a_sensor_out_of_level_is_put_right_at_the_users_word(tilt: float) -> None:
    """Whatever the tilt [deg], what is left of it is below what a good sensor shows."""
    offset = G * np.sin(np.radians(tilt))
    drive = changed(ay=lambda d: d["ay"] + offset)
    log = parse_log(written(drive), "log.csv", settings=LogSettings(offsets="remove"))
    assert abs(float(np.mean(log.force[:, 1] - good()["ay"]))) < 0.2


@pytest.mark.parametrize("offset", [1.2, -3.0])
def test_what_no_mounting_explains_is_not_removed(offset: float) -> None:
    drive = changed(ax=lambda d: d["ax"] + offset)
    assert_allclose(read(drive).force[:, 0], drive["ax"], atol=1e-4)
    with pytest.raises(InputError, match=r"a sensor that is mounted level shows at most 0\.85"):
        parse_log(written(drive), "log.csv", settings=LogSettings(offsets="remove"))
