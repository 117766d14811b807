"""The table [hexapod] of a platform file."""

from collections.abc import Mapping

import numpy as np
import pytest
from numpy.testing import assert_allclose

from otolith.core.errors import InputError
from otolith.platforms import Platform, load, parse_platform

HEXAPOD = {
    "neutral_height_m": "1.2366",
    "reference_point_m": "[0.28, 0.0, 0.09]",
    "circles.base_radius_m": "1.2",
    "circles.base_half_angle_deg": "2.87",
    "circles.platform_radius_m": "0.975",
    "circles.platform_half_angle_deg": "3.53",
    "legs.length_m": "[1.297, 1.937]",
    "legs.speed_mps": "0.52",
    "legs.acceleration_mps2": "7.8",
    "legs.force_n": "2e4",
    "legs.mass_kg": "125",
    "legs.stiffness_npm": "2e7",
    "legs.damping_nspm": "3e5",
    "payload.mass_kg": "2000",
    "payload.centre_m": "[0, 0, 0.4]",
    "payload.inertia_kgm2": "[900, 1100, 1300]",
}


def toml(changes: Mapping[str, str | None] | None = None) -> str:
    fields = {**HEXAPOD, **(changes or {})}
    lines = [f"hexapod.{key} = {value}" for key, value in fields.items() if value is not None]
    surge = "surge = {position_m = 0.3, velocity_mps = 0.5, acceleration_mps2 = 4}"
    return "\n".join(['name = "rig"', surge, *lines])


def parsed(changes: Mapping[str, str | None] | None = None) -> Platform:
    return parse_platform(toml(changes), "rig.toml")


def refusal(changes: Mapping[str, str | None]) -> str:
    with pytest.raises(InputError) as caught:
        parsed(changes)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_the_shipped_surrogate_meets_the_published_leg() -> None:
    """A leg of 1.591 m in the neutral pose, pairs of 0.12 m; symmetric about the x-z plane."""
    hexapod = load("davsi").six_legs()
    assert_allclose(hexapod.lengths(np.zeros(6)), 1.591, atol=1e-4)
    base = hexapod.anchors
    gaps = sorted(np.linalg.norm(base - np.roll(base, 1, axis=0), axis=1))
    assert_allclose(gaps[:3], 0.12, atol=5e-4)
    mirrored = hexapod.joints * [1, -1, 1]
    assert_allclose(np.sort(mirrored, axis=0), np.sort(hexapod.joints, axis=0), atol=1e-12)


def test_chapter_6_runs_the_thesiss_limits_on_the_same_legs() -> None:
    lent, own = load("thesis").hexapod, load("davsi").hexapod
    assert lent is not None
    assert own is not None
    assert lent.model_copy(update={"lent": False, "source": own.source}) == own
    assert load("thesis").head is None  # so that the planar runs stay those of chapter 5


def test_twelve_points_describe_the_same_machine_as_two_circles() -> None:
    circles = parsed().hexapod
    assert circles is not None
    assert circles.circles is not None
    base, platform = (points.tolist() for points in circles.circles.points())
    without = {key: None for key in HEXAPOD if key.startswith("circles")}
    points = parsed({**without, "joints.base_m": str(base), "joints.platform_m": str(platform)})
    pose = np.array([0.1, -0.1, 0.05, 0.1, -0.05, 0.1])
    assert_allclose(points.six_legs().lengths(pose), parsed().six_legs().lengths(pose), atol=1e-15)


def test_the_other_pair_forward_is_the_machine_turned_round() -> None:
    pose, mirrored = np.array([0.1, 0.2, 0.05, 0, 0, 0.1]), np.array([-0.1, -0.2, 0.05, 0, 0, 0.1])
    origin = {"reference_point_m": "[0, 0, 0]"}
    here = parsed(origin).six_legs().lengths(pose)
    there = parsed({**origin, "circles.forward": '"base"'}).six_legs().lengths(mirrored)
    assert_allclose(np.sort(here), np.sort(there), atol=1e-14)


def test_the_head_is_given_from_the_reference_point() -> None:
    assert parsed({"head_m": "[0.1, 0, 0.9]"}).head == (0.1, 0.0, 0.9)
    assert (
        parse_platform(
            'name = "r"\nheave = {position_m = 1, velocity_mps = 1, acceleration_mps2 = 1}', "r"
        ).head
        is None
    )


def test_joint_angles_are_optional_and_become_radians() -> None:
    free, bound = parsed().six_legs(), parsed({"joint_angles.base_deg": "30"}).six_legs()
    assert free.lean == (np.pi, np.pi)
    assert bound.lean == (pytest.approx(np.pi / 6), np.pi)
    assert not bound.upright
    assert parsed({"joint_angles.about": '"normal"', "joint_angles.base_deg": "60"}).six_legs().upright


def test_legs_may_not_lean_too_far_in_the_neutral_pose() -> None:
    found = refusal({"joint_angles.about": '"normal"', "joint_angles.platform_deg": "20"})
    assert found.startswith("hexapod.leaning at the platform's joints in the neutral pose in rig.toml is 39")
    assert found.endswith(" deg, must be below 20 deg")


def test_a_platform_without_legs_says_so() -> None:
    expected = r"\[hexapod\] of platform benchmark is missing, must be in its file for its legs to be used"
    with pytest.raises(InputError, match=expected):
        load("benchmark").six_legs()


def test_a_hexapod_survives_json() -> None:
    platform = parsed({"head_m": "[0.1, 0, 0.9]"})
    assert Platform.model_validate_json(platform.model_dump_json()) == platform
    assert hash(platform) == hash(Platform.model_validate_json(platform.model_dump_json()))


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("legs.length_m", "[2, 1]", "is [2, 1], must be [shortest, longest] with shortest < longest, in m"),
        ("legs.length_m", "1.3", "is 1.3, must be [shortest, longest], in m"),
        ("legs.length_m", "[1297, 1937]", "is [1297, 1937], must be between 0.05 and 20 m (is it in mm?)"),
        ("legs.force_n", "-3", "is -3, must be greater than 0 N"),
        ("legs.speed_mps", "520", "is 520, must be between 0.005 and 20 m/s (is it in mm/s?)"),
        ("head_m", "[0, 1]", "is [0, 1], must be a point [x, y, z], in m"),
        ("head_m", "[0, nan, 1]", "is [0, nan, 1], must be a finite number in m"),
        ("head_m", "[0, 0, 900]", "is [0, 0, 900], must be a point within 20 m (is it in mm?)"),
        ("circles.base_half_angle_deg", "1.03", "is 1.03, must be between 1.05 and 59 deg (is it in rad?)"),
        (
            "circles.platform_half_angle_deg",
            "0.0616",
            "is 0.0616, must be between 1.05 and 59 deg (is it in rad?)",
        ),
        ("joint_angles.base_deg", "0.5", "is 0.5, must be between 3.2 and 180 deg (is it in rad?)"),
        ("joint_angles.platform_deg", "3.14", "is 3.14, must be between 3.2 and 180 deg (is it in rad?)"),
        (
            "joint_angles.bas_deg",
            "5",
            "is unknown, must be one of base_deg, platform_deg, about (did you mean base_deg?)",
        ),
        ("circles.forward", '"left"', "is 'left', must be one of 'platform' or 'base'"),
        ("payload.inertia_kgm2", "[1, 1]", "is [1, 1], must be [roll, pitch, yaw], in kg m2"),
        (
            "payload.inertia_kgm2",
            "[1, 1, 9]",
            "is [1, 1, 9], must be moments of which none exceeds the sum of the others, as of any body",
        ),
        ("joints.base_m", "[[0, 0, 0]]", "is [[0, 0, 0]], must be six points [x, y, z], in m"),
        (
            "legs.stroke_m",
            "1",
            "is unknown, must be one of length_m, speed_mps, acceleration_mps2, force_n, mass_kg, "
            "stiffness_npm, damping_nspm",
        ),
    ],
)
def test_a_wrong_value_names_field_value_bound_and_unit(key: str, value: str, words: str) -> None:
    assert refusal({key: value}) == f"hexapod.{key} in rig.toml {words}"


def test_there_must_be_one_geometry() -> None:
    without = {key: None for key in HEXAPOD if key.startswith("circles")}
    assert refusal(without) == "hexapod.the geometry in rig.toml is absent, must be one of circles and joints"
    points = str([[0.1 * i, 0.2, 0.3] for i in range(6)])
    both = {"joints.base_m": points, "joints.platform_m": points}
    assert (
        refusal(both) == "hexapod.the geometry in rig.toml is both given, must be one of circles and joints"
    )


def test_legs_must_fit_the_neutral_pose() -> None:
    found = refusal({"neutral_height_m": "2.0"})
    assert found.startswith("hexapod.legs in the neutral pose in rig.toml is 2.237 to 2.237 m long")
    assert found.endswith("must be within 1.297 to 1.937 m")


def test_legs_that_cannot_hold_the_platform_are_refused() -> None:
    """Joints over joints: six parallel legs hold no sway."""
    alike = {
        "circles.base_radius_m": "0.975",
        "circles.base_half_angle_deg": "56.47",
        "neutral_height_m": "1.5",
    }
    found = refusal(alike)
    assert found.startswith("hexapod.condition number in the neutral pose in rig.toml is ")
    assert found.endswith("must be below 50: such legs cannot hold the platform")
