"""The form: every setting says what it is, what it does and what it may be, and refuses in the same words."""

import re
from typing import Any

import pytest

from otolith import registry
from otolith.commander.rig import Rig
from otolith.commander.schema import LIVE, Form, bound_of, changed, checked, checked_as, schema
from otolith.core.errors import InputError
from otolith.cueing.mpc.rows import BrakingRows
from otolith.cueing.mpc.settings import Entry
from otolith.cueing.mpc.washout_weights import PRESETS
from otolith.cueing.prediction.named import PREDICTIONS

PROPERTIES: dict[str, Any] = schema()["properties"]
RIG: dict[str, Any] = schema((), Rig)["properties"]


@pytest.mark.parametrize("name", PROPERTIES)
def test_every_setting_has_title_group_unit_bound_and_effect(name: str) -> None:
    shown = PROPERTIES[name]
    assert shown["title"]
    assert shown["title"] != name
    assert shown["x-group"] in ("Input", "Platform", "Algorithm", "Run")
    assert isinstance(shown["x-unit"], str)
    assert isinstance(shown["x-live"], bool)
    assert len(shown["x-bound"]) > 5
    assert re.search(r"\(.+\) = \(.+\)", shown["description"])


@pytest.mark.parametrize("name", PROPERTIES)
def test_a_value_beyond_the_bound_is_refused_in_the_words_of_the_form(name: str) -> None:
    field = PROPERTIES[name]
    one = next((kind for kind in field.get("anyOf", [field]) if "maximum" in kind), field)
    beyond = [one[end] + step for end, step in (("minimum", -1), ("maximum", 1)) if end in one]
    for value in beyond or ["/etc/passwd " * 40]:
        with pytest.raises(InputError) as refused:
            checked({name: value})
        assert refused.value.field == name
        assert f"must be {bound_of(name)}" in str(refused.value)


def test_words_that_are_offered_are_those_that_the_program_knows() -> None:
    def offered(name: str) -> set[str]:
        return {word for word in PROPERTIES[name]["enum"] if word}

    assert offered("washout") == set(PRESETS)
    assert offered("braking") == set(BrakingRows)
    assert offered("guess_entry") == set(Entry)
    assert offered("prediction") == set(PREDICTIONS) - {"road"}
    assert offered("plant") == set(registry.PLANTS.own)
    assert offered("through") == {
        name.removeprefix("otolith-") for name in registry.PERCEPTION if "canal" not in name
    }


@pytest.mark.parametrize("name", RIG)
def test_every_setting_of_a_rig_says_what_it_is_and_refuses_in_its_own_words(name: str) -> None:
    shown = RIG[name]
    assert shown["title"] != name
    assert shown["x-group"] in ("Platform", "Device", "Telemetry", "First ride")
    assert re.search(r"\(.+\) = \(.+\)", shown["description"])
    wrong = {"number": 1e9, "integer": 1e9, "boolean": "perhaps"}.get(shown["type"], "/etc/passwd " * 40)
    with pytest.raises(InputError) as refused:
        checked_as(Rig, {name: wrong})
    assert refused.value.field == name
    assert f"must be {bound_of(name, Rig)}" in str(refused.value)


def test_code_from_outside_cannot_be_named() -> None:
    for name in ("evil:make", "evil.py:make", "../x.py:make"):
        with pytest.raises(InputError, match="cueing"):
            checked({"cueing": name})


def test_a_change_while_it_runs_is_checked_by_the_same_form() -> None:
    assert changed({"scale": 0.5}) == {"scale": 0.5}
    assert set(LIVE) == {name for name, one in PROPERTIES.items() if one["x-live"]}
    for values in ({}, {"platform": "davsi"}, {"scale": 1e9}, {"nonsense": 1.0}):
        with pytest.raises(InputError):
            changed(values)


def test_an_empty_form_is_the_default() -> None:
    assert checked({}) == Form()
