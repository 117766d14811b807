"""Geometries found from what a data sheet prints."""

import numpy as np
import pytest

from otolith.core.errors import InputError
from otolith.platforms import Platform, load, parse_platform
from otolith.platforms.fit import Fit, _Problem, as_toml, fit, table_of
from otolith.platforms.reach import reach
from tests.platforms.test_geometry import HEXAPOD

DAVSI = load("davsi")
STROKE = DAVSI.six_legs().stroke


def data_sheet() -> Platform:
    """A platform file that holds what a known machine reaches, and nothing of its legs."""
    ranges = reach(DAVSI.six_legs())
    lines = ['name = "sheet"']
    for axis, ends in ranges.items():
        if axis in {"surge", "sway", "heave"}:
            lines.append(f"{axis} = {{position_m = {list(ends)}, velocity_mps = 0.5, acceleration_mps2 = 5}}")
        else:
            lines.append(
                f"{axis} = {{angle_deg = {np.degrees(ends).tolist()}, rate_degps = 30, "
                "acceleration_degps2 = 200}"
            )
    return parse_platform("\n".join(lines), "sheet.toml")


@pytest.fixture(scope="module")
def fitted() -> Fit:
    return fit(data_sheet(), STROKE, starts=6, seed=0)


def test_a_sheet_that_a_machine_has_is_met(fitted: Fit) -> None:
    """Some regular machine meets it exactly: the one it was taken from, and others."""
    assert fitted.best.worst < 1e-6
    assert fitted.best.condition < 5.0
    assert 1 <= len(fitted.alike) <= fitted.starts


def test_what_is_written_is_read_as_the_machine_that_was_fitted(fitted: Fit) -> None:
    text = as_toml(fitted, STROKE)
    needed = {
        k: v
        for k, v in HEXAPOD.items()
        if f"# {k.rpartition('.')[2]} =" in text and not k.startswith("circles")
    }
    legs = "\n".join(f"{k.removeprefix('legs.')} = {v}" for k, v in needed.items() if k.startswith("legs."))
    payload = "\n".join(
        f"{k.removeprefix('payload.')} = {v}" for k, v in needed.items() if k.startswith("payload.")
    )
    text = text.replace("[hexapod.payload]", f"{legs}\n[hexapod.payload]\n{payload}")
    heave = "heave = {position_m = 0.3, velocity_mps = 0.5, acceleration_mps2 = 4}"
    platform = parse_platform(f'name = "r"\n{heave}\n{text}', "r.toml")
    found, wanted = reach(platform.six_legs()), reach(DAVSI.six_legs())
    for axis, (low, high) in wanted.items():
        errors = fitted.best.errors[axis]
        np.testing.assert_allclose(found[axis], [low * (1 + errors[0]), high * (1 + errors[1])], rtol=1e-4)
    assert platform.six_legs().speed == pytest.approx(fitted.leg_speed, rel=1e-3)


def test_equal_seeds_give_equal_geometries() -> None:
    one, other = (fit(data_sheet(), STROKE, starts=1, seed=3).best for _ in range(2))
    assert one == other


def test_a_table_of_few_axes_is_refused() -> None:
    with pytest.raises(InputError, match="axes of platform benchmark is surge, pitch, must be at least four"):
        fit(load("benchmark"), STROKE)


def test_four_axes_are_enough() -> None:
    four = data_sheet().model_copy(update={"surge": None, "sway": None})
    assert fit(four, STROKE, starts=3).best.worst < 1e-4


def test_the_search_grows_with_the_legs() -> None:
    """A machine twice as large is among the candidates where its half is; angles stay."""
    table = table_of(DAVSI)
    small, large = _Problem(table, (1.0, 1.5)), _Problem(table, (2.0, 3.0))
    lengths = np.array([2.0, 2.0, 1.0, 1.0, 2.0, 2.0, 2.0])  # of radii, half-angles, height, reference point
    np.testing.assert_allclose(large._high, lengths * small._high)
    np.testing.assert_allclose(large._low, lengths * small._low)


@pytest.mark.parametrize("ratio", [0.75, 1.3])
def test_the_search_holds_machines_of_usual_proportions(ratio: float) -> None:
    """Platforms from half to four thirds of a mean leg, bases to one and a half; 1 to 30 deg half-angles."""
    problem = _Problem(table_of(DAVSI), (1.0, 3.0))  # a mean leg of 2 m
    wide = np.array([2.9, 2.0 * ratio - 0.05, 25.0, 25.0, 1.9, 0.9, 0.9])
    assert np.all(problem._low < wide)
    assert np.all(wide < problem._high)


def test_speeds_that_the_file_does_not_give_are_left_open() -> None:
    result = fit(load("thesis").model_copy(update={"heave": DAVSI.heave, "yaw": DAVSI.yaw}), STROKE, starts=4)
    assert result.leg_speed is None
    assert "# speed_mps =   # please fill in" in as_toml(result, STROKE)


def test_machines_that_stand_badly_are_no_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("otolith.platforms.fit.WELL", 1.0)  # better than any machine
    with pytest.raises(
        InputError, match="fit of sheet is without a result in 1 starts, must be tried with more"
    ):
        fit(data_sheet(), STROKE, starts=1)
