from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from otolith.core.errors import InputError
from otolith.interfaces import Command, Outcome, PlatformState, Status
from otolith.plant import Ideal
from otolith.plant.ideal import without_lag


def commanding(acceleration: float) -> Command:
    zero = np.zeros(6)
    outcome = Outcome(status=Status.DECIDED)
    return Command(
        acceleration=np.full(6, acceleration), pose=zero, twist=zero, plan=np.zeros((0, 6)), outcome=outcome
    )


def test_a_step_command_is_followed_in_closed_form() -> None:
    T, t, plant = 0.01, 0.03, Ideal(lag=0.01)
    state = plant.step(commanding(2.0), t)
    decay = np.exp(-t / T)
    assert_allclose(state.acceleration, 2.0 * (1 - decay), atol=1e-12)
    assert_allclose(state.twist, 2.0 * (t - T * (1 - decay)), atol=1e-12)
    assert_allclose(state.pose, 2.0 * (t**2 / 2 - T * t + T**2 * (1 - decay)), atol=1e-12)


def test_without_lag_it_is_a_double_integrator() -> None:
    state = without_lag().step(commanding(2.0), 0.5)
    assert_allclose(state.acceleration, 2.0)
    assert_allclose(state.twist, 1.0)
    assert_allclose(state.pose, 0.25)


@given(lag=st.just(0.0) | st.floats(1e-6, 0.2), a=st.floats(-10, 10), steps=st.integers(1, 7))
def test_the_step_size_changes_nothing(lag: float, a: float, steps: int) -> None:
    """The discretisation is exact, so any division of the same time ends in the same state."""
    once, often = Ideal(lag), Ideal(lag)
    start = PlatformState(pose=np.ones(6), twist=-np.ones(6), acceleration=np.full(6, 0.3))
    once.reset(start)
    often.reset(start)
    whole = once.step(commanding(a), 0.01 * steps)
    for _ in range(steps):
        parts = often.step(commanding(a), 0.01)
    assert_allclose(parts.pose, whole.pose, atol=1e-10)
    assert_allclose(parts.twist, whole.twist, atol=1e-10)


def test_a_negative_lag_is_refused_and_one_too_short_to_compute() -> None:
    with pytest.raises(InputError, match=r"plant lag is 1e-41, must be 0 or at least 1e-06 s"):
        Ideal(lag=1e-41)
    with pytest.raises(InputError, match=r"plant lag is -1\.0, must be finite and at least 0 s"):
        Ideal(lag=-1.0)


def test_a_head_above_the_reference_point_feels_the_tilt_acceleration() -> None:
    """Lever arm: at rest in a neutral pose, pitch accelerates nose-down, and a head above goes forward."""
    pitching = np.array([0.0, 0.0, 0.0, 0.0, 0.5, 0.0])
    height, start = 0.9, PlatformState(acceleration=pitching)
    above, bare = Ideal(0.0, head=(0.0, 0.0, height)), Ideal(0.0)
    for plant in (above, bare):
        plant.reset(start)
    command = replace(commanding(0.0), acceleration=pitching)
    state = above.step(command, 1e-6)
    assert state.specific_force is not None
    assert_allclose(state.specific_force, [0.5 * height, 0.0, 0.0], atol=1e-4)
    assert bare.step(command, 1e-6).specific_force is None
