"""Time as loggers write it, against the seconds that were written."""

from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from otolith.core.errors import InputError
from otolith.recordings import parse_log
from otolith.recordings.clocks import clock_times, even_out, even_rows, numeric_stamps
from otolith.recordings.columns import Column

T = np.arange(0.0, 30.0, 0.05)
START = datetime(2026, 5, 5, 23, 59, 50, tzinfo=UTC)
UNKNOWN = Column("t", 0, "time", 1.0, "s", assumed=True)


def where(row: int) -> str:
    return f"line {row + 2} of log.csv"


def written(form: str) -> list[str]:
    return [(START + timedelta(milliseconds=round(1000 * t))).strftime(form) for t in T]


@pytest.mark.parametrize(
    "form",
    [
        "%Y-%m-%dT%H:%M:%S.%fZ",
        "%Y-%m-%dT%H:%M:%S.%f+02:00",
        "%Y-%m-%d %H:%M:%S,%f",
        "%Y%m%dT%H%M%S.%fZ",
        "%d/%m/%Y %H:%M:%S.%f",
        "%m/%d/%Y %I:%M:%S.%f %p",
        "%d.%m.%y %H:%M:%S.%f",
        "%d-%b-%Y %H:%M:%S.%f",
        "%a %b %d %H:%M:%S.%f GMT 2026",
        "%H:%M:%S.%f",
        "%I:%M:%S.%f %p",
        "%H:%M:%S:%f",
    ],
)
def test_dates_and_clock_times_go_on_over_midnight(form: str) -> None:
    assert_allclose(clock_times(written(form), UNKNOWN, where).t, T, atol=1e-6)


def test_minutes_and_seconds_are_read() -> None:
    texts = [f"{int(t // 60)}:{t % 60:06.3f}" for t in T + 50.0]
    assert_allclose(clock_times(texts, UNKNOWN, where).t, T, atol=1e-9)


@pytest.mark.parametrize(
    ("cells", "sentence"),
    [
        (["10:00:00", "soon"], "'time' in line 3 of log.csv is 'soon', must be a number or a clock time"),
        (["10:00:00Z", "10:00:01+01:00"], "time zone in 'time' is '+01:00' and 'Z', must be one zone"),
        (["lap 10:00:00", "lap 10:00:01"], "'time' in line 2 of log.csv is 'lap 10:00:00'"),
    ],
)
def test_what_is_no_clock_time_is_named(cells: list[str], sentence: str) -> None:
    with pytest.raises(InputError) as caught:
        clock_times(cells, UNKNOWN, where)
    assert str(caught.value).startswith(sentence)


@pytest.mark.parametrize(("unit", "scale"), [("s", 1.0), ("ms", 1e3), ("us", 1e6), ("ns", 1e9)])
@given(year=st.floats(1991.0, 2099.0))
def test_an_epoch_tells_its_unit_by_its_size(unit: str, scale: float, year: float) -> None:
    start = round((year - 1970.0) * 31556952.0)
    values = np.array([float(round((start + round(t, 3)) * scale)) if unit != "s" else start + t for t in T])
    stamps = numeric_stamps(values, UNKNOWN)
    assert_allclose(stamps.t, T, atol=2e-6)
    assert bool(stamps.notes) == (unit != "s")


def test_packed_clock_times_are_told_by_their_leaps_and_nothing_else_is() -> None:
    packed = np.array([float(text) for text in written("%H%M%S.%f")])
    assert_allclose(numeric_stamps(packed, UNKNOWN).t, T, atol=1e-6)
    plain = np.arange(50.0, 130.0, 0.1)
    assert_allclose(numeric_stamps(plain, UNKNOWN).t, plain - 50.0, atol=1e-9)
    gap = np.r_[np.arange(10.0, 50.0, 0.1), np.arange(120.0, 150.0, 0.1)]
    assert_allclose(numeric_stamps(gap, UNKNOWN).t, gap - 10.0, atol=1e-9)


def test_a_unit_that_makes_rows_too_near_is_refused() -> None:
    with pytest.raises(
        InputError, match=r"usual step of 'time', read in s, is 5.79e-07 s, must be at least 1e-05"
    ):
        numeric_stamps(46147.4 + T / 86400.0, UNKNOWN)
    days = Column("t", 0, "time", 86400.0, "d", assumed=False)
    assert_allclose(numeric_stamps(46147.4 + T / 86400.0, days).t, T, atol=1e-5)


@given(
    rate=st.sampled_from([15.0, 20.0, 25.0, 50.0, 100.0]), digits=st.sampled_from([0, 1]), cut=st.booleans()
)
def test_rounded_stamps_are_spread_to_within_half_their_step(rate: float, digits: int, cut: bool) -> None:
    t = np.arange(0.0, 30.0, 1.0 / rate)
    step = 10.0**-digits
    coarse = np.floor(t / step) * step if cut else np.round(t, digits)
    even = even_out(coarse)
    assert even is not None
    late = even - t
    assert np.ptp(late) < 0.05 * step + 1e-9  # evenly spaced, right to 5 % of a stamp …
    assert np.abs(late).max() <= 0.6 * step  # … and late by no more than stamps are cut


@pytest.mark.parametrize("t", [[0, 0, 1, 0], [0, 0, 0, 0], [0, 0, 0, 0, 0, 0, 1, 1, 2, 3, 4, 5, 6, 7, 8, 9]])
def test_stamps_of_uneven_rows_are_not_spread(t: list[float]) -> None:
    assert even_out(np.array(t, dtype=float)) is None


@pytest.mark.parametrize(
    ("text", "step"), [("every:0.05s", 0.05), ("every:50ms", 0.05), ("every:20Hz", 0.05), ("every:0.1", 0.1)]
)
def test_a_user_may_say_that_rows_are_evenly_spaced(text: str, step: float) -> None:
    assert_allclose(even_rows(text, 5).t, step * np.arange(5))
    log = parse_log("ax\tay\n" + "\n".join(f"{i}\t0" for i in range(5)), "log.csv", columns={"t": text})
    assert_allclose(log.t, step * np.arange(5))


@pytest.mark.parametrize(
    "text", ["every:", "every:0", "every:2s", "every:-1ms", "every:x", "every:5 parsecs"]
)
def test_a_spacing_that_cannot_be_is_refused(text: str) -> None:
    with pytest.raises(InputError, match=r"must be such as every:0.05s or every:20Hz"):
        even_rows(text, 5)


def test_rows_of_two_cars_that_take_turns_are_not_one_drive() -> None:
    t = np.repeat(np.arange(0.0, 20.0, 0.1), 2)
    own = np.where(np.arange(len(t)) % 2 == 0, np.sin(t), np.cos(t))
    rows = "\n".join(f"{a:.1f},{b:.4f}" for a, b in zip(t, own, strict=True))
    with pytest.raises(InputError, match=r"200 stamps repeat"):
        parse_log(f"time,ax\n{rows}", "log.csv")


def test_the_rate_of_n_rows_is_n_minus_one_over_the_duration() -> None:
    t = np.r_[np.arange(0.0, 1.0, 0.01), 1.5]
    rows = "\n".join(f"{a:.2f},{0.1 * (i % 7)}" for i, a in enumerate(t))
    assert parse_log(f"t,ax\n{rows}", "log.csv").notes[0].startswith("log.csv: 101 rows, 1.5 s, 66.667 Hz")


def test_of_two_clocks_the_finer_is_read() -> None:
    rows = "\n".join(f"2026-05-05 10:00:{int(t):02d},{1000 * t:.0f},{np.sin(t):.5f}" for t in T)
    log = parse_log(f"date,elapsed_ms,ax\n{rows}", "log.csv")
    assert_allclose(log.t, T, atol=1e-9)
    assert any("'elapsed_ms'" in note for note in log.notes)
