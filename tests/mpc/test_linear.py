"""MPC with the driver's organs in the prediction, judged by things that share no code with it."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from otolith import metrics
from otolith.core.filter import Filter
from otolith.core.frames import GRAVITY, SURGE_PITCH, SWAY_ROLL
from otolith.interfaces import Cueing, PlatformState, Reference
from otolith.mpc.design import Design, implicit
from otolith.mpc.implicit import ImplicitSettings
from otolith.mpc.linear import implicit_sensed, linear_mpc
from otolith.mpc.perceiving import Organ
from otolith.perception import otoliths, sense
from otolith.plant import Ideal
from otolith.platforms import load
from otolith.qp import Status
from otolith.qp.engines import CondensedEngine, StructuredEngine, expand
from otolith.scenarios import Scenario, scenario
from otolith.simulate import Run, simulate

T = 0.01


def design(**fields) -> Design:
    fields = {"platform": load("davsi"), **fields}
    return Design(implicit=ImplicitSettings(horizon=20, engine=CondensedEngine), **fields)


def loop(cueing: Cueing, wanted: Scenario, pairs: tuple[str, ...] = ("surge-pitch",)) -> Run:
    return simulate(cueing, Ideal(), wanted, platform=load("davsi"), pairs=pairs, plant_period=2e-3)


def test_an_organ_follows_and_predicts_as_the_perception_module_senses() -> None:
    rng = np.random.default_rng(1)
    felt = np.cumsum(rng.normal(size=200)) * 0.05
    organ = Organ(otoliths.telban(), 30, T)
    for value in felt:
        organ.feel(value)
    system = otoliths.telban()
    now = (system.C @ organ.x)[0]
    theirs = sense(system, felt[:, None], T, before=np.zeros(1))
    assert now == pytest.approx(theirs[-1, 0], rel=1e-9)
    ahead = organ.ahead(np.full(30, 0.7))
    held = Filter(system.discretise(T))
    held.state = organ.x
    assert_allclose(ahead, held.simulate(np.full((31, 1), 0.7))[1:, 0], atol=1e-12)


def test_the_prediction_in_the_problem_is_what_is_then_sensed() -> None:
    """The plan's sensed force, from the QP's own matrices, against the organs' after driving the plan."""
    cueing = implicit_sensed(design())
    reference = Reference(specific_force=np.array([0.8, 0.0, 0.0]))
    state, plant = PlatformState(), Ideal()
    for _ in range(120):
        state = plant.step(cueing.step(state, reference), T)
    command = cueing.step(state, reference)
    problem, memory = cueing.problem, cueing.engine.memory
    qp = expand(problem.problem, memory)
    x, U = qp.x0, cueing._plan
    errors = []
    for k in range(20):
        x = problem.A @ x + problem.B @ U[k]
        errors.append(qp.output[k] @ x + qp.error[k])
    car, simulator = (Organ(otoliths.telban(), 20, T) for _ in range(2))
    simulator.x[:], simulator._felt = problem.here[0].x, problem.here[0]._felt
    car.x[:], car._felt = problem.there[0].x, problem.there[0]._felt
    controls = np.vstack([command.acceleration, command.plan])
    seen = []
    for k in range(20):
        driven = replace(command, acceleration=controls[k])
        state = plant.step(driven, T)
        simulator.feel(state.acceleration[0] - GRAVITY * np.sin(state.pose[4]))
        car.feel(0.8)
        seen.append((otoliths.telban().C @ (simulator.x - car.x))[0])
    assert_allclose(np.array(errors)[:, 0], seen, atol=5e-3)


@pytest.mark.parametrize("make", [linear_mpc, implicit_sensed])
def test_both_engines_decide_alike(make) -> None:
    runs = []
    for engine in (CondensedEngine, StructuredEngine):
        settings = ImplicitSettings(horizon=20, engine=engine)
        cueing = make(Design(platform=load("davsi"), implicit=settings))
        runs.append(loop(cueing, scenario("step:amplitude=1,duration=3")))
        assert set(runs[-1].status) == {"optimal"}
        assert runs[-1].residual.max() < 1e-6
    assert_allclose(runs[0].command, runs[1].command, atol=2e-3)


@pytest.mark.parametrize("make", [linear_mpc, implicit_sensed])
def test_limits_hold_in_four_degrees_of_freedom(make) -> None:
    cueing = make(design(pairs=(SURGE_PITCH, SWAY_ROLL)))
    along = "step:amplitude=2,duration=3,end=2.5"
    run = loop(cueing, scenario(along).beside(scenario(along, axis="lateral")), ("surge-pitch", "sway-roll"))
    assert set(run.status) == {"optimal"}
    for excess in metrics.excesses(run):
        assert excess.at_nodes < 1e-6, excess


def test_linear_sub_problems_do_not_know_of_each_other() -> None:
    """Four of them, and what is wanted sideways, upwards or in yaw leaves the surge as it is."""
    alone = linear_mpc(design())
    all_four = linear_mpc(design(pairs=(SURGE_PITCH, SWAY_ROLL), singles=("heave", "yaw")))
    assert [len(one.problem.parts) for one in all_four.parts] == [1, 1, 1, 1]
    state = PlatformState()
    force = np.array([0.5, -0.8, 0.4])
    for _ in range(5):
        many = all_four.step(state, Reference(specific_force=force, angular_rate=np.array([0.0, 0.0, 0.3])))
        one = alone.step(state, Reference(specific_force=force))
    assert_allclose(many.acceleration[[0, 4]], one.acceleration[[0, 4]], atol=1e-9)
    assert np.abs(many.acceleration[[1, 2, 3, 5]]).min() > 1e-4
    assert many.acceleration[2] > 0.1
    assert many.acceleration[5] > 0.1


def test_a_platform_predicts_where_its_command_leads() -> None:
    for make in (linear_mpc, implicit_sensed):
        cueing = make(design(pairs=(SURGE_PITCH, SWAY_ROLL), singles=("heave", "yaw")))
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
    assert beyond.outcome.status is Status.INFEASIBLE
    cueing.reset(PlatformState())
    moving = PlatformState(pose=np.array([5.0, 0, 0, 0, 0, 0]), twist=np.array([0.2, 0, 0, 0, 0.01, 0]))
    braked = cueing.step(moving, Reference(specific_force=np.zeros(3)))
    assert braked.acceleration[0] < 0.0
    assert braked.acceleration[4] < 0.0


def test_a_preview_is_used_and_blocks_are_taken() -> None:
    settings = ImplicitSettings(horizon=20, blocks=(1, 1, 3, 5, 10), engine=CondensedEngine)
    cueing = linear_mpc(Design(platform=load("davsi"), implicit=settings))
    coming = np.zeros((20, 3))
    coming[10:, 0] = 1.0
    command = cueing.step(PlatformState(), Reference(specific_force=np.zeros(3), preview=coming))
    assert command.outcome.status is Status.OPTIMAL
    assert np.abs(command.plan).max() > 1e-3
    assert len(command.plan) >= 19  # and from its end to rest


@pytest.mark.parametrize("make", [linear_mpc, implicit_sensed])
def test_yaw_is_cued_to_size_where_the_platform_can_turn_so_far(make) -> None:
    """0.1 rad/s at 0.1 Hz turn a platform of ±25 deg by 18 deg."""
    plant, davsi = Ideal(), load("davsi")
    wanted = scenario("sine-1", axis="yaw")
    run = simulate(
        make(design(pairs=(), singles=("yaw",))),
        plant,
        wanted,
        platform=davsi,
        pairs=(),
        singles=("yaw",),
        plant_period=T,
    )
    size = metrics.scale_ratio(run.reference_rate[:, 2], run.felt_rate[:, 2])
    assert 0.9 < size < 1.1
    assert all(excess.at_nodes < 1e-6 for excess in metrics.excesses(run))
