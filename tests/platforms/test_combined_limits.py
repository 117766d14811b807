"""What four axes do together, against the legs themselves."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from otolith.core.errors import InputError
from otolith.platforms import Platform, load
from otolith.platforms.combined_limits import Together, holds_all, reach_share, reaches_all, together

DAVSI, FOUR = load("davsi"), load("davsi-4dof")
LEGS = FOUR.six_legs()
SIGNS = [np.array([1.0, a, 0.0, b, c, 0.0]) for a, b, c in itertools.product((-1.0, 1.0), repeat=3)]


@pytest.fixture(scope="module")
def share() -> Together:
    return together(DAVSI)


def _poses(circle: float, tilt: float, n: int) -> np.ndarray:
    """Random poses (n, 6), a third of them at the edge of the disc and half of them at corners of tilt."""
    rng = np.random.default_rng(4)
    radius = circle * np.where(rng.uniform(size=n) < 1 / 3, 1.0, np.sqrt(rng.uniform(size=n)))
    around = rng.uniform(0.0, 2.0 * np.pi, n)
    tilts = tilt * rng.uniform(-1.0, 1.0, (n, 2))
    corners = rng.uniform(size=n) < 0.5
    tilts[corners] = tilt * np.sign(tilts[corners])
    poses = np.zeros((n, 6))
    poses[:, 0], poses[:, 1] = radius * np.cos(around), radius * np.sin(around)
    poses[:, 3:5] = tilts
    return poses


def test_no_pose_of_the_share_needs_more_stroke(share: Together) -> None:
    assert LEGS.reaches(_poses(share.circle, share.tilt, 50_000)).all()


def test_a_little_more_than_the_share_is_out_of_reach(share: Together) -> None:
    assert not LEGS.reaches(_poses(1.005 * share.circle, 1.005 * share.tilt, 50_000)).all()
    assert not reaches_all(LEGS, 1.001 * share.circle, 1.001 * share.tilt)


def test_the_shipped_platform_is_that_share_rounded_down(share: Together) -> None:
    assert FOUR.circle is not None
    assert FOUR.surge is not None
    assert FOUR.pitch is not None
    given = (FOUR.circle, FOUR.pitch.angle_deg[1], FOUR.surge.velocity_mps, FOUR.surge.acceleration_mps2)
    found = (share.circle, math.degrees(share.tilt), share.velocity, share.translation)
    for file, legs in zip(given, found, strict=True):
        assert legs is not None
        assert 0.99 * legs < file <= legs
    assert FOUR.pitch.acceleration_degps2 is not None
    assert share.tilt_acceleration is not None
    assert 0.99 < FOUR.pitch.acceleration_degps2 / math.degrees(share.tilt_acceleration) <= 1.0
    assert FOUR.pitch.rate_degps is not None
    assert 0.99 < FOUR.pitch.rate_degps / math.degrees(share.tilt_rate) <= 1.0
    assert FOUR.hexapod is not None
    assert DAVSI.hexapod is not None
    assert FOUR.hexapod.hexapod().stroke == DAVSI.hexapod.hexapod().stroke
    assert (FOUR.surge, FOUR.pitch) == (FOUR.sway, FOUR.roll)


def test_no_motion_within_the_shipped_limits_is_too_much_for_a_leg() -> None:
    """Every corner of speeds and accelerations, at random poses: length, speed and acceleration of legs."""
    assert FOUR.surge is not None
    assert FOUR.pitch is not None
    assert FOUR.circle is not None
    rate, turning = FOUR.pitch.rate_degps, FOUR.pitch.acceleration_degps2
    assert rate is not None
    assert turning is not None
    fast = np.array([FOUR.surge.velocity_mps] * 3 + [math.radians(rate)] * 3)
    strong = np.array([FOUR.surge.acceleration_mps2] * 3 + [math.radians(turning)] * 3)
    for pose in _poses(FOUR.circle, math.radians(FOUR.pitch.angle_deg[1]), 500):
        for a, b, way in itertools.product(SIGNS, SIGNS, (-1.0, 1.0)):
            moving = LEGS.leg_motion(pose, a * fast, way * b * strong)
            assert LEGS.stroke[0] <= moving.length.min() <= moving.length.max() <= LEGS.stroke[1]
            assert np.abs(moving.speed).max() <= LEGS.speed
            assert np.abs(moving.acceleration).max() <= LEGS.acceleration


def test_a_file_without_an_axis_of_the_four_is_refused() -> None:
    with pytest.raises(InputError, match="one of surge, sway, roll and pitch of platform benchmark-6"):
        together(Platform.model_validate(DAVSI.model_dump() | {"name": "benchmark-6", "sway": None}))


def test_without_a_circle_the_smaller_end_of_surge_and_sway_is_taken(share: Together) -> None:
    """0.51 m instead of 0.5 m: the same poses, so a share that much smaller at most."""
    found = together(Platform.model_validate(DAVSI.model_dump() | {"workspace": {}}))
    assert found.circle / found.tilt == pytest.approx(0.51 / 0.5 * share.circle / share.tilt)
    assert found.circle == pytest.approx(share.circle, rel=0.02)
    assert LEGS.reaches(_poses(found.circle, found.tilt, 20_000)).all()


def test_without_rates_of_tilt_the_thresholds_count_and_accelerations_are_not_told() -> None:
    found = together(load("thesis"))
    assert found.reach == pytest.approx(0.2866, abs=1e-4)
    assert math.degrees(found.tilt_rate) == pytest.approx(2.6 * found.speed)
    assert found.speed == pytest.approx(LEGS.speed / (7.2 * 1.08), rel=0.1)  # legs lie near their direction
    assert (found.acceleration, found.translation, found.tilt_acceleration) == (None, None, None)


def test_joint_angles_take_of_what_four_axes_can_do() -> None:
    """Just within what the shares' worst pose leans, and just beyond, against random poses."""
    lean = LEGS.leans(_poses(0.165, math.radians(8.03), 20_000)).max(axis=(0, 2))
    loose = replace(LEGS, lean_base=1.02 * lean[0], lean_platform=1.02 * lean[1])
    assert holds_all(loose, 0.165, math.radians(8.03))
    tight = replace(LEGS, lean_base=0.7 * lean[0])
    found = reach_share(tight, 0.165, math.radians(8.03))
    assert 0.6 < found < 0.8
    assert tight.reaches(_poses(found * 0.165, found * math.radians(8.03), 20_000)).all()
    assert not tight.reaches(_poses(1.06 * found * 0.165, 1.06 * found * math.radians(8.03), 20_000)).all()


def test_legs_that_fold_within_their_strokes_are_not_counted_on() -> None:
    """Nearly parallel legs, long strokes: the strokes alone would allow it all."""
    wide = replace(LEGS, anchors=LEGS.anchors * [0.9, 0.9, 1.0], stroke=(0.2, 6.0))
    assert reaches_all(wide, 1.0, 1.0)
    assert not holds_all(wide, 1.0, 1.0)
    found = reach_share(wide, 1.0, 1.0)
    assert 0.05 < found < 1.0
    assert wide.reaches(_poses(found, found, 20_000)).all()
