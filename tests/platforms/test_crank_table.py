"""Cranks as a file describes them: against an open rig's own formulas, and what a wrong file says."""

import tomllib
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from otolith.core.arrays import Vec
from otolith.core.errors import InputError
from otolith.platforms import Platform, parse_platform
from otolith.platforms.template import filled, template

RIG = template("cranks")


def parsed(changes: dict[str, Any] | None = None) -> Platform:
    values = {f"hexapod.{key}": value for key, value in (changes or {}).items()}
    return parse_platform(filled(RIG, values), "rig.toml")


def refusal(changes: dict[str, Any]) -> str:
    with pytest.raises(InputError) as caught:
        parsed(changes)
    return str(caught.value)


def angles_by_sines(pose: Vec) -> Vec:
    """The angles [rad] of the open rig by the usual sine form: asin(g/√(e² + f²)) − atan2(f, e).

    Shafts at 30, 90 … deg on 406.4 mm, joints at ±10 deg of 0, 120 and 240 on 400.05 mm, arms at right angles
    to the shaft's radius (its firmware, turned by 30 deg so that a pair of joints points forward).
    """
    shafts, joints = np.radians([30, 90, 150, 210, 270, 330]), np.radians([10, 110, 130, 230, 250, 350])
    headings = shafts + np.radians([90, -90, 90, -90, 90, -90])
    c, s = np.cos(pose[3:]), np.sin(pose[3:])
    roll = np.array([[1, 0, 0], [0, c[0], -s[0]], [0, s[0], c[0]]])
    pitch = np.array([[c[1], 0, s[1]], [0, 1, 0], [-s[1], 0, c[1]]])
    yaw = np.array([[c[2], -s[2], 0], [s[2], c[2], 0], [0, 0, 1]])
    on_platform = 0.40005 * np.column_stack([np.cos(joints), np.sin(joints), np.zeros(6)])
    on_base = 0.4064 * np.column_stack([np.cos(shafts), np.sin(shafts), np.zeros(6)])
    leg = pose[:3] + [0.0, 0.0, 0.6481] + on_platform @ (yaw @ pitch @ roll).T - on_base
    arm, rod = 0.18415, 0.7239
    e = 2.0 * arm * leg[:, 2]
    f = 2.0 * arm * (np.cos(headings) * leg[:, 0] + np.sin(headings) * leg[:, 1])
    g = np.sum(leg**2, axis=1) - (rod**2 - arm**2)
    found: Vec = np.arcsin(g / np.hypot(e, f)) - np.arctan2(f, e)
    return found


def test_the_template_turns_as_the_open_rig_does() -> None:
    """Its file gives the firmware's numbers; its angles are those of the firmware's formula."""
    hexapod = parsed().six_legs()
    rng = np.random.default_rng(0)
    for pose in rng.uniform(-1.0, 1.0, (200, 6)) * [0.05, 0.05, 0.05, 0.1, 0.1, 0.1]:
        assert_allclose(hexapod.angles(hexapod.lengths(pose)), angles_by_sines(pose), atol=1e-9)
    assert np.degrees(np.abs(angles_by_sines(np.zeros(6)))).max() < 0.02  # its arms are level at home


def test_limits_of_angles_become_those_of_the_tips() -> None:
    hexapod = parsed({"cranks.angle_deg": (-45.0, 60.0)}).six_legs()
    rho = 0.18415
    assert_allclose(hexapod.stroke, rho * np.radians([-45.0, 60.0]))
    assert_allclose([hexapod.speed, hexapod.acceleration], rho * np.radians([300.0, 3000.0]))
    assert_allclose([hexapod.force * rho, hexapod.leg_mass * rho**2], [220.0, 0.35])
    assert_allclose([hexapod.stiffness * rho**2, hexapod.damping * rho**2], [5e4, 700.0])


def test_three_ways_to_say_where_cranks_point_agree() -> None:
    first = parsed().six_legs().cranks
    assert first is not None
    by_vectors = tomllib.loads(RIG)
    table = by_vectors["hexapod"]["cranks"]
    del table["heading_deg"]
    table["shaft"] = (3.0 * np.cross(first.zero, first.quarter)).tolist()  # of any length
    table["zero"] = first.zero.tolist()
    second = Platform.model_validate(by_vectors).six_legs().cranks
    assert second is not None
    assert_allclose(second.zero, first.zero, atol=1e-12)
    assert_allclose(second.quarter, first.quarter, atol=1e-12)


def test_apart_and_together_are_along_the_line_of_a_pair() -> None:
    """Two shafts of a pair at 30 and 90 deg: the line through them points to 150 deg and back."""
    together = parsed({"cranks.heading_deg": None, "cranks.points": "together"}).six_legs().cranks
    assert together is not None
    headings = np.degrees(np.arctan2(together.zero[:, 1], together.zero[:, 0])) % 360.0
    assert_allclose(headings, [150.0, 330.0, 270.0, 90.0, 30.0, 210.0], atol=1e-9)


def test_the_zero_may_be_tilted() -> None:
    """The same machine, whose controller counts from 10 deg above the horizontal."""
    tilted, level = parsed({"cranks.zero_deg": 10.0}).six_legs(), parsed().six_legs()
    pose = np.array([0.03, -0.02, 0.04, 0.02, -0.05, 0.03])
    difference = level.angles(level.lengths(pose)) - tilted.angles(tilted.lengths(pose))
    assert_allclose(np.degrees(difference), 10.0, atol=1e-9)


def test_the_other_branch_folds_its_cranks_the_other_way() -> None:
    """Both close the loop: the pulling angle is the pushing one's mirror about the direction of the joint."""
    pushing, still = parsed().six_legs(), np.zeros(6)
    assert pushing.cranks is not None
    pulling = replace(pushing, cranks=replace(pushing.cranks, push=False))
    legs = pushing.joints - pushing.anchors
    along, across = (np.sum(legs * one, axis=1) for one in (pushing.cranks.zero, pushing.cranks.quarter))
    first, second = pushing.angles(pushing.lengths(still)), pulling.angles(pulling.lengths(still))
    assert_allclose(np.cos(first + second - 2.0 * np.arctan2(across, along)), 1.0, atol=1e-9)
    assert np.abs(first - second).min() > 1.0


def test_a_machine_on_cranks_survives_json() -> None:
    platform = parsed()
    assert Platform.model_validate_json(platform.model_dump_json()) == platform


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("cranks.radius_m", 184.0, "is 184.0, must be between 0.005 and 2 m (is it in mm?)"),
        (
            "cranks.angle_deg",
            (60.0, -45.0),
            "is [60.0, -45.0], must be [lowest, highest] with lowest < highest, in deg",
        ),
        (
            "cranks.angle_deg",
            (-1.05, 60.0),
            "is [-1.05, 60.0], must be between 3.2 and 175 deg (is it in rad?)",
        ),
        ("cranks.angle_deg", 1.05, "is 1.05, must be between 3.2 and 175 deg (is it in rad?)"),
        ("cranks.speed_degps", 5.24, "is 5.24, must be between 20 and 10000 deg/s (is it in rad/s?)"),
        (
            "cranks.acceleration_degps2",
            52.4,
            "is 52.4, must be between 100 and 1e+06 deg/s2 (is it in rad/s2?)",
        ),
        (
            "cranks.heading_deg",
            (2.1, 0.0, 4.19, 2.1, 0.0, 4.19),
            "is [2.1, 0.0, 4.19, 2.1, 0.0, 4.19], must be six directions in deg, of which one at least is "
            "above 6.3 (are they in rad?)",
        ),
        ("cranks.torque_nm", -1.0, "is -1.0, must be greater than 0 N m"),
        ("cranks.heading_deg", (1.0, 2.0), "is [1.0, 2.0], must be six directions, in deg"),
        ("cranks.branch", "up", "is 'up', must be one of 'push' or 'pull'"),
        ("cranks.zero_deg", "up", "is 'up', must be a number in deg"),
    ],
)
def test_a_wrong_value_names_field_value_bound_and_unit(key: str, value: Any, words: str) -> None:
    assert refusal({key: value}) == f"hexapod.{key} in rig.toml {words}"


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {"cranks.points": "apart"},
            "cranks.where the cranks point in rig.toml is points and heading_deg given",
        ),
        (
            {"cranks.rod_m": 0.4},
            "cranks.rod_m in rig.toml is 0.4, must be between 0.4793 and 0.847 m, to reach",
        ),
        (
            {"cranks.rod_m": 0.8471},  # the bound that is told must be one
            "cranks.rod_m in rig.toml is 0.8471, must be between 0.4793 and 0.847 m, to reach",
        ),
        (
            {"neutral_height_m": 0.55, "cranks.angle_deg": 30.0},
            "cranks in the neutral pose in rig.toml is at -39.61 to -39.61 deg, must be within -30 to 30 deg",
        ),
        (
            {"joint_angles.base_deg": 3.3, "circles.platform_half_angle_deg": 5.0},
            "leaning at the base's joints in the neutral pose in rig.toml is 3.4",
        ),
        ({"legs.length_m": (0.5, 0.7)}, "legs.speed_mps in rig.toml is missing, must be given"),
    ],
)
def test_a_machine_that_does_not_stand_is_refused(changes: dict[str, Any], words: str) -> None:
    assert refusal(changes).startswith(f"hexapod.{words}")


def test_cranks_point_somewhere() -> None:
    text = "\n".join(line for line in RIG.splitlines() if not line.startswith("heading_deg"))
    expected = r"cranks\.where the cranks point in rig\.toml is missing, must be one of points, heading_deg"
    with pytest.raises(InputError, match=expected):
        parse_platform(text, "rig.toml")


def test_there_must_be_legs_or_cranks() -> None:
    text = RIG[: RIG.index("[hexapod.cranks]")] + RIG[RIG.index("[hexapod.payload]") :]
    with pytest.raises(
        InputError, match=r"what moves the platform in rig\.toml is absent, must be one of legs"
    ):
        parse_platform(text, "rig.toml")
