"""What four axes do together, against the legs themselves."""

import itertools
import math

import numpy as np
import pytest

from otolith.core.errors import InputError
from otolith.platforms import Platform, load
from otolith.platforms.together import Together, reaches_all, together

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
    assert LEGS.reaches(_poses(share.circle, share.tilt, 200_000)).all()


def test_a_little_more_than_the_share_is_out_of_reach(share: Together) -> None:
    assert not LEGS.reaches(_poses(1.005 * share.circle, 1.005 * share.tilt, 200_000)).all()
    assert not reaches_all(LEGS, 1.001 * share.circle, 1.001 * share.tilt)


def test_the_shipped_platform_is_that_share_rounded_down(share: Together) -> None:
    assert FOUR.circle is not None
    assert FOUR.surge is not None
    assert FOUR.pitch is not None
    given = (FOUR.circle, FOUR.pitch.angle_deg[1], FOUR.surge.velocity_mps, FOUR.surge.acceleration_mps2)
    found = (share.circle, math.degrees(share.tilt), share.velocity, share.translation)
    for file, legs in zip(given, found, strict=True):
        assert 0.99 * legs < file <= legs
    assert FOUR.pitch.acceleration_degps2 is not None
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


def test_a_file_without_one_of_the_limits_is_refused() -> None:
    with pytest.raises(InputError, match="circle_m"):
        together(load("thesis"))  # which gives no rate of tilt
    narrow = Platform.model_validate(DAVSI.model_dump() | {"workspace": {}})
    with pytest.raises(InputError, match="together"):
        together(narrow)
