"""Units in the cells themselves reach the column; what is no unit, or contradicts, stays text."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from otolith.recordings.inscribed import measured, without_units


@pytest.mark.parametrize(
    ("cell", "parts"),
    [
        ("12.3 km/h", ("12.3", "km/h")),
        ("-0.02g", ("-0.02", "g")),
        ("1e-3 m/s²", ("1e-3", "m/s²")),
        ("0,5 °/s", ("0,5", "°/s")),
        ("12.3", None),
        ("12.3 parsecs", None),
        ("10:00:00", None),
        ("km/h", None),
        ("", None),
    ],
)
def test_a_cell_is_parted_into_number_and_unit(cell: str, parts: tuple[str, str] | None) -> None:
    assert measured(cell) == parts


@given(st.lists(st.floats(-1e3, 1e3), min_size=2, max_size=9), st.sampled_from(["km/h", "mph", "m/s"]))
def test_numbers_survive_and_the_unit_is_told(values: list[float], unit: str) -> None:
    rows, units = without_units([f"{i},{v!r} {unit}" for i, v in enumerate(values)], ",", ["", ""])
    assert [float(row.split(",")[1]) for row in rows] == values
    assert units == ["", unit]


def test_cells_that_follow_the_stated_unit_are_read() -> None:
    assert without_units(["1 km/h;2", ";3"], ";", ["kph", ""]) == (["1;2", ";3"], ["kph", ""])


@pytest.mark.parametrize(
    ("body", "stated"),
    [(["1 km/h,2", "1 mph,2"], ["", ""]), (["1 km/h,2", "2 km/h,2"], ["m/s", ""])],
)
def test_contradicting_units_leave_the_column_as_text(body: list[str], stated: list[str]) -> None:
    assert without_units(body, ",", stated) == (body, stated)
