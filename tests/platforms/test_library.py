import math

import pytest

from otolith.core.errors import InputError
from otolith.core.frames import AXES, DOFS, SURGE_PITCH, SWAY_ROLL
from otolith.platforms import Braking, catalog, load


def test_the_shipped_platforms_are_listed() -> None:
    assert {"davsi", "thesis"} <= set(catalog())
    assert list(catalog()) == sorted(catalog())


@pytest.mark.parametrize("name", catalog())
def test_every_shipped_platform_loads_under_its_own_name_and_describes_itself(name: str) -> None:
    platform = load(name)
    assert platform.name == name
    assert platform.description
    pairs = [
        dof for dof in DOFS.values() if dof.is_pair and {AXES[i] for i in dof.axes} <= set(platform.axes)
    ]
    assert pairs
    for pair in pairs:
        platform.limits(pair)


def test_the_thesiss_limits_are_those_of_its_equations() -> None:
    """Eqs. 4.3, 4.10 and 4.17; the braking law below eqs. 4.7 and 4.8."""
    thesis = load("thesis")
    for pair, threshold in ((SURGE_PITCH, 3.0), (SWAY_ROLL, 2.6)):
        travel, tilt = thesis.limits(pair)
        assert travel.position == (-0.5, 0.5)
        assert (travel.velocity, travel.acceleration, travel.command) == (7.2, 9.81, 5.0)
        assert tilt.position == pytest.approx((-math.pi / 6, math.pi / 6))
        assert tilt.acceleration == math.inf
        assert math.degrees(tilt.velocity) == pytest.approx(threshold)
    assert thesis.braking == Braking(c_v=1.0, c_w=1.0, c_u=0.45, position_s=2.5, tilt_s=0.5)
    assert thesis.circle == 0.5


def test_the_davsis_limits_are_those_of_its_table() -> None:
    """Table 6.1, and for pitch and roll the smaller of the two rows that look swapped."""
    davsi = load("davsi")
    travel, tilt = davsi.limits(SURGE_PITCH)
    assert travel.position == (-0.51, 0.63)
    assert (travel.velocity, travel.acceleration, travel.command) == (0.81, 7.1, 7.1)
    assert math.degrees(tilt.position[1]) == pytest.approx(24.3)
    assert math.degrees(tilt.acceleration) == pytest.approx(260.0)
    assert davsi.axes == ("surge", "sway", "heave", "roll", "pitch", "yaw")


def test_an_unknown_platform_is_refused_with_the_ones_there_are() -> None:
    with pytest.raises(InputError) as caught:
        load("davsy")
    names = ", ".join(catalog())
    assert str(caught.value) == f"platform is 'davsy', must be one of {names} (did you mean davsi?)"
