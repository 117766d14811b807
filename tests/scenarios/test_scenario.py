import numpy as np
import pytest
from numpy.testing import assert_array_equal

from otolith.core.errors import InputError
from otolith.scenarios import scenario
from otolith.scenarios.scenario import Scenario

T = np.linspace(0.0, 10.0, 101)


def ramp(t: np.ndarray) -> np.ndarray:
    return np.stack([t, 2 * t, 3 * t], axis=1)


def test_scaling_multiplies_force_and_rate_and_says_so() -> None:
    made = Scenario(
        name="ramp", duration=10.0, specific_force=ramp, angular_rate=ramp, origin="formula"
    ).scaled(0.5)
    assert_array_equal(made.specific_force(T), 0.5 * ramp(T))
    assert_array_equal(made.angular_rate(T), 0.5 * ramp(T))
    assert (made.name, made.duration, made.origin) == ("ramp", 10.0, "formula, scaled by 0.5")


def test_scaling_by_one_changes_nothing() -> None:
    made = scenario("sine-1")
    assert made.scaled(1.0) is made


@pytest.mark.parametrize("factor", [0.0, -1.0, 10.5, np.nan])
def test_a_scale_beyond_its_bound_is_refused(factor: float) -> None:
    with pytest.raises(InputError) as caught:
        scenario("sine-1").scaled(factor)
    assert str(caught.value) == f"scale is {factor}, must be greater than 0 and at most 10"
