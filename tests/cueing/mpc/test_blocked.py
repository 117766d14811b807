"""Inputs held over blocks: one formulation for both forms, limits at the nodes, plans in single steps."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from otolith import metrics, registry
from otolith.core.arrays import Mat, Vec
from otolith.core.frames import SURGE_PITCH, SWAY_ROLL, Dof
from otolith.cueing.design import Design
from otolith.cueing.mpc.controller import Mpc
from otolith.cueing.mpc.problem import Problem
from otolith.cueing.mpc.settings import BLOCKS, MpcSettings
from otolith.interfaces import PlatformState, Reference, Status
from otolith.loop import simulate
from otolith.plant import Ideal
from otolith.platforms import load
from otolith.qp.blocked import condense_blocked
from otolith.qp.condensed import CondensedSolver
from otolith.qp.engines import CondensedEngine, expand
from otolith.qp.stage import StageQp
from otolith.scenarios import scenario

SHORT = (1, 1, 3, 7)
PAIRS = pytest.mark.parametrize("pairs", [(SURGE_PITCH,), (SURGE_PITCH, SWAY_ROLL)], ids=["2 DOF", "4 DOF"])


def written(of: Problem, blocks: tuple[int, ...], x: Vec, plan: Mat, wanted: Mat, u_ref: Mat) -> StageQp:
    """The problem that a formulation writes, as a value with the arrays of all steps."""
    engine = CondensedEngine(of.structure, tolerance=1e-6, blocks=blocks)
    of.begin(engine.memory)
    of.write(engine.memory, x, plan, wanted, u_ref)
    return expand(of.structure, engine.memory, blocks)


@PAIRS
@given(seed=st.integers(0, 10_000))
@settings(max_examples=10, deadline=None)
def test_the_blocked_problem_is_the_full_one_with_inputs_held(pairs: tuple[Dof, ...], seed: int) -> None:
    rng = np.random.default_rng(seed)
    N, P = sum(SHORT), len(pairs)
    at = (0.2 * rng.normal(size=6 * P), rng.normal(size=(N, 2 * P)), rng.normal(size=(N, P)))
    u_ref = rng.normal(size=(N, 2 * P))
    soft = {"tilt_rate": 100.0}
    full, blocked = (
        Problem(load("thesis"), pairs, MpcSettings(horizon=N, soft=soft, blocks=blocks, later_penalty=np.inf))
        for blocks in ((), SHORT)
    )
    expected = condense_blocked(written(full, (), *at, u_ref), SHORT)
    of_blocks = written(blocked, SHORT, *at, u_ref)
    by_solver = CondensedSolver(blocked.structure, blocks=SHORT).condense(of_blocks)
    for found in (condense_blocked(of_blocks, SHORT), by_solver):
        for name in ("H", "g", "A", "lower", "upper", "penalty"):
            assert_allclose(getattr(found, name), getattr(expected, name), atol=1e-9)


def test_rows_on_states_are_hard_at_the_first_blocks_and_soft_after_them() -> None:
    options = MpcSettings(horizon=12, blocks=SHORT, later_penalty=7.0, soft={"tilt": 3.0})
    penalty = Problem(load("thesis"), (SURGE_PITCH,), options).structure.penalty
    tilt, commands = 1, slice(-2, None)
    assert_array_equal(penalty[:, tilt], 3.0)  # softer than asked for later: as the user says
    assert np.isinf(penalty[:2, 2:]).all()
    assert_array_equal(penalty[2:, 2:-2], 7.0)
    assert np.isinf(penalty[:, commands]).all()


@PAIRS
def test_a_plan_of_blocks_is_told_in_single_steps_and_ends_at_rest(pairs: tuple[Dof, ...]) -> None:
    mpc = registry.make_cueing("predictive", Design(platform=load("davsi-4dof"), dofs=pairs))
    assert isinstance(mpc, Mpc)
    blocks = mpc.settings.blocks
    mpc.reset(PlatformState())
    good = mpc.step(PlatformState(), Reference(specific_force=np.array([1.0, 0.5, 0.0])))
    assert good.outcome.status is Status.DECIDED
    held = np.repeat(np.arange(len(blocks)), blocks)
    assert len(good.plan) >= sum(blocks) - 1
    for block in range(1, len(blocks)):
        steps = 1 + np.flatnonzero(held[1:] == block)
        assert (good.plan[steps - 1] == good.plan[steps[0] - 1]).all()
    plant, state = Ideal(), PlatformState()
    for acceleration in (good.acceleration, *good.plan, *np.zeros((20, 6))):
        state = plant.step(replace(good, acceleration=acceleration), 0.01)
    assert np.abs(state.twist).max() < 1e-6


def test_a_long_horizon_travels_less_than_a_short_one() -> None:
    runs = [
        simulate(mpc, Ideal(), scenario("sine-1"), platform=load("thesis"), dofs=("surge-pitch",))
        for mpc in (
            Mpc(load("thesis"), (SURGE_PITCH,), MpcSettings()),
            Mpc(load("thesis"), (SURGE_PITCH,), MpcSettings(horizon=sum(BLOCKS), blocks=BLOCKS)),
        )
    ]
    short, long = (metrics.summarise(run) for run in runs)
    assert long["rmse"] < short["rmse"]
    assert long["travel_rms"]["surge"] < 0.5 * short["travel_rms"]["surge"]
