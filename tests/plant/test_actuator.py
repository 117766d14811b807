import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from otolith.core.errors import InputError
from otolith.interfaces import PlatformState
from otolith.plant.actuator import Actuator, actuator
from otolith.plant.ideal import Ideal
from otolith.platforms import load
from tests.plant.test_ideal import commanding


def test_a_step_is_followed_a_dead_time_later_in_closed_form() -> None:
    T, dead, t = 0.02, 0.0137, 0.05
    plant, command = Actuator(lag=T, dead_time=dead), commanding(2.0)
    for _ in range(50):
        state = plant.step(command, t / 50)
    late = t - dead
    assert_allclose(state.acceleration, 2.0 * (1 - np.exp(-late / T)), atol=1e-9)
    assert_allclose(state.twist, 2.0 * (late - T * (1 - np.exp(-late / T))), atol=1e-9)


@settings(derandomize=True, max_examples=30, deadline=None)
@given(st.lists(st.floats(-5.0, 5.0), min_size=8, max_size=30), st.integers(0, 5))
def test_a_dead_time_of_whole_steps_is_the_ideal_platform_shifted(commands: list[float], late: int) -> None:
    dt, prompt, tardy = 0.01, Ideal(), Actuator(dead_time=0.01 * late)
    ahead = [prompt.step(commanding(u), dt).pose for u in commands]
    behind = [tardy.step(commanding(u), dt).pose for u in commands]
    assert_allclose(behind[late:], ahead[: len(ahead) - late], atol=1e-12)
    assert not np.any(behind[:late])


def test_reset_forgets_the_commands_on_their_way() -> None:
    plant = Actuator(dead_time=0.05)
    plant.step(commanding(5.0), 0.02)
    plant.reset(PlatformState())
    assert not plant.step(commanding(0.0), 0.2).pose.any()


def test_its_lags_come_from_the_platforms_file() -> None:
    state = actuator(load("davsi")).step(commanding(1.0), 0.01)  # all of it within the dead time
    assert not state.pose.any()


@pytest.mark.parametrize("dead", [-0.1, np.nan, 2.0])
def test_an_impossible_dead_time_is_refused(dead: float) -> None:
    with pytest.raises(InputError, match=r"plant dead time is .*, must be between 0 and 1 s"):
        Actuator(dead_time=dead)
