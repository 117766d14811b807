"""What a program may be called."""

import pytest

from otolith.core.errors import InputError
from otolith.export.program import Program


@pytest.mark.parametrize("name", ["", "2nd", "motion-cueing", "int", "this", "größe", "a b", "x" * 41, "_x"])
def test_a_name_that_c_does_not_take_is_refused(name: str) -> None:
    with pytest.raises(InputError, match="name of the program"):
        Program(name=name, period=0.01, inputs=(), outputs=(), header="")


def test_a_name_of_c_is_taken() -> None:
    assert Program(name="cueing_2", period=0.01, inputs=(), outputs=(), header="").name == "cueing_2"
