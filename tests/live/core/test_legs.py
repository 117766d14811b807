"""Legs in motion, against differences of lengths by scipy's rotations; and that bounds are bounds."""

import numpy as np
import pytest

from otolith.core.arrays import Mat
from otolith.live.audit import coordinates, leg_lengths
from otolith.live.core.bounds import Bounds
from otolith.live.core.gate import Gate
from otolith.live.core.legs import HOLDS, LEAN, LENGTH, SPEED, STRENGTH, legs_at, legs_hold
from otolith.platforms import Platform, load, parse_platform
from otolith.platforms.template import template

H = 1e-4  # [s] of differences


@pytest.fixture(scope="module")
def b() -> Bounds:
    return Gate(load("davsi"), lag=0.01, period=0.01).bounds


def work() -> tuple[Mat, Mat]:
    return np.empty((3, 3)), np.empty((3, 3))


def motions(rng: np.random.Generator, count: int) -> Mat:
    size = np.array([[0.25] * 3 + [0.25] * 3, [0.3] * 3 + [0.3] * 3, [3.0] * 3 + [3.0] * 3])
    return size * rng.uniform(-1.0, 1.0, (count, 3, 6)) * rng.uniform(0.1, 1.3, (count, 3, 1))


def differences(motion: Mat, b: Bounds) -> tuple[Mat, Mat, Mat]:
    """Lengths, speeds and accelerations (6,) of the legs."""
    times = np.array([-H, 0.0, H])[:, None]
    lengths = leg_lengths(motion[0] + times * motion[1] + 0.5 * times**2 * motion[2], b.joints, b.anchors)
    speed = (lengths[2] - lengths[0]) / (2.0 * H)
    return lengths[1], speed, (lengths[2] - 2.0 * lengths[1] + lengths[0]) / H**2


def test_every_limit_of_a_leg_is_met_where_differences_meet_it(b: Bounds) -> None:
    """The limit of one leg is put just beside what the differences say: on one side it holds, else not."""
    rng, free = np.random.default_rng(0), b._replace(stroke=(0.0, 9.0), leg_speed=99.0, leg_acceleration=1e9)
    for motion in motions(rng, 200):
        lengths, speed, strength = differences(motion, b)
        for kind, values, limit in (
            (LENGTH, lengths, lambda x: {"stroke": (0.0, x)}),
            (SPEED, np.abs(speed), lambda x: {"leg_speed": x}),
            (STRENGTH, np.abs(strength), lambda x: {"leg_acceleration": x}),
        ):
            most, leg = float(values.max()), int(values.argmax())
            assert legs_at(motion, free._replace(**limit(most * 1.0001 + 1e-5)), 0.0, *work()) == (HOLDS, 0)
            found = legs_at(motion, free._replace(**limit(most * 0.9999 - 1e-5)), 0.0, *work())
            assert found[0] == kind
            assert values[found[1]] > most * 0.9999 - 1e-4
            assert found[1] <= leg
        shortest = float(lengths.min())
        code, _ = legs_at(motion, free._replace(stroke=(shortest + 1e-6, 9.0)), 0.0, *work())
        assert code == LENGTH


RIG = parse_platform(template("cranks"), "cranks.toml")
RIG_SIZE = np.array([[0.08] * 3 + [0.1] * 3, [0.3] * 6, [3.0] * 6])


def test_every_limit_of_a_crank_is_met_where_differences_meet_it() -> None:
    """Against the arcs of the usual sine form, by scipy's rotations and differences in time."""
    bounds, rng = Gate(RIG, lag=0.01, period=0.01).bounds, np.random.default_rng(0)
    free = bounds._replace(stroke=(-9.0, 9.0), leg_speed=99.0, leg_acceleration=1e9, lean=(np.pi, np.pi))
    times, hexapod = np.array([-H, 0.0, H])[:, None], RIG.six_legs()
    for motion in RIG_SIZE * rng.uniform(-0.7, 0.7, (200, 3, 6)):
        arcs = coordinates(motion[0] + times * motion[1] + 0.5 * times**2 * motion[2], hexapod)
        speed, strength = (arcs[2] - arcs[0]) / (2.0 * H), (arcs[2] - 2.0 * arcs[1] + arcs[0]) / H**2
        for kind, values, limit in (
            (LENGTH, arcs[1], lambda x: {"stroke": (-9.0, x)}),
            (LENGTH, -arcs[1], lambda x: {"stroke": (-x, 9.0)}),
            (SPEED, np.abs(speed), lambda x: {"leg_speed": x}),
            (STRENGTH, np.abs(strength), lambda x: {"leg_acceleration": x}),
        ):
            most, room = float(values.max()), 1e-5 * (1.0 + float(np.abs(strength).max()))
            assert legs_at(motion, free._replace(**limit(most + room)), 0.0, *work()) == (HOLDS, 0)
            assert legs_at(motion, free._replace(**limit(most - room)), 0.0, *work())[0] == kind


@pytest.mark.parametrize("joint", [0, 1])
@pytest.mark.parametrize("platform", [RIG, load("davsi")], ids=["cranks", "legs"])
def test_a_leg_that_leans_too_far_is_found(platform: Platform, joint: int) -> None:
    """The limit is put just beside what `Hexapod.leans` says, which shares no code."""
    bounds, rng, hexapod = (
        Gate(platform, lag=0.01, period=0.01).bounds,
        np.random.default_rng(2),
        platform.six_legs(),
    )
    motion = np.zeros((3, 6))
    for pose in rng.uniform(-1.0, 1.0, (50, 6)) * 0.7 * RIG_SIZE[0]:
        motion[0], lean = pose, np.full(2, np.pi)
        lean[joint] = hexapod.leans(pose[None])[0, joint].max()
        for change, code in ((1e-6, HOLDS), (-1e-6, LEAN)):
            limited = bounds._replace(lean=tuple((lean + change * (np.arange(2) == joint)).tolist()))
            assert legs_at(motion, limited, 0.0, *work())[0] == code
            assert not legs_hold(pose, motion, limited, 0.0, *work())  # nothing is proved by bounds


def test_rods_that_do_not_reach_are_out_of_range() -> None:
    bounds, motion = Gate(RIG, lag=0.01, period=0.01).bounds, np.zeros((3, 6))
    motion[0, 2] = 0.3
    assert legs_at(motion, bounds._replace(stroke=(-9.0, 9.0)), 0.0, *work())[0] == LENGTH


def test_what_holds_by_bounds_holds_at_every_motion_within_them(b: Bounds) -> None:
    rng, proved, refuted = np.random.default_rng(1), 0, 0
    for around in motions(rng, 300):
        spread = np.abs(motions(rng, 1)[0]) * np.array([0.3, 1.0, 1.0])[:, None] * rng.uniform(0.1, 1.2)
        holds = legs_hold(around[0], spread, b, 0.01, *work())
        worst = 0
        for corner in range(60):
            share = rng.uniform(-1.0, 1.0, (3, 6)) if corner % 2 else rng.choice([-1.0, 1.0], (3, 6))
            motion = share * spread
            motion[0] += around[0]
            worst = max(worst, legs_at(motion, b, 0.01, *work())[0])
        proved += holds
        refuted += worst != HOLDS
        assert not (holds and worst != HOLDS)
    assert proved > 20
    assert refuted > 20


@pytest.mark.parametrize("row", [0, 1, 2])
def test_a_motion_that_is_no_number_holds_nowhere(row: int, b: Bounds) -> None:
    motion = np.zeros((3, 6))
    motion[row, 1] = np.nan
    assert legs_at(motion, b, 0.0, *work())[0] != HOLDS
    assert not legs_hold(np.zeros(6), motion, b, 0.0, *work())
