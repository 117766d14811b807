"""Measures of a run that pass through a filter or a limit, against closed forms."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from otolith import metrics
from otolith.core.errors import InputError
from otolith.core.lti import StateSpace
from otolith.loop import Run
from otolith.perception import Vestibular

# ISO 2631-1, Table 4: factors of W_f at the nominal third-octave frequencies [Hz], times 1000.
W_F = {
    0.02: 24.2, 0.025: 37.7, 0.0315: 59.7, 0.04: 97.1, 0.05: 157, 0.063: 267, 0.08: 461, 0.1: 695, 0.125: 895,
    0.16: 1006, 0.2: 992, 0.25: 854, 0.315: 619, 0.4: 384, 0.5: 224, 0.63: 116, 0.8: 53.0, 1.0: 23.5,
}  # fmt: skip


def test_the_perceived_error_is_the_difference_of_what_the_organs_sense(handmade: Run) -> None:
    organs = Vestibular()
    sensed = [organs.force(f, 0.01) for f in (handmade.felt_force, handmade.reference_force)]
    assert_allclose(metrics.perceived_error(handmade), sensed[0] - sensed[1], atol=1e-12)


def test_a_sustained_error_is_perceived_at_the_gain_of_the_model(handmade: Run) -> None:
    lag = StateSpace.from_polynomials([0.5], [0.001, 1.0])  # settles within a sample
    assert_allclose(metrics.perceived_rmse(handmade, lag), [0.1, 0.0, 0.0], atol=1e-3)


def test_the_sickness_weighting_is_that_of_the_standards_table() -> None:
    response = metrics.sickness_weighting().frequency_response(2 * np.pi * np.array(list(W_F)))
    assert_allclose(1000 * np.abs(response[:, 0, 0]), list(W_F.values()), rtol=0.003)


def test_the_dose_of_a_sine_is_its_weighted_rms_times_the_root_of_time() -> None:
    dt, duration, frequency = 0.01, 2000.0, 0.2
    t = np.arange(round(duration / dt)) * dt
    dose = metrics.sickness_dose(1.5 * np.sin(2 * np.pi * frequency * t), dt)
    assert dose == pytest.approx(0.992 * 1.5 / math.sqrt(2) * math.sqrt(duration), rel=0.003)
    assert metrics.illness_percent(dose) == pytest.approx(dose / 3)


def test_a_constant_mismatch_is_rated_as_a_lag_approaches_it(handmade: Run) -> None:
    lateral = replace(
        handmade,
        dofs=("surge-pitch", "sway-roll"),
        reference_force=np.tile([0.2, -1.0, 0.0], (100, 1)),
        felt_force=np.zeros((100, 3)),
    )
    rating = metrics.mismatch_rating(lateral, time_constant=0.3)
    mismatch = 0.34 * 0.2 + 0.66 * 1.0
    # the mismatch appears over one sample, as a ramp: its response is the mean of the step's over a sample
    t = np.arange(100) * 0.01
    lagged = 1.0 - 0.3 / 0.01 * (np.exp(-t / 0.3) - np.exp(-(t + 0.01) / 0.3))
    assert_allclose(rating, mismatch * lagged, atol=1e-12)
    with pytest.raises(InputError, match="time constant"):
        metrics.mismatch_rating(handmade, time_constant=0.0)


def test_workspace_use_is_a_share_of_the_reach_on_the_side_of_travel(handmade: Run) -> None:
    # position ramps from 0 to 0.1 m of ±0.5 m: RMS 0.1 √(Σ k²/100³)
    used = metrics.workspace_use(handmade)
    assert set(used) == {"surge", "pitch"}
    assert used["surge"].largest == pytest.approx(0.2)
    assert used["surge"].rms == pytest.approx(0.2 * math.sqrt(338350 / 1e6))
    assert used["surge"].near_limit == 0.0
    tilted = handmade.pose.copy()
    tilted[:, 4] = np.deg2rad(np.linspace(-30.0, 0.0, 101)[:100])
    pitch = metrics.workspace_use(replace(handmade, pose=tilted))["pitch"]
    assert pitch.largest == pytest.approx(1.0)
    assert pitch.near_limit == pytest.approx(0.1)  # −30° … −27.3°: ten samples of a hundred


def test_the_circle_is_used_by_surge_and_sway_together(handmade: Run) -> None:
    pose = handmade.pose.copy()
    pose[:, :2] = [0.3, -0.4]
    both = replace(handmade, pose=pose, dofs=("surge-pitch", "sway-roll"))
    circle = metrics.workspace_use(both)["circle"]
    assert both.platform.circle is not None
    assert circle.largest == pytest.approx(0.5 / both.platform.circle)
