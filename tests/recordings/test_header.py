"""Where a table stands in a text, and which line is to blame where it cannot be found."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from otolith.core.errors import InputError
from otolith.recordings.checks.remedies import spelled
from otolith.recordings.columns import Header, candidates
from otolith.recordings.header import find
from otolith.recordings.table import split

ROWS = ["0.0,0.10,1", "0.1,0.20,2", "0.2,0.30,3", "0.3,0.40,4"]


def lines(*head: str, rows: list[str] = ROWS) -> list[str]:
    return [*head, *rows]


@pytest.mark.parametrize(
    ("head", "header", "units", "first"),
    [
        (["t,ax,ay"], 0, -1, 1),
        (["", "t,ax,ay", "", ""], 1, -1, 4),
        (["# made by a tool", "# of 3, 4, 5", "t,ax,ay"], 2, -1, 3),
        (["# t,ax,ay"], 0, -1, 1),
        (["% t ax ay"], 0, -1, 1),
        (["t,ax,ay", "s,g,g"], 0, 1, 2),
        (["s,g,g", "t,ax,ay"], 1, -1, 2),
        (["t,ax,ay", "[s],[m/s^2],[m/s^2]", "", "gps,acc,acc"], 0, 1, 4),
        (["Title", "Driver,Nobody", "Rate,20", "Laps,3", "t,ax,ay", "s,,g"], 4, 5, 6),
        (["Run,1,ok", "Date,2,3", "t,ax,ay"], 2, -1, 3),
        (["[header]", "time", "[column names]", "t ax ay", "", "[data]"], 3, -1, 6),
        (["alpha,beta,gamma", "names of nothing", "-----"], 0, -1, 3),
        (["t,ax", "time,ax,ay", "C1,C1,C1", "s,m/s^2,m/s^2"], 1, 3, 4),
    ],
)
def test_names_units_and_rows_are_found_by_their_content(
    head: list[str], header: int, units: int, first: int
) -> None:
    place = find(lines(*head), "log.csv")
    assert (place.header, place.unit_row, place.first) == (header, units, first)
    assert place.delimiter == ","
    assert len(place.names) == 3


@given(
    junk=st.lists(
        st.sampled_from(["", "A title", "Key,Value", "Duration,28", "# remark", "a;b", "Beacons,"])
    ),
    units=st.booleans(),
    blanks=st.integers(0, 3),
)
def test_whatever_stands_before_the_table_is_not_read(junk: list[str], units: bool, blanks: int) -> None:
    head = [*junk, "time,ax,ay", *(["s,g,g"] if units else []), *[""] * blanks]
    table = split("\n".join(lines(*head)), "log.csv")
    assert table.names == ["time", "ax", "ay"]
    assert table.units == (["s", "g", "g"] if units else ["", "", ""])
    assert table.body == ROWS
    assert list(table.lines) == list(range(len(head) + 1, len(head) + 5))


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (lines(), "line 1 of log.csv is numbers, must be the names of the columns"),
        (
            lines("t,ax"),
            "number of names in line 1 of log.csv is 2, must be 3, as in the rows from line 2 on "
            "(complete that line, or state the line of the names with --header LINE)",
        ),
        (
            lines("Title", "t,ax,ay,az", ""),
            "number of names in line 2 of log.csv is 4, must be 3, as in the rows from line 4 on "
            "(complete that line, or state the line of the names with --header LINE)",
        ),
        (
            lines("t,ax,ay", rows=[*ROWS, "0.4,0.5", *ROWS]),
            "number of values in line 6 of log.csv is 2, must be 3",
        ),
        (
            lines("t,ax,ay", rows=[*ROWS, "0.4,0.5,1,2"]),
            "number of values in line 6 of log.csv is 4, must be 3",
        ),
        (lines("t,ax,ay", "0.0,0.1", rows=ROWS), "number of values in line 2 of log.csv is 2, must be 3"),
        (
            lines("t,ax,ay", rows=["0,0,0,10,1,5", "0,1,0,20,2,5"]),
            "number of names in line 1 of log.csv is 3, must be 6, as in the rows from line 2 on "
            "(do commas mark decimals and also separate columns? then write decimal points)",
        ),
        (["t,ax", "a,b"], "number of rows in log.csv is 0, must be at least 2"),
    ],
)
def test_the_line_to_blame_is_named(text: list[str], sentence: str) -> None:
    with pytest.raises(InputError) as caught:
        split("\n".join(text), "log.csv")
    assert str(caught.value).startswith(sentence)


@pytest.mark.parametrize("end", ["", "\n", "\n\n"])
@pytest.mark.parametrize("torn", ["0.4", "0.4,0.5", "0.4,"])
def test_a_last_row_that_was_torn_off_is_left_out_and_said(torn: str, end: str) -> None:
    table = split("\n".join(lines("t,ax,ay", rows=[*ROWS, torn])) + end, "log.csv")
    assert table.body == ROWS
    cells = torn.count(",") + 1
    assert f"log.csv: the last row, line 6, is torn: {cells} of 3 cells; left out" in table.notes


@pytest.mark.parametrize("mark", [",", " ", "\t", ";"])
@pytest.mark.parametrize("quote", ["", '"'])
@pytest.mark.parametrize("header", [None, 1])
def test_numbers_of_rows_need_no_name_as_r_writes_them(mark: str, quote: str, header: int | None) -> None:
    names = mark.join(f"{quote}{name}{quote}" for name in ("t", "ax", "ay"))
    rows = [f"{quote}{i}{quote}{mark}{row.replace(',', mark)}" for i, row in enumerate(ROWS, 7)]
    table = split("\n".join([names, *rows]), "log.csv", header=header)
    assert table.names == ["row", "t", "ax", "ay"]
    assert [list(map(float, row.split(table.delimiter)))[1:] for row in table.body] == [
        list(map(float, row.split(","))) for row in ROWS
    ]


def test_values_without_a_name_are_no_numbers_of_rows() -> None:
    with pytest.raises(InputError, match=r"number of names in line 1 of log\.csv is 2, must be 3"):
        split("\n".join(["t,ax", "0,0.1,1", "50,0.2,2", "100,0.3,3"]), "log.csv")


@pytest.mark.parametrize(("e", "mark"), [("D", ","), ("d", " "), ("D", ";")])
def test_exponents_of_fortran_are_read(e: str, mark: str) -> None:
    rows = [mark.join(f"{float(c):.3E}".replace("E", e) for c in row.split(",")) for row in ROWS]
    table = split("\n".join([mark.join(("t", "ax", "ay")), *rows]), "log.csv")
    read = [list(map(float, line.split(table.delimiter))) for line in table.body]
    assert read == [list(map(float, row.split(","))) for row in ROWS]


def test_units_in_cells_reach_their_columns() -> None:
    rows = ["0.0 s,0.1 g,1", "0.1 s,0.2 g,2", "0.2 s,,3"]
    table = split("\n".join(["time,ax,ay", *rows]), "log.csv")
    assert (table.units, table.body) == (["s", "g", ""], ["0.0,0.1,1", "0.1,0.2,2", "0.2,,3"])


def test_a_user_states_the_lines_where_the_guess_fails() -> None:
    text = "\n".join(lines("time,ax,ay", "s,g,mg", "GPS time,x_acc,y_acc", "s,g,g"))
    assert split(text, "log.csv").names == ["GPS time", "x_acc", "y_acc"]
    with pytest.raises(InputError, match=r"number of rows"):
        split("\n".join(lines("time,ax,ay", rows=[])), "log.csv", header=1)
    table = split(text, "log.csv", header=1, units=2)
    assert (table.names, table.units) == (["time", "ax", "ay"], ["s", "g", "mg"])
    assert (table.layout.header, table.layout.units, table.layout.first) == ("line 1", "line 2", "line 5")
    with pytest.raises(InputError, match=r"--header is 99, must be a line of log.csv, 1 to 8"):
        split(text, "log.csv", header=99)
    with pytest.raises(InputError, match=r"number of names in line 1 of log.csv is 2"):
        split("\n".join(lines("one,two", "time,ax,ay")), "log.csv", header=1)


def test_blank_lines_and_comments_among_the_rows_are_left_out_and_said() -> None:
    table = split("\n".join(lines("t,ax,ay", rows=[*ROWS[:2], "", "# lap 2", *ROWS[2:], "# end"])), "log.csv")
    assert table.body == ROWS
    assert list(table.lines) == [2, 3, 6, 7]
    assert table.notes == ("log.csv: 1 blank lines and 2 comments among the data were left out",)


def test_rows_may_end_in_a_delimiter_that_the_names_lack() -> None:
    table = split("t;ax\n0;1;\n1;2;\n2;3;\n", "log.csv")
    assert table.names == ["t", "ax", ""]
    assert split("t,ax,speed\n0,1,\n1,,5\n2,3,\n", "log.csv").names == ["t", "ax", "speed"]


def test_quotes_may_hide_delimiters() -> None:
    table = split('t,ax,ay\n0,"1,5",2\n1,"2,5",3\n', "log.csv")
    assert table.cells([0, 2])[1].tolist() == [2.0, 3.0]  # type: ignore[union-attr]


@pytest.mark.parametrize(
    "text",
    [
        ["# t ax yaw_rate", "# s m/s^2", "0 1 2", "1 1 3", "2 1 2"],
        ["t,ax,yaw_rate", "s,m/s^2", *ROWS],
        ["t,ax,yaw_rate", "# s,m/s^2,deg/s,deg/s", *ROWS],
    ],
)
def test_units_that_are_not_one_for_each_column_are_refused(text: list[str]) -> None:
    """Left out, they would make rad/s of deg/s."""
    with pytest.raises(InputError, match=r"number of units in line 2 of log.csv is [24], must be 3.*--units"):
        split("\n".join(text), "log.csv")


def vbox(*names: str) -> Header:
    titles = [{"velocity": "velocity kmh", "Longacc": "Long accel g"}.get(name, name) for name in names]
    head = ["[header]", *titles, "", "[comments]", "x", "[column names]", " ".join(names), "", "[data]"]
    cells = {"time": "10000{}.00", "lat": "+03119.09{}", "long": "+00056.24{}", "heading": "12.{}"}
    rows = [" ".join(cells.get(name, "4.{}").format(i) for name in names) for i in range(4)]
    table = split("\n".join([*head, *rows]), "run.vbo")
    assert any("minutes of arc, west positive" in note for note in table.notes)
    return Header(table.source, table.names, table.units)


def test_a_vbox_files_coordinates_are_minutes_and_west_is_positive() -> None:
    found = candidates(vbox("sats", "time", "lat", "long", "heading"), {})
    assert found["lat"][0].factor == pytest.approx(np.pi / 180 / 60)
    assert found["lon"][0].factor == pytest.approx(-np.pi / 180 / 60)
    assert spelled(found["lon"][0]) == "long:arcmin west"
    assert spelled(found["lon"][0], -1.0) == "-long:arcmin west"


def test_a_vbox_files_coordinates_are_not_read_without_a_heading_that_confirms_them() -> None:
    """Some programs that write the form count east as positive, which would mirror the drive."""
    assert not {"lat", "lon"} & set(candidates(vbox("sats", "time", "lat", "long", "velocity"), {}))


def test_a_vbox_files_titles_hold_the_units_of_its_columns() -> None:
    found = candidates(vbox("sats", "time", "velocity", "Longacc"), {})
    assert (found["vx"][0].unit, found["ax"][0].unit) == ("kmh", "g")
