"""Foresight: where the car is on an earlier drive's path, and what was felt next; never the own future."""

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from otolith.core.arrays import Mat
from otolith.core.errors import InputError
from otolith.recordings import Log, sampled_log
from otolith.recordings.foresight import DIFFERENCE_LASTS, Follower, Foresight, Path, foresight
from otolith.scenarios.sampled import on_lines

Real = NDArray[np.floating[Any]]
RADIUS, ROUND = 100.0, 628.32  # [m]
DT = 0.05


def on_circle(way: Real) -> Mat:
    return RADIUS * np.stack([np.cos(way / RADIUS), np.sin(way / RADIUS)], axis=1)


def bumpy(way: Real) -> Mat:
    """A force that belongs to the place: one hill per 60 m."""
    wave = np.sin(2.0 * np.pi * way / 62.832)
    return np.stack([wave, 2.0 * wave, 0.0 * wave], axis=1)


def drive(speed: float, laps: float = 1.0, more: float = 0.0, offset: float = 0.0) -> Log:
    """Round a circle at a constant speed, `offset` outside of its line, everywhere with `more` force."""
    t = np.arange(0.0, laps * ROUND / speed, DT)
    place = on_circle(speed * t) * (1.0 + offset / RADIUS)
    return sampled_log(f"at {speed:g} m/s", t, bumpy(speed * t) + more, np.zeros((len(t), 3)), place=place)


def seen(log: Log, earlier: Log) -> Foresight:
    return foresight(
        log,
        earlier,
        period=DT,
        force=lambda t: on_lines(t, log.t, log.force),
        forces_then=lambda t: on_lines(t, earlier.t, earlier.force),
    )


def test_the_same_drive_is_foreseen_exactly() -> None:
    log = drive(30.0)
    foreseen = seen(log, log)(5.0, DT, 100)
    assert_allclose(foreseen, bumpy(30.0 * (5.0 + DT * np.arange(1, 101))), atol=0.03)


def test_a_quicker_car_meets_the_same_hills_sooner() -> None:
    """At 33 instead of 30 m/s; a pace is kept for some 2 s, and then forgotten, since no driver keeps it."""
    foreseen = seen(drive(33.0), drive(30.0))(5.0, DT, 10)
    assert_allclose(foreseen, bumpy(33.0 * (5.0 + DT * np.arange(1, 11))), atol=0.1)


def test_another_line_through_the_bend_is_the_same_road() -> None:
    foreseen = seen(drive(30.0, offset=4.0), drive(30.0))(5.0, DT, 10)
    assert_allclose(foreseen, bumpy(30.0 * (5.0 + DT * np.arange(1, 11))), atol=0.1)


def test_what_is_felt_more_now_dies_away() -> None:
    foreseen = seen(drive(30.0, more=0.5), drive(30.0))(5.0, DT, 100)
    ahead = DT * np.arange(1, 101)
    expected = bumpy(30.0 * (5.0 + ahead)) + 0.5 * np.exp(-ahead / DIFFERENCE_LASTS)[:, None]
    assert_allclose(foreseen, expected, atol=0.03)


def test_a_closed_road_goes_on_where_it_began() -> None:
    log = drive(30.0, laps=2.0)
    foreseen = seen(log, drive(30.0))(20.0, DT, 100)  # the earlier lap ends after 20.9 s
    assert len(foreseen) == 100
    assert_allclose(foreseen, bumpy(30.0 * (20.0 + DT * np.arange(1, 101))), atol=0.1)
    assert_allclose(
        seen(log, drive(30.0))(30.0, DT, 5), bumpy(30.0 * (30.0 + DT * np.arange(1, 6))), atol=0.1
    )


def test_an_open_road_is_foreseen_to_its_end() -> None:
    half = drive(30.0, laps=0.5)
    foreseen = seen(drive(30.0), half)(9.0, DT, 100)
    assert len(foreseen) == pytest.approx((half.duration - 9.0) / DT, abs=1)
    assert not len(seen(drive(30.0), half)(15.0, DT, 100))


def test_another_future_changes_nothing() -> None:
    """Two drives that agree until 5 s, and part there, are foreseen alike until then."""
    one, earlier = drive(30.0), drive(28.0)
    past = one.t <= 5.0
    place, force = np.array(one.place), np.array(one.force)
    place[~past] += 500.0
    force[~past] = 9.0
    other = sampled_log("elsewhere", one.t, force, np.zeros((len(one.t), 3)), place=place)
    for now in (0.5, 2.0, 5.0):
        assert_allclose(
            seen(one, earlier)(now, DT, 80), seen(other, earlier)(now, DT, 80), rtol=0.0, atol=0.0
        )
    assert not len(seen(other, earlier)(8.0, DT, 80))


def test_a_road_that_crosses_itself_is_followed_straight_on() -> None:
    """On a figure of eight, the branch that the car is on, at the crossing too, and when it starts there."""
    phase = np.linspace(0.0, 2.0 * np.pi, 2000, endpoint=False)
    eight = 100.0 * np.stack([np.sin(phase), np.sin(phase) * np.cos(phase)], axis=1)
    path = Path(phase * 10.0, eight)
    for start in (0.3, 2.9):
        follower = Follower(path)
        way = np.linspace(start, start + 5.0, 400)
        places = 100.0 * np.stack([np.sin(way), np.sin(way) * np.cos(way)], axis=1)
        found = [follower.at(place) for place in places]
        times = np.array([np.nan if one is None else one for one in found])
        assert np.isfinite(times[5:]).all()
        assert_allclose(times[5:], 10.0 * np.mod(way[5:], 2.0 * np.pi), atol=0.05)


def test_the_way_back_is_another_road() -> None:
    follower = Follower(Path(np.arange(100.0), np.stack([np.arange(100.0), np.zeros(100)], axis=1)))
    assert all(follower.at(np.array([50.0 - k, 3.0])) is None for k in range(40))


@pytest.mark.parametrize("which", ["log", "earlier"])
def test_a_drive_without_places_is_refused(which: str) -> None:
    t = np.arange(0.0, 5.0, DT)
    plain = sampled_log("plain.csv", t, np.zeros((len(t), 3)), np.zeros((len(t), 3)))
    drives = {"log": drive(30.0), "earlier": drive(30.0)} | {which: plain}
    with pytest.raises(
        InputError, match=r"places of plain\.csv is absent, must be there to foresee its road"
    ):
        seen(drives["log"], drives["earlier"])


def test_a_drive_of_another_road_is_refused() -> None:
    far = sampled_log(
        "far.csv",
        drive(30.0).t,
        np.zeros((len(drive(30.0).t), 3)),
        np.zeros((len(drive(30.0).t), 3)),
        place=np.array(drive(30.0).place) + 1000.0,
    )
    with pytest.raises(
        InputError, match=r"road of at 30 m/s is another one than that of far\.csv, must be along"
    ):
        seen(far, drive(30.0))
