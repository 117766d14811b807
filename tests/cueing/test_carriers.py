"""Cueing with a base below the platform."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from otolith import metrics, registry
from otolith.core.arrays import Vec
from otolith.core.frames import BASES, SURGE_PITCH
from otolith.core.lti import zero_order_hold
from otolith.cueing.design import Design
from otolith.cueing.mpc.controller import Mpc
from otolith.cueing.mpc.motion import dynamics
from otolith.interfaces import Cueing, PlatformState
from otolith.loop import Run, simulate
from otolith.platforms import Platform, load
from otolith.qp.blocked import condense_blocked
from otolith.qp.dense import DenseSolver
from otolith.qp.engines import expand
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


def rmse(run: Run) -> float:
    return float(np.sqrt(np.mean((run.felt_force - run.reference_force)[:, 0] ** 2)))


def test_with_one_carrier_joint_is_predictive_bit_for_bit() -> None:
    wanted = scenario("combined:duration=4")
    joint, alone = (loop(name, wanted, THESIS) for name in ("joint", "predictive"))
    for series in ("pose", "command", "felt_force", "changes", "residual"):
        np.testing.assert_array_equal(getattr(joint, series), getattr(alone, series), err_msg=series)
    assert joint.base is None


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
    """Random states within the limits and random forces, up to the edge; the minimum of the cost agrees."""
    controller, rng = mpc("joint"), np.random.default_rng(seed)
    of, engine = controller.problem, controller.engine
    scale = np.array([0.05, 0.1, 0.4, 0.15, 2.0, 0.1, 2.0, 2.0, 2.0])
    x = rng.uniform(-0.6, 0.6, 9) * scale
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


@settings(max_examples=15, deadline=None, derandomize=True)
@given(heights=st.lists(st.floats(-8.0, 8.0), min_size=2, max_size=12))
def test_every_limit_of_every_carrier_holds(heights: list[float]) -> None:
    run = loop("joint", jumps(heights))
    assert set(run.status) == {"decided"}
    for excess in metrics.excesses(run):
        assert excess.at_nodes < 1e-6, excess


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
