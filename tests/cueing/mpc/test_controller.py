"""The controller in closed loop: its limits, its failures, its engines, its guesses."""

from dataclasses import replace
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from otolith import metrics
from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.errors import InputError
from otolith.core.frames import SURGE_PITCH, SWAY_ROLL, Dof
from otolith.cueing.mpc.controller import Mpc
from otolith.cueing.mpc.guess import HeldPlan, NoGuess
from otolith.cueing.mpc.settings import BLOCKS, Entry, MpcSettings, parse_entry
from otolith.cueing.prediction import Decay, Oracle
from otolith.interfaces import PlatformState, Reference, Status
from otolith.loop import Run, simulate
from otolith.plant import Ideal
from otolith.platforms import load
from otolith.qp.engines import CondensedEngine, StructuredEngine, expand
from otolith.qp.problem import Status as QpStatus
from otolith.qp.stage import OnRequest, StageSolution
from otolith.scenarios import Scenario, scenario

BOTH = (SURGE_PITCH, SWAY_ROLL)
BETWEEN = 1e-6  # [SI] beyond a limit at any time: as at the nodes


def controller(
    pairs: tuple[Dof, ...] = (SURGE_PITCH,),
    platform: str = "thesis",
    entry: Entry = Entry.REFERENCE,
    **options: Any,
) -> Mpc:
    guess = options.pop("guess", None) or NoGuess()
    return Mpc(load(platform), pairs, MpcSettings(**options), guess=guess, entry=entry)


def close(mpc: Mpc, of: Scenario, pairs: tuple[Dof, ...], platform: str = "thesis", preview: int = 0) -> Run:
    names = tuple(pair.name for pair in pairs)
    return simulate(mpc, Ideal(), of, platform=load(platform), dofs=names, preview=preview)


def random_reference(seed: int, duration: float) -> Scenario:
    """Jumps between values from gentle to absurd, at random times, different along the two axes."""
    rng = np.random.default_rng(seed)
    times = np.sort(rng.uniform(0.0, duration, (2, 12)))
    values = rng.normal(size=(2, 13)) * rng.choice([0.3, 1.0, 4.0, 30.0], (2, 13))

    def force(t: Vec) -> Mat:
        f = np.zeros((len(t), 3))
        for axis in range(2):
            f[:, axis] = values[axis][np.searchsorted(times[axis], t)]
        return f

    return Scenario(name=f"random {seed}", duration=duration, specific_force=force)


FORMS: dict[str, dict[str, Any]] = {"full": {}, "blocked": {"horizon": sum(BLOCKS), "blocks": BLOCKS}}
# Every structure is compiled once, which takes tens of seconds: the blocked form on one platform only.
CASES = [(form, "thesis", pairs) for form in FORMS for pairs in ((SURGE_PITCH,), (SWAY_ROLL,), BOTH)]
CASES += [("full", "davsi", pairs) for pairs in ((SURGE_PITCH,), (SWAY_ROLL,), BOTH)]


@cache
def built(form: str, platform: str, pairs: tuple[Dof, ...]) -> Mpc:
    """The controller of a case, compiled when it is first asked for."""
    return controller(pairs, platform, **FORMS[form])


@example(seed=37, which=("blocked", "thesis", (SURGE_PITCH,)))  # once "proved" infeasible by rounding
@given(seed=st.integers(0, 10_000), which=st.sampled_from(CASES))
@settings(max_examples=80, deadline=None)
def test_no_limit_is_violated_whatever_is_wanted(seed: int, which: tuple[str, str, tuple[Dof, ...]]) -> None:
    _, platform, pairs = which
    run = close(built(*which), random_reference(seed, 4.0), pairs, platform)
    assert set(run.status) == {Status.DECIDED}
    assert max(run.residual) < 1e-6
    for excess in metrics.excesses(run):
        assert excess.at_nodes < 1e-6, excess
        assert excess.between_nodes < BETWEEN, excess


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("pairs", [(SURGE_PITCH,), BOTH], ids=["2 DOF", "4 DOF"])
def test_the_engines_drive_the_same_loop(pairs: tuple[Dof, ...], form: str) -> None:
    along = scenario("combined")
    if len(pairs) == 2:
        along = along.combined_with(scenario("step-1", axis="lateral"))
    runs = [
        close(controller(pairs, engine=engine, **FORMS[form]), along, pairs)
        for engine in (StructuredEngine, CondensedEngine)
    ]
    rmse = [metrics.tracking_rmse(run) for run in runs]
    assert_allclose(rmse[0], rmse[1], atol=1e-6)
    assert_allclose(runs[0].pose, runs[1].pose, atol=1e-5)


def test_what_the_structured_engine_gives_up_is_decided_exactly_in_any_loop() -> None:
    """No exchange and no interior point: it gives up, and the kernel asks for help in both loops."""
    mpc, along = controller(), scenario("sine:frequency=0.5,duration=2")
    assert isinstance(mpc.engine, StructuredEngine)
    mpc.engine._solver.part("SETTING")[1:4] = 0.0
    compiled = close(mpc, along, (SURGE_PITCH,))
    assert mpc.engine.undecided > 50
    plain = simulate(mpc, Ideal(), along, platform=load("thesis"), dofs=("surge-pitch",), clock=lambda: 0.0)
    assert np.array_equal(compiled.command, plain.command)
    assert set(compiled.status) == {Status.DECIDED}
    dense = close(controller(engine=CondensedEngine), along, (SURGE_PITCH,))
    assert_allclose(compiled.pose, dense.pose, atol=1e-7)


def test_more_gauss_newton_steps_change_little_and_end_where_linearisation_is_exact() -> None:
    """RTI's loss: on a signal with tilts of up to 12 deg the converged loop tracks the same within 1 %."""
    rti = close(controller(), scenario("step-2"), (SURGE_PITCH,))
    sqp = close(controller(iterations=10), scenario("step-2"), (SURGE_PITCH,))
    assert set(sqp.status) == {Status.DECIDED}
    one, ten = (metrics.tracking_rmse(run)[0] for run in (rti, sqp))
    assert one != ten
    assert one == pytest.approx(ten, rel=0.01)


class _Once(CondensedEngine):
    """Solves the first problem of a period and gives the second one up."""

    asked = 0

    def run(self, start: Ints | None = None, hint: OnRequest | None = None) -> StageSolution:
        self.asked += 1
        found = super().run(start, hint)
        return found if self.asked % 2 else replace(found, status=QpStatus.LIMIT, residual=np.inf)


def test_a_second_gauss_newton_step_without_an_answer_leaves_the_plan_of_the_first() -> None:
    """That plan is certified; the platform need not brake because more was tried."""
    reference = Reference(specific_force=np.array([2.0, 0.0, 0.0]))
    one, two = controller(iterations=1, engine=CondensedEngine), controller(iterations=2, engine=_Once)
    assert isinstance(two.engine, _Once)
    for mpc in (one, two):
        mpc.reset(PlatformState())
    two.engine.asked = 0
    expected, command = (mpc.step(PlatformState(), reference) for mpc in (one, two))
    assert two.engine.asked == 2
    assert command.outcome.status is Status.DECIDED
    assert command.outcome.residual == expected.outcome.residual < 1e-6
    assert_allclose(command.acceleration, expected.acceleration, atol=1e-12)


def test_a_preview_helps_and_a_constant_one_changes_nothing() -> None:
    mpc = controller(prediction=Oracle())
    held = close(mpc, scenario("sine-1"), (SURGE_PITCH,))
    seen = close(mpc, scenario("sine-1"), (SURGE_PITCH,), preview=50)
    assert metrics.tracking_rmse(seen)[0] < metrics.tracking_rmse(held)[0]
    force = np.array([0.7, 0.0, 0.0])
    mpc.reset(PlatformState())
    plain = mpc.step(PlatformState(), Reference(specific_force=force))
    mpc.reset(PlatformState())
    command = mpc.step(PlatformState(), Reference(specific_force=force, preview=np.tile(force, (50, 1))))
    assert_allclose(command.acceleration, plain.acceleration)


def test_a_guess_as_reference_moves_the_cost_and_as_primal_only_the_linearisation() -> None:
    plan = np.tile([0.4, -1.0], (50, 1))
    written = {}
    for entry in Entry:
        mpc = controller(entry=entry, guess=HeldPlan(), engine=CondensedEngine)
        mpc.program.plan[:] = plan
        mpc.step(PlatformState(), Reference(specific_force=np.array([1.0, 0, 0])))
        written[entry] = expand(mpc.problem.structure, mpc.engine.memory)
    assert_allclose(written[Entry.REFERENCE].input_linear, -1e-3 * plan)
    assert not written[Entry.PRIMAL].input_linear.any()
    assert_allclose(written[Entry.PRIMAL].output, written[Entry.REFERENCE].output)  # held plan = plan before


def test_a_soft_tilt_rate_gives_way_where_a_hard_one_is_infeasible() -> None:
    forward = Reference(specific_force=np.zeros(3))
    spinning = PlatformState(
        twist=np.array([0, 0, 0, 0, np.deg2rad(-6.0), 0]), acceleration=np.array([0, 0, 0, 0, -2.0, 0])
    )
    hard = controller(platform="davsi").step(spinning, forward)
    soft = controller(platform="davsi", soft={"tilt_rate": 100.0}).step(spinning, forward)
    assert hard.outcome.status is Status.FALLBACK
    assert soft.outcome.status is Status.DECIDED
    assert soft.acceleration[4] > 0.0  # against the rotation


def test_the_blocks_reach_as_far_as_the_page_says() -> None:
    """Three times the thesis's horizon, in blocks that never shorten, single steps first."""
    assert sum(BLOCKS) == 3 * MpcSettings().horizon
    assert BLOCKS[:2] == (1, 1)
    assert all(later >= sooner for sooner, later in pairwise(BLOCKS))


def test_after_reset_equal_inputs_give_equal_outputs() -> None:
    mpc = built("full", "thesis", BOTH)
    runs = [close(mpc, random_reference(7, 1.0), BOTH) for _ in range(2)]
    np.testing.assert_array_equal(runs[0].command, runs[1].command)
    np.testing.assert_array_equal(runs[0].changes, runs[1].changes)


@pytest.mark.parametrize("wanted", [np.nan, np.inf])
def test_a_reference_that_is_no_number_gives_a_finite_command_that_says_so(wanted: float) -> None:
    mpc = controller()
    moving = PlatformState(twist=np.array([0.3, 0, 0, 0, 0.02, 0]))
    mpc.reset(moving)
    bad = mpc.step(moving, Reference(specific_force=np.array([wanted, 0, 0])))
    assert bad.outcome.status is Status.INVALID
    assert (bad.acceleration[[0, 4]] < 0.0).all()  # against the motion
    plant = Ideal()
    plant.reset(moving)
    for acceleration in (bad.acceleration, *bad.plan, *np.zeros((20, 6))):
        state = plant.step(replace(bad, acceleration=acceleration), 0.01)
    assert np.abs(state.twist).max() < 1e-6  # and at last at rest


@pytest.mark.parametrize("engine", [StructuredEngine, CondensedEngine])
def test_a_state_that_cannot_stop_in_time_is_infeasible_and_braked_fully(engine) -> None:
    mpc = controller(engine=engine)
    mpc.reset(PlatformState())
    twist = np.array([3.0, 0, 0, 0, 0, 0])  # towards the end stop, too fast to stop
    state = PlatformState(pose=np.array([0.45, 0, 0, 0, 0, 0]), twist=twist)
    command = mpc.step(state, Reference(specific_force=np.zeros(3)))
    assert command.outcome.status is Status.FALLBACK
    assert command.acceleration[0] == -5.0


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"horizon": 1}, "implicit horizon is 1, must be from 2 to 1,000 steps"),
        ({"horizon": 100_000}, "implicit horizon is 100000, must be from 2 to 1,000 steps"),
        ({"period": 0.0}, "period is 0 s, must be from 0.0001 to 1 s"),
        ({"lag": float("nan")}, "lag is nan"),
        ({"iterations": 0}, "iterations is 0, must be at least 1 per period"),
        ({"soft": {"tilt": -1.0}}, "penalty of tilt is -1, must be from 1e-12 to 1e[+]12"),
        ({"blocks": (1, 3)}, "blocks is 1,3, must be of at least 1 step each, 50 in sum"),
        ({"blocks": (51, -1)}, "blocks is 51,-1, must be of at least 1 step each"),
        ({"firm": 0}, "firm blocks is 0, must be at least 1, for the next node"),
        ({"later_penalty": float("nan")}, "later penalty is nan, must be greater than 0"),
    ],
)
def test_settings_out_of_bounds_are_refused(options: dict[str, object], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        MpcSettings(**options)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="one of reference, primal"):
        parse_entry("sideways")


def test_settings_at_their_bounds_are_taken_and_work() -> None:
    """Two steps, two blocks, one firm, one iteration: the least that the sentences of refusal allow."""
    mpc = controller(horizon=2, blocks=(1, 1), firm=1, iterations=1, engine=CondensedEngine)
    command = mpc.step(PlatformState(), Reference(specific_force=np.array([0.3, 0.0, 0.0])))
    assert command.outcome.status is Status.DECIDED
    assert command.acceleration[0] > 0.0


def test_a_controller_keeps_its_prediction_whatever_others_are_made() -> None:
    """Its kernel reads the prediction's data by address; hundreds of others would take their place."""
    wanted = Reference(specific_force=np.array([1.0, 0.0, 0.0]))
    mpc = controller(prediction=Decay(time=0.3), horizon=20, engine=CondensedEngine)
    mpc.reset(PlatformState())
    before = mpc.step(PlatformState(), wanted).acceleration
    for k in range(300):
        Decay(time=1.0 + k).begin().ahead(wanted, 0.01, 5)
    mpc.reset(PlatformState())
    assert_allclose(mpc.step(PlatformState(), wanted).acceleration, before, rtol=0.0, atol=0.0)
