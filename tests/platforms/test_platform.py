import contextlib
import math
import string
from pathlib import Path
from typing import get_args

import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from pydantic import BaseModel

import otolith
from otolith.core.errors import InputError
from otolith.core.frames import AXES, DOFS, SURGE_PITCH, SWAY_ROLL, Dof, pairs_of
from otolith.platforms import Braking, Platform, parse_platform

RIG = {
    "name": '"rig"',
    "surge.position_m": "[-0.1, 0.2]",
    "surge.velocity_mps": "0.5",
    "surge.acceleration_mps2": "4",
    "pitch.angle_deg": "[-10, 20]",
}


def toml(changes: dict[str, str] | None = None) -> str:
    fields = {**RIG, **(changes or {})}
    return "\n".join(f"{key} = {value}" for key, value in fields.items())


def refusal(text: str) -> str:
    with pytest.raises(InputError) as caught:
        parse_platform(text, "rig.toml")
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_one_number_means_both_ways() -> None:
    platform = parse_platform(toml({"surge.position_m": "0.3"}), "rig.toml")
    assert platform.limits(SURGE_PITCH)[0].position == (-0.3, 0.3)


def test_pitch_limits_turn_into_the_sign_of_the_longitudinal_tilt() -> None:
    """Positive pitch is nose-down and the tilt is nose-up, so the two bounds change places."""
    travel, tilt = parse_platform(toml(), "rig.toml").limits(SURGE_PITCH)
    assert travel.position == (-0.1, 0.2)
    assert_allclose(tilt.position, [-math.radians(20), math.radians(10)])


@pytest.mark.parametrize("pair", pairs_of(DOFS.values()), ids=lambda pair: pair.name)
@given(low=st.floats(-80, -1), high=st.floats(1, 80))
def test_tilt_limits_are_those_of_the_platforms_angle(pair: Dof, low: float, high: float) -> None:
    names = {0: "surge", 1: "sway"}[pair.translation], {3: "roll", 4: "pitch"}[pair.rotation]
    text = (
        f'name = "r"\n{names[0]} = {{position_m = 1, velocity_mps = 1, acceleration_mps2 = 1}}\n'
        f"{names[1]} = {{angle_deg = [{low!r}, {high!r}]}}"
    )
    tilt = parse_platform(text, "r").limits(pair)[1].position
    assert tilt[0] < 0 < tilt[1]
    assert_allclose(sorted(pair.sign * math.degrees(end) for end in tilt), [low, high])


def test_without_further_limits_command_is_the_acceleration_and_tilt_acceleration_is_free() -> None:
    travel, tilt = parse_platform(toml(), "rig.toml").limits(SURGE_PITCH)
    assert (travel.velocity, travel.acceleration, travel.command) == (0.5, 4.0, 4.0)
    assert tilt.acceleration == math.inf


@pytest.mark.parametrize(("machine", "expected"), [("2", 2.0), ("35", 3.0)])
def test_tilt_rate_is_the_machines_or_the_threshold_whichever_is_less(machine: str, expected: float) -> None:
    _, tilt = parse_platform(toml({"pitch.rate_degps": machine}), "rig.toml").limits(SURGE_PITCH)
    assert tilt.velocity == pytest.approx(math.radians(expected))


def test_degrees_become_radians() -> None:
    _, tilt = parse_platform(toml({"pitch.acceleration_degps2": "180"}), "r").limits(SURGE_PITCH)
    assert tilt.acceleration == pytest.approx(math.pi)


@pytest.mark.parametrize(
    ("line", "sentence"),
    [
        ("live = true", "live in rig.toml is unknown, must be one of name, description, surge, sway"),
        ("hexpod.neutral_height_m = 1", "hexpod in rig.toml is unknown, must be one of name"),
        ("surge.velocity_kmh = 3", "(did you mean velocity_mps?)"),
        ("pitch.rate_degs = 3", "(did you mean rate_degps?)"),
        ("tilt_coordination.pitch_rate = 3", "tilt_coordination.pitch_rate in rig.toml is unknown"),
        ("braking.position = 3", "(did you mean position_s?)"),
        ("workspace.radius_m = 3", "workspace.radius_m in rig.toml is unknown, must be one of circle_m"),
        ("actuators.lag = 3", "(did you mean lag_s?)"),
        ("hexapod.payload.mass = 3", "(did you mean mass_kg?)"),
    ],
)
def test_what_nothing_reads_is_refused_in_every_table(line: str, sentence: str) -> None:
    assert sentence in refusal(toml() + "\n" + line)


def test_every_field_of_the_file_is_read_somewhere() -> None:
    """A field that no line outside the tables of the file mentions would be one that does nothing."""
    package = Path(otolith.__file__).parent
    text = "\n".join(path.read_text("utf-8") for path in package.rglob("*.py"))
    models: list[type[BaseModel]] = [Platform]
    seen: set[str] = set()
    while models:
        model = models.pop()
        for name, field in model.model_fields.items():
            kinds = [field.annotation, *get_args(field.annotation)]
            models += [kind for kind in kinds if isinstance(kind, type) and issubclass(kind, BaseModel)]
            seen.add(name)
    unread = sorted(name for name in seen - set(AXES) if f".{name}" not in text)
    assert unread == []


def test_a_missing_axis_is_named() -> None:
    platform = parse_platform(toml(), "rig.toml")
    assert platform.axes == ("surge", "pitch")
    with pytest.raises(InputError) as caught:
        platform.limits(SWAY_ROLL)
    assert (
        str(caught.value) == "sway of platform rig is missing, must be in its file for sway-roll to be cued"
    )


@pytest.mark.parametrize(
    ("field", "value", "words"),
    [
        ("surge.velocity_mps", "-1", "is -1, must be greater than 0 m/s"),
        ("surge.velocity_mps", "0", "is 0, must be greater than 0 m/s"),
        ("surge.velocity_mps", "nan", "is nan, must be a finite number in m/s"),
        ("surge.velocity_mps", "inf", "is inf, must be a finite number in m/s"),
        ("surge.velocity_mps", "810", "is 810, must be between 0.005 and 20 m/s (is it in mm/s?)"),
        ("surge.velocity_mps", '"fast"', "is 'fast', must be a number in m/s"),
        ("surge.velocity_mps", "true", "is true, must be a number in m/s"),
        ("surge.position_m", "[0.1, 0.2]", "is [0.1, 0.2], must be [low, high] with low < 0 < high, in m"),
        ("surge.position_m", "[0.2, -0.1]", "is [0.2, -0.1], must be [low, high] with low < 0 < high, in m"),
        ("surge.position_m", "[-0.1, 0, 1]", "is [-0.1, 0, 1], must be one number, or [low, high], in m"),
        ("surge.position_m", "510", "is 510, must be between 0.005 and 20 m (is it in mm?)"),
        ("pitch.angle_deg", "0.42", "is 0.42, must be between 1 and 89 deg (is it in rad?)"),
        ("pitch.angle_deg", "90", "is 90, must be between 1 and 89 deg"),
        ("pitch.rate_degps", "0.6", "is 0.6, must be between 1 and 500 deg/s (is it in rad/s?)"),
        ("pitch.acceleration_degps2", "4.5", "is 4.5, must be between 5 and 10000 deg/s2 (is it in rad/s2?)"),
        ("tilt_coordination.pitch_degps", "11", "is 11, must be between 0.5 and 10 deg/s"),
        (
            "tilt_coordination.roll_degps",
            "0.05",
            "is 0.05, must be between 0.5 and 10 deg/s (is it in rad/s?)",
        ),
        ("braking.position_s", "2500", "is 2500, must be between 0.05 and 20 s (is it in ms?)"),
        ("name", "3", "is 3, must be a text in quotes"),
        ("name", '""', "is '', must be a text of at least 1 character"),
        ("sway", "1", "is 1, must be a table of fields"),
        ("workspace.circle_m", "-0.5", "is -0.5, must be greater than 0 m"),
        ("heave.position_m", "[]", "is [], must be one number, or [low, high], in m"),
        (
            "surge.command_mmps2",
            "5",
            "is unknown, must be one of position_m, velocity_mps, acceleration_mps2, command_mps2 "
            "(did you mean command_mps2?)",
        ),
    ],
)
def test_a_wrong_value_names_field_value_bound_and_unit(field: str, value: str, words: str) -> None:
    assert refusal(toml({field: value})) == f"{field} in rig.toml {words}"


def test_a_misspelt_name_goes_before_the_field_it_leaves_missing() -> None:
    text = 'name = "r"\n[surge]\nvelocty_mps = 1'
    assert refusal(text).startswith("surge.velocty_mps in rig.toml is unknown")
    assert (
        refusal(text.replace("velocty", "velocity"))
        == "surge.position_m in rig.toml is missing, must be given"
    )


def test_a_platform_must_move() -> None:
    expected = (
        "the set of axes in rig.toml is empty, must be at least one of surge, sway, heave, roll, pitch, yaw"
    )
    assert refusal('name = "rock"') == expected


def test_integers_beyond_a_float_are_refused() -> None:
    expected = f"surge.velocity_mps in rig.toml is 1{'0' * 39}…, must be a finite number in m/s"
    assert refusal(toml({"surge.velocity_mps": "1" + "0" * 400})) == expected
    assert refusal("a = 1" + "0" * 5000).startswith("length of line 1 of rig.toml is 5,005 characters")
    assert refusal("a = 1" + "0" * 1900).startswith("a in rig.toml is unknown, must be one of")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            'name = "r"\nvelocity 3',
            "line 2 of rig.toml is 'velocity 3', must be valid TOML "
            "(expected '=' after a key in a key/value pair)",
        ),
        ("a = 1\na = 2", "line 2 of rig.toml is 'a = 2', must be valid TOML (cannot overwrite a value)"),
        ("name =", "line 1 of rig.toml is 'name =', must be valid TOML (invalid value)"),
    ],
)
def test_broken_syntax_is_quoted_with_its_line(text: str, expected: str) -> None:
    assert refusal(text) == expected


@given(st.text(alphabet=string.printable, max_size=60))
def test_any_text_gives_a_platform_or_is_refused(text: str) -> None:
    with contextlib.suppress(InputError):
        parse_platform(text, "rig.toml")


def test_nesting_beyond_reason_is_refused() -> None:
    assert refusal("a = " + "[" * 1_900).startswith("a value in rig.toml is nested too deeply")


@pytest.mark.parametrize("name", ["c_v", "c_w"])
def test_a_braking_law_that_oscillates_is_refused(name: str) -> None:
    expected = (
        f"braking.{name}^2/c_u in rig.toml is 1.8, "
        "must be at least 2, or the braking law oscillates and overshoots the limit"
    )
    assert refusal(toml({f"braking.{name}": "0.9"})) == expected


def test_braking_at_the_bound_is_critically_damped() -> None:
    """(c_u T²/2) e″ + c_v T e′ + e = 0 has a double root exactly where c_v²/c_u = 2."""
    law = Braking(c_v=1.0, c_w=1.0, c_u=0.5, position_s=2.5)
    discriminant = (law.c_v * law.position_s) ** 2 - 4 * (law.c_u * law.position_s**2 / 2)
    assert discriminant == pytest.approx(0.0)


def test_a_platform_survives_json() -> None:
    platform = parse_platform(toml({"workspace.circle_m": "0.1"}), "rig.toml")
    assert Platform.model_validate_json(platform.model_dump_json()) == platform
    assert hash(platform) == hash(Platform.model_validate_json(platform.model_dump_json()))
