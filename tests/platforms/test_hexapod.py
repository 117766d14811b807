"""The legs of the shipped surrogate, and of a machine without any symmetry."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from otolith.core.arrays import Mat, Vec
from otolith.platforms import load
from otolith.platforms.hexapod import Hexapod
from otolith.platforms.unreachable import LeansTooFar, LegOutsideStroke, NoPose, Singular

DAVSI = load("davsi").six_legs()
BOX = np.array([0.3, 0.3, 0.25, 0.2, 0.2, 0.2])
inside = arrays(np.float64, 6, elements=st.floats(-1.0, 1.0)).map(lambda unit: unit * BOX)
moving = arrays(np.float64, 6, elements=st.floats(-2.0, 2.0))
exactly = settings(derandomize=True, max_examples=60, deadline=None)


def irregular() -> Hexapod:
    rng = np.random.default_rng(5)
    fields = {name: getattr(DAVSI, name) for name in Hexapod.__slots__}
    fields["joints"] = DAVSI.joints + rng.uniform(-0.1, 0.1, (6, 3))
    fields["anchors"] = DAVSI.anchors + rng.uniform(-0.1, 0.1, (6, 3))
    return Hexapod(**fields)


MACHINES = pytest.mark.parametrize("hexapod", [DAVSI, irregular()], ids=["davsi", "irregular"])


def poses_within_reach(n: int) -> Mat:
    """Random poses of which every leg is within its stroke."""
    rng, found = np.random.default_rng(1), np.empty((0, 6))
    while len(found) < n:
        tried = rng.uniform(-1.0, 1.0, (5 * n, 6)) * [0.6, 0.5, 0.4, 0.4, 0.4, 0.4]
        found = np.vstack([found, tried[DAVSI.reaches(tried)]])
    return found[:n]


@MACHINES
@exactly
@given(pose=inside)
def test_lengths_are_distances_between_joints(hexapod: Hexapod, pose: Vec) -> None:
    R = Rotation.from_euler("ZYX", pose[5:2:-1]).as_matrix()
    ends = pose[:3] + hexapod.joints @ R.T
    assert_allclose(hexapod.lengths(pose), np.linalg.norm(ends - hexapod.anchors, axis=1), atol=1e-14)


@MACHINES
@exactly
@given(pose=inside)
def test_the_jacobian_is_the_derivative_of_the_lengths(hexapod: Hexapod, pose: Vec) -> None:
    h = 1e-6
    differences = np.array(
        [(hexapod.lengths(pose + h * e) - hexapod.lengths(pose - h * e)) / (2 * h) for e in np.eye(6)]
    )
    assert_allclose(hexapod.pose_jacobian(pose), differences.T, atol=1e-9)


@MACHINES
@exactly
@given(pose=inside, twist=moving, acceleration=moving)
def test_leg_speed_and_acceleration_are_derivatives_along_the_path(
    hexapod: Hexapod, pose: Vec, twist: Vec, acceleration: Vec
) -> None:
    h = 1e-4
    before, now, after = (hexapod.lengths(pose + twist * t + 0.5 * acceleration * t**2) for t in (-h, 0.0, h))
    motion = hexapod.leg_motion(pose, twist, acceleration)
    assert_allclose(motion.length, now, atol=1e-14)
    assert_allclose(motion.speed, (after - before) / (2 * h), atol=1e-6)
    assert_allclose(motion.acceleration, (after - 2 * now + before) / h**2, atol=1e-5)


def test_forward_after_inverse_is_the_identity_over_ten_thousand_poses() -> None:
    poses = poses_within_reach(10_000)
    found = np.array([DAVSI.pose_of(lengths) for lengths in DAVSI.lengths(poses)])
    assert_allclose(found, poses, atol=1e-10)


def test_every_combination_of_leg_lengths_is_reached_and_none_is_near_singular() -> None:
    """So whatever stays within the strokes, by whatever path, can neither jam nor fold."""
    start = DAVSI.lengths(np.zeros(6))
    worst = 0.0
    for corner in itertools.product(DAVSI.stroke, repeat=6):
        pose = np.zeros(6)
        for share in np.linspace(0.0, 1.0, 9)[1:]:
            pose = DAVSI.pose_of(start + share * (np.array(corner) - start), near=pose)
            worst = max(worst, DAVSI.condition(pose))
    assert worst < 3.0


def test_the_condition_number_has_no_unit() -> None:
    """The same machine counted in millimetres is as well conditioned."""
    fields = {name: getattr(DAVSI, name) for name in Hexapod.__slots__}
    for name in ("joints", "anchors"):
        fields[name] = 1e3 * fields[name]
    pose = np.array([0.1, -0.2, 0.1, 0.1, -0.1, 0.05])
    millimetres = Hexapod(**fields).condition(pose * [1e3, 1e3, 1e3, 1, 1, 1])
    assert millimetres == pytest.approx(DAVSI.condition(pose), rel=1e-12)


def test_a_pose_beyond_the_stroke_names_the_leg() -> None:
    with pytest.raises(
        LegOutsideStroke, match=r"leg [1-6] needs 2\.\d{4} m, its stroke is 1\.2970 to 1\.9370 m"
    ):
        DAVSI.check(np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0]))
    with pytest.raises(LegOutsideStroke):
        DAVSI.check(np.full(6, np.nan))
    DAVSI.check(np.zeros(6))


def test_a_singular_pose_is_refused() -> None:
    """At 90 deg of yaw the legs of a symmetric machine all meet its axis (Fichter's singularity)."""
    fields = {name: getattr(DAVSI, name) for name in Hexapod.__slots__}
    fields["stroke"] = (0.1, 9.0)
    with pytest.raises(Singular, match=r"condition number is .* in this pose, must be below 50"):
        Hexapod(**fields).check(np.array([0.0, 0.0, 0.0, 0.0, 0.0, np.pi / 2]) + _about_the_axis(np.pi / 2))


def _about_the_axis(yaw: float) -> Vec:
    """Displacement of the reference point when the platform turns about its own axis instead."""
    axis = DAVSI.joints.mean(axis=0)
    R = Rotation.from_euler("z", yaw).as_matrix()
    return np.concatenate([axis - R @ axis, np.zeros(3)])


@pytest.mark.parametrize("lengths", [np.full(6, 0.3), np.array([9.0, 1, 1, 1, 1, 1]), np.full(6, np.nan)])
def test_lengths_that_no_pose_has_are_refused(lengths: Vec) -> None:
    with pytest.raises(NoPose, match="no pose of the leg lengths"):
        DAVSI.pose_of(lengths)


def test_a_leg_leans_as_far_as_geometry_says() -> None:
    """A leg straight up, the platform moved aside by its length: 45 deg."""
    upright = replace(DAVSI, joints=DAVSI.anchors + np.array([0.0, 0.0, 1.5]), stroke=(0.5, 5.0))
    aside = np.zeros((3, 6))
    aside[0, 0] = 1.5
    aside[1, 2] = 0.3
    aside[2, 3] = 0.2  # roll about the reference point
    leans = upright.leans(aside)
    assert_allclose(leans[0], np.pi / 4, atol=1e-12)
    assert_allclose(leans[1], 0.0, atol=1e-12)
    assert np.all(np.abs(leans[2, 1] - leans[2, 0]) <= 0.2 + 1e-12)
    assert_allclose(replace(upright, upright=True).leans(aside), leans, atol=1e-12)  # the legs stood along z


def test_a_pose_that_leans_too_far_is_refused_by_leg_and_joint() -> None:
    bound = replace(DAVSI, lean_platform=0.1)
    pose = np.array([0.0, 0.0, 0.0, 0.15, 0.0, 0.0])
    assert not bound.reaches(pose[None]).any()
    leans = DAVSI.leans(pose[None])[0, 1]
    with pytest.raises(LeansTooFar) as caught:
        bound.check(pose)
    leg = int(np.argmax(leans)) + 1
    assert str(caught.value).startswith(
        f"leg {leg} leans {np.degrees(leans.max()):.1f} deg at its platform joint"
    )
    assert str(caught.value).endswith("must be at most 5.72958 deg")


def test_a_pose_beyond_a_singular_one_is_not_reached_although_the_legs_have_its_lengths() -> None:
    """Yawed by 120 deg the legs are firm again, but the way there is through a pose that they cannot hold."""
    wide = replace(DAVSI, stroke=(0.2, 6.0))
    pose = np.zeros((1, 6))
    pose[0, 5] = np.radians(120.0)
    assert wide.condition(pose[0]) < 20.0
    assert not wide.reaches(pose).any()


def test_leans_turn_joints_as_scipy_rotates() -> None:
    """Another author's rotation; the joints' axes at the platform are carried by it."""
    poses = np.random.default_rng(3).uniform(-0.4, 0.4, (50, 6))
    R = Rotation.from_euler("ZYX", poses[:, [5, 4, 3]]).as_matrix()  # (n, 3, 3)
    legs = poses[:, None, :3] + np.einsum("nij,kj->nki", R, DAVSI.joints) - DAVSI.anchors
    axes = DAVSI.joints - DAVSI.anchors
    turned = np.einsum("nij,kj->nki", R, axes)
    lengths = np.linalg.norm(axes, axis=1) * np.linalg.norm(legs, axis=2)
    expected = [np.arccos(np.sum(a * legs, axis=2) / lengths) for a in (axes, turned)]
    assert_allclose(DAVSI.leans(poses), np.stack(expected, axis=1), atol=1e-7)
