import json
import math

import numpy as np
import pytest

from otolith.core.errors import InputError
from otolith.core.frames import BASES, DOFS, HEAVE, SURGE_PITCH, SWAY_ROLL, YAW, bases_of
from otolith.platforms import Platform, load, parse_platform

RIG = """
name = "rig"
[surge]
position_m = 0.2
velocity_mps = 0.5
acceleration_mps2 = 4.0
[pitch]
angle_deg = 10.0
"""
RAIL = """
[base.surge]
position_m = [-1.0, 2.0]
velocity_mps = 1.5
acceleration_mps2 = 3.0
"""


def test_the_rail_and_the_tilt_of_ultimate_are_those_of_eq_c4() -> None:
    ultimate = load("ultimate")
    (rail,) = ultimate.limits(BASES[0])
    _, tilt = ultimate.limits(SURGE_PITCH)
    assert (rail.position, rail.velocity, rail.acceleration) == ((-2.6, 2.6), 3.0, 5.0)
    assert [math.degrees(value) for value in (tilt.position[1], tilt.velocity, tilt.acceleration)] == (
        pytest.approx([10.0, 6.0, 15.0])
    )


def test_a_base_carries_the_axes_that_it_has_and_no_others() -> None:
    assert load("ultimate").bases(DOFS.values()) == (BASES[0], BASES[1])
    assert load("tripod").bases((SWAY_ROLL, HEAVE, YAW)) == (BASES[1], BASES[5])
    assert load("davsi").bases(DOFS.values()) == ()
    assert bases_of((HEAVE,)) == ()
    assert [dof.feels_rate for dof in BASES.values()] == [False, False, True]
    assert all(dof.is_base for dof in BASES.values())
    assert not any(dof.is_base for dof in DOFS.values())


def test_its_limits_are_its_own() -> None:
    rig = parse_platform(RIG + RAIL, "rig.toml")
    (rail,) = rig.limits(BASES[0])
    assert (rail.position, rail.velocity, rail.command) == ((-1.0, 2.0), 1.5, 3.0)
    assert rig.limits(SURGE_PITCH)[0].position == (-0.2, 0.2)


def test_the_record_of_a_platform_without_a_base_names_none_and_one_with_a_base_comes_back() -> None:
    """Digests of laws, hints and permits are of the record, so it stays what it was."""
    assert "base" not in json.loads(load("thesis").model_dump_json())
    for name in ("tripod", "ultimate"):
        assert Platform.model_validate_json(load(name).model_dump_json()) == load(name)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[base]\nlag_s = 0.05", "base.the set of axes in rig.toml is empty, must be at least one of"),
        ("[base.heave]\nposition_m = 1.0", "base.heave in rig.toml is unknown, must be one of"),
        ("[base.yaw]\nangle_deg = 20.0", "base.rate or acceleration in rig.toml is missing, must be given"),
        (RAIL + "[base]\nweight = -1.0", "base.weight in rig.toml is -1.0, must be greater than 0"),
    ],
)
def test_what_is_wrong_with_a_base_is_one_sentence(text: str, said: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_platform(RIG + text, "rig.toml")
    assert str(caught.value).startswith(said)


def test_an_axis_or_a_base_that_is_missing_is_named() -> None:
    with pytest.raises(InputError, match="sway of the base is missing"):
        parse_platform(RIG + RAIL, "rig.toml").limits(BASES[1])
    with pytest.raises(InputError, match=r"\[base\] of platform rig is missing"):
        parse_platform(RIG, "rig.toml").limits(BASES[0])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("surge = 1.0\nat_most_m = 0.5", r"base_surge or base_sway in rig.toml is 0, must be other than 0"),
        (
            "base_surge = 1.0\nsurge = 1.0\nat_most_m = 0.1",
            r"\.0\.at_most_m in rig.toml is 0.1, must be at least 0.2 m",
        ),
        ("base_surge = 1.0", r"base.interference.0.at_most_m in rig.toml is missing"),
        (
            "base_sway = 1.0\nat_most_m = 0.5",
            r"0\.base_sway in rig.toml is 1.0, must be 0: the base has no sway",
        ),
        (
            "base_surge = 1.0\nheave = 1.0\nat_most_m = 1",
            r"0\.heave in rig.toml is 1.0, must be 0: the platform has",
        ),
        ("base_surge = 1.0\nat_most_m = 500", r"0\.at_most_m in rig.toml is 500, must be between .* m"),
        ("base_surge = 1.0\npitch = 1.0\nat_most_m = 1", r"interference.0.pitch in rig.toml is unknown"),
    ],
)
def test_interference_that_makes_no_sense_is_refused(text: str, words: str) -> None:
    with pytest.raises(InputError, match=words) as refused:
        parse_platform(f"{RIG}{RAIL}[[base.interference]]\n{text}\n", "rig.toml")
    assert "\n" not in str(refused.value)


def test_interference_comes_back_and_a_circle_makes_the_platforms_own_reach_smaller() -> None:
    text = f"{RIG}{RAIL}[[base.interference]]\nsurge = -2.0\nbase_surge = 1.0\nat_most_m = 0.4\n"
    rig = parse_platform(text, "rig.toml")
    assert Platform.model_validate_json(rig.model_dump_json()) == rig
    assert "interference" not in load("tripod").model_dump_json()
    diagonal = np.array([1.0, 1.0, 0.0])
    assert load("tripod").farthest(diagonal) == pytest.approx(0.165 * math.sqrt(2.0))
    assert load("ultimate").farthest(diagonal) == 0.5
