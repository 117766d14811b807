"""The form of a platform file: bounds and sentences are those of the file."""

import re
import tomllib
from typing import Any

import pytest

from otolith.commander.machine import ENTRIES, KINDS, field_of, form, text_of, values_of, within
from otolith.core.errors import InputError
from otolith.platforms import load, parse_platform
from otolith.platforms.template import template


@pytest.mark.parametrize("kind", KINDS)
def test_every_field_says_what_it_is_and_what_it_does(kind: Any) -> None:
    shown = form(kind)
    assert len(shown["properties"]) == len(ENTRIES[kind])
    for name, field in shown["properties"].items():
        assert field["title"] != name
        assert re.search(r"\(.+\) = \(.+\)", field["description"])
        assert name in shown["values"]


@pytest.mark.parametrize("kind", KINDS)
def test_the_template_goes_through_the_form_unchanged(kind: Any) -> None:
    text = text_of(form(kind)["values"], kind, "rig.toml")
    assert tomllib.loads(text) == tomllib.loads(template(kind))
    assert values_of(text, kind) == form(kind)["values"]


@pytest.mark.parametrize(
    ("kind", "entry"),
    [(kind, one) for kind in ("legs", "cranks") for one in ENTRIES[kind] if within(one.path)],
    ids=lambda value: value if isinstance(value, str) else value.name,
)
def test_a_value_beyond_its_bound_is_refused_in_the_words_of_a_platform_file(kind: Any, entry: Any) -> None:
    """The bounds of the form are where the file's own model begins to refuse."""
    bound = within(entry.path)
    assert bound is not None
    values = form(kind)["values"]
    for beyond in (0.99 * bound.low, 1.01 * bound.high):
        with pytest.raises(InputError) as refused:
            text_of(values | {entry.name: beyond}, kind, "rig.toml")
        assert field_of(refused.value).startswith(entry.name.removesuffix("_high").removesuffix("_low"))
        assert "in rig.toml is" in str(refused.value)


def test_without_a_way_there_is_no_axis() -> None:
    values = form("axes")["values"]
    assert values["pitch_rate_degps"] is not None
    one = values | {"pitch_angle_deg_low": None, "pitch_angle_deg_high": None}
    assert parse_platform(text_of(one, "axes", "x"), "x").axes == ("surge",)
    with pytest.raises(InputError, match=r"high end of pitch\.angle_deg in x is missing"):
        text_of(values | {"pitch_angle_deg_high": None}, "axes", "x")


def test_what_else_a_file_says_stays() -> None:
    before = template("axes").replace("# [workspace]\n# circle_m = 0.1 ", "[workspace]\ncircle_m = 0.1 ")
    text = text_of({"surge_velocity_mps": 0.25}, "axes", "x", before)
    platform = parse_platform(text, "x")
    assert platform.circle == 0.1
    assert platform.surge is not None
    assert platform.surge.velocity_mps == 0.25


def test_a_text_with_any_character_stays_when_it_is_saved_again() -> None:
    odd = "rig\x7f \x85 \u2028 \\"  # two"
    once = text_of({"description": odd}, "axes", "x")
    again = text_of({"surge_velocity_mps": 0.25}, "axes", "x", once)
    assert parse_platform(again, "x").description == odd


def test_both_ways_are_told_without_a_sign() -> None:
    values = values_of(
        "surge = {position_m = [-0.3, 0.2]}\nhexapod = {legs = {length_m = [0.5, 0.7]}}", "legs"
    )
    assert (values["surge_position_m_low"], values["surge_position_m_high"]) == (0.3, 0.2)
    assert (values["hexapod_legs_length_m_low"], values["hexapod_legs_length_m_high"]) == (0.5, 0.7)


def test_what_is_no_field_or_no_number_is_refused() -> None:
    velocity = "surge.velocity_mps in y"
    for values, field in (
        ({"x": 1.0}, "x"),
        ({"surge_velocity_mps": [1]}, velocity),
        ({"surge_velocity_mps": 10**400}, velocity),  # beyond any float, but JSON
        ({"description": "\ud800"}, "description in y"),  # half of a pair, which no file can hold
    ):
        with pytest.raises(InputError) as refused:
            text_of(values, "axes", "y")
        assert refused.value.field == field
    with pytest.raises(InputError, match="kind"):
        text_of({}, "wheels", "y")
    assert field_of(InputError("kind", "'wheels'", "one of two")) == ""
    assert load("davsi").axes  # shipped files need no form
