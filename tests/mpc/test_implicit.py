"""The condensed QP against a rollout of its own definition; the controller against its limits."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from otolith import metrics
from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError
from otolith.core.frames import GRAVITY, SURGE_PITCH, SWAY_ROLL
from otolith.core.lti import zero_order_hold
from otolith.interfaces import PlatformState, Reference, Status
from otolith.mpc.hybrid import HeldPlan, NoGuess
from otolith.mpc.implicit import Entry, Implicit, ImplicitSettings, parse_entry
from otolith.mpc.model import BrakingRows, implicit_dynamics
from otolith.mpc.washout import PRESETS
from otolith.plant import Ideal
from otolith.platforms import load
from otolith.scenarios import Scenario
from otolith.simulate import simulate

THESIS = load("thesis")
A, B = zero_order_hold(*implicit_dynamics(0.01), 0.01)


def controller(
    platform: str = "thesis", entry: Entry = Entry.REFERENCE, guess: object = None, **options
) -> Implicit:  # type: ignore[no-untyped-def]
    described = load(platform)
    return Implicit(
        SURGE_PITCH,
        described.pair_limits(SURGE_PITCH),
        described.braking,
        settings=ImplicitSettings(**options),
        guess=guess or NoGuess(),  # type: ignore[arg-type]
        entry=entry,
    )


def rollout(x: Vec, U: Mat) -> Mat:
    """(N, 6) states x_1 … x_N under inputs (N, 2), one step at a time."""
    states = []
    for u in U:
        x = A @ x + B @ u
        states.append(x)
    return np.array(states)


def cost_by_definition(x: Vec, U: Mat, wanted: float, weights: dict[int, float], u_ref: Mat) -> float:
    """The stage costs added up along the rollout, output linearised about level platform (ū = 0, x₀ = 0)."""
    X = rollout(x, U)
    felt = X[:, 4] + GRAVITY * X[:, 1]
    washout = sum(w * np.sum(X[:, i] ** 2) for i, w in weights.items())
    return float(np.sum((felt - wanted) ** 2) + washout + 1e-3 * np.sum((U - u_ref) ** 2))


@given(seed=st.integers(0, 10_000))
@settings(max_examples=20, deadline=None)
def test_the_condensed_cost_is_the_cost_of_the_rollout(seed: int) -> None:
    rng = np.random.default_rng(seed)
    mpc = controller()
    x, wanted = np.zeros(6), float(rng.normal())  # level and at rest, so the linearisation is about zero tilt
    qp, _ = mpc.problem(x, wanted)
    weights = {i: w.at(x) for i, w in ((2, PRESETS["thesis-fit"][0]), (3, PRESETS["thesis-fit"][1]))}

    def difference(U: Mat) -> float:
        z = U.ravel()
        quadratic = z @ qp.H @ z + 2 * qp.g @ z
        constant = cost_by_definition(x, np.zeros((50, 2)), wanted, weights, np.zeros((50, 2)))
        return float(quadratic + constant - cost_by_definition(x, U, wanted, weights, np.zeros((50, 2))))

    assert difference(rng.normal(size=(50, 2))) == pytest.approx(0.0, abs=1e-9)


def test_the_linearised_force_has_the_slope_of_finite_differences() -> None:
    """Gradient of the cost at the linearisation point equals that of the nonlinear rollout's cost."""
    rng = np.random.default_rng(5)
    mpc = controller(washout=())
    x = np.array([0.01, 0.3, 0.1, -0.05, 0.2, 0.0])
    mpc._plan = rng.normal(size=(50, 2))

    def nonlinear(z: Vec) -> float:
        X = rollout(x, z.reshape(50, 2))
        return float(np.sum((X[:, 4] + GRAVITY * np.sin(X[:, 1]) - 1.0) ** 2) + 1e-3 * z @ z)

    qp, _ = mpc.problem(x, 1.0)
    at = mpc._plan.ravel()
    step = 1e-6
    numeric = [
        (nonlinear(at + step * e) - nonlinear(at - step * e)) / (2 * step)
        for e in np.eye(100)[rng.integers(0, 100, 12)]
    ]
    rng = np.random.default_rng(5)
    rng.normal(size=(50, 2))
    chosen = rng.integers(0, 100, 12)
    assert_allclose(2 * (qp.H @ at + qp.g)[chosen], numeric, rtol=1e-5, atol=1e-6)


@given(seed=st.integers(0, 10_000))
@settings(max_examples=20, deadline=None)
def test_every_row_is_the_limit_it_stands_for(seed: int) -> None:
    """Rows of eq. 4.10, written out once more by hand along the rollout (braking: eq. C.2)."""
    rng = np.random.default_rng(seed)
    x, U = 0.1 * rng.normal(size=6), rng.normal(size=(50, 2))
    qp, _ = controller().problem(x, 0.0)
    w, th, v, s, at, ar = rollout(x, U).T
    degree = np.pi / 180
    by_hand = [
        (w, 3 * degree),
        (th, 30 * degree),
        (v, 7.2),
        (s, 0.5),
        (at, 9.81),
        (s + 2.5 * v + 1.40625 * at, 0.5),
        (th + 0.5 * w + 0.05625 * ar, 30 * degree),
    ]
    expected_upper = np.concatenate([bound - value for value, bound in by_hand])
    expected_lower = np.concatenate([bound + value for value, bound in by_hand])
    rows = qp.A @ U.ravel()
    assert_allclose(qp.upper[100:] - rows, expected_upper, atol=1e-9)
    assert_allclose(rows - qp.lower[100:], expected_lower, atol=1e-9)
    assert_allclose(qp.upper[1:100:2], 5.0)  # translation commands; u = [a_rot, a_tran]
    assert np.isinf(qp.upper[:100:2]).all()


def test_a_guess_as_reference_moves_the_cost_and_as_primal_only_the_linearisation() -> None:
    plan = np.tile([0.4, -1.0], (50, 1))
    x = np.zeros(6)
    problems = {}
    for entry in Entry:
        mpc = controller(entry=entry, guess=HeldPlan())
        mpc._plan = plan.copy()
        problems[entry], missed = mpc.problem(x, 1.0)
        assert not missed
    plain = controller()
    plain._plan = plan.copy()
    without, _ = plain.problem(x, 1.0)
    assert_allclose(problems[Entry.REFERENCE].g - without.g, -1e-3 * plan.ravel(), atol=1e-12)
    assert_allclose(problems[Entry.REFERENCE].H, without.H)
    assert_allclose(problems[Entry.PRIMAL].g, without.g)  # held plan = previous plan here


def random_reference(seed: int, duration: float) -> Scenario:
    """Jumps between values from gentle to absurd, at random times."""
    rng = np.random.default_rng(seed)
    times = np.sort(rng.uniform(0.0, duration, 12))
    values = rng.normal(size=13) * rng.choice([0.3, 1.0, 4.0, 30.0], 13)

    def force(t: Vec) -> Mat:
        f = np.zeros((len(t), 3))
        f[:, 0] = f[:, 1] = values[np.searchsorted(times, t)]
        return f

    return Scenario(name=f"random {seed}", duration=duration, specific_force=force)


@given(
    seed=st.integers(0, 10_000),
    platform=st.sampled_from(["thesis", "davsi"]),
    pair=st.sampled_from([SURGE_PITCH, SWAY_ROLL]),
)
@settings(max_examples=12, deadline=None)
def test_no_limit_is_violated_whatever_is_wanted(seed: int, platform: str, pair) -> None:  # type: ignore[no-untyped-def]
    described = load(platform)
    mpc = Implicit(
        pair, described.pair_limits(pair), described.braking, settings=ImplicitSettings(), guess=NoGuess()
    )
    run = simulate(mpc, Ideal(), random_reference(seed, 4.0), platform=described, pairs=(pair.name,))
    assert set(run.status) == {"optimal"}
    assert max(run.residual) < 1e-6
    for excess in metrics.excesses(run):
        assert excess.at_nodes < 1e-6, excess


def test_after_reset_equal_inputs_give_equal_outputs() -> None:
    mpc = controller()
    runs = [
        simulate(mpc, Ideal(), random_reference(7, 1.0), platform=THESIS, pairs=("surge-pitch",))
        for _ in range(2)
    ]
    np.testing.assert_array_equal(runs[0].command, runs[1].command)
    np.testing.assert_array_equal(runs[0].changes, runs[1].changes)


@pytest.mark.parametrize("wanted", [np.nan, np.inf])
def test_a_reference_that_is_no_number_gives_a_finite_command_that_says_so(wanted: float) -> None:
    mpc = controller()
    mpc.reset(PlatformState())
    good = mpc.step(PlatformState(), Reference(specific_force=np.array([1.0, 0, 0])))
    bad = mpc.step(PlatformState(), Reference(specific_force=np.array([wanted, 0, 0])))
    assert bad.outcome.status is Status.INVALID
    assert np.isfinite(bad.acceleration).all()
    np.testing.assert_array_equal(bad.acceleration, good.plan[0])  # the last certified plan goes on


def test_a_state_beyond_its_limits_is_infeasible_and_braked() -> None:
    mpc = controller()
    mpc.reset(PlatformState())
    twist = np.array([3.0, 0, 0, 0, 0, 0])  # towards the end stop, too fast to stop
    command = mpc.step(
        PlatformState(pose=np.array([0.45, 0, 0, 0, 0, 0]), twist=twist),
        Reference(specific_force=np.zeros(3)),
    )
    assert command.outcome.status is Status.INFEASIBLE
    assert command.acceleration[0] == -5.0


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"horizon": 1}, "implicit horizon is 1, must be at least 2 steps"),
        ({"period": 0.0}, "period is 0.0, must be finite and greater than 0"),
        ({"lag": float("nan")}, "lag is nan"),
    ],
)
def test_settings_out_of_bounds_are_refused(options: dict[str, float], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        ImplicitSettings(**options)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="one of reference, primal"):
        parse_entry("sideways")


def test_printed_braking_rows_lack_the_position() -> None:
    with_position, _ = controller().problem(np.zeros(6), 0.0)
    printed, _ = controller(braking=BrakingRows.PRINTED).problem(np.zeros(6), 0.0)
    none, _ = controller(braking=BrakingRows.NONE).problem(np.zeros(6), 0.0)
    difference = with_position.A - printed.A
    rows = none.A.reshape(-1, 50, 100)
    assert_allclose(difference.reshape(-1, 50, 100)[5], rows[3])  # position
    assert_allclose(difference.reshape(-1, 50, 100)[6], rows[1])  # tilt
