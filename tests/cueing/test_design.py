"""Every algorithm as it is put together: six axes, what is sensed, what is linear."""

import functools

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.optimize import minimize

from otolith import metrics, registry
from otolith.core.errors import InputError
from otolith.core.frames import DOFS, HEAVE, SURGE_PITCH, SWAY_ROLL, YAW, Dof
from otolith.cueing.design import Design, implicit, implicit_sensed, linear_mpc
from otolith.cueing.mpc.controller import Mpc
from otolith.cueing.mpc.explicit_problem import ExplicitSettings
from otolith.cueing.mpc.objective import RATE_WEIGHT
from otolith.cueing.mpc.settings import MpcSettings
from otolith.cueing.mpc.washout_weights import constant
from otolith.cueing.prediction import Oracle
from otolith.cueing.several import Several
from otolith.interfaces import Cueing, PlatformState, Reference, Status
from otolith.loop import Run, simulate
from otolith.plant import Ideal
from otolith.platforms import load
from otolith.qp.engines import CondensedEngine, StructuredEngine
from otolith.scenarios import Scenario, scenario

T = 0.01
DAVSI = load("davsi")
PAIRS, ALONE = (SURGE_PITCH, SWAY_ROLL), (HEAVE, YAW)
SETTINGS = MpcSettings(horizon=30, blocks=(1, 1, 3, 5, 10, 10), engine=CondensedEngine)
SHORT = MpcSettings(horizon=20, engine=CondensedEngine)
SENSED = pytest.mark.parametrize("make", [linear_mpc, implicit_sensed])


def design(*dofs: Dof, mpc: MpcSettings = SHORT) -> Design:
    return Design(platform=DAVSI, dofs=dofs or (SURGE_PITCH,), mpc=mpc)


def loop(cueing: Cueing, wanted: Scenario, dofs: tuple[Dof, ...] = (SURGE_PITCH,)) -> Run:
    names = tuple(dof.name for dof in dofs)
    return simulate(cueing, Ideal(), wanted, platform=DAVSI, dofs=names, plant_period=2e-3)


def cue(*dofs: Dof, name: str = "implicit", text: str = "step:amplitude=3,duration=4,end=3") -> Run:
    wanted = functools.reduce(Scenario.combined_with, [scenario(text, axis=dof.along) for dof in dofs])
    return loop(registry.make_cueing(name, design(*dofs, mpc=SETTINGS)), wanted, dofs)


@pytest.fixture(scope="module")
def six() -> Run:
    return cue(*DOFS.values())


def test_all_six_axes_move_and_every_limit_holds(six: Run) -> None:
    assert six.dofs == tuple(DOFS)
    assert set(six.status) == {Status.DECIDED}
    assert (np.abs(six.pose).max(axis=0) > 1e-3).all()
    quantities = {excess.quantity.split()[0] for excess in metrics.excesses(six)}
    assert quantities == {*DOFS, "circle"}
    for excess in metrics.excesses(six):
        assert excess.at_nodes < 1e-6, excess


def test_the_pairs_move_as_they_do_alone_and_so_do_heave_and_yaw(six: Run) -> None:
    pairs, alone = cue(*PAIRS), cue(*ALONE)
    assert_array_equal(six.command[:, [0, 1, 3, 4]], pairs.command[:, [0, 1, 3, 4]])
    assert_array_equal(six.command[:, [2, 5]], alone.command[:, [2, 5]])
    assert not pairs.command[:, [2, 5]].any()
    assert not alone.command[:, [0, 1, 3, 4]].any()


def test_one_problem_of_all_six_axes_decides_as_the_several_do(six: Run) -> None:
    """One MPC over four degrees of freedom: nothing couples heave and yaw to the pairs."""
    wanted = [scenario("step:amplitude=3,duration=4,end=3", axis=dof.along) for dof in DOFS.values()]
    dofs = tuple(DOFS.values())
    one = loop(Mpc(DAVSI, dofs, SETTINGS), functools.reduce(Scenario.combined_with, wanted), dofs)
    assert set(one.status) == {Status.DECIDED}
    assert_allclose(one.pose, six.pose, atol=1e-5)


def test_yaw_is_the_optimum_that_another_solver_finds() -> None:
    """Where no limit is near: the physical rate, tracked at every step's end, against scipy's BFGS."""
    N, lag, R, W, wanted = 12, 0.01, 1e-3, 2.0, 0.02
    settings = MpcSettings(
        horizon=N, control_weight=R, washout=constant({"position": W}), engine=CondensedEngine
    )
    mpc = implicit(design(YAW, mpc=settings))
    x0 = np.array([0.01, 0.03, 0.1])  # rate, angle, acceleration
    state = PlatformState(
        pose=np.array([0, 0, 0, 0, 0, x0[1]]),
        twist=np.array([0, 0, 0, 0, 0, x0[0]]),
        acceleration=np.array([0, 0, 0, 0, 0, x0[2]]),
    )
    command = mpc.step(
        state, Reference(specific_force=np.zeros(3), angular_rate=np.array([0.0, 0.0, wanted]))
    )

    def cost(u: np.ndarray) -> float:
        rate, angle, a = x0
        total, e = 0.0, np.exp(-T / lag)
        for command in u:  # the lag's closed form over one period
            fade = a - command
            angle += rate * T + command * T**2 / 2 + fade * lag * (T - lag * (1 - e))
            rate += command * T + fade * lag * (1 - e)
            a = command + fade * e
            total += 0.5 * RATE_WEIGHT * (rate - wanted) ** 2 + 0.5 * W * angle**2 + 0.5 * R * command**2
        return total

    best = minimize(cost, np.zeros(N), method="BFGS", options={"gtol": 1e-10, "maxiter": 2000}).x
    plan = np.concatenate([command.acceleration[None], command.plan])[:N, 5]
    assert command.outcome.status is Status.DECIDED
    assert_allclose(plan, best, atol=1e-4 * np.abs(best).max())


def test_the_worst_status_of_all_parts_is_reported() -> None:
    cueing = implicit(design(*DOFS.values(), mpc=SETTINGS))
    high = PlatformState(pose=np.array([0, 0, 5.0, 0, 0, 0]))
    outcome = cueing.step(high, Reference(specific_force=np.zeros(3))).outcome
    assert (outcome.status, outcome.solver) == (Status.FALLBACK, "infeasible")


def test_what_decides_at_other_times_does_not_go_together() -> None:
    slow = MpcSettings(horizon=10, period=0.02, engine=CondensedEngine)
    with pytest.raises(InputError, match="periods of several algorithms at once"):
        Several([implicit(design(mpc=slow)), implicit(design(YAW))])


def test_the_explicit_law_cues_heave_and_yaw_as_well() -> None:
    """Each by its own law; the joint run moves every axis as alone."""
    settings = ExplicitSettings(horizon=3, block_from=2)
    both = Design(platform=DAVSI, dofs=ALONE, explicit=settings)
    wanted = scenario("step:amplitude=0.5,duration=3,end=2.5", axis="vertical")
    wanted = wanted.combined_with(scenario("sine-1", axis="yaw").scaled(0.2))
    plant = registry.PLANTS["ideal-no-lag"].load()(DAVSI)
    run = simulate(
        registry.make_cueing("explicit", both), plant, wanted, platform=DAVSI, dofs=("heave", "yaw")
    )
    assert np.mean([status == Status.DECIDED for status in run.status]) > 0.9
    assert (np.abs(run.pose[:, [2, 5]]).max(axis=0) > 1e-2).all()
    assert all(excess.at_nodes < 1e-6 for excess in metrics.excesses(run))


@SENSED
def test_both_engines_decide_alike(make) -> None:
    runs = []
    for engine in (CondensedEngine, StructuredEngine):
        cueing = make(design(mpc=MpcSettings(engine=engine)))  # the horizon that other tests compile, too
        runs.append(loop(cueing, scenario("step:amplitude=1,duration=3")))
        assert set(runs[-1].status) == {Status.DECIDED}
        assert runs[-1].residual.max() < 1e-6
    assert_allclose(runs[0].command, runs[1].command, atol=2e-3)


@SENSED
def test_limits_hold_in_four_degrees_of_freedom(make) -> None:
    along = "step:amplitude=2,duration=3,end=2.5"
    run = loop(make(design(*PAIRS)), scenario(along).combined_with(scenario(along, axis="lateral")), PAIRS)
    assert set(run.status) == {Status.DECIDED}
    for excess in metrics.excesses(run):
        assert excess.at_nodes < 1e-6, excess


def test_linear_sub_problems_do_not_know_of_each_other() -> None:
    """Four of them, and what is wanted sideways, upwards or in yaw leaves the surge as it is."""
    alone = linear_mpc(design())
    all_four = linear_mpc(design(*PAIRS, *ALONE))
    assert isinstance(all_four, Several)
    assert [len(one.problem.dofs) for one in all_four.parts] == [1, 1, 1, 1]  # type: ignore[attr-defined]
    state = PlatformState()
    force = np.array([0.5, -0.8, 0.4])
    for _ in range(5):
        many = all_four.step(state, Reference(specific_force=force, angular_rate=np.array([0.0, 0.0, 0.3])))
        one = alone.step(state, Reference(specific_force=force))
    assert_allclose(many.acceleration[[0, 4]], one.acceleration[[0, 4]], atol=1e-9)
    assert np.abs(many.acceleration[[1, 2, 3, 5]]).min() > 1e-4
    assert many.acceleration[2] > 0.1
    assert many.acceleration[5] > 0.1


@SENSED
def test_a_platform_predicts_where_its_command_leads(make) -> None:
    cueing = make(design(*PAIRS, *ALONE))
    state, plant = PlatformState(), Ideal()
    for _ in range(20):
        command = cueing.step(
            state, Reference(specific_force=np.array([0.5, 0.3, 0.2]), angular_rate=np.full(3, 0.1))
        )
        state = plant.step(command, T)
        assert_allclose(command.pose, state.pose, atol=1e-12)
        assert_allclose(command.twist, state.twist, atol=1e-12)


def test_tracking_what_is_sensed_is_worth_something() -> None:
    """On a step the perceived error is less than that of the MPC that tracks the physical force."""
    plain, sensed = (loop(make(design()), scenario("step-2")) for make in (implicit, implicit_sensed))
    assert metrics.perceived_rmse(sensed)[0] < metrics.perceived_rmse(plain)[0]


def test_in_trouble_it_stops_and_the_outcome_says_so() -> None:
    cueing = implicit_sensed(design())
    moving = PlatformState(twist=np.array([0.2, 0, 0, 0, 0.01, 0]))
    bad = cueing.step(moving, Reference(specific_force=np.array([np.nan, 0.0, 0.0])))
    assert bad.outcome.status is Status.INVALID
    assert (bad.acceleration[[0, 4]] < 0.0).all()
    beyond = cueing.step(
        PlatformState(pose=np.array([5.0, 0, 0, 0, 0, 0])), Reference(specific_force=np.zeros(3))
    )
    assert (beyond.outcome.status, beyond.outcome.solver) == (Status.FALLBACK, "infeasible")
    cueing.reset(PlatformState())
    moving = PlatformState(pose=np.array([5.0, 0, 0, 0, 0, 0]), twist=np.array([0.2, 0, 0, 0, 0.01, 0]))
    braked = cueing.step(moving, Reference(specific_force=np.zeros(3)))
    assert braked.acceleration[0] < 0.0
    assert braked.acceleration[4] < 0.0


def test_a_preview_is_used_and_blocks_are_taken() -> None:
    settings = MpcSettings(horizon=20, blocks=(1, 1, 3, 5, 10), engine=CondensedEngine, prediction=Oracle())
    cueing = linear_mpc(design(mpc=settings))
    coming = np.zeros((20, 3))
    coming[10:, 0] = 1.0
    command = cueing.step(PlatformState(), Reference(specific_force=np.zeros(3), preview=coming))
    assert command.outcome.status is Status.DECIDED
    assert np.abs(command.plan).max() > 1e-3
    assert len(command.plan) >= 19  # and from its end to rest


@SENSED
def test_yaw_is_cued_to_size_where_the_platform_can_turn_so_far(make) -> None:
    """0.1 rad/s at 0.1 Hz turn a platform of ±25 deg by 18 deg."""
    run = loop(make(design(YAW)), scenario("sine-1", axis="yaw"), (YAW,))
    size = metrics.scale_ratio(run.reference_rate[:, 2], run.felt_rate[:, 2])
    assert 0.9 < size < 1.1
    assert all(excess.at_nodes < 1e-6 for excess in metrics.excesses(run))


def test_what_is_linear_and_what_is_sensed_is_as_each_algorithm_says() -> None:
    made = [make(design()) for make in (implicit, implicit_sensed, linear_mpc)]
    of = [one.problem.settings for one in made if isinstance(one, Mpc)]
    assert [one.linear for one in of] == [False, False, True]
    assert [one.objective.senses is not None for one in of] == [False, True, True]
    assert [one.braking.value for one in of] == ["stopping", "stopping", "leading"]


def test_after_a_reset_nobody_remembers_what_was_felt() -> None:
    cueing, fresh = (implicit_sensed(design()) for _ in range(2))
    reference = Reference(specific_force=np.array([0.7, 0.0, 0.0]))
    for _ in range(20):
        cueing.step(PlatformState(), reference)
    cueing.reset(PlatformState())
    first, again = fresh.step(PlatformState(), reference), cueing.step(PlatformState(), reference)
    assert_array_equal(first.acceleration, again.acceleration)
