import math

import pytest

from otolith.core.errors import InputError
from otolith.core.frames import GRAVITY
from otolith.vehicle import load_car, parse_car


def toml() -> str:
    from importlib.resources import files

    return (files("otolith.vehicle") / "data" / "tesla-model-s.toml").read_text("utf-8")


def test_the_shipped_car_has_the_values_of_table_c7_and_marks_the_rest_as_estimates() -> None:
    body, friction = load_car().body, load_car().tyres.friction
    published = {
        "mass_kg": 2108.0,
        "cg_to_rear_axle_m": 1.5,
        "cg_to_front_axle_m": 1.47,
        "yaw_inertia_kgm2": 1585.3,
        "cg_height_m": 0.545,
        "track_m": 1.70,
    }
    assert {name: getattr(body, name) for name in published} == published
    assert friction == 1.0
    given = {f"body.{name}" for name in published} | {"tyres.friction"}
    dumped = load_car().model_dump()
    fields = {
        f"{table}.{name}" for table, values in dumped.items() if isinstance(values, dict) for name in values
    }
    estimates = set(load_car().estimates)
    marked = {name for name in fields if name in estimates or name.split(".")[0] in estimates}
    assert marked == fields - given


def test_static_loads_carry_the_car_in_balance() -> None:
    p = load_car().numbers()
    assert 2.0 * (p.F_f + p.F_r) == pytest.approx(p.m * GRAVITY)
    assert p.F_f * p.l_f == pytest.approx(p.F_r * p.l_r)


def test_the_understeer_gradient_is_that_of_the_axles_stiffnesses() -> None:
    """K = (m/L) (l_r/C_f − l_f/C_r), C the sum of both tyres' slopes at their static loads."""
    car = load_car()
    p = car.numbers()
    at_static = math.sin(2.0 * math.atan(1.0 / p.z_stiff))
    C_f, C_r = 2.0 * p.K_f * p.F_f * at_static, 2.0 * p.K_r * p.F_r * at_static
    expected = p.m / car.wheelbase * (p.l_r / C_f - p.l_f / C_r)
    assert car.understeer_gradient == pytest.approx(expected)


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("mass_kg = 2108.0", "mass_kg = 2.108", "body.mass_kg in car.toml is 2.108, must be between 200"),
        ("mass_kg = 2108.0", "mass = 2108.0", "body.mass"),
        ("cg_height_m = 0.545", "cg_height_m = 545", "(is it in mm?)"),
        ("lag_s = 0.06", "lag_s = 60.0", "(is it in ms?)"),
        (
            '"steering",',
            '"wheels",',
            "estimates in car.toml is 'wheels', must be the name of a table or field",
        ),
        ("[body]", "[body", "line"),
        ("shape = 1.4", "shape = true", "tyres.shape"),
    ],
)
def test_a_car_that_cannot_be_is_refused(old: str, new: str, sentence: str) -> None:
    text = toml()
    assert old in text
    with pytest.raises(InputError) as caught:
        parse_car(text.replace(old, new, 1), "car.toml")
    assert sentence in str(caught.value)
