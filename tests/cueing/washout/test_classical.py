"""The classical washout at work against its transfer functions on paper."""

from typing import Any

import numpy as np
import pytest

from otolith.core.frames import GRAVITY, SURGE_PITCH
from otolith.cueing.washout.classical import (
    classical,
    cross_response,
    force_response,
    hold_response,
    rate_response,
)
from tests.cueing.washout.loop import Task, along, drive, fitted

OMEGA = (0.1, 0.631, 2.512, 6.31, 15.849)  # of the OMCT's twelve
DEGREE = np.pi / 180.0


def response(omega: float, *, of_force: bool) -> tuple[complex, complex]:
    """Felt force and rate per unit of the wanted force, or of the wanted rate; measured in the loop."""
    amplitude = 1e-3  # [m/s², rad/s] where the scaling's cubic is straight
    signal = along(0 if of_force else 1, lambda t: amplitude * np.sin(omega * t))
    felt: dict[str, Any] = {"force" if of_force else "rate": signal}
    run = drive(
        classical(Task()),
        2.0 * max(40.0, 8 * np.pi / omega),
        **felt,
        plant_period=2e-3 if omega > 3.0 else 1e-2,
    )
    moved = fitted(run.time - 0.5 * run.plant_period, run.acceleration[:, 0], omega)  # held: stands midway
    tilted = fitted(run.time, run.pose[:, 4], omega)
    turning = fitted(run.time, run.twist[:, 4], omega)
    return (moved - GRAVITY * tilted) / amplitude, turning / amplitude


def agree(measured: complex, paper: complex) -> None:
    """Within one percent and one degree."""
    assert abs(measured) == pytest.approx(abs(paper), rel=0.01)
    assert abs(np.angle(measured / paper)) < DEGREE


@pytest.mark.parametrize("omega", OMEGA)
def test_felt_force_is_that_of_the_transfer_function_within_one_percent_and_one_degree(omega: float) -> None:
    w = np.array([omega])
    felt, _ = response(omega, of_force=True)
    agree(felt, (force_response(Task().tuning, SURGE_PITCH, w) * hold_response(w))[0])


@pytest.mark.parametrize("omega", [0.631, 2.512, 6.31])
def test_rotation_and_its_cross_talk_are_those_of_their_transfer_functions(omega: float) -> None:
    w = np.array([omega])
    felt, turning = response(omega, of_force=False)
    held = hold_response(w, late=True)
    agree(turning, (rate_response(Task().tuning, w) * held)[0])
    agree(felt, (cross_response(Task().tuning, SURGE_PITCH, w) * held)[0])


def test_the_channels_complement_each_other_at_both_ends() -> None:
    ends = np.abs(force_response(Task().tuning, SURGE_PITCH, np.array([1e-3, 1e3])))
    assert ends == pytest.approx(np.full(2, Task().tuning.scaling.force.slope), rel=1e-2)
