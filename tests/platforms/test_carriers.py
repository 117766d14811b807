import json
import math

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
