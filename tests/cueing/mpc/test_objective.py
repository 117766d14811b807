"""What the channels want and what the organs are told, against the same organs fed by hand."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from otolith.core.arrays import Mat, Vec
from otolith.core.filter import Filter
from otolith.core.frames import DOFS, GRAVITY, SURGE_PITCH, SWAY_ROLL, YAW, Dof
from otolith.core.lti import StateSpace, first_order_hold
from otolith.cueing.mpc import kernels, motion
from otolith.cueing.mpc.motion import in_six_axes, model_state, stacked
from otolith.cueing.mpc.objective import Objective
from otolith.cueing.mpc.problem import Problem
from otolith.cueing.mpc.settings import MpcSettings
from otolith.cueing.prediction import Hold
from otolith.interfaces import PlatformState, Reference
from otolith.perception import Vestibular, sense
from otolith.platforms import load
from otolith.qp.engines import empty_memory, expand

N, T = 30, 0.01
DAVSI = load("davsi")
SENSED = Objective(senses=Vestibular())
PITCH, ROLL = -0.3, 0.2  # [rad]; the nose up, and the left side up


def for_ever(reference: Reference, n: int) -> Mat:
    """What is wanted now, in each of n periods."""
    return Hold().ahead(reference, 0.01, n)


def sensed(*dofs: Dof, linear: bool = False) -> Problem:
    return Problem(DAVSI, dofs, MpcSettings(horizon=N, objective=SENSED, linear=linear))


def by_hand(organ: StateSpace, felt: Vec) -> Vec:
    """States of an organ after the series (n,), at rest before it, straight in between."""
    A, B0, B1 = first_order_hold(organ.A, organ.B, T)
    x, before = np.zeros(len(A)), 0.0
    for value in felt:
        x, before = A @ x + B0[:, 0] * before + B1[:, 0] * value, value
    return x


def held(problem: Problem, pose: Vec, reference: Reference) -> None:
    """A second at one pose."""
    x = model_state(problem.axes, PlatformState(pose=pose))
    for _ in range(100):
        kernels.sense(problem.given, x, problem.wanted(for_ever(reference, problem.settings.horizon)))


@pytest.mark.parametrize("dofs", [(SURGE_PITCH, SWAY_ROLL), (SURGE_PITCH,)])
@pytest.mark.parametrize("linear", [False, True])
def test_in_a_tilt_the_otoliths_are_told_of_gravity_as_it_is_and_the_canals_of_nothing(
    dofs: tuple[Dof, ...], linear: bool
) -> None:
    """g sin θ, not g θ, also where the prediction is linear; roll turns within pitch where both are cued."""
    problem = sensed(*dofs, linear=linear)
    pose = np.array([0.0, 0.0, 0.0, ROLL, PITCH, 0.0])
    held(problem, pose, Reference(specific_force=np.array([0.4, -0.3, 0.0])))
    forces = [-GRAVITY * np.sin(PITCH), GRAVITY * np.cos(PITCH) * np.sin(ROLL)]
    first = problem._organs.first
    for c, (force, wanted) in enumerate(zip(forces, (0.4, -0.3), strict=False)):
        if c >= len(dofs):
            break
        of_otolith, of_canal = slice(*first[2 * c : 2 * c + 2]), slice(*first[2 * c + 1 : 2 * c + 3])
        for state, value in ((problem._organs.here, force), (problem._organs.there, wanted)):
            series = np.full(100, value)
            assert_allclose(state[of_otolith], by_hand(Vestibular().otolith, series), rtol=1e-9)
            assert not state[of_canal].any()


def test_what_the_car_will_be_sensed_to_do_is_what_the_perception_module_senses() -> None:
    """A platform at rest: the errors are minus what the car's driver senses, from any past."""
    rng = np.random.default_rng(1)
    problem, x = sensed(SURGE_PITCH), np.zeros(6)
    past = np.cumsum(rng.normal(size=200)) * 0.05
    for value in past:
        kernels.sense(
            problem.given,
            x,
            problem.wanted(for_ever(Reference(specific_force=np.array([value, 0.0, 0.0])), N)),
        )
    organ = Vestibular().otolith
    theirs = sense(organ, past[:, None], T, before=np.zeros(1))
    there = problem._organs.there[slice(*problem._organs.first[:2])]
    assert (organ.C @ there)[0] == pytest.approx(theirs[-1, 0], rel=1e-9)

    memory = empty_memory(problem.structure)
    wanted = problem.wanted(for_ever(Reference(specific_force=np.array([0.7, 0.0, 0.0])), N))
    problem.write(memory, x, np.zeros((N, 2)), wanted, None)
    ahead = Filter(organ.discretise(T))
    ahead.state = there
    held_on = ahead.simulate(np.full((N + 1, 1), 0.7))[1:, 0]
    assert_allclose(memory.error[:, 0], -held_on, atol=1e-12)


def test_the_prediction_in_the_problem_is_what_is_then_sensed() -> None:
    """Plan driven by the exact model: what the organs then sense is what the QP says along that plan."""
    problem = sensed(SURGE_PITCH)
    rng = np.random.default_rng(3)
    held(problem, np.array([0.0, 0, 0, 0, 0.1, 0]), Reference(specific_force=np.array([0.8, 0, 0])))
    x, plan = 0.1 * rng.normal(size=6), np.repeat(rng.normal(size=(3, 2)), 10, axis=0)
    wanted = problem.wanted(
        for_ever(Reference(specific_force=np.array([0.8, 0, 0])), problem.settings.horizon)
    )
    memory = empty_memory(problem.structure)
    problem.begin(memory)
    kernels.sense(problem.given, x, wanted)
    problem.write(memory, x, plan, wanted, None)
    qp = expand(problem.structure, memory)
    z, errors = qp.x0, []
    for k in range(N):
        z = qp.problem.A @ z + qp.problem.B @ plan[k]
        errors.append(qp.output[k, 0] @ z + qp.error[k, 0])

    fine = 50  # steps per period
    X = np.empty((N * fine, 6))
    hold = np.tile(motion.held(0.01, T / fine), (2, 1))
    motion.predict(problem.axes, hold, x, np.repeat(plan, fine, axis=0), X)
    felt = X[:, 4] + GRAVITY * np.sin(X[:, 1])
    organ, first = Vestibular().otolith, slice(*problem._organs.first[:2])
    A, B0, B1 = first_order_hold(organ.A, organ.B, T / fine)
    here, there = problem._organs.here[first], problem._organs.there[first]
    before, seen = x[4] + GRAVITY * np.sin(x[1]), []
    for value in felt:
        here = A @ here + B0[:, 0] * before + B1[:, 0] * value
        there = A @ there + (B0[:, 0] + B1[:, 0]) * 0.8
        before = value
        seen.append(organ.C[0] @ (here - there))
    assert_allclose(
        errors, seen[fine - 1 :: fine], atol=2e-3
    )  # only what sin θ lacks of θ is held in the one


@pytest.mark.parametrize("pair", [SURGE_PITCH, SWAY_ROLL])
def test_the_rate_wanted_of_a_tilt_is_that_of_its_own_axis_and_of_no_other(pair: Dof) -> None:
    problem, wanted = sensed(pair), np.array([0.1, 0.2, 0.3])
    reference = Reference(specific_force=np.zeros(3), angular_rate=wanted)
    ahead = problem.wanted(for_ever(reference, N))[:, 1]
    assert_allclose(ahead, pair.sign * wanted[pair.rotation - 3])
    wanted[pair.rotation - 3] = 0.0
    reference = Reference(specific_force=np.zeros(3), angular_rate=wanted)
    assert_array_equal(problem.wanted(for_ever(reference, N))[:, 1], 0.0)


def test_the_rate_wanted_of_yaw_is_that_about_z() -> None:
    problem = Problem(DAVSI, (YAW,), MpcSettings(horizon=N))
    wanted = Reference(specific_force=np.zeros(3), angular_rate=np.array([0.1, 0.2, 0.3]))
    assert_array_equal(problem.wanted(for_ever(wanted, N)), np.full((N, 1), 0.3))


def test_states_and_commands_of_a_platform_go_to_the_model_and_back_in_its_signs() -> None:
    """Six axes at once: tilt = -pitch for surge, roll for sway; x in the thesis's order."""
    axes = stacked(tuple(DOFS.values()))
    pose, twist, acceleration = np.arange(1.0, 7.0), np.arange(11.0, 17.0), np.arange(21.0, 27.0)
    x = model_state(axes, PlatformState(pose=pose, twist=twist, acceleration=acceleration))
    assert_array_equal(x[:6], [-15, -5, 11, 1, 21, -25])
    assert_array_equal(x[6:12], [14, 4, 12, 2, 22, 24])
    assert_array_equal(x[12:], [13, 3, 23, 16, 6, 26])
    plan = np.arange(1.0, 7.0)[None]  # a_rot, a_tran of both pairs, heave, yaw
    assert_array_equal(in_six_axes(axes, plan)[0], [2, 4, 5, 3, -1, 6])
