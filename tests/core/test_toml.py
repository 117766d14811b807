"""Values as TOML writes them, against the reader of the standard library."""

import tomllib

from hypothesis import given
from hypothesis import strategies as st

from otolith.core.toml import toml_value

TEXTS = st.text(st.characters(codec="utf-8"), max_size=20)
ALONE = [chr(code) for code in (*range(0xA0), 0x2028, 0x2029)]


@given(
    value=st.one_of(TEXTS, st.booleans(), st.floats(allow_nan=False, allow_infinity=False), st.lists(TEXTS))
)
def test_what_is_written_is_read_again(value: str | float | list[str]) -> None:
    assert tomllib.loads(f"one = {toml_value(value)}") == {"one": value}


def test_no_character_ends_the_line_or_the_file() -> None:
    for one in ALONE:
        text = f"one = {toml_value(one)}"
        assert tomllib.loads(text) == {"one": one}
        assert text.splitlines() == [text]
