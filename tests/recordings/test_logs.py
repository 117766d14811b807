import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose, assert_array_equal

from otolith.core.arrays import Vec
from otolith.core.errors import InputError
from otolith.recordings import Log, parse_log
from otolith.recordings.columns import STANDARD_GRAVITY
from otolith.recordings.table import decode

N = 30
T = (np.arange(N, dtype=float) * 0.1).round(3)
AX = np.sin(T).round(6)


def text(header: str = "t,ax", *series: Vec, sep: str = ",", end: str = "\n") -> str:
    columns = series or (T, AX)
    rows = [sep.join(repr(float(value)) for value in row) for row in zip(*columns, strict=True)]
    return end.join([header, *rows]) + end


def damaged(line: int, new: str, header: str = "t,ax") -> str:
    """The plain log with one line of the file, counted from 1, replaced."""
    lines = text(header).splitlines()
    lines[line - 1] = new
    return "\n".join(lines)


def refusal(log: str, **columns: str) -> str:
    with pytest.raises(InputError) as caught:
        parse_log(log, "log.csv", columns=columns)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def assert_plain(log: Log) -> None:
    assert_array_equal(log.t, T)
    assert_array_equal(log.force[:, 0], AX)
    assert not log.force[:, 1:].any()
    assert not log.rate.any()


@pytest.mark.parametrize(
    "log",
    [
        text(),
        "\ufeff" + text(),
        text(end="\r\n"),
        text("t;ax", sep=";"),
        text("t\tax", sep="\t"),
        text("t|ax", sep="|"),
        text("t ax", sep=" "),
        text("t;ax", sep=";").replace(".", ","),
        text('"t","ax"').replace("\n", '"\n"').replace(",", '","').replace('""', '"').removesuffix('"'),
        "# a comment\n\n" + text(),
        text("t,ax\ns,m/s^2"),
        text("t,ax\n[s],[m/s^2]"),
        text() + "\n\n",
        text("t,note,ax", T, np.zeros(N), AX).replace(",0.0,", ",hello,"),
    ],
)
def test_delimiters_decimals_quotes_units_and_line_ends_are_recognised(log: str) -> None:
    assert_plain(parse_log(log, "log.csv"))


def test_every_quantity_finds_its_place_in_si() -> None:
    names = "time_ms,ax_g,ay_g,az_g,roll_rate_degps,pitch_rate_degps,yaw_rate_degps"
    values = np.arange(1.0, 7.0)[:, None] * np.ones(N) / 10
    log = parse_log(text(names, 1.7e12 + 1000 * T, *values), "log.csv")
    assert_allclose(log.t, T, atol=1e-9)
    assert_allclose(log.force[3], STANDARD_GRAVITY * np.array([0.1, 0.2, 0.3]))
    assert_allclose(log.rate[3], np.deg2rad([0.4, 0.5, 0.6]))
    assert log.columns == {
        "ax": "ax_g", "ay": "ay_g", "az": "az_g",
        "roll_rate": "roll_rate_degps", "pitch_rate": "pitch_rate_degps", "yaw_rate": "yaw_rate_degps",
    }  # fmt: skip


@given(arrays(np.float64, (N, 3), elements=st.floats(-4.5, 4.5)))
def test_numbers_are_read_back_bit_for_bit(force: Vec) -> None:
    log = parse_log(text("t_s,ax_mps2,ay_mps2,az_mps2", T, *force.T), "log.csv")
    assert_array_equal(log.force, force)


def test_notes_say_what_was_read_and_assumed() -> None:
    assert parse_log(text("t_s,ax"), "log.csv").notes == (
        "log.csv: 30 rows, 2.9 s, 10 Hz",
        "t: column 't_s' in s",
        "ax: column 'ax' in m/s2, no unit stated, taken as SI",
        "not in the log, taken as zero: ay, az, roll_rate, pitch_rate, yaw_rate",
        "the sign of ax is not proven: nothing in the file can be compared with it; "
        "it is taken in the axes of the rest",
    )


def test_a_turned_sign_is_noted() -> None:
    log = parse_log(text("t,foo"), "log.csv", columns={"ax": "-foo:g"})
    assert_allclose(log.force[:, 0], -STANDARD_GRAVITY * AX)
    assert "ax: column 'foo' in g, sign turned" in log.notes


def test_uneven_sampling_is_noted() -> None:
    t = T + 0.03 * (np.arange(N) % 2)
    assert parse_log(text("t,ax", t, AX), "log.csv").notes[0].endswith("unevenly sampled")


@pytest.mark.parametrize(
    ("log", "sentence"),
    [
        ("", "log.csv is empty, must be a table with one line of column names and one row per time"),
        (
            "\n# nothing\n",
            "log.csv is empty, must be a table with one line of column names and one row per time",
        ),
        ("t,ax\n", "number of rows in log.csv is 0, must be at least 2"),
        ("t,ax\n0,0\n", "number of rows in log.csv is 1, must be at least 2"),
        ("0,1\n2,3\n4,5\n", "line 1 of log.csv is numbers, must be the names of the columns"),
        (damaged(7, "0.5,-inf"), "'ax' in line 7 of log.csv is -inf, must be a finite number"),
        (damaged(7, "0.5,oops"), "'ax' in line 7 of log.csv is 'oops', must be a finite number"),
        (damaged(7, "0.5"), "number of values in line 7 of log.csv is 1, must be 2, as in the header"),
        (damaged(7, "0.5,1,2"), "number of values in line 7 of log.csv is 3, must be 2, as in the header"),
        (damaged(7, "1_0,0"), "'t' in line 7 of log.csv is '1_0', must be a finite number"),
        (
            damaged(7, "0.3,0"),
            "time in line 7 of log.csv is 0.3 s after the first row, must be after the row before, 0.4 s",
        ),
        (
            damaged(7, "0.4,0").replace("0.7,", "0.9,").replace("0.8,", "0.9,"),
            "time in line 7 of log.csv is 0.4 s after the first row, must be after the row before, 0.4 s "
            "(3 stamps repeat, and evenly spaced rows do not explain them; if the rows are evenly spaced "
            "all the same, map t=every:0.1s)",
        ),
        (
            text("t,ax", np.where(T < 1.0, T, T + 1.5), AX),
            "gap in ax before line 12 of log.csv, 0.9 s after the first row, is 1.6 s, must be at most 1 s "
            "(--events cut joins what lies before and after it, --events mark bridges it)",
        ),
        (
            text("t,ax", 1000 * T, AX),
            "gap in ax before line 3 of log.csv, 0 s after the first row, is 100 s, must be at most 1 s "
            "(is time in ms? then map t=t:ms)",
        ),
        (
            damaged(7, "0.5,-70", "t,ax_mps2"),
            "ax in line 7 of log.csv is -70 m/s², must be within ±50 m/s² (is it really in m/s2?)",
        ),
        (
            damaged(7, "0.5,9", "t,ax_g"),
            "ax in line 7 of log.csv is 88.2599 m/s², must be within ±50 m/s² (is it really in g?)",
        ),
        (
            damaged(7, "0.5,900"),
            "ax in line 7 of log.csv is 900 m/s², must be within ±50 m/s² "
            "(no unit is stated: is it in mm/s² or counts of the sensor?)",
        ),
        (
            text("t,ax,yaw_rate", T, AX, 30 * T),
            "yaw_rate in log.csv is 30 rad/s over two seconds, must be within ±2.5 rad/s for most of the "
            "drive (is it in deg/s? then map yaw_rate=yaw_rate:deg/s)",
        ),
        (
            text("t,ax,ay_mps2,az_mps2", T, AX, AX, np.full(N, -9.81)),
            "mean of az in log.csv is -9.81 m/s², must be about 0 or +9.81 m/s²: does z point down? "
            "Then y may point right, which nothing in the file shows: --axes sae if it does (ay, az, pitch "
            "and yaw rate are turned), map az=-az_mps2 if it points left",
        ),
        (
            text("t,ax,az", T, AX, np.ones(N)),
            "mean of az in log.csv is 1 m/s², must be about 0 or +9.81 m/s² "
            "(no unit is stated: is it in g? then map az=az:g, and ax, ay alike)",
        ),
    ],
)
def test_a_log_that_cannot_be_trusted_is_refused(log: str, sentence: str) -> None:
    assert refusal(log) == sentence


def test_gravity_in_az_is_removed_and_said() -> None:
    log = parse_log(text("t,ax,az_g", T, AX, np.ones(N)), "log.csv")
    assert_allclose(log.force[:, 2], 0.0, atol=1e-12)
    assert "az averages 9.807 m/s²: it holds gravity, 1 g was removed" in log.notes


def test_a_vertical_column_without_gravity_is_left_as_it_is() -> None:
    assert_array_equal(parse_log(text("t,ax,az", T, AX, AX), "log.csv").force[:, 2], AX)


@pytest.mark.parametrize("log", [text("t,ax,vx", T, AX, AX), text("t,ax,vx", 5 * T, AX, np.ones(N))])
def test_a_short_drive_or_a_constant_speed_says_nothing_about_the_others(log: str) -> None:
    notes = parse_log(log, "log.csv").notes
    assert len(notes) == 5  # rows, t, ax, what is not there, and that the sign of ax is not proven


def test_rows_written_twice_are_left_out() -> None:
    lines = text().splitlines()
    log = parse_log("\n".join([*lines[:9], lines[8], lines[8], *lines[9:]]), "log.csv")
    assert_plain(log)
    assert "ax: 2 rows were written twice and left out" in log.notes


def test_a_column_written_twice_is_read_once() -> None:
    log = parse_log(text("t,ax,Car.ax", T, AX, AX), "log.csv")
    assert_plain(log)
    assert "ax: column 'ax' in m/s2, no unit stated, taken as SI (the same as 'Car.ax')" in log.notes
    with pytest.raises(InputError, match=r"ax in log.csv is given by"):
        parse_log(text("t,ax,Car.ax", T, AX, 1.5 * AX), "log.csv")
    log = parse_log(text("t,ax,Car.ax", T, AX, 1.1 * AX), "log.csv")
    assert_plain(log)
    assert any("taken before 'Car.ax', different numbers: it comes first" in note for note in log.notes)
    assert_plain(parse_log(text("t,ax,Car.ax", T, AX, np.full(N, np.nan)), "log.csv"))


def test_small_gaps_are_bridged_and_said() -> None:
    t = np.where(T < 1.0, T, T + 0.6)
    assert (
        "ax: 1 gaps bridged by straight lines, the longest of 0.7 s at 0.9 s"
        in parse_log(text("t,ax", t, AX), "log.csv").notes
    )


def test_nothing_but_one_row_over_and_over_is_refused() -> None:
    assert refusal("t,ax\n1,2\n1,2\n1,2") == "number of samples of 'ax' in log.csv is 1, must be at least 2"


def test_names_behind_a_comment_mark_are_read() -> None:
    assert_plain(parse_log("# made by hand\n# " + text(), "log.csv"))
    assert_plain(parse_log("#" + text("Time Car.ax", sep=" "), "log.csv"))


def test_where_the_car_was_is_kept() -> None:
    log = parse_log(text("t,ax,x_m,y_km", T, AX, 10 * T, 0.001 * T), "log.csv")
    assert log.place is not None
    assert_allclose(log.place, np.stack([10 * T, T], axis=1))
    assert parse_log(text("t,ax,x_m", T, AX, T), "log.csv").place is None


@pytest.mark.parametrize(
    ("encoding", "note"),
    [("utf-8", ""), ("utf-8-sig", ""), ("cp1252", "read as cp1252"), ("utf-16", "read as utf-16")],
)
def test_what_spreadsheets_write_is_decoded(encoding: str, note: str) -> None:
    written = text("t [s],ax [m/s²],yaw rate [°/s]", T, AX, AX)
    decoded, notes = decode(written.encode(encoding), "log.csv")
    assert decoded == written
    assert [note in one for one in notes] == [True] * bool(note)


@pytest.mark.parametrize("data", [b"\x00\x01\x02", b"\xff\xfe\x00", b"\x81\x8d"])
def test_bytes_that_are_no_text_are_refused(data: bytes) -> None:
    with pytest.raises(InputError, match=r"log x.bin is not text"):
        decode(data, "x.bin")


def test_a_speed_with_holes_does_not_spoil_the_log() -> None:
    log = parse_log(text("t,ax,vx", T, AX, np.full(N, np.nan)), "log.csv")
    assert "vx: 'vx' is not used: number of samples of 'vx' in log.csv is 0, must be at least 2" in log.notes
    assert_plain(log)


@given(st.text(alphabet="0123456789.,;\t\n -+eEnaxt_#\"'\r", max_size=80))
def test_any_text_gives_a_log_or_is_refused(body: str) -> None:
    for log in (body, f"t,ax\n{body}", f"t;ax\n0;0\n{body}"):
        try:
            assert len(parse_log(log, "log.csv").t) >= 2
        except InputError:
            continue


def test_reading_is_fast() -> None:
    """A million rows take a few seconds; here a tenth of it, with room for a slow machine."""
    n = 100_000
    rows = "\n".join(
        f"{0.01 * i:.2f},{(i % 77) * 0.01 - 0.38:.2f},{(i % 13) * 0.1 - 0.6:.1f}" for i in range(n)
    )
    started = time.process_time()
    assert len(parse_log("t,ax,ay\n" + rows, "log.csv").t) == n
    assert time.process_time() - started < 3.0


def test_a_file_whose_end_was_never_written_is_read() -> None:
    written = text("t,ax", T, AX)
    assert decode(written.encode() + b"\0" * 5000, "log.csv")[0] == written
