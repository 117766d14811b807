"""Ranges against the legs themselves, and against the published table."""

from dataclasses import replace
from typing import Any, Literal

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from otolith.core.frames import AXES
from otolith.platforms import load
from otolith.platforms.geometry import Circles
from otolith.platforms.hexapod import Hexapod
from otolith.platforms.reach import axis_speeds, box_share, cut, leg_end, reach, reach_ends

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
        assert -1e-12 <= gaps.min() < 1e-9
        assert not DAVSI.reaches(1.0001 * pose[None]).any()


def _machine(
    base: float = 1.2, platform: float = 0.975, *, halves: tuple[float, float] = (2.87, 3.53), **changes: Any
) -> Hexapod:
    """A hexapod of two circles, the reference point amid the platform's joints, 1.2366 m above the base's."""
    circles = Circles(
        base_radius_m=base,
        base_half_angle_deg=halves[0],
        platform_radius_m=platform,
        platform_half_angle_deg=halves[1],
    )
    below, above = circles.points()
    height = changes.pop("height", 1.2366)
    return replace(DAVSI, joints=above, anchors=below - [0.0, 0.0, height], **changes)


def _brute(machine: Hexapod, axis: str, far: float) -> float:
    """The end of an axis by looking at 20,000 poses, one after the other."""
    poses = np.zeros((20_001, 6))
    poses[:, AXES.index(axis)] = np.linspace(0.0, far, len(poses))
    out = ~machine.reaches(poses)
    return float(poses[max(int(np.argmax(out)) - 1, 0), AXES.index(axis)]) if out.any() else far


def test_heave_ends_above_the_legs_own_base() -> None:
    """Legs of 0.3 to 1.6 m, 0.55 m below: their lengths alone would let it sink far under the base."""
    low = _machine(0.55, 0.40, halves=(8.0, 8.0), height=0.55, stroke=(0.3, 1.6))
    assert leg_end(low.joints, low.anchors, low.stroke, 2, -1.0) > 1.0
    end, why = reach_ends(low)["heave"][0]
    assert -0.55 < end < -0.4
    assert why == "a singular pose"
    assert end == pytest.approx(_brute(low, "heave", -0.55), abs=1e-4)


@pytest.mark.parametrize("turn", [-1.0, 1.0])
def test_legs_fold_at_90_degrees_of_yaw_and_reach_ends_before(turn: float) -> None:
    """Joints in three pairs on two circles: lengths taken out, the determinant goes as cos(yaw).

    So such a machine is singular at ±90 deg of yaw (Fichter 1986); legs long enough go beyond it.
    """
    wide = _machine(stroke=(0.3, 4.0))
    poses = np.zeros((50, 6))
    poses[:, 5] = np.linspace(0.0, 3.0, 50)
    dets = np.linalg.det(wide.scaled_jacobians(poses)) * np.prod(wide.lengths(poses), axis=1)
    assert_allclose(dets / dets[0], np.cos(poses[:, 5]), atol=1e-12)
    end = reach_ends(wide)["yaw"][0 if turn < 0 else 1]
    assert end.why == "a singular pose"
    assert 80.0 * DEGREE < turn * end.at < 90.0 * DEGREE
    pose = np.zeros((1, 6))
    pose[0, 5] = end.at
    assert wide.condition(pose[0]) == pytest.approx(50.0, rel=1e-4)
    assert not wide.reaches(
        np.pi / (2 * end.at) * 1.02 * pose
    ).any()  # beyond, where legs are long enough again


@pytest.mark.parametrize("axis", AXES)
def test_an_end_is_where_looking_at_every_pose_finds_it(axis: str) -> None:
    """Strokes, leaning and singular poses, on machines of very different kind."""
    machines = [
        DAVSI,
        _machine(stroke=(0.5, 3.0)),
        _machine(0.9, 0.9, halves=(20.0, 8.0), height=1.0, stroke=(0.7, 1.9), lean_base=0.45),
        _machine(stroke=(0.5, 3.0), lean_platform=0.6, upright=True),
    ]
    for machine in machines:
        for k, end in enumerate(reach(machine)[axis]):
            far = (2.2 if axis in AXES[:3] else np.pi) * (2 * k - 1)
            if abs(end) < np.pi:
                assert end == pytest.approx(_brute(machine, axis, far), abs=2e-4 * max(1.0, abs(far)))


@given(
    base=st.floats(0.6, 1.8),
    platform=st.floats(0.5, 1.2),
    low=st.floats(0.3, 0.95),
    high=st.floats(1.05, 3.0),
    leans=st.tuples(st.floats(0.1, 3.1), st.floats(0.1, 3.1)),
)
@settings(max_examples=12, derandomize=True, deadline=None)
def test_no_pose_on_the_way_to_an_end_is_out_of_reach(
    base: float, platform: float, low: float, high: float, leans: tuple[float, float]
) -> None:
    machine = _machine(base, platform)
    neutral = machine.lengths(np.zeros(6))
    stroke = (low * float(neutral.min()), high * float(neutral.max()))
    machine = replace(machine, stroke=stroke, lean_base=leans[0], lean_platform=leans[1])
    for axis, ends in reach(machine).items():
        for end in ends:
            poses = np.zeros((500, 6))
            poses[:, AXES.index(axis)] = np.linspace(0.0, (1.0 - 1e-7) * end, 500)
            assert machine.reaches(poses).all()


@pytest.mark.parametrize("axis", [3, 4, 5])
def test_a_turn_that_no_leg_ends_ends_after_half_a_turn(axis: int) -> None:
    assert leg_end(DAVSI.joints, DAVSI.anchors, (0.01, 50.0), axis, 1.0) == np.pi
    assert leg_end(DAVSI.joints, DAVSI.anchors, (1.6, 1.937), axis, 1.0) == 0.0  # neutral out of the strokes


def test_the_end_says_which_leg_ends_it_and_how() -> None:
    ends = reach_ends(DAVSI)
    pose = np.zeros(6)
    pose[0] = ends["surge"][1].at
    longest = int(np.argmax(DAVSI.lengths(pose))) + 1
    assert ends["surge"][1].why in (f"leg {longest} at its longest", f"leg {7 - longest} at its longest")
    assert "at its shortest" in ends["heave"][0].why
    leaning = reach_ends(_machine(stroke=(0.5, 3.0), lean_base=0.2))["sway"][0]
    assert leaning.why.startswith("leg ")
    assert leaning.why.endswith("leaning as far as its base joint allows")
    pose = np.zeros((1, 6))
    pose[0, 1] = leaning.at
    assert _machine(stroke=(0.5, 3.0)).leans(pose)[0, 0].max() == pytest.approx(0.2, abs=1e-6)


def test_a_cut_shows_only_what_can_be_come_to() -> None:
    """A strip of good poses beyond a stretch of folded ones is white."""
    one = cut(_machine(stroke=(0.3, 4.0)), ("heave", "yaw"), n=41)
    assert np.abs(one.second[one.inside.any(axis=1)]).max() < np.pi / 2


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
