import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from otolith.core.errors import InputError
from otolith.recordings.columns import STANDARD_GRAVITY, Header, candidates, missing, recognise


def chosen(*names: str, **mapping: str) -> dict[str, tuple[int, float]]:
    found = candidates(Header("log.csv", names, [""] * len(names)), mapping)
    return {key: (some[0].index, some[0].factor) for key, some in found.items() if some}


@pytest.mark.parametrize(
    ("name", "key", "factor"),
    [
        ("t_s", "t", 1.0),
        ("Time", "t", 1.0),
        ("time [s]", "t", 1.0),
        ("timestamp_ms", "t", 1e-3),
        ("Time (µs)", "t", 1e-6),
        ("ax_mps2", "ax", 1.0),
        ("AccX [m/s^2]", "ax", 1.0),
        ("accel_x (g)", "ax", STANDARD_GRAVITY),
        ("ax_g", "ax", STANDARD_GRAVITY),
        ("longitudinal acceleration", "ax", 1.0),
        ("Longitudinal Acceleration [mG]", "ax", STANDARD_GRAVITY / 1000),
        ("Linear Acceleration x (m/s²)", "ax", 1.0),
        ("Car.ax", "ax", 1.0),
        ("a_long_m_s2", "ax", 1.0),
        ("LatAccel", "ay", 1.0),
        ("Lat G", "ay", STANDARD_GRAVITY),
        ("G Force Lat", "ay", STANDARD_GRAVITY),
        ("gforce x [m/s2]", "ax", 1.0),
        ("G_VERT", "az", STANDARD_GRAVITY),
        ("vertAcc {ft/s2}", "az", 0.3048),
        ("RollRate", "roll_rate", 1.0),
        ("Gyroscope y (rad/s)", "pitch_rate", 1.0),
        ("yaw_rate_degps", "yaw_rate", math.pi / 180),
        ("Yaw Rate [°/s]", "yaw_rate", math.pi / 180),
        ("yaw rate (deg/s)", "yaw_rate", math.pi / 180),
        ("fx_mps2", "ax", 1.0),
        ("Specific Force y [g]", "ay", STANDARD_GRAVITY),
        ("Car.YawVel", "yaw_rate", 1.0),
        ("x_m", "x", 1.0),
        ("Position Y [km]", "y", 1000.0),
    ],
)
def test_names_tell_quantity_and_unit(name: str, key: str, factor: float) -> None:
    others = [column for column in ("t_s", "ax_mps2") if not column.startswith(f"{key}_")]
    assert chosen(name, *others)[key] == (0, pytest.approx(factor))


@pytest.mark.parametrize(
    "name",
    [
        "throttle",
        "latitude of start",
        "gx",
        "x",
        "Fx [N]",
        "x [mm/s]",
        "y [deg]",
        "steering angle [deg]",
        "lap time",
        "",
    ],
)
def test_other_names_tell_nothing(name: str) -> None:
    assert recognise(name) is None


@given(st.text(max_size=30))
def test_any_name_is_read_without_failing(name: str) -> None:
    recognise(name)


@pytest.mark.parametrize(
    ("mapping", "factor"),
    [
        ("Foo", 1.0),
        ("Foo:g", STANDARD_GRAVITY),
        ("-Foo:g", -STANDARD_GRAVITY),
        ("-Foo", -1.0),
        ("-neg", 1.0),
        ("with:colon", 1.0),
        ("with:colon:g", STANDARD_GRAVITY),
        ("ay_g", STANDARD_GRAVITY),
        ("-Bar [g]", -STANDARD_GRAVITY),
        ("group_g", STANDARD_GRAVITY),
        ("of_s", 1.0),
        ("Längs [mg]", STANDARD_GRAVITY / 1000),
        ("b_mps2", 1.0),
    ],
)
def test_a_mapping_goes_before_names(mapping: str, factor: float) -> None:
    """The unit in a name counts for every quantity of its kind; a mere letter of another kind does not."""
    names = (
        "t",
        "ax",
        "Foo",
        "-neg",
        "with:colon",
        "ay_g",
        "Bar [g]",
        "group_g",
        "of_s",
        "Längs [mg]",
        "b_mps2",
    )
    assert chosen(*names, ax=mapping)["ax"][1] == pytest.approx(factor)


def test_names_that_are_repeated_can_be_addressed() -> None:
    names = ("t", "acc", "speed", "acc")
    assert chosen(*names, ax="acc#2:g")["ax"] == (3, STANDARD_GRAVITY)
    assert chosen(*names, ax="-acc#1")["ax"] == (1, -1.0)
    with pytest.raises(
        InputError, match=r"ax=acc is the name of 2 columns, must be of one only \(write acc#1 or"
    ):
        chosen(*names, ax="acc")
    with pytest.raises(InputError, match=r"mapped to 'acc#3'"):
        chosen(*names, ax="acc#3")


def test_what_was_measured_goes_before_what_was_calculated_and_words_before_letters() -> None:
    names = ("GPS LatAcc", "LateralAcc", "y_acc", "Lat acc filtered", "LateralAcc [g]")
    units = [""] * 5
    found = candidates(Header("log.csv", names, units), {})["ay"]
    assert [column.index for column in found] == [4, 1, 3, 0, 2]
    found = candidates(Header("log.csv", ("ay", "ay"), ["g", "g"], origins=("100: gps", "101: acc")), {})[
        "ay"
    ]
    assert [column.index for column in found] == [1, 0]


def test_a_quantity_can_be_left_out() -> None:
    assert "az" not in chosen("t", "ax", "az", az="none")


def test_a_speed_in_another_kind_of_unit_is_none() -> None:
    assert "vx" not in chosen("t", "ax", "velocity [rpm]")
    assert chosen("t", "ax", "speed [km/h]")["vx"][1] == pytest.approx(1 / 3.6)


@pytest.mark.parametrize(
    ("key", "names", "sentence"),
    [
        (
            "ax",
            ("time", "foo"),
            "longitudinal acceleration (ax) in log.csv is missing, must be mapped as ax=NAME:UNIT, "
            "UNIT such as m/s2, NAME one of 'time', 'foo', or derived with ax=from-speed",
        ),
        (
            "t",
            ("ax", "foo"),
            "time (t) in log.csv is missing, must be mapped as t=NAME:UNIT, "
            "UNIT such as s, NAME one of 'ax', 'foo', or t=every:0.05s if the rows are evenly spaced",
        ),
        (
            "ax",
            ("t", "ax [furlong]", "accel_x (V)"),
            "longitudinal acceleration (ax) in log.csv is given only by 'accel_x (V)' in 'V', must be mapped "
            "as ax=NAME:UNIT, UNIT such as m/s2 (one of m/s2, g, mg, cm/s2, mm/s2, ft/s2), NAME one of 't', "
            "'ax [furlong]', 'accel_x (V)', or derived with ax=from-speed",
        ),
    ],
)
def test_what_is_missing_is_said_with_the_remedy(key: str, names: tuple[str, ...], sentence: str) -> None:
    assert key not in chosen(*names)
    assert str(missing(key, Header("log.csv", names, [""] * len(names)))) == sentence


@pytest.mark.parametrize(
    ("names", "mapping", "sentence"),
    [
        (
            ("t", "ax"),
            {"ay": "foo:g"},
            "ay in log.csv is mapped to 'foo:g', must be NAME or NAME:UNIT with NAME one of 't', 'ax'",
        ),
        (
            ("t", "ax"),
            {"axx": "ax"},
            "mapped quantity is 'axx', must be one of t, ax, ay, az, roll_rate, pitch_rate, yaw_rate, "
            "vx, x, y, lat, lon, heading, yaw (did you mean ax?)",
        ),
        (
            ("t", "foo [km/h]"),
            {"ax": "foo [km/h]"},
            "unit of 'foo [km/h]' in log.csv is 'km/h', must be one of m/s2, g, mg, cm/s2, mm/s2, ft/s2 "
            "(map it, for example ax=foo [km/h]:m/s2)",
        ),
    ],
)
def test_a_mapping_that_cannot_be_is_said_with_the_remedy(
    names: tuple[str, ...], mapping: dict[str, str], sentence: str
) -> None:
    with pytest.raises(InputError) as caught:
        chosen(*names, **mapping)
    assert str(caught.value) == sentence
