"""Ranges against the legs themselves, and against the published table."""

from dataclasses import replace
from typing import Literal

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from otolith.core.frames import AXES
from otolith.platforms import load
from otolith.platforms.geometry import Circles
from otolith.platforms.reach import axis_speeds, box_share, cut, reach

DAVSI = load("davsi").six_legs()
DEGREE = np.pi / 180.0
TABLE_6_1 = {  # the rows of pitch and roll in the reading that a left-right symmetric machine can have
    "surge": (-0.51, 0.63),
    "sway": (-0.51, 0.51),
    "heave": (-0.42, 0.42),
    "roll": (-24.3 * DEGREE, 24.3 * DEGREE),
    "pitch": (-25.4 * DEGREE, 28.4 * DEGREE),
    "yaw": (-25.0 * DEGREE, 25.0 * DEGREE),
}


@pytest.mark.parametrize("axis", AXES)
def test_the_surrogates_ranges_are_those_of_the_table(axis: str) -> None:
    """The travel of every axis within 1.5 %, its worst single end within 2.8 %."""
    (low, high), (low_6_1, high_6_1) = reach(DAVSI)[axis], TABLE_6_1[axis]
    assert high - low == pytest.approx(high_6_1 - low_6_1, rel=0.015)
    assert_allclose([low, high], [low_6_1, high_6_1], rtol=0.028)


@pytest.mark.parametrize("axis", AXES)
def test_at_the_end_of_a_range_a_leg_is_at_the_end_of_its_stroke(axis: str) -> None:
    for end in reach(DAVSI)[axis]:
        pose = np.zeros(6)
        pose[AXES.index(axis)] = end
        lengths = DAVSI.lengths(pose)
        gaps = np.minimum(lengths - DAVSI.stroke[0], DAVSI.stroke[1] - lengths)
        assert 0.0 <= gaps.min() < 1e-9
        assert not DAVSI.reaches(1.0001 * pose[None]).any()


def test_the_table_of_speeds_is_within_the_legs() -> None:
    """Table 6.1's speeds and accelerations, axis by axis, and no more than a tenth is left of the legs."""
    speeds = np.array([0.81, 0.81, 0.61, 35 * DEGREE, 38 * DEGREE, 41 * DEGREE]) * axis_speeds(DAVSI)
    accelerations = np.array([7.1, 7.1, 10, 260 * DEGREE, 260 * DEGREE, 510 * DEGREE]) * axis_speeds(DAVSI)
    assert 0.9 * DAVSI.speed < speeds.max() <= DAVSI.speed
    assert 0.9 * DAVSI.acceleration < accelerations.max() <= DAVSI.acceleration


def test_the_box_of_single_ranges_is_not_the_workspace() -> None:
    assert box_share(DAVSI) == pytest.approx(0.021, abs=0.003)


def test_a_cut_shows_what_the_legs_reach_and_how_firmly() -> None:
    one = cut(DAVSI, ("surge", "pitch"), n=21)
    ranges = reach(DAVSI)
    along = one.first[one.inside[np.argmin(np.abs(one.second))]]
    assert ranges["surge"][0] <= along.min() < along.max() <= ranges["surge"][1]
    at = np.argwhere(one.inside)[10]
    pose = np.zeros(6)
    pose[0], pose[4] = one.first[at[1]], one.second[at[0]]
    assert one.condition[tuple(at)] == pytest.approx(DAVSI.condition(pose), rel=1e-12)
    assert np.isnan(one.condition[~one.inside]).all()


@given(
    base=st.floats(1.0, 1.8),
    platform=st.floats(0.7, 1.2),
    halves=st.tuples(st.floats(2.0, 25.0), st.floats(2.0, 25.0)),
    point=st.tuples(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3)),
    forward=st.sampled_from(["platform", "base"]),
)
@settings(max_examples=30, derandomize=True, deadline=None)
def test_a_machine_alike_on_both_sides_sways_rolls_and_yaws_alike_to_both(
    base: float,
    platform: float,
    halves: tuple[float, float],
    point: tuple[float, float],
    forward: Literal["platform", "base"],
) -> None:
    """So a row of −25.4 … 28.4 deg cannot be such a machine's roll."""
    circles = Circles(
        base_radius_m=base,
        base_half_angle_deg=halves[0],
        platform_radius_m=platform,
        platform_half_angle_deg=halves[1],
        forward=forward,
    )
    below, above = circles.points()
    reference = np.array([point[0], 0.0, point[1]])
    machine = replace(DAVSI, joints=above - reference, anchors=below - reference - [0.0, 0.0, 1.25])
    assume(machine.reaches(np.zeros((1, 6)))[0])
    ranges = reach(machine)
    for axis in ("sway", "roll", "yaw"):
        assert -ranges[axis][0] == pytest.approx(ranges[axis][1], rel=1e-9, abs=1e-12)
