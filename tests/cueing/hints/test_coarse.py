"""The coarse explicit law against daqp on the same coarse problem, and how its rows are carried over."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from otolith.core.frames import SURGE_PITCH, SWAY_ROLL
from otolith.cueing.hints.coarse import Coarse, CoarseLaws, coarse_lengths, coarse_problem
from otolith.cueing.mpc.problem import Problem
from otolith.cueing.mpc.settings import BLOCKS, MpcSettings
from otolith.cueing.mpc.washout_weights import constant
from otolith.platforms import load
from otolith.qp.condensed import CondensedSolver
from otolith.qp.engines import CondensedEngine
from otolith.qp.problem import Status

THESIS = load("thesis")
WEIGHTS = {"velocity": 0.7, "position": 4.0}
CONSTANT = MpcSettings(washout=constant(WEIGHTS))
LEVEL = np.array([list(WEIGHTS.values())])


def nothing_learned(pairs: int) -> CoarseLaws:
    return CoarseLaws(LEVEL, (np.empty((0, 7)),) * pairs)


def states(count: int) -> np.ndarray:
    """Random states and forces that a drive may visit: (count, 7)."""
    rng = np.random.default_rng(11)
    return rng.uniform(-1.0, 1.0, (count, 7)) * [0.05, 0.1, 0.1, 0.2, 0.3, 1.0, 2.0]


def test_the_law_holds_the_rows_that_daqp_holds() -> None:
    lengths = coarse_lengths(CONSTANT)
    assert lengths == (5,) * 10
    formulation = Problem(THESIS, (SURGE_PITCH,), replace(CONSTANT, blocks=lengths, firm=10))
    engine = CondensedEngine(formulation.structure, tolerance=1e-6, blocks=lengths)
    formulation.begin(engine.memory)
    law, agreed = Coarse(nothing_learned(1), THESIS, (SURGE_PITCH,), CONSTANT), 0
    for theta in states(60):
        x = theta[:6].copy()
        formulation.write(engine.memory, np.zeros(6), np.zeros((50, 2)), np.zeros((50, 1)), None)
        engine.memory.start[:], engine.memory.error[:] = x, -theta[6]  # linearised at zero tilt
        engine.memory.state_weight[:] = LEVEL
        by_daqp = engine.run(np.zeros((10, formulation.structure.rows), dtype=np.int64))
        found = law.coarse_set(0, x, theta[6])
        if by_daqp.status is Status.OPTIMAL:
            assert found is not None
            weak = np.abs(by_daqp.y) < 1e-7  # a row without force may be held or not
            assert_array_equal(found[~weak], by_daqp.working_set[~weak])
            agreed += 1
        else:
            assert found is None
    assert agreed > 20


def test_the_laws_problem_is_the_condensed_problem_at_every_parameter() -> None:
    made = coarse_problem(THESIS, SURGE_PITCH, CONSTANT, LEVEL[0])
    assert made.problem.H.shape == (20, 20)
    assert made.problem.F.shape == (20, 7)
    low, high = made.problem.lower, made.problem.upper
    assert (low < 0.0).all()
    assert (high > 0.0).all()
    assert set(made.side) == {-1, 1}


def test_a_law_that_has_visited_a_drive_knows_it_afterwards() -> None:
    law = Coarse(nothing_learned(1), THESIS, (SURGE_PITCH,), CONSTANT)
    drive = states(40) * 0.3
    met = law.visit(drive[:, :6], drive[:, 6:])
    again = Coarse(CoarseLaws(LEVEL, met), THESIS, (SURGE_PITCH,), CONSTANT)
    assert again.regions == law.regions == len(met[0])
    assert again.visit(drive[:, :6], drive[:, 6:])[0].shape == (0, 7)


@pytest.mark.parametrize(
    "settings", [CONSTANT, replace(CONSTANT, horizon=sum(BLOCKS), blocks=BLOCKS)], ids=["full", "blocked"]
)
def test_rows_are_carried_to_their_own_kind_pair_and_time(settings: MpcSettings) -> None:
    """One row of one pair, active throughout on the coarse grid, is that row on the fine one."""
    pairs = (SURGE_PITCH, SWAY_ROLL)
    fine = Problem(THESIS, pairs, settings).structure
    law = Coarse(nothing_learned(2), THESIS, pairs, settings)
    names = ["tilt_rate", "tilt", "velocity", "position", "braking_position", "braking_tilt"]
    for p, pair in enumerate(pairs):
        own = Problem(THESIS, (pair,), settings).structure
        for row, name in enumerate([*names, "rotation", "translation"]):
            coarse = np.zeros((len(coarse_lengths(settings)), own.rows), dtype=np.int64)
            coarse[:, row] = 1
            found = np.zeros(law._carry.shape, dtype=np.int64)
            law._carry.add(p, coarse, found)
            (active,) = np.nonzero(found.all(axis=0))
            assert found.sum() == found[:, active].sum()
            if name == "position":  # the circle limits both together
                assert len(active) == 0
            elif row < len(names):
                assert_array_equal(fine.C[active[0], 6 * p : 6 * p + 6], own.C[row])
            else:
                assert active[0] == fine.rows - 4 + 2 * p + row - len(names)


def test_the_set_of_all_pairs_is_made_of_what_each_law_says_of_its_own_states_and_force() -> None:
    law, answered = Coarse(nothing_learned(2), THESIS, (SURGE_PITCH, SWAY_ROLL), CONSTANT), 0
    for question in states(40).reshape(20, 2, 7):
        x, wanted = question[:, :6].ravel(), question[:, 6].copy()
        each = [law.coarse_set(p, state[:6], state[6]) for p, state in enumerate(question)]
        found = law.sets(x, wanted, np.empty((0, 0)))
        if each[0] is None or each[1] is None:
            assert found is None
            continue
        expected = np.zeros(law._carry.shape, dtype=np.int64)
        for p, rows in enumerate(each):
            assert rows is not None
            law._carry.add(p, rows, expected)
        assert_array_equal(found, expected[None])
        answered += bool(expected.any())
    assert answered > 3


def test_times_are_the_nearest_and_inputs_those_of_the_block() -> None:
    law = Coarse(nothing_learned(1), THESIS, (SURGE_PITCH,), CONSTANT)
    coarse = np.zeros((10, 8), dtype=np.int64)
    coarse[3, 0], coarse[3, -1] = -1, 1  # block 4: steps 15 to 19, its end at 0.20 s
    fine = np.zeros((50, 8), dtype=np.int64)
    law._carry.add(0, coarse, fine)
    assert_array_equal(np.flatnonzero(fine[:, 0]), [17, 18, 19, 20, 21])  # 0.18 s to 0.22 s
    assert_array_equal(np.flatnonzero(fine[:, -1]), [15, 16, 17, 18, 19])
    assert CondensedSolver(Problem(THESIS, (SURGE_PITCH,), CONSTANT).structure).problem.rows == 8
