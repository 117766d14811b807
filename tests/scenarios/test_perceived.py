import numpy as np
import pytest
from numpy.testing import assert_allclose

from otolith.core.arrays import Mat
from otolith.core.errors import InputError
from otolith.perception import otoliths, sense
from otolith.scenarios import Scenario, scenario
from otolith.scenarios.perceived import perceived


def telban(force: Mat, period: float) -> Mat:
    return sense(otoliths.telban(), force, period, before=force[0])


def test_a_pulse_is_felt_as_the_closed_form_says() -> None:
    """Step response of 0.4 (10 s + 1)/((5 s + 1)(0.016 s + 1)), by partial fractions."""
    felt = perceived(scenario("step-1"), telban, name="telban")
    t = np.linspace(1.1, 4.9, 50)
    k, T_a, T_L, T_S = 0.4, 10.0, 5.0, 0.016
    slow, quick = (T_L - T_a) / (T_L - T_S), (T_a - T_S) / (T_L - T_S)
    expected = k * (1.0 - slow * np.exp(-(t - 1.0) / T_L) * 1.0 - quick * np.exp(-(t - 1.0) / T_S))
    assert_allclose(felt.specific_force(t)[:, 0], expected, atol=1e-3)
    assert felt.origin.endswith("through telban")
    assert felt.duration == scenario("step-1").duration


def test_what_was_felt_before_the_start_has_settled() -> None:
    constant = Scenario(
        name="lean", duration=2.0, specific_force=lambda t: np.tile([1.0, -2.0, 0.0], (len(t), 1))
    )
    felt = perceived(constant, telban, name="telban").specific_force(np.array([0.0, 1.0]))
    assert_allclose(felt, [[0.4, -0.8, 0.0]] * 2, atol=1e-12)


def test_a_scenario_without_end_is_refused() -> None:
    endless = Scenario(name="endless", duration=1e5, specific_force=lambda t: np.zeros((len(t), 3)))
    with pytest.raises(InputError, match="duration of endless is 100000 s, must be at most 3600 s"):
        perceived(endless, telban, name="telban")
