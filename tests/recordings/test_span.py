"""Channels of several rates and lengths: what shortens a drive, what is refused, what is only said."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from otolith.core.arrays import Vec
from otolith.core.errors import InputError
from otolith.recordings import Log, log_from, log_scenario
from otolith.recordings.channels import Layout
from otolith.recordings.recorded import Signal, with_own_clocks

FAST = np.arange(0.0, 60.0, 0.01)
SLOW = np.arange(0.0, 60.0, 0.1)


def swing(t: Vec) -> Vec:
    return np.asarray(np.sin(0.7 * t))


def read(*signals: tuple[str, Vec, Vec], needs: tuple[str, ...] = ()) -> Log:
    units = {"speed": "m/s", "YawRate": "rad/s"}
    made = [Signal(name, units.get(name, "m/s^2"), t, values) for name, t, values in signals]
    return log_from(with_own_clocks("d.mf4", made, Layout(form="MDF")), needs=needs)


@pytest.mark.parametrize(("name", "key"), [("speed", "vx"), ("YawRate", "yaw_rate")])
def test_what_is_not_cued_never_shortens_the_drive(name: str, key: str) -> None:
    short = np.arange(5.0, 25.0, 0.1)
    log = read(("AccX", FAST, swing(FAST)), (name, short, 0.01 * short + 9.0 * (key == "vx")), needs=("ax",))
    assert log.duration == pytest.approx(59.99)
    notes_on_span = [
        note
        for note in log.notes
        if note == f"{key}: left out, taken as zero: it runs from 5 s to 24.9 s of 59.99 s"
    ]
    assert bool(notes_on_span) == (key == "yaw_rate")
    assert (key in log.channels) == (key == "vx")


def test_what_is_cued_shortens_the_drive_and_the_times_are_said() -> None:
    short = np.arange(5.0, 25.0, 0.1)
    log = read(("AccX", FAST, swing(FAST)), ("AccY", short, swing(short)), needs=("ax", "ay"))
    assert log.duration == pytest.approx(19.9)
    assert_allclose(log.felt(np.array([1.0]))[0, :2], swing(np.array([6.0, 6.0])), atol=2e-3)
    assert any("5 s to 24.9 s: ax from 0 s to 59.99 s, ay from 5 s to 24.9 s" in note for note in log.notes)


def holed(t: Vec) -> Vec:
    return t[(t < 20.0) | (t >= 40.0)]


def test_a_dropout_of_what_is_cued_is_refused_with_its_times() -> None:
    with pytest.raises(
        InputError, match=r"gap in ax before sample 2001 of d.mf4, 19.99 s after the first row, is 20"
    ):
        read(("AccX", holed(FAST), swing(holed(FAST))), ("AccY", FAST, swing(FAST)))


def test_a_dropout_of_what_is_not_cued_leaves_the_channel_out_and_is_said() -> None:
    log = read(("AccX", FAST, swing(FAST)), ("AccY", holed(FAST), swing(holed(FAST))), needs=("ax",))
    assert "ay: left out, taken as zero: it has no values from 19.99 s to 40 s" in log.notes
    assert not log.force[:, 1].any()


def test_a_dropout_within_a_second_is_bridged_and_said() -> None:
    t = FAST[(FAST < 20.0) | (FAST >= 20.8)]
    log = read(("AccX", t, swing(t)))
    assert "ax: 1 gaps bridged by straight lines, the longest of 0.81 s at 19.99 s" in log.notes


@pytest.mark.parametrize("others", [1, 20])
def test_a_vibration_is_not_aliased_by_slower_or_longer_channels(others: int) -> None:
    """9 Hz at 100 Hz beside channels of 10 Hz: sampled at 10 Hz it would be a cue of 1 Hz, 1.9 m/s² large."""
    long = np.arange(0.0, 60.0 * others, 0.1)
    vibration = swing(FAST) + 2.0 * np.sin(2.0 * np.pi * 9.0 * FAST)
    log = read(("AccX", FAST, vibration), ("speed", long, np.full(len(long), 20.0)), needs=("ax",))
    cued = log_scenario(log, period=0.1)
    t = np.arange(5.0, 55.0, 0.1)
    assert float(np.abs(cued.specific_force(t)[:, 0] - swing(t)).max()) < 0.02
    read_at_10_hz = np.interp(t, FAST, vibration)
    assert float(np.abs(read_at_10_hz - swing(t)).max()) > 1.5  # what the anti-alias filter is for


def test_each_channel_is_resampled_from_its_own_clock() -> None:
    uneven = np.sort(np.r_[0.0, np.random.default_rng(5).uniform(0.0, 59.9, 3000), 59.9])
    log = read(("AccX", FAST, swing(FAST)), ("AccY", uneven, swing(uneven)), ("AccZ", SLOW, swing(SLOW)))
    t = np.arange(1.0, 58.0, 0.01)
    felt = log_scenario(log, period=0.01).specific_force(t)
    assert_allclose(felt, np.stack([swing(t)] * 3, axis=1), atol=2e-3)
