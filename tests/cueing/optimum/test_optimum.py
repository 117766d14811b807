"""The best that is possible: below every algorithm, within all limits, and what was published by others."""

from functools import cache

import numpy as np
import pytest
from numpy.testing import assert_allclose

from otolith import metrics, registry
from otolith.cli.optimum import distance
from otolith.core.errors import InputError
from otolith.core.frames import DOFS, HEAVE, SURGE_PITCH, SWAY_ROLL, YAW, Dof
from otolith.cueing.design import Design
from otolith.cueing.optimum import Optimum, optimum
from otolith.loop import simulate
from otolith.platforms import load
from otolith.scenarios import Scenario, scenario


@cache
def best(name: str, platform: str = "thesis", *dofs: Dof) -> Optimum:
    chosen = dofs or (SURGE_PITCH,)
    wanted = scenario(name, axis=chosen[0].along)
    for dof in chosen[1:]:
        wanted = wanted.combined_with(scenario(name, axis=dof.along))
    return optimum(load(platform), chosen, wanted)


@pytest.mark.parametrize(
    ("name", "rmse"),
    [("sine-2", 0.3085), ("step-2", 0.2956), ("sine-1", 0.0), ("combined", 0.0)],
)
def test_errors_are_those_of_another_formulation(name: str, rmse: float) -> None:
    """Found by others with IPOPT and one sample per period: .3088, .2985, .0000, .0000."""
    found = best(name)
    assert metrics.tracking_rmse(found.run)[0] == pytest.approx(rmse, abs=2e-4)
    assert metrics.summarise(found.run)["violations"] == 0
    assert found.certificate.worst < 1e-4


@pytest.mark.parametrize("cueing", ["predictive", "implicit", "linear-mpc", "optimal"])
def test_no_algorithm_does_better(cueing: str) -> None:
    platform = load("thesis")
    for name in ("sine-2", "sine-1"):
        run = simulate(
            registry.make_cueing(cueing, Design(platform=platform)),
            registry.make_plant("ideal", platform),
            scenario(name),
            platform=platform,
            dofs=("surge-pitch",),
        )
        assert metrics.tracking_rmse(run)[0] > metrics.tracking_rmse(best(name).run)[0]


def test_a_mirrored_drive_has_the_mirrored_optimum() -> None:
    wanted = scenario("step-2")
    mirrored = Scenario(
        name="mirrored", duration=wanted.duration, specific_force=lambda t: -wanted.specific_force(t)
    )
    other = optimum(load("thesis"), (SURGE_PITCH,), mirrored)
    assert_allclose(other.run.pose, -best("step-2").run.pose, atol=1e-5)


def test_four_axes_keep_within_the_circle() -> None:
    run = best("sine-2", "davsi-4dof", SURGE_PITCH, SWAY_ROLL).run
    circle = load("davsi-4dof").circle
    assert circle is not None
    reached = np.hypot(run.pose[:, 0], run.pose[:, 1]).max()
    assert 0.95 * circle < reached < circle + 1e-6
    assert metrics.summarise(run)["violations"] == 0


@pytest.mark.parametrize("dof", [HEAVE, YAW], ids=["heave", "yaw"])
def test_heave_and_yaw_are_problems_of_their_own(dof: Dof) -> None:
    found = best("sine-1", "davsi", dof)
    assert found.certificate.worst < 1e-4
    assert metrics.summarise(found.run)["violations"] == 0


def test_what_it_cannot_do_is_refused_in_one_sentence() -> None:
    with pytest.raises(InputError, match="without heave"):
        best("sine-1", "davsi", SURGE_PITCH, DOFS["heave"])
    endless = Scenario(name="endless", duration=1e5, specific_force=lambda t: np.zeros((len(t), 3)))
    with pytest.raises(InputError, match="duration of the scenario is 100000 s, must be at most 3600 s"):
        optimum(load("thesis"), (SURGE_PITCH,), endless)


def test_where_nothing_is_wanted_nothing_moves() -> None:
    still = best("step:amplitude=0,duration=2,end=2")
    assert np.abs(still.run.pose).max() < 1e-9


def test_distances_in_words() -> None:
    summary = {"rmse_per_pair": {"surge-pitch": 0.6}, "wanted_rms": {"surge-pitch": 1.4}}
    turning = {"rate_rmse": {"yaw": np.radians(2.0)}, "wanted_rms": {"yaw": np.radians(8.0)}}
    assert distance(turning, turning) == "yaw 1.00 times the best that is possible (2.000 deg/s)"
    hard, easy = (summary | {"rmse_per_pair": {"surge-pitch": value}} for value in (0.3, 0.001))
    assert distance(summary, hard) == "surge-pitch 2.00 times the best that is possible (0.3000 m/s²)"
    assert distance(summary, easy) == "surge-pitch 0.6000 m/s², where a perfect answer is within reach"
