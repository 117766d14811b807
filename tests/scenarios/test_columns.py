import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from otolith.core.errors import InputError
from otolith.scenarios.columns import STANDARD_GRAVITY, choose, recognise


def chosen(*names: str, **mapping: str) -> dict[str, tuple[int, float]]:
    columns = choose(names, "log.csv", mapping, [""] * len(names))
    return {column.key: (column.index, column.factor) for column in columns}


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
    ["throttle", "lat", "gx", "x", "Fx [N]", "x [mm/s]", "y [deg]", "steering angle [deg]", "lap time", ""],
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
    ],
)
def test_a_mapping_goes_before_names(mapping: str, factor: float) -> None:
    """The unit in a name counts only for the quantity that the name tells."""
    assumed = 1.0 if mapping == "ay_g" else factor
    assert chosen("t", "ax", "Foo", "-neg", "with:colon", "ay_g", ax=mapping)["ax"][1] == assumed


def test_twins_are_taken_once_and_others_refused() -> None:
    names = ("t", "ax", "Car.YawRate [rad/s]", "Car.YawVel [deg/s]")
    columns = choose(names, "log.csv", {}, [""] * 4, differ=lambda one, other: False)
    yaw = next(column for column in columns if column.key == "yaw_rate")
    assert yaw.index == 2
    assert str(yaw).endswith("in rad/s (the same as 'Car.YawVel [deg/s]')")
    with pytest.raises(InputError, match=r"yaw_rate in log.csv is given by"):
        choose(names, "log.csv", {}, [""] * 4)


def test_a_quantity_can_be_left_out() -> None:
    assert "az" not in chosen("t", "ax", "az", az="none")


def test_a_doubtful_speed_is_ignored_for_it_only_serves_checks() -> None:
    assert "vx" not in chosen("t", "ax", "speed", "vx")
    assert "vx" not in chosen("t", "ax", "velocity [rpm]")
    assert chosen("t", "ax", "speed [km/h]")["vx"][1] == pytest.approx(1 / 3.6)


@pytest.mark.parametrize(
    ("names", "mapping", "sentence"),
    [
        (
            ("time", "foo"),
            {},
            "longitudinal acceleration (ax) in log.csv is missing, must be mapped as ax=NAME:UNIT, "
            "UNIT such as m/s2, NAME one of 'time', 'foo'",
        ),
        (
            ("ax", "foo"),
            {},
            "time (t) in log.csv is missing, must be mapped as t=NAME:UNIT, "
            "UNIT such as s, NAME one of 'ax', 'foo'",
        ),
        (
            ("t", "ax", "accel_x"),
            {},
            "ax in log.csv is given by 'ax' (column 2) and 'accel_x' (column 3), "
            "must be one column (rename one, or map ax=NAME)",
        ),
        (("t", "q", "q"), {"ax": "q"}, "ax=q is the name of 2 columns, must be of one only"),
        (
            ("t", "ax"),
            {"ay": "foo:g"},
            "ay in log.csv is mapped to 'foo:g', must be NAME or NAME:UNIT with NAME one of 't', 'ax'",
        ),
        (
            ("t", "ax"),
            {"axx": "ax"},
            "mapped quantity is 'axx', must be one of t, ax, ay, az, roll_rate, pitch_rate, yaw_rate, "
            "vx, x, y (did you mean ax?)",
        ),
        (
            ("t", "ax [furlong]"),
            {},
            "unit of 'ax [furlong]' in log.csv is 'furlong', must be one of m/s2, g, mg, cm/s2, mm/s2, ft/s2 "
            "(map it, for example ax=ax [furlong]:m/s2)",
        ),
    ],
)
def test_what_cannot_be_told_is_said_with_the_remedy(
    names: tuple[str, ...], mapping: dict[str, str], sentence: str
) -> None:
    with pytest.raises(InputError) as caught:
        chosen(*names, **mapping)
    assert str(caught.value) == sentence
