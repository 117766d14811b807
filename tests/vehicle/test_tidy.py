"""Measured roads with their faults, each made of an oval whose shape is known."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from otolith.core.arrays import Mat
from otolith.vehicle.survey import Survey
from otolith.vehicle.tidy import (
    meets_its_start,
    one_lap,
    scatter,
    way_along,
    without_repeats,
    without_seam,
    without_strays,
)

LENGTH = 690.40  # [m] of an ellipse of 150 m and 60 m: Ramanujan's second formula, good to 1e-5 here


def oval(turns: float = 1.0, points: int = 120, start: float = 0.0) -> Mat:
    angle = start + 2.0 * np.pi * np.arange(round(turns * points)) / points
    return np.stack([150.0 * np.cos(angle), 60.0 * np.sin(angle)], axis=1)


def survey(points: Mat) -> Survey:
    places = tuple(f"line {k + 2} of t.csv" for k in range(len(points)))
    return Survey("t.csv", points, {"z": np.arange(float(len(points)))}, places, ())


def test_a_repeated_row_is_left_out_with_its_line() -> None:
    ring = oval()
    found = without_repeats(survey(np.insert(ring, 41, ring[40], axis=0)))
    assert_allclose(found.points, ring)
    assert found.notes == ("1 repeated point left out, the first in line 43 of t.csv",)
    assert len(found.along["z"]) == len(found.places) == 120


@given(
    at=st.integers(1, 100),
    rows=st.integers(1, 15),
    still=st.integers(0, 200),
    jitter=st.floats(0.0, 0.02),
)
@settings(max_examples=60, derandomize=True, deadline=None)
def test_blocks_and_standing_are_left_out(at: int, rows: int, still: int, jitter: float) -> None:
    """Rows written again as a block, and a car that stands while the logger goes on."""
    ring, rng = oval(), np.random.default_rng(at)
    standing = ring[at + rows] + jitter * rng.uniform(-1.0, 1.0, (still, 2))
    twice = np.vstack([ring[: at + rows], ring[at : at + rows], ring[at + rows : at + rows + 1], standing])
    found = without_repeats(survey(np.vstack([twice, ring[at + rows + 1 :]])))
    assert_allclose(found.points, ring)
    assert f"{rows + still} repeated point" in found.notes[0]


def test_points_that_jump_far_off_are_left_out_and_holes_are_told() -> None:
    ring = oval()
    jumps = np.insert(ring, [20, 20, 60], [[9e3, 4e3], [9.1e3, 4e3], [-300.0, 0.0]], axis=0)
    found = without_strays(survey(jumps))
    assert_allclose(found.points, ring)
    assert found.notes == ("3 stray points left out, the first in line 22 of t.csv",)
    holed = without_strays(survey(np.delete(oval(points=360), range(100, 261), axis=0)))
    gap = "there are no points for 119 m between line 101 of t.csv and line 102 of t.csv"
    assert holed.notes == (f"{gap}: the road there is a guess",)
    assert without_strays(survey(ring)).notes == ()


def test_a_sharp_hairpin_is_not_astray() -> None:
    turn = np.linspace(-np.pi / 2, np.pi / 2, 4)
    out = np.arange(0.0, 200.0, 20.0)
    points = np.vstack(
        [
            np.c_[out, 0 * out - 5],
            np.c_[200 + 5 * np.cos(turn), 5 * np.sin(turn)],
            np.c_[out[::-1], 0 * out + 5],
        ]
    )
    assert without_strays(survey(points)).notes == ()


def test_a_ring_that_is_written_twice_at_its_seam_is_no_fault() -> None:
    closed = np.vstack([oval(), oval()[:1]])
    found = without_repeats(survey(closed))
    assert (len(found.points), found.notes) == (121, ())
    assert len(without_seam(found).points) == 120


@given(
    over=st.floats(0.03, 1.7),
    start=st.floats(0.0, 6.2),
    drift=st.floats(-5.0, 5.0),
    points=st.integers(60, 700),
)
@settings(max_examples=60, derandomize=True, deadline=None)
def test_a_lap_that_overlaps_itself_is_cut_to_one(
    over: float, start: float, drift: float, points: int
) -> None:
    """Any start, any overlap, a receiver that drifts sideways: one lap, whose ends meet without a step."""
    track = oval(1.0 + over, points, start)
    turns = np.arange(len(track)) / points
    track *= 1.0 + (drift * turns / np.linalg.norm(track, axis=1))[:, None]
    lap, found = one_lap(survey(track))
    assert found
    assert meets_its_start(lap.points)
    ring = np.vstack([lap.points, lap.points[0]])
    assert way_along(ring)[-1] == pytest.approx(LENGTH + np.pi * drift, abs=3.0 + 2.0 * abs(drift))
    chords = np.diff(np.vstack([ring, lap.points[1]]), axis=0)
    turn = np.abs(
        np.cross(np.c_[chords[:-1], np.zeros(len(chords) - 1)], np.c_[chords[1:], np.zeros(len(chords) - 1)])
    )[:, 2]
    sines = turn / np.linalg.norm(chords[1:], axis=1) / np.linalg.norm(chords[:-1], axis=1)
    gap = LENGTH / points
    assert sines[-3:].max() < 0.06 * gap + 0.25  # no corner at the seam; the tightest bend has 24 m


def test_what_was_driven_before_and_after_the_lap_is_left_out_and_said() -> None:
    lead = np.stack([150.0 + np.arange(40.0, 0.0, -4.0) ** 2 / 40.0, np.linspace(-90.0, -4.0, 10)], axis=1)
    lap, found = one_lap(survey(np.vstack([lead, oval(1.2)])))
    assert found
    assert_allclose(
        lap.points[5:100], oval()[np.argmin(np.linalg.norm(oval() - lap.points[5], axis=1)) :][:95]
    )
    assert "one lap is kept, the 9" in lap.notes[0]
    assert "m after it left out" in lap.notes[0]


def test_the_end_of_a_lap_that_lies_beside_its_start_is_moved_over() -> None:
    turns = np.linspace(0.0, 1.3, 300)
    track = np.stack(
        [(150.0 + 3.0 * turns) * np.cos(2 * np.pi * turns), (60.0 + 3.0 * turns) * np.sin(2 * np.pi * turns)],
        axis=1,
    )
    lap, _ = one_lap(survey(track))
    assert "its end lies 3." in lap.notes[1]
    assert_allclose(lap.points[:100], track[:100])
    assert np.linalg.norm(lap.points[-1] - lap.points[0]) < 4.0


@pytest.mark.parametrize(
    "points",
    [
        np.stack([np.linspace(0.0, 300.0, 61), 20.0 * np.sin(np.linspace(0.0, 5.0, 61))], axis=1),
        np.vstack(
            [np.c_[np.linspace(0, 300, 61), np.zeros(61)], np.c_[np.linspace(300, 0, 61), np.full(61, 7.0)]]
        ),
        np.stack(
            [
                f(np.linspace(0.0, 12.0, 300)) * (40.0 + 3.0 * np.linspace(0.0, 12.0, 300))
                for f in (np.cos, np.sin)
            ],
            axis=1,
        ),
        oval(0.9),
    ],
    ids=["wavy", "there and back", "spiral", "most of an oval"],
)
def test_an_open_road_stays_open(points: Mat) -> None:
    lap, found = one_lap(survey(points))
    assert not found
    assert lap.points is points
    assert not meets_its_start(points)


def test_a_figure_of_eight_is_one_lap_although_it_crosses_itself() -> None:
    t = np.linspace(0.0, 2.0 * np.pi, 200)[:-1]
    eight = np.stack([200.0 * np.sin(t), 100.0 * np.sin(2.0 * t)], axis=1)
    assert not one_lap(survey(eight))[1]
    assert meets_its_start(eight)
    lap, found = one_lap(survey(np.vstack([eight, eight[:20] + 1.0])))
    assert found
    assert_allclose(lap.points, eight, atol=1.0)


@pytest.mark.parametrize("noise", [0.05, 0.3, 1.0, 2.5])
def test_noise_is_told_from_shape(noise: float) -> None:
    """Independent noise of a known size on an oval, in each of two coordinates and in one."""
    found = []
    for seed in range(8):
        rng = np.random.default_rng(seed)
        found.append(scatter(oval() + rng.normal(0.0, noise, (120, 2))))
    assert np.mean(found) == pytest.approx(np.sqrt(2.0) * noise, rel=0.12)
    z = np.sin(np.linspace(0.0, 6.0, 400))[:, None] + np.random.default_rng(1).normal(0.0, noise, (400, 1))
    assert scatter(z) == pytest.approx(noise, rel=0.15)


@pytest.mark.parametrize("points", [16, 40, 120])
def test_exact_points_scatter_little_however_few_they_are(points: int) -> None:
    assert scatter(oval(points=points)) < 0.03
