"""The classical washout at work against its transfer functions on paper."""

from typing import Any

import numpy as np
import pytest

from otolith.core.errors import InputError
from otolith.core.frames import GRAVITY, SURGE_PITCH
from otolith.cueing.washout import tuning as tables
from otolith.cueing.washout.classical import (
    Classical,
    classical,
    cross_response,
    force_response,
    hold_response,
    rate_response,
)
from otolith.cueing.washout.tuning import Corners
from tests.cueing.washout.loop import TUNING, Task, along, drive, fitted

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


def steps(t: np.ndarray) -> np.ndarray:
    return np.where(t < 2.0, 0.6, -0.3)


def test_factors_of_corner_frequencies_are_a_tuning_with_other_frequencies() -> None:
    of = TUNING.of(tables.Classical)
    rows = {name: getattr(of, name) for name in ("surge", "sway", "heave", "rotation")}
    faster = {
        name: row.model_copy(
            update={one: 1.5 * getattr(row, one) for one in type(row).model_fields if one.endswith("_radps")}
        )
        for name, row in rows.items()
    }
    slower = of.tilt.model_copy(update={"natural_radps": 0.7 * of.tilt.natural_radps})
    table = of.model_copy(update={**faster, "tilt": slower})
    written = Task(tuning=TUNING.model_copy(update={"classical": table}))
    factors = Task(corners=Corners(high_pass=1.5, low_pass=0.7))
    one, other, plain = (drive(classical(task), 4.0, along(0, steps)) for task in (factors, written, Task()))
    np.testing.assert_array_equal(one.pose, other.pose)
    assert np.abs(one.pose - plain.pose).max() > 1e-3


def test_corners_that_change_at_rest_are_those_of_another_washout_bit_for_bit() -> None:
    task = Task(corners=Corners(high_pass=2.0, low_pass=0.5))
    changed = Classical(Task())
    changed.retune(task)
    runs = [drive(one, 4.0, along(0, steps)) for one in (changed, classical(task))]
    np.testing.assert_array_equal(runs[0].pose, runs[1].pose)
    changed.retune(Task())
    runs = [drive(one, 4.0, along(0, steps)) for one in (changed, classical(Task()))]
    np.testing.assert_array_equal(runs[0].pose, runs[1].pose)


@pytest.mark.parametrize("factor", [0.49, 2.01, float("nan")])
def test_a_factor_out_of_bounds_is_refused(factor: float) -> None:
    with pytest.raises(InputError, match=r"high_pass is .*, must be between 0\.5 and 2"):
        Corners(high_pass=factor)


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
