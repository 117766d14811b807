"""A template that is filled is the template with other values, and nothing else."""

import tomllib
from typing import get_args

import pytest

from otolith.platforms import parse_platform
from otolith.platforms.template import Kind, Value, filled, template


@pytest.mark.parametrize("kind", get_args(Kind))
def test_without_values_a_file_stays_as_it_is(kind: Kind) -> None:
    assert filled(template(kind), {}) == template(kind)


def test_only_what_is_given_changes_and_comments_stay() -> None:
    text = filled(template("axes"), {"surge.velocity_mps": 0.3, "name": 'a "rig" # of mine'})
    before, after = tomllib.loads(template("axes")), tomllib.loads(text)
    assert after.pop("name") == 'a "rig" # of mine'
    assert after["surge"].pop("velocity_mps") == 0.3
    before.pop("name")
    before["surge"].pop("velocity_mps")
    assert after == before
    comments = [line.partition("#")[2] for line in template("axes").splitlines()]
    assert [line.partition("#")[2] for line in text.splitlines()][12:] == comments[12:]


def test_an_axis_comes_and_goes() -> None:
    sway: dict[str, Value] = {
        "sway.position_m": (-0.1, 0.2),
        "sway.velocity_mps": 0.2,
        "sway.acceleration_mps2": 2.0,
    }
    gone: dict[str, Value] = {
        f"pitch.{key}": None for key in ("angle_deg", "rate_degps", "acceleration_degps2")
    }
    text = filled(template("axes"), sway | gone)
    platform = parse_platform(text, "rig.toml")
    assert platform.axes == ("surge", "sway")
    assert platform.sway is not None
    assert platform.sway.position_m == (-0.1, 0.2)
    back = filled(text, dict.fromkeys(sway) | {"pitch.angle_deg": (-12.0, 12.0)})
    assert parse_platform(back, "rig.toml").axes == ("surge", "pitch")


def test_a_field_or_a_table_that_is_not_there_is_put_in() -> None:
    roll: dict[str, Value] = {"roll.angle_deg": (-3.0, 3.0), "roll.rate_degps": 9.0}
    text = filled(
        'name = "x"\n[surge]\nposition_m = 1.0\nvelocity_mps = 1.0\nacceleration_mps2 = 1.0\n', roll
    )
    assert tomllib.loads(text)["roll"] == {"angle_deg": 3.0, "rate_degps": 9.0}
    assert tomllib.loads(filled(text, {"surge.command_mps2": 0.5}))["surge"]["command_mps2"] == 0.5
