"""What a user says of a log, once: it goes into a file and comes back."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from otolith.core.errors import InputError
from otolith.recordings.columns import QUANTITIES
from otolith.recordings.settings import PLAIN, LogSettings, settings_from_toml, settings_to_toml

LINES = st.none() | st.integers(0, 500)
NAMES = st.text(min_size=1, max_size=20).filter(lambda text: text.isprintable())


@given(
    columns=st.dictionaries(st.sampled_from(list(QUANTITIES)), st.text(min_size=1, max_size=20), max_size=6),
    header=LINES,
    units=LINES,
    axes=st.sampled_from([None, "iso", "sae"]),
    events=st.sampled_from(["refuse", "mark", "cut"]),
    offsets=st.sampled_from(["keep", "remove"]),
)
def test_a_mapping_file_gives_back_what_was_written(
    columns: dict[str, str],
    header: int | None,
    units: int | None,
    axes: str | None,
    events: str,
    offsets: str,
) -> None:
    settings = LogSettings(
        columns=columns, header=header, units=units, axes=axes, events=events, offsets=offsets
    )
    assert settings_from_toml(settings_to_toml(settings, "drive.csv"), "map.toml") == settings


def test_what_is_as_by_default_is_not_written() -> None:
    assert settings_to_toml(PLAIN, "drive.csv").splitlines()[1:] == ["", "[columns]"]


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("axes = ", "mapping map.toml is not TOML"),
        ('axis = "sae"', "field of map.toml is 'axis', must be one of"),
        ("axes = 3", "axes in map.toml is 3, must be of kind str"),
        ('axes = "nautical"', "--axes is 'nautical', must be one of iso, sae"),
        ('events = "drop"', "--events is 'drop', must be one of refuse, mark, cut"),
        ('offsets = "level"', "--offsets is 'level', must be keep or remove"),
        ("header = true", "header in map.toml is True, must be of kind int"),
        ('[columns]\na_x = "Acc"', "columns.a_x in map.toml is 'Acc', must be a text for one of"),
        ("[columns]\nax = 3", "columns.ax in map.toml is 3, must be a text"),
    ],
)
def test_a_wrong_mapping_file_is_refused_in_a_sentence(text: str, sentence: str) -> None:
    with pytest.raises(InputError) as caught:
        settings_from_toml(text, "map.toml")
    assert sentence in str(caught.value)
    assert "\n" not in str(caught.value)
