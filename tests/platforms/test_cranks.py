"""Cranks: against finite differences, a numerically closed loop, and themselves backwards."""

import functools
import itertools
from dataclasses import replace

import numpy as np
import pytest
import scipy
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from otolith.core.arrays import Mat, Vec
from otolith.platforms.hexapod import Hexapod
from otolith.platforms.unreachable import CrankOutsideRange, LeansTooFar, NoPose, RodDoesNotReach
from tests.platforms.cranks import RADIUS, ROD, machine

BOX = np.array([0.006, 0.006, 0.006, 0.025, 0.025, 0.025])
inside = arrays(np.float64, 6, elements=st.floats(-1.0, 1.0)).map(lambda unit: unit * BOX)
moving = arrays(np.float64, 6, elements=st.floats(-1.0, 1.0))
exactly = settings(derandomize=True, max_examples=30, deadline=None)
REGULAR, IRREGULAR, PULLING = machine(), machine(seed=1), machine(push=False, seed=2)
MACHINES = pytest.mark.parametrize(
    "hexapod",
    [REGULAR, IRREGULAR, PULLING, machine(tilt_deg=15.0)],
    ids=["regular", "irregular", "pulling", "tilted"],
)


def joints_of(hexapod: Hexapod, pose: Vec) -> Mat:
    """The platform's joints (6, 3) in world, by scipy's rotations."""
    R = Rotation.from_euler("ZYX", pose[5:2:-1]).as_matrix()
    joints: Mat = pose[:3] + hexapod.joints @ R.T
    return joints


def loop(hexapod: Hexapod, pose: Vec, i: int, angle: float) -> float:
    """How far [m²] the loop of crank, rod and platform is open at an angle [rad]."""
    assert hexapod.cranks is not None
    cranks = hexapod.cranks
    tip = hexapod.anchors[i] + cranks.radius * (
        np.cos(angle) * cranks.zero[i] + np.sin(angle) * cranks.quarter[i]
    )
    return float(np.sum((joints_of(hexapod, pose)[i] - tip) ** 2) - cranks.rod**2)


@MACHINES
@exactly
@given(pose=inside)
def test_angles_close_the_loop_on_the_stated_branch(hexapod: Hexapod, pose: Vec) -> None:
    """Both solutions, bracketed around the least opening; ours is the one that pushes, or pulls."""
    angles = hexapod.angles(hexapod.lengths(pose))
    assert hexapod.cranks is not None
    for i in range(6):
        opening = functools.partial(loop, hexapod, pose, i)
        around = np.linspace(-np.pi, np.pi, 721)
        turning = float(around[np.argmin([opening(angle) for angle in around])])
        both = [
            float(scipy.optimize.brentq(opening, low, low + np.pi, xtol=1e-14))
            for low in (turning - np.pi, turning)
        ]
        expected = both[0] if hexapod.cranks.push else both[1]
        assert angles[i] == pytest.approx((expected + np.pi) % (2.0 * np.pi) - np.pi, abs=1e-9)


@MACHINES
@exactly
@given(pose=inside)
def test_the_jacobian_is_the_derivative_of_the_arcs(hexapod: Hexapod, pose: Vec) -> None:
    h = 1e-6
    differences = np.array(
        [(hexapod.lengths(pose + h * e) - hexapod.lengths(pose - h * e)) / (2 * h) for e in np.eye(6)]
    )
    assert_allclose(hexapod.pose_jacobian(pose), differences.T, rtol=1e-6, atol=1e-8)


@MACHINES
@exactly
@given(pose=inside, twist=moving, acceleration=moving)
def test_speed_and_acceleration_are_derivatives_along_the_path(
    hexapod: Hexapod, pose: Vec, twist: Vec, acceleration: Vec
) -> None:
    """Differences of fourth order; relative, for a crank amplifies what the platform does."""
    h = 5e-5
    at = [hexapod.lengths(pose + twist * t + 0.5 * acceleration * t**2) for t in h * np.arange(-2.0, 3.0)]
    motion = hexapod.leg_motion(pose, twist, acceleration)
    first = (at[0] - 8.0 * at[1] + 8.0 * at[3] - at[4]) / (12.0 * h)
    second = (-at[0] + 16.0 * at[1] - 30.0 * at[2] + 16.0 * at[3] - at[4]) / (12.0 * h**2)
    assert_allclose(motion.length, at[2], atol=1e-14)
    assert_allclose(motion.speed, first, rtol=1e-6, atol=1e-6)
    assert_allclose(motion.acceleration, second, rtol=1e-6, atol=1e-5)


@MACHINES
@exactly
@given(pose=inside)
def test_forward_after_inverse_is_the_identity(hexapod: Hexapod, pose: Vec) -> None:
    assert_allclose(hexapod.pose_of(hexapod.lengths(pose)), pose, atol=1e-10)


@exactly
@given(pose=inside)
def test_angles_change_little_where_the_pose_does(pose: Vec) -> None:
    """Along the straight way from neutral no arc jumps: the branch is kept."""
    arcs = REGULAR.lengths(np.linspace(0.0, 1.0, 400)[:, None] * pose)
    assert np.abs(np.diff(arcs, axis=0)).max() < 2e-3


def test_a_straight_crank_and_rod_lift_by_the_textbooks_formula() -> None:
    """A crank below its joint, in the plane of the rod: h = ρ sin φ + √(d² − (a − ρ cos φ)²)."""
    assert REGULAR.cranks is not None
    away = 0.1
    up = np.tile([0.0, 0.0, 1.0], (6, 1))
    level = np.tile([1.0, 0.0, 0.0], (6, 1))
    plain = replace(
        REGULAR,
        anchors=REGULAR.joints - [away, 0.0, 0.3],
        cranks=replace(REGULAR.cranks, zero=level, quarter=up),
    )
    for degrees in (-50.0, -10.0, 0.0, 30.0, 70.0):
        phi = np.radians(degrees)
        lift = RADIUS * np.sin(phi) + np.sqrt(ROD**2 - (away - RADIUS * np.cos(phi)) ** 2) - 0.3
        assert_allclose(
            np.degrees(plain.angles(plain.lengths(np.array([0, 0, lift, 0, 0, 0])))), degrees, atol=1e-9
        )


def test_what_the_rods_do_not_reach_is_said_in_one_sentence() -> None:
    with pytest.raises(RodDoesNotReach, match=r"the rod of crank [1-6] reaches .* for no angle of the crank"):
        REGULAR.check(np.array([0.0, 0.0, 0.2, 0.0, 0.0, 0.0]))
    with pytest.raises(RodDoesNotReach, match=r"for no angle of the crank"):
        REGULAR.check(np.array([0.0, 0.0, -0.25, 0.0, 0.0, 0.0]))
    wide = replace(REGULAR, stroke=(-0.15, 0.15))
    top = max(
        z
        for z in np.linspace(0.0, 0.05, 501)
        if np.isfinite(wide.lengths(np.array([0, 0, z, 0, 0, 0.0]))).all()
    )
    with pytest.raises(
        RodDoesNotReach, match=r"only with the crank near its dead centre \(n·t = 0\.\d+, must be"
    ):
        wide.check(np.array([0.0, 0.0, top, 0.0, 0.0, 0.0]))
    with pytest.raises(
        CrankOutsideRange, match=r"crank [1-6] needs -7\d\.\d\d deg, its range is -60 to 60 deg"
    ):
        REGULAR.check(np.array([0.0, 0.0, -0.062, 0.0, 0.0, 0.0]))
    REGULAR.check(np.zeros(6))


def test_a_rod_leans_from_the_plane_of_its_crank() -> None:
    """At the crank, the angle between rod and plane: asin of the rod's part along the shaft."""
    assert REGULAR.cranks is not None
    pose = np.array([0.01, -0.005, 0.004, 0.03, 0.02, -0.04])
    rods = joints_of(REGULAR, pose) - REGULAR.tips(REGULAR.lengths(pose)[None])[0]
    assert_allclose(np.linalg.norm(rods, axis=1), ROD, atol=1e-14)
    shafts = np.cross(REGULAR.cranks.zero, REGULAR.cranks.quarter)
    out = np.arcsin(np.abs(np.sum(rods * shafts, axis=1)) / ROD)
    assert_allclose(REGULAR.leans(pose[None])[0, 0], out, atol=1e-12)
    limited = replace(REGULAR, lean_base=float(out.max()) - 0.01)
    with pytest.raises(LeansTooFar, match=r"leg [1-6] leans .* at its base joint"):
        limited.check(pose)
    assert not limited.reaches(pose[None])[0]
    assert REGULAR.reaches(pose[None])[0]


def test_arcs_that_no_pose_has_are_refused() -> None:
    with pytest.raises(NoPose, match="no pose of the leg lengths"):
        REGULAR.pose_of(np.full(6, np.nan))


def test_every_corner_of_the_angles_has_a_pose_that_is_firm() -> None:
    """Of 50 mm cranks at ±45 deg: what stays within the ranges can neither jam nor fold."""
    small, worst = machine(range_deg=45.0), 0.0
    for corner in itertools.product(small.stroke, repeat=6):
        pose = np.zeros(6)
        for share in np.linspace(0.0, 1.0, 9)[1:]:
            pose = small.pose_of(share * np.array(corner), near=pose)
            worst = max(worst, small.condition(pose))
    assert worst < 10.0
