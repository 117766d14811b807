"""The best that is possible: below every algorithm, within all limits, and what was published by others."""

from functools import cache

import numpy as np
import pytest
from numpy.testing import assert_allclose

from otolith import metrics, registry
from otolith.core.errors import InputError
from otolith.core.frames import DOFS, HEAVE, SURGE_PITCH, SWAY_ROLL, YAW, Dof
from otolith.core.rotation import felt_along
from otolith.cueing.design import Design
from otolith.cueing.optimum import Optimum, measure_of, optimum
from otolith.loop import simulate
from otolith.metrics.limits import excesses
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


def test_six_degrees_of_freedom_are_one_problem() -> None:
    """Tilts pull on heave to the second order, which Gauss-Newton steps do not see: they never settled."""
    found = best("sine-1", "davsi", *DOFS.values())
    assert found.certificate.worst < 1e-8
    entry = metrics.summarise(found.run)
    assert entry["violations"] == 0
    alone = metrics.summarise(best("sine-1", "davsi", HEAVE).run)["rmse_per_pair"]["heave"]
    assert entry["rmse_per_pair"]["heave"] < alone  # tilting makes the driver lighter
    assert entry["rmse_per_pair"]["surge-pitch"] < 0.05


def test_what_it_cannot_do_is_refused_in_one_sentence() -> None:
    endless = Scenario(name="endless", duration=1e5, specific_force=lambda t: np.zeros((len(t), 3)))
    with pytest.raises(InputError, match="duration of the scenario is 100000 s, must be at most 3600 s"):
        optimum(load("thesis"), (SURGE_PITCH,), endless)


@pytest.mark.parametrize(
    ("platform", "dofs"),
    [
        ("thesis", (SURGE_PITCH, SWAY_ROLL)),
        ("benchmark", (SURGE_PITCH,)),
        ("davsi-4dof", (SURGE_PITCH, SWAY_ROLL)),
        ("davsi", (SURGE_PITCH,)),
        ("davsi", (SURGE_PITCH, YAW)),
        ("davsi", (SURGE_PITCH, SWAY_ROLL, YAW)),
        ("davsi", (HEAVE,)),
    ],
    ids=lambda value: value if isinstance(value, str) else ",".join(dof.name for dof in value),
)
def test_where_nothing_is_wanted_nothing_moves(platform: str, dofs: tuple[Dof, ...]) -> None:
    """Limits that lie unequally far push the first iterates aside, and there is no gradient to measure by."""
    still = best("step:amplitude=0,duration=2,end=2", platform, *dofs)
    assert np.abs(still.run.pose).max() < 1e-9
    assert still.certificate.worst < 1e-9


def test_the_force_at_the_head_is_what_counts() -> None:
    """A lever arm of a metre: commands that are best without it are far from the best with it."""
    thesis = load("thesis")
    assert thesis.hexapod is not None
    table = thesis.hexapod.model_copy(update={"head_m": (0.3, 0.0, 1.0)})
    headed = thesis.model_copy(update={"hexapod": table})
    found = optimum(headed, (SURGE_PITCH,), scenario("step-1"))
    error = metrics.tracking_rmse(found.run)[0]
    assert error == pytest.approx(0.0156, abs=1e-4)
    assert found.certificate.worst < 1e-4
    sensed = np.empty_like(found.run.felt_force)
    felt_along(np.array(headed.head), found.run.pose, found.run.twist, found.run.acceleration, sensed)
    assert_allclose(found.run.felt_force, sensed, atol=1e-12)
    without = best("step-1").run
    felt_along(np.array(headed.head), without.pose, without.twist, without.acceleration, sensed)
    assert np.sqrt(np.mean((sensed - without.reference_force)[:, 0] ** 2)) > 5 * error


def test_the_error_through_the_lag_is_that_of_the_jumps() -> None:
    """By brute force: of all accelerations at the jump and one period after it, those that miss it least."""
    lag, t = 0.01, np.arange(1, 11) * 1e-3
    through = (1.0 - np.exp(-t / lag)) / (1.0 - np.exp(-1.0))  # from one node's acceleration to the next's

    def missed(at_jump: float, after: float) -> float:
        courses = at_jump * through, at_jump + (after - at_jump) * through, after + (1.0 - after) * through
        return sum(float(np.sum((a - w) ** 2)) for a, w in zip(courses, (0.0, 1.0, 1.0), strict=True))

    least = min(missed(a, b) for a in np.linspace(0.0, 1.0, 101) for b in np.linspace(0.9, 1.3, 101))
    found = best("step:amplitude=2,start=1,end=5,duration=6").through_lag["surge-pitch"]
    assert found == pytest.approx(np.sqrt(2 * 2.0**2 * least / 6000), rel=0.03)  # two jumps of 2 m/s²


def test_a_platform_without_lag_follows_jumps() -> None:
    quick = optimum(load("thesis"), (SURGE_PITCH,), scenario("step-1"), plant="ideal-no-lag")
    assert quick.through_lag["surge-pitch"] < 1e-4
    assert metrics.tracking_rmse(quick.run)[0] < 1e-3


def test_a_reference_that_is_no_number_is_refused() -> None:
    broken = Scenario(
        name="b", duration=2.0, specific_force=lambda t: np.where(t > 1.0, np.nan, 0.0)[:, None].repeat(3, 1)
    )
    with pytest.raises(InputError, match=r"the reference is no number at 1.00. s"):
        optimum(load("thesis"), (SURGE_PITCH,), broken)


def test_another_plant_is_refused() -> None:
    with pytest.raises(InputError, match="plant of the optimum is hexapod, must be ideal or ideal-no-lag"):
        optimum(load("thesis"), (SURGE_PITCH,), scenario("step-1"), plant="hexapod")
    assert [measure_of(plant) for plant in ("ideal-no-lag", "ideal", "hexapod", "actuator")] == [
        "ideal-no-lag",
        "ideal",
        "ideal",
        "ideal",
    ]


def test_a_rail_makes_the_best_better_and_its_run_is_the_motion_that_was_found() -> None:
    """The cheap predictor of what redundancy gains: certified, and within the limits of both carriers."""
    ultimate = load("ultimate")
    alone = ultimate.model_copy(update={"base": None})
    found, without = (optimum(one, (SURGE_PITCH,), scenario("step-2")) for one in (ultimate, alone))
    errors = [
        float(np.sqrt(np.mean((one.run.felt_force - one.run.reference_force)[:, 0] ** 2)))
        for one in (found, without)
    ]
    assert errors[0] < 0.3 * errors[1]
    assert found.certificate.worst < 1e-4
    assert found.run.base is not None
    assert 2.5 < np.abs(found.run.base[:, 0]).max() <= 2.6 + 1e-4
    assert all(one.at_nodes < 1e-5 for one in excesses(found.run))
