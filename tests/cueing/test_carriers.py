"""Cueing with a base below the platform."""

import time
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from otolith import files, metrics, registry
from otolith.core.arrays import Vec
from otolith.core.errors import InputError
from otolith.core.frames import BASES, SURGE_PITCH
from otolith.core.lti import zero_order_hold
from otolith.cueing.design import Design
from otolith.cueing.mpc.controller import Mpc
from otolith.cueing.mpc.motion import dynamics, stacked
from otolith.cueing.mpc.rows import BrakingRows, interference_rows
from otolith.cueing.mpc.settings import MpcSettings
from otolith.cueing.several import Several
from otolith.interfaces import Cueing, PlatformState, Reference
from otolith.loop import Run, simulate
from otolith.plant import Ideal
from otolith.platforms import Platform, load
from otolith.qp.blocked import condense_blocked
from otolith.qp.dense import DenseSolver
from otolith.qp.engines import CondensedEngine, expand
from otolith.scenarios import Scenario, scenario

ULTIMATE, THESIS = load("ultimate"), load("thesis")


@cache
def algorithm(name: str, platform: Platform = ULTIMATE) -> Cueing:
    return registry.make_cueing(name, Design(platform=platform))


def loop(name: str, wanted: Scenario, platform: Platform = ULTIMATE) -> Run:
    plant = registry.make_plant("ideal", platform)
    return simulate(algorithm(name, platform), plant, wanted, platform=platform, dofs=("surge-pitch",))


def jumps(heights: list[float], *, then: float = 0.0) -> Scenario:
    """Forces that jump every half second, and then rest."""

    def force(t: Vec) -> Vec:
        f = np.zeros((len(t), 3))
        for k, height in enumerate(heights):
            f[(t >= 0.5 * k) & (t < 0.5 * (k + 1)), 0] = height
        return f

    return Scenario(name="jumps", duration=0.5 * len(heights) + then, specific_force=force)


def mpc(name: str) -> Mpc:
    found = algorithm(name)
    assert isinstance(found, Mpc)
    return found


FOUR = ("joint", "lnl", "nll", "split")


def rmse(run: Run) -> float:
    return float(np.sqrt(np.mean((run.felt_force - run.reference_force)[:, 0] ** 2)))


@pytest.mark.parametrize("name", FOUR)
def test_with_one_carrier_each_is_predictive_bit_for_bit(name: str) -> None:
    wanted = scenario("combined:duration=4")
    carried, alone = (loop(one, wanted, THESIS) for one in (name, "predictive"))
    for series in ("pose", "command", "felt_force", "changes", "residual"):
        np.testing.assert_array_equal(getattr(carried, series), getattr(alone, series), err_msg=series)
    assert carried.base is None


def test_the_base_is_a_column_of_b_on_the_same_channel() -> None:
    """The model written by hand: the force is the sum of both accelerations and of gravity."""
    problem = mpc("joint").problem
    assert problem.dofs == (SURGE_PITCH, BASES[0])
    A, B = dynamics(problem.axes, np.array([0.01, 0.01, 0.08]))
    of_x, of_u = zero_order_hold(A, B, 0.01)
    np.testing.assert_array_equal(problem.structure.A, of_x)
    np.testing.assert_array_equal(problem.structure.B, of_u)
    (row,) = problem.given.felt.row
    np.testing.assert_array_equal(row, [0.0, 9.81, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0])


@pytest.mark.parametrize("seed", range(12))
def test_every_answer_is_that_of_a_dense_solver(seed: int) -> None:
    """Random states from which the platform can stop, and random forces far beyond its reach."""
    controller, rng = mpc("joint"), np.random.default_rng(seed)
    of, engine = controller.problem, controller.engine
    scale = np.array([0.05, 0.1, 0.4, 0.15, 2.0, 0.1, 0.8, 1.2, 2.0])
    x = rng.uniform(-0.4, 0.4, 9) * scale
    plan = np.zeros((of.settings.horizon, 3))
    wanted = np.repeat(rng.normal(0.0, 2.0, (5, 1)), 30, axis=0)
    of.write(engine.memory, x, plan, wanted, None)
    engine.reset()
    found = engine.run()
    assert found.residual < 1e-6
    qp = condense_blocked(expand(of.structure, engine.memory, of.settings.blocks), of.settings.blocks)
    exact = DenseSolver(tolerance=1e-6).solve(qp)
    np.testing.assert_allclose(found.U.ravel(), exact.z, atol=1e-5)
    controller.reset(PlatformState())


@pytest.mark.parametrize("name", FOUR)
@settings(max_examples=12, deadline=None, derandomize=True)
@given(heights=st.lists(st.floats(-8.0, 8.0), min_size=2, max_size=12))
def test_every_limit_of_every_carrier_holds(name: str, heights: list[float]) -> None:
    run = loop(name, jumps(heights))
    assert set(run.status) == {"decided"}
    for excess in metrics.excesses(run):
        assert excess.at_nodes < 1e-6, excess


def together(bound: float, **others: float) -> Platform:
    """`ultimate` with a wall that the rail and the hexapod on it reach together."""
    values = ULTIMATE.model_dump()
    values["base"]["interference"] = [{"surge": 1.0, "base_surge": 1.0, "at_most_m": bound, **others}]
    return Platform.model_validate(values)


@pytest.mark.parametrize("name", ["joint", "lnl", "nll"])
def test_base_and_platform_stay_apart_where_they_would_not_without_the_rows(name: str) -> None:
    """By the file and the motion alone; a base that decides first leaves room for all that follows."""
    wall, push = together(0.4), scenario("step-2").part(0.9, 3.2)
    (free,) = (one for one in metrics.excesses(replace(loop(name, push), platform=wall)) if one.violations)
    assert (free.quantity, free.limit) == ("interference 1", (-2.85, 0.4))
    assert free.at_nodes > 0.5
    dense = MpcSettings(engine=CondensedEngine)
    cueing = registry.make_cueing(name, Design(platform=wall, mpc=dense))
    run = simulate(
        cueing,
        registry.make_plant("ideal", wall),
        push,
        platform=wall,
        dofs=("surge-pitch",),
        plant_period=0.01,
    )
    assert set(run.status) == {"decided"}
    assert not any(one.violations for one in metrics.excesses(run))
    assert run.base is not None
    assert (run.pose[:, 0] + run.base[:, 0]).max() > 0.2  # the room is used


def test_the_row_is_the_braking_law_of_the_sum_less_the_reach_of_what_another_decides() -> None:
    platform = together(3.0, sway=-0.5)
    own, both = stacked((SURGE_PITCH, BASES[0])), BrakingRows.STOPPING
    (row,) = interference_rows(platform, own, both)
    assert row.upper == pytest.approx(3.0 - 0.5 * 0.25)
    x = np.arange(9.0)
    s, v, a = (x[own.place], x[own.speed], x[own.acceleration])
    law = [of[1] + of[2] for of in (s, v, a)]  # surge of platform and base
    assert row.coefficients @ x == pytest.approx(law[0] + 2.5 * law[1] + 0.5 * 0.45 * 2.5**2 * law[2])
    assert interference_rows(platform, stacked((SURGE_PITCH,)), both) == []
    assert interference_rows(platform, stacked((BASES[1],)), both) == []


def test_a_fixed_split_refuses_what_it_could_not_keep() -> None:
    with pytest.raises(
        InputError, match=r"\[\[base.interference\]\] of platform ultimate is given, must be left"
    ):
        registry.make_cueing("split", Design(platform=together(0.4)))


def test_the_limits_of_the_base_are_judged() -> None:
    """By the file and the motion alone: the same run on a platform whose rail is shorter breaks its limit."""
    run = loop("joint", scenario("step-1"))
    values = ULTIMATE.model_dump()
    values["base"]["surge"]["position_m"] = [-0.5, 0.5]
    short = Platform.model_validate(values)
    broken = {one.quantity for one in metrics.excesses(replace(run, platform=short)) if one.violations}
    assert broken == {"base-surge position"}


def test_what_is_felt_is_the_sum_of_both_carriers_and_gravity() -> None:
    run = loop("joint", scenario("step-1"))
    assert run.base is not None
    expected = run.acceleration[:, 0] + run.base[:, 12] - 9.81 * np.sin(run.pose[:, 4])
    np.testing.assert_allclose(run.felt_force[:, 0], expected, atol=1e-12)
    assert np.abs(run.base[:, 0]).max() > 4.0 * np.abs(run.pose[:, 0]).max()  # the larger reach does more


@pytest.mark.parametrize("name", FOUR)
def test_the_loop_in_python_gives_the_numbers_of_the_compiled_one(name: str) -> None:
    plant = registry.make_plant("ideal", ULTIMATE)
    runs = [
        simulate(
            algorithm(name),
            plant,
            jumps([1.0, -3.0, 6.0]),
            platform=ULTIMATE,
            dofs=("surge-pitch",),
            clock=clock,
        )
        for clock in (time.thread_time, lambda: 0.0)
    ]
    for series in ("pose", "base", "base_command", "felt_force", "command"):
        np.testing.assert_array_equal(getattr(runs[0], series), getattr(runs[1], series), err_msg=series)


def test_the_second_mpc_follows_what_the_first_one_s_plan_leaves() -> None:
    """The plan's force, by the plant: the base's accelerations under the commands of its plan."""
    cueing = algorithm("lnl")
    assert isinstance(cueing, Several)
    base, own = cueing.parts
    assert isinstance(base, Mpc)
    assert isinstance(own, Mpc)
    cueing.reset(PlatformState())
    command = cueing.step(PlatformState(), Reference(specific_force=np.array([1.5, 0.0, 0.0])))
    assert command.base is not None
    alone = mpc("joint").problem.settings.prediction
    assert alone is not None
    coming = alone.begin().ahead(Reference(specific_force=np.array([1.5, 0.0, 0.0])), 0.01, 150)
    plant, felt = Ideal(0.08), []
    for u in np.vstack([command.base.acceleration, command.base.plan])[:150]:
        moved = plant.step(replace(command, acceleration=u, base=None), 0.01)
        felt.append(moved.acceleration[0])
    expected = coming[:, 0] - np.interp(np.arange(150), np.arange(len(felt)), felt)
    np.testing.assert_allclose(own.program.wanted[:, 0], expected, atol=1e-9)


def test_a_shorter_second_horizon_is_taken_and_a_longer_one_refused() -> None:
    with pytest.raises(InputError, match="horizon of the second MPC is 200 steps, must be at most"):
        registry.make_cueing("lnl", Design(platform=ULTIMATE, second_blocks=(1, 1, 198)))
    with pytest.raises(InputError, match="of at least 1 step each"):
        Design(platform=ULTIMATE, second_blocks=(0, 1))


@pytest.mark.parametrize("name", ["lnl", "nll"])
def test_blocks_of_a_second_mpc_are_refused_where_nothing_carries_the_platform(name: str) -> None:
    with pytest.raises(InputError, match="no base of platform thesis moves along surge-pitch"):
        registry.make_cueing(name, Design(platform=load("thesis"), second_blocks=(1, 1)))


def test_the_split_follows_its_low_pass() -> None:
    """Against the transfer function: of a sine at the cutoff the base's share is 1/√2, and 45 deg late."""
    run = loop("split", scenario("sine:amplitude=0.5,frequency=2,duration=6"))
    assert run.base is not None
    late = run.time > 3.0
    wave = np.exp(-2j * np.pi * 2.0 * run.time[late])
    base, both = run.base[late, 12] @ wave, (run.base[late, 12] + run.acceleration[late, 0]) @ wave
    assert abs(base / both) == pytest.approx(np.sqrt(0.5), abs=0.02)
    assert np.degrees(np.angle(base / both)) == pytest.approx(-45.0, abs=2.0)


@pytest.mark.parametrize("name", FOUR)
def test_a_run_on_a_base_is_stored_and_read_as_it_was(name: str, tmp_path: Path) -> None:
    run = loop(name, jumps([1.0]))
    files.write_run(run, tmp_path / "run.h5")
    again = files.read_run(tmp_path / "run.h5")
    np.testing.assert_array_equal(again.base, run.base)
    np.testing.assert_array_equal(again.base_command, run.base_command)
    assert again.platform == ULTIMATE
    with files.open_run(tmp_path / "run.h5") as stored:
        np.testing.assert_array_equal(stored.base, run.base)


def test_the_rail_comes_home_unfelt() -> None:
    """From 2 m of its 2.6 m, while nothing is wanted: to a millimetre within a minute, as the platform."""
    cueing, plant = algorithm("joint"), registry.make_plant("ideal", ULTIMATE)
    state = PlatformState(base=PlatformState(pose=np.array([2.0, 0.0, 0.0, 0.0, 0.0, 0.0])))
    cueing.reset(state)
    plant.reset(state)
    felt = []
    for _ in range(6000):
        state = plant.step(cueing.step(state, Reference(specific_force=np.zeros(3))), 0.01)
        assert state.specific_force is not None
        felt.append(state.specific_force[0])
    assert state.base is not None
    assert abs(state.base.pose[0]) < 1e-3
    assert np.abs(state.pose).max() < 1e-3
    assert np.abs(felt).max() < 0.02


@pytest.mark.parametrize("name", FOUR)
def test_a_late_plant_is_looked_ahead_for_both_carriers(name: str) -> None:
    """On actuators with a dead time the limits of both hold at the nodes, to what timing leaves."""
    plant = registry.make_plant("actuator", ULTIMATE)
    cueing = registry.make_cueing(name, Design(platform=ULTIMATE), dead_time=plant.dead_time)
    run = simulate(cueing, plant, jumps([1.0, 2.0, -4.0, 3.0, 0.0]), platform=ULTIMATE, dofs=("surge-pitch",))
    assert set(run.status) == {"decided"}
    assert run.base is not None
    assert np.abs(run.base[:, 0]).max() > 0.05
    for excess in metrics.excesses(run):
        assert excess.at_nodes < 1e-6, excess
