"""Settings of `predictive`: the homing that its docstring promises, on every platform and axis."""

import numpy as np
import pytest
from scipy.linalg import solve_continuous_are

from otolith import registry
from otolith.core.errors import InputError
from otolith.core.frames import DOFS, HEAVE, SURGE_PITCH, SWAY_ROLL, YAW, Dof
from otolith.cueing.design import Design
from otolith.cueing.mpc.predictive import HOMING, HOMING_RATE, RANGE, predictive_settings, reach
from otolith.cueing.mpc.settings import MpcSettings
from otolith.cueing.prediction import Adaptive, Hold, Road
from otolith.loop import simulate
from otolith.platforms import load
from otolith.scenarios import scenario


def weights(platform: str, dofs: tuple[Dof, ...], liveliness: float = 0.5) -> dict[str, float]:
    settings = predictive_settings(MpcSettings(), load(platform), dofs, liveliness)
    return {weight.on: weight.coefficients[0] for weight in settings.washout}


@pytest.mark.parametrize("platform", ["thesis", "davsi", "davsi-4dof"])
@pytest.mark.parametrize("liveliness", [0.0, 0.5, 1.0])
def test_home_is_called_for_with_the_same_acceleration_from_the_end_of_any_reach(
    platform: str, liveliness: float
) -> None:
    """The linear-quadratic regulator of these weights, solved by another method, has that stiffness."""
    for dof in DOFS.values():
        try:
            S = reach(load(platform), dof)
        except InputError:
            continue
        if dof is YAW:
            continue
        w = weights(platform, (dof,), liveliness)
        A, B = np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[0.0], [1.0]])
        P = solve_continuous_are(A, B, np.diag([w["position"], w["velocity"]]), np.eye(1))
        stiffness, damping = (B.T @ P)[0]
        price = RANGE ** (1.0 - 2.0 * liveliness)
        assert stiffness * S == pytest.approx(HOMING * price**0.5, rel=1e-6)
        assert damping / (2.0 * stiffness**0.5) == pytest.approx(0.78, abs=0.01)


def test_yaw_turns_home_at_two_degrees_a_second_from_its_end() -> None:
    w = weights("davsi", (YAW,))
    rate = (w["position"] / MpcSettings().objective.rate) ** 0.5  # of min Σ rate error² + w θ²
    assert rate * reach(load("davsi"), YAW) == pytest.approx(HOMING_RATE)


def test_two_pairs_keep_to_the_circle_and_only_tilts_have_a_rate_to_weigh() -> None:
    both = weights("davsi-4dof", (SURGE_PITCH, SWAY_ROLL))
    assert set(both) == {"position", "velocity", "tilt_rate"}
    assert both["position"] >= weights("davsi-4dof", (SURGE_PITCH,))["position"]
    assert set(weights("davsi", (HEAVE,))) == {"position", "velocity"}


def test_what_was_chosen_stays() -> None:
    chosen = MpcSettings(soft={"tilt_rate": 100.0}, prediction=Hold())
    made = predictive_settings(chosen, load("thesis"), (SURGE_PITCH,), 0.5)
    assert made.soft == chosen.soft
    assert made.prediction == Hold()
    assert predictive_settings(MpcSettings(), load("thesis"), (SURGE_PITCH,), 0.5).prediction == Adaptive()


def test_thirty_seconds_after_a_pulse_the_platform_is_home() -> None:
    """Within 1 cm, although it went through a quarter of a metre."""
    platform = load("thesis")
    run = simulate(
        registry.make_cueing("predictive", Design(platform=platform)),
        registry.make_plant("ideal", platform),
        scenario("step:amplitude=2,start=1,end=3,duration=33"),
        platform=platform,
        dofs=("surge-pitch",),
        plant_period=0.01,
    )
    assert np.abs(run.pose[:, 0]).max() > 0.2
    assert abs(run.pose[-1, 0]) < 0.01


def test_what_is_foreseen_further_than_the_horizon_makes_it_longer() -> None:
    """But for a rate: only forces are foreseen."""
    far, near = MpcSettings(prediction=Road()), MpcSettings(prediction=Road(time=1.5, lead=1.0))
    thesis, davsi = load("thesis"), load("davsi")
    assert predictive_settings(far, thesis, (SURGE_PITCH,), 0.5).horizon == 500
    assert predictive_settings(near, thesis, (SURGE_PITCH,), 0.5).horizon == 150
    assert predictive_settings(far, davsi, (YAW,), 0.5).horizon == 150
