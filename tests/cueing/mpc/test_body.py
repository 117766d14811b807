"""The whole body as part of the MPC: its rows and outputs against the legs and the head themselves."""

import tomllib
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from otolith import registry
from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError
from otolith.core.frames import DOFS, HEAVE, SURGE_PITCH, SWAY_ROLL, YAW, Dof
from otolith.core.rotation import felt, rate_along
from otolith.cueing.design import Design, reweigh
from otolith.cueing.mpc.body import BODY_ROWS, MARGINS, Body, _misjudged
from otolith.cueing.mpc.controller import Mpc
from otolith.cueing.mpc.decide import ROUND
from otolith.cueing.mpc.motion import in_six_axes
from otolith.interfaces import PlatformState, Reference, Status
from otolith.loop import simulate
from otolith.plant import Ideal
from otolith.platforms import Platform, load
from otolith.platforms.template import template
from otolith.qp.blocked_engine import BlockedEngine
from otolith.qp.engines import expand
from otolith.scenarios import scenario

DAVSI = load("davsi")
ALL = tuple(DOFS.values())
SETS = pytest.mark.parametrize(
    "dofs", [ALL, (SURGE_PITCH,), (HEAVE,), (SWAY_ROLL, YAW)], ids=lambda dofs: "+".join(d.name for d in dofs)
)


def with_head(platform: Platform) -> Platform:
    hexapod = platform.hexapod
    assert hexapod is not None
    return platform.model_copy(update={"hexapod": hexapod.model_copy(update={"head_m": (-0.3, 0.1, 0.9)})})


def controller(dofs: tuple[Dof, ...] = ALL, platform: Platform = DAVSI) -> Mpc:
    made = registry.make_cueing("six-axis", Design(platform=platform, dofs=dofs))
    assert isinstance(made, Mpc)
    return made


def motions(mpc: Mpc, X: Mat) -> list[Mat]:
    """The platform's motion (3, 6) in every state of a prediction."""
    axes = mpc.problem.axes
    parts = (X[:, axes.place], X[:, axes.speed], X[:, axes.acceleration])
    return list(np.stack([in_six_axes(axes, part) for part in parts], axis=1))


def random_plan(mpc: Mpc, rng: np.random.Generator) -> tuple[Vec, Mat]:
    nu = len(mpc.problem.axes.axis)
    x = np.zeros(3 * nu)
    x[mpc.problem.axes.place] = rng.uniform(-0.1, 0.1, nu)
    x[mpc.problem.axes.speed] = rng.uniform(-0.1, 0.1, nu)
    return x, mpc.problem.of_steps(0.2 * rng.uniform(-1.0, 1.0, (9, nu)))


@SETS
def test_rows_and_outputs_are_those_of_the_legs_and_the_head_to_first_order(dofs: tuple[Dof, ...]) -> None:
    """About a plan they are exact; beside it, what is left falls with the square of the distance."""
    platform = with_head(DAVSI)
    mpc, rng, head = controller(dofs, platform), np.random.default_rng(2), np.array([-0.3, 0.1, 0.9])
    problem, legs = mpc.problem, platform.six_legs()
    x, plan = random_plan(mpc, rng)
    wanted = rng.standard_normal((150, len(problem.channels)))
    problem.write(mpc.engine.memory, x, plan, wanted, None)
    qp = expand(problem.structure, mpc.engine.memory, mpc.settings.blocks)
    ends = np.cumsum(mpc.settings.blocks) - 1
    limits = np.array([legs.stroke[1], legs.speed, legs.acceleration])
    washout = {dof.name: () for dof in dofs}
    body = Body(platform=platform, washout=washout, weights={}, period=0.01, lag=0.01, settled=1.0)
    margins = [[size * (1.0 + 0.1 * leg) for leg in range(6)] for size in MARGINS]
    high = (limits[:, None] - margins - np.array(body.between)[:, None]).ravel()
    of_legs = slice(len(problem.structure.C) + len(problem.structure.varying) - BODY_ROWS, -len(plan[0]))
    change = mpc.problem.of_steps(rng.uniform(-1.0, 1.0, (9, plan.shape[1])))
    left = []
    for share in (0.0, 1e-3, 2e-3):
        X = problem.predicted(x, plan + share * change)
        errors = []
        for k, motion in enumerate(motions(mpc, X)):
            force, rate = np.empty(3), np.empty((1, 3))
            felt(head, motion[0], motion[1], motion[2], force)
            rate_along(motion[:1], motion[1:2], rate)
            feels = np.concatenate([force, rate[0]])
            root = np.sqrt([one.weight for one in problem.channels])
            exact = root * (feels[[one.column for one in problem.channels]] - wanted[k])
            errors.append(np.abs(qp.output[k] @ X[k] + qp.error[k] - exact).max())
            if k in ends:
                now = legs.leg_motion(*motion)
                lead = legs.speed / legs.acceleration + 0.02  # lag and period
                ahead = now.speed + 0.01 * now.acceleration  # through the lag
                leading = now.length + 0.01 * now.speed + lead * ahead
                values = np.concatenate([leading, ahead, now.acceleration])
                room = qp.upper[k, of_legs][:18] - qp.varying[k, -BODY_ROWS:-3] @ X[k]
                errors.append(np.abs(room - (high - values)).max())
        left.append(max(errors))
    assert left[0] < 1e-11
    assert left[2] / left[1] == pytest.approx(4.0, rel=0.1)


def test_legs_of_either_side_that_move_alike_leave_no_step_without_an_answer() -> None:
    """On a drive along x; with equal margins two of these steps have no certified answer."""
    wanted = scenario("sine:amplitude=1.5,frequency=0.27,duration=5")
    names = tuple(dof.name for dof in ALL)
    run = simulate(controller(), Ideal(), wanted, platform=DAVSI, dofs=names, plant_period=0.01)
    assert set(run.status) == {"decided"}
    assert np.abs(run.pose[:, [1, 3, 5]]).max() < 0.01  # nearly straight on


def test_what_a_step_misjudges_is_what_its_rows_cost_in_truth() -> None:
    """Relative to the cost of errors and rows that the linear problem sees, both as at the ends of blocks."""
    mpc, rng, legs = controller(), np.random.default_rng(5), DAVSI.six_legs()
    problem, memory, blocks = mpc.problem, mpc.engine.memory, mpc.settings.blocks
    x, plan = random_plan(mpc, rng)
    problem.write(memory, x, plan, rng.standard_normal((150, len(problem.channels))), None)
    qp, ends = expand(problem.structure, memory, blocks), np.cumsum(blocks) - 1
    body = Body(
        platform=DAVSI, washout={dof.name: () for dof in ALL}, weights={}, period=0.01, lag=0.01, settled=1.0
    )
    low, high = body.bounds(problem.axes)
    of_body = slice(len(problem.structure.C) + len(problem.structure.varying) - BODY_ROWS, -len(plan[0]))
    for size in (0.01, 3.0):
        X = problem.predicted(x, plan + problem.of_steps(size * rng.uniform(-1.0, 1.0, (9, plan.shape[1]))))
        whole = more = 0.0
        for block, k in enumerate(ends):
            whole += 0.5 * blocks[block] * float(np.sum((qp.output[k] @ X[k] + qp.error[k]) ** 2))
            (motion,) = motions(mpc, X[k : k + 1])
            now, rate = legs.leg_motion(*motion), np.empty((1, 3))
            rate_along(motion[:1], motion[1:2], rate)
            ahead = now.speed + 0.01 * now.acceleration
            leading = now.length + 0.01 * now.speed + body.lead * ahead
            truth = beyond(np.concatenate([leading, ahead, now.acceleration, rate[0]]), low, high)
            linear = qp.varying[k, -BODY_ROWS:] @ X[k]
            thought = beyond(linear, qp.lower[k, of_body], qp.upper[k, of_body])
            price = problem.structure.penalty[k, of_body]
            whole += float(price @ thought)
            more += float(price @ np.maximum(truth - thought, 0.0))
        found = _misjudged(
            problem._of_body[1].held,
            X,
            memory.output,
            memory.error,
            memory.varying,
            memory.lower,
            memory.upper,
        )
        assert found == pytest.approx(more / whole, rel=1e-9, abs=1e-12)
    assert found > 0.0


def beyond(values: Vec, low: Vec, high: Vec) -> Vec:
    return np.maximum(np.maximum(values - high, low - values), 0.0)


def on_cranks() -> Platform:
    """The cranks of the template, with limits per axis of which most are out of reach."""
    table = tomllib.loads(template("cranks"))
    of_axes = DAVSI.model_dump(exclude_none=True)
    table |= {name: of_axes[name] for name in ("surge", "sway", "heave", "roll", "pitch", "yaw")}
    table.pop("workspace")
    return Platform.model_validate(table)


def test_a_pose_that_cranks_do_not_reach_has_the_rows_of_the_one_before() -> None:
    """At its own place they would be no numbers; and what a plan there has misjudged is without bound."""
    mpc = controller(platform=on_cranks())
    problem, memory, ends = mpc.problem, mpc.engine.memory, np.cumsum(mpc.settings.blocks) - 1
    up = np.zeros((150, 6))
    up[:, list(problem.axes.axis).index(2)] = 1.0
    x = np.zeros(18)
    problem.write(memory, x, up, np.zeros((150, len(problem.channels))), None)
    X = problem.predicted(x, up)
    legs = on_cranks().six_legs()
    reached = [bool(np.isfinite(legs.leg_motion(*motions(mpc, X[k : k + 1])[0]).length).all()) for k in ends]
    assert not reached[-1]
    assert reached[0]
    assert all(np.isfinite(getattr(memory, name)).all() for name in ("varying", "output", "error"))
    last = int(np.argmin(reached))
    assert np.array_equal(memory.varying[-1], memory.varying[last - 1])
    assert not np.array_equal(memory.varying[last - 1], memory.varying[0])
    rows = (memory.output, memory.error, memory.varying, memory.lower, memory.upper)
    assert _misjudged(problem._of_body[1].held, X, *rows) == np.inf


def test_on_cranks_random_jumps_leave_no_step_without_answer_and_every_crank_within_its_limits() -> None:
    """Linearised about poses that cranks do not reach, steps had problems that nothing could solve."""
    platform, rng, held = on_cranks(), np.random.default_rng(8), 8
    mpc, plant, state, legs = controller(platform=platform), Ideal(), PlatformState(), platform.six_legs()
    plant.reset(state)
    found, furthest = Counter[Status](), 0.0
    for k in range(800):
        if k % held == 0:
            size = np.exp(rng.uniform(np.log(0.1), np.log(50.0)))
            force, rate = size * rng.standard_normal(3), size * rng.standard_normal(3) * [0.02, 0.02, 0.1]
        command = mpc.step(state, Reference(specific_force=force, angular_rate=rate))
        found[command.outcome.status] += 1
        state = plant.step(command, mpc.period)
        now = legs.leg_motion(state.pose, state.twist, state.acceleration)
        low, high = legs.stroke
        shares = (
            np.abs(now.length - 0.5 * (low + high)).max() / (0.5 * (high - low)),
            np.abs(now.speed).max() / legs.speed,
            np.abs(now.acceleration).max() / legs.acceleration,
        )
        assert max(shares) <= 1.0
        furthest = max(furthest, *shares[:2])
    assert found == {Status.DECIDED: 800}
    assert furthest > 0.95  # so the limits were met


def displaced(platform: Platform, seed: int) -> Platform:
    """The same machine with shafts, joints and headings displaced at random."""
    table, legs = platform.model_dump(exclude_none=True), platform.six_legs()
    hexapod, rng = table["hexapod"], np.random.default_rng(seed)
    hexapod.pop("circles")
    shift = np.array([0.0, 0.0, hexapod["neutral_height_m"]])
    shafts = legs.anchors + shift + rng.uniform(-0.04, 0.04, (6, 3))
    joints = legs.joints + rng.uniform(-0.04, 0.04, (6, 3))
    hexapod["joints"] = {"base_m": shafts.tolist(), "platform_m": joints.tolist()}
    heading = np.array(hexapod["cranks"]["heading_deg"]) + rng.uniform(-15.0, 15.0, 6)
    hexapod["cranks"]["heading_deg"] = heading.tolist()
    return Platform.model_validate(table)


def test_a_search_that_goes_round_in_circles_begins_anew() -> None:
    """From the working set before, the problem of decision 41 is not solved; from none it is."""
    mpc, plant, state = controller(platform=displaced(on_cranks(), 4)), Ideal(), PlatformState()
    rng, number = np.random.default_rng(41), 20_000
    size = np.exp(rng.uniform(np.log(0.1), np.log(50.0), number))[:, None]
    jumps = size * rng.standard_normal((number, 6)) * [1.0, 1.0, 1.0, 0.02, 0.02, 0.1]
    plant.reset(state)
    for k in range(48):
        wanted = jumps[5000 + k // 8]
        command = mpc.step(state, Reference(specific_force=wanted[:3], angular_rate=wanted[3:]))
        assert command.outcome.status is Status.DECIDED
        assert isinstance(mpc.engine, BlockedEngine)
        assert mpc.engine.undecided == 0
        state = plant.step(command, mpc.period)


def test_the_plan_is_linearised_about_where_the_last_one_leads() -> None:
    """One period on, the prediction about which the problem is written goes on where the plan went."""
    two, plant, state = controller(), Ideal(), PlatformState()
    mpc = Mpc(DAVSI, ALL, replace(two.settings, iterations=1), body=two.problem._body)
    plant.reset(state)
    command = mpc.step(state, Reference(specific_force=np.array([1.5, 0.5, 0.0])))
    before = mpc.problem.predicted(mpc.program.x, mpc.program.plan)
    assert np.ptp(mpc.program.plan, axis=0).max() > 0.1
    state = plant.step(command, mpc.period)
    mpc.step(state, Reference(specific_force=np.array([1.5, 0.5, 0.0])))
    assert_allclose(mpc.problem.given.X[:-1], before[1:], atol=1e-12)


@pytest.mark.parametrize(("force", "most"), [(1e-3, 1), (2.0, 2)])
def test_a_second_step_is_taken_where_the_first_has_misjudged(force: float, most: int) -> None:
    """Not for a force that no limit hinders; in the first half second after a jump, when legs begin to."""
    mpc, plant, state, steps = controller(), Ideal(), PlatformState(), []
    plant.reset(state)
    for _ in range(60):
        command = mpc.step(state, Reference(specific_force=np.array([force, -force, 0.0])))
        steps.append(mpc.program.at[ROUND])
        state = plant.step(command, mpc.period)
    assert max(steps) == most


def test_random_jumps_leave_no_step_without_answer_and_every_leg_within_its_limits() -> None:
    """At all nodes, and at every fifth of a period between them."""
    mpc, plant, rng, legs = controller(), Ideal(), np.random.default_rng(6), DAVSI.six_legs()
    state = PlatformState()
    plant.reset(state)
    mpc.reset(state)
    wanted = np.zeros(6)
    for k in range(300):
        if k % 15 == 0:
            wanted = rng.choice([0.3, 1.0, 5.0, 50.0]) * rng.standard_normal(6) * [1, 1, 1, 0.1, 0.1, 0.1]
        command = mpc.step(state, Reference(specific_force=wanted[:3], angular_rate=wanted[3:]))
        assert command.outcome.status is Status.DECIDED
        assert command.outcome.solver == "optimal"
        for _ in range(5):
            state = plant.step(command, mpc.period / 5)
            now = legs.leg_motion(state.pose, state.twist, state.acceleration)
            assert legs.stroke[0] <= now.length.min()
            assert now.length.max() <= legs.stroke[1]
            assert np.abs(now.speed).max() <= legs.speed
            assert np.abs(now.acceleration).max() <= legs.acceleration


@pytest.mark.parametrize("size", [1e-3, 1e-12, 1e-20, 1e-100])
def test_the_tail_of_a_filter_is_decided_as_fast_as_any_force(size: float) -> None:
    """No problem goes to the exact engine, which takes 50 times as long."""
    mpc, plant, state = controller(), Ideal(), PlatformState()
    plant.reset(state)
    for k in range(20):
        force = size * np.array([0.3, 0.5, 0.7]) * (k < 10)
        command = mpc.step(state, Reference(specific_force=force))
        assert command.outcome.solver == "optimal"
        state = plant.step(command, mpc.period)
    assert isinstance(mpc.engine, BlockedEngine)
    assert mpc.engine.undecided == 0


@pytest.mark.parametrize("rate", [30.0, 100.0, 300.0])
def test_a_rate_in_degrees_that_is_taken_for_radians_is_decided(rate: float) -> None:
    """Nearly all rows are at their limits, so that hundreds enter; legs keep their limits all the same."""
    mpc, plant, state, legs = controller(), Ideal(), PlatformState(), DAVSI.six_legs()
    plant.reset(state)
    for _ in range(15):
        command = mpc.step(state, Reference(specific_force=np.zeros(3), angular_rate=np.array([0, 0, rate])))
        assert command.outcome.solver == "optimal"
        state = plant.step(command, mpc.period)
        now = legs.leg_motion(state.pose, state.twist, state.acceleration)
        assert np.abs(now.speed).max() <= legs.speed
        assert np.abs(now.acceleration).max() <= legs.acceleration
    assert isinstance(mpc.engine, BlockedEngine)
    assert mpc.engine.undecided == 0


def test_where_no_command_holds_the_legs_the_answer_says_so() -> None:
    """A start beyond the stroke, with no way back within two periods."""
    mpc = controller()
    state = PlatformState(pose=np.array([0.0, 0.0, 0.41, 0.1, 0.1, 0.0]))
    assert DAVSI.six_legs().lengths(state.pose).max() > DAVSI.six_legs().stroke[1]
    mpc.reset(state)
    outcome = mpc.step(state, Reference(specific_force=np.zeros(3))).outcome
    assert outcome.status is Status.DECIDED
    assert outcome.solver == "infeasible"


def test_a_platform_without_legs_is_refused() -> None:
    legless = load("benchmark").model_copy(update={"hexapod": None})
    with pytest.raises(InputError, match="hexapod"):
        registry.make_cueing("six-axis", Design(platform=legless, dofs=(SURGE_PITCH,)))


def test_a_larger_machine_is_held_as_loosely_in_relation() -> None:
    """Twice the reach, a quarter of the weight on position, half of that on speed."""
    surge = DAVSI.surge
    assert surge is not None
    weights = []
    for reach in (0.25, 0.5):
        updated = {"surge": surge.model_copy(update={"position_m": (-reach, reach)})}
        mpc = controller((SURGE_PITCH,), DAVSI.model_copy(update=updated))
        weights.append(mpc.problem.given.washout[:2, 0])
    assert_allclose(weights[0], weights[1] * [4.0, 2.0])


def test_liveliness_is_changed_at_work() -> None:
    mpc = controller((SURGE_PITCH,))
    before = mpc.problem.given.washout.copy()
    reweigh(mpc, "six-axis", Design(platform=DAVSI, dofs=(SURGE_PITCH,), liveliness=0.8))
    assert (mpc.problem.given.washout[:2, 0] < before[:2, 0]).all()
