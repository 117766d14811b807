"""The stage problem against a rollout of its own definition, in 2 and 4 DOF."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError
from otolith.core.frames import GRAVITY, HEAVE, SURGE_PITCH, SWAY_ROLL, Dof
from otolith.core.lti import zero_order_hold
from otolith.cueing.mpc.motion import dynamics, stacked
from otolith.cueing.mpc.problem import Problem
from otolith.cueing.mpc.rows import HAIR, BrakingRows
from otolith.cueing.mpc.settings import MpcSettings
from otolith.cueing.mpc.washout_weights import WashoutWeight, constant
from otolith.platforms import load
from otolith.qp.engines import CondensedEngine, expand
from otolith.qp.stage import StageQp, cost, rollout, row_values

BOTH = (SURGE_PITCH, SWAY_ROLL)
PAIRS = pytest.mark.parametrize("pairs", [(SURGE_PITCH,), (SWAY_ROLL,), BOTH], ids=["surge", "sway", "both"])
N = 12
A, B = zero_order_hold(*dynamics(stacked((SURGE_PITCH,)), 0.01), 0.01)
DEGREE = np.pi / 180


def problem(pairs: tuple[Dof, ...], platform: str = "thesis", **options) -> Problem:
    return Problem(load(platform), pairs, MpcSettings(horizon=N, **options))


def written(of: Problem, x: Vec, plan: Mat, wanted: Mat, u_ref: Mat | None = None) -> StageQp:
    """The problem that the MPC writes, as a value."""
    engine = CondensedEngine(of.structure, tolerance=1e-6)
    of.begin(engine.memory)
    of.write(engine.memory, x, plan, wanted, u_ref)
    return expand(of.structure, engine.memory)


def felt(X: Mat, pairs: tuple[Dof, ...]) -> Mat:
    """(N, P) forces of eq. 4.19 (in our signs), written out by hand."""
    forces = []
    for p, pair in enumerate(pairs):
        cosine = np.cos(X[:, 1]) if pair is SWAY_ROLL and len(pairs) == 2 else 1.0
        forces.append(X[:, 6 * p + 4] + GRAVITY * cosine * np.sin(X[:, 6 * p + 1]))
    return np.array(forces).T


@PAIRS
@given(seed=st.integers(0, 10_000))
@settings(max_examples=20, deadline=None)
def test_the_cost_at_the_linearisation_point_is_the_nonlinear_one(pairs: tuple[Dof, ...], seed: int) -> None:
    """Tracking, washout and control cost added up along a rollout that goes one step at a time."""
    rng = np.random.default_rng(seed)
    P = len(pairs)
    x, plan, u_ref = 0.2 * rng.normal(size=6 * P), rng.normal(size=(N, 2 * P)), rng.normal(size=(N, 2 * P))
    wanted = rng.normal(size=(N, P))
    of = problem(pairs, washout=constant({"velocity": 0.3, "position": 2.0}))
    qp = written(of, x, plan, wanted, u_ref)

    states, now = [], x.reshape(P, 6)
    for u in plan:
        now = now @ A.T + u.reshape(P, 2) @ B.T
        states.append(now.ravel())
    X = np.array(states)
    by_hand = np.sum((felt(X, pairs) - wanted) ** 2) + 1e-3 * np.sum((plan - u_ref) ** 2)
    by_hand += 0.3 * np.sum(X[:, 2::6] ** 2) + 2.0 * np.sum(X[:, 3::6] ** 2)
    constant_term = 1e-3 * np.sum(u_ref**2)
    assert 2 * cost(qp, plan, rollout(qp, plan)) + constant_term == pytest.approx(by_hand, rel=1e-10)


@PAIRS
def test_the_linearised_force_has_the_slope_of_finite_differences(pairs: tuple[Dof, ...]) -> None:
    rng = np.random.default_rng(5)
    P = len(pairs)
    x, plan = 0.3 * rng.normal(size=6 * P), 3.0 * rng.normal(size=(N, 2 * P))
    of = problem(pairs)
    qp = written(of, x, plan, np.zeros((N, P)))
    X = rollout(qp, plan)
    assert_allclose(np.einsum("kyi,ki->ky", qp.output, X) + qp.error, felt(X, pairs), atol=1e-12)
    step = 1e-6
    for i in range(6 * P):
        nudge = step * np.eye(6 * P)[i]
        slope = (felt(X + nudge, pairs) - felt(X - nudge, pairs)) / (2 * step)
        assert_allclose(qp.output[:, :, i], slope, atol=1e-8)


@given(seed=st.integers(0, 10_000), pair=st.sampled_from(BOTH))
@settings(max_examples=20, deadline=None)
def test_every_row_is_the_limit_it_stands_for(seed: int, pair: Dof) -> None:
    """Rows on the leading motion written out by hand: lag T = 0.01 s, τ = 0.59 s (tilt: 0.05 s)."""
    rng = np.random.default_rng(seed)
    x, plan = 0.1 * rng.normal(size=6), rng.normal(size=(N, 2))
    qp = written(problem((pair,)), x, plan, np.zeros((N, 1)))
    X = rollout(qp, plan)
    w, th, v, s, at, ar = X.T
    rate = {SURGE_PITCH: 3.0, SWAY_ROLL: 2.6}[pair] * DEGREE
    tau = 0.25 * 1.1**9  # a tenth of the braking law's time, until every vertex can be kept inside
    by_hand = [
        (w + 0.02 * ar, rate),
        (th + 0.01 * w + 0.05 * (w + 0.01 * ar), 30 * DEGREE),
        (v + 0.02 * at, 7.2),
        (s + 0.01 * v + tau * (v + 0.01 * at), 0.5),
        (s + 2.5 * v + 1.40625 * at, 0.5),
        (th + 0.5 * w + 0.05625 * ar, 30 * DEGREE - HAIR),
        (plan[:, 0], np.inf),
        (plan[:, 1], 5.0),
    ]
    assert_allclose(row_values(qp, plan, X), np.array([value for value, _ in by_hand]).T, atol=1e-12)
    assert_allclose(qp.upper, np.tile([bound for _, bound in by_hand], (N, 1)), atol=1e-6)
    assert_allclose(qp.lower, -qp.upper)


@given(seed=st.integers(0, 10_000), pair=st.sampled_from(BOTH))
@settings(max_examples=20, deadline=None)
def test_the_thesiss_rows_are_the_limits_they_stand_for(seed: int, pair: Dof) -> None:
    """Rows of eq. 4.10 written out once more by hand (braking: eq. C.2)."""
    rng = np.random.default_rng(seed)
    x, plan = 0.1 * rng.normal(size=6), rng.normal(size=(N, 2))
    qp = written(problem((pair,), braking=BrakingRows.POSITION), x, plan, np.zeros((N, 1)))
    X = rollout(qp, plan)
    w, th, v, s, at, ar = X.T
    rate = {SURGE_PITCH: 3.0, SWAY_ROLL: 2.6}[pair] * DEGREE
    by_hand = [
        (w, rate),
        (th, 30 * DEGREE),
        (v, 7.2),
        (s, 0.5),
        (at, 9.81),
        (s + 2.5 * v + 1.40625 * at, 0.5),
        (th + 0.5 * w + 0.05625 * ar, 30 * DEGREE - HAIR),
        (plan[:, 0], np.inf),
        (plan[:, 1], 5.0),
    ]
    values = row_values(qp, plan, X)
    assert_allclose(values, np.array([value for value, _ in by_hand]).T, atol=1e-12)
    assert_allclose(qp.upper, np.tile([bound for _, bound in by_hand], (N, 1)), atol=1e-6)
    assert_allclose(qp.lower, -qp.upper)
    assert (np.diff(qp.upper[:, :7], axis=0) < 0.0).all()  # tightened by a hair from stage to stage


def test_in_4_dof_the_circle_takes_the_place_of_the_positions_it_implies() -> None:
    both, one = problem(BOTH), problem((SURGE_PITCH,))
    assert both.structure.rows == 2 * (one.structure.rows - 1) + 1
    assert problem((SURGE_PITCH,)).circle is None


@given(seed=st.integers(0, 10_000))
@settings(max_examples=20, deadline=None)
def test_the_circle_is_touched_where_the_prediction_points(seed: int) -> None:
    """The half-plane contains the circle, and its boundary passes through the circle's nearest point."""
    rng = np.random.default_rng(seed)
    x, plan = 0.3 * rng.normal(size=12), 3 * rng.normal(size=(N, 4))
    qp = written(problem(BOTH, braking=BrakingRows.POSITION), x, plan, np.zeros((N, 2)))
    s = rollout(qp, plan)[:, [3, 9]]
    row = len(qp.problem.C)
    n = qp.varying[:, 0][:, [3, 9]]
    nearest = 0.5 * s / np.linalg.norm(s, axis=1, keepdims=True)
    assert_allclose(np.sum(n * nearest, axis=1), qp.upper[:, row], atol=2e-5)
    angles = np.linspace(0, 2 * np.pi, 50)
    around = 0.5 * np.array([np.cos(angles), np.sin(angles)])
    assert (n @ around <= qp.upper[:, row, None] + 2e-5).all()
    assert np.isneginf(qp.lower[:, row]).all()
    assert (np.diff(qp.upper[:, row]) < 0.0).all()  # tightened from stage to stage, as all rows on states


@given(seed=st.integers(0, 10_000))
@settings(max_examples=20, deadline=None)
def test_the_circle_limits_where_the_way_to_rest_may_end(seed: int) -> None:
    """Its row is n·c with c = s + T v + τ (v + T a) of both pairs, n towards the predicted c."""
    rng = np.random.default_rng(seed)
    x, plan = 0.3 * rng.normal(size=12), 3 * rng.normal(size=(N, 4))
    qp = written(problem(BOTH), x, plan, np.zeros((N, 2)))
    X = rollout(qp, plan).reshape(N, 2, 6)
    tau = 0.25 * 1.1**9
    c = X[:, :, 3] + 0.01 * X[:, :, 2] + tau * (X[:, :, 2] + 0.01 * X[:, :, 4])
    values = np.einsum("ki,ki->k", qp.varying[:, 0], X.reshape(N, 12))
    assert_allclose(values, np.linalg.norm(c, axis=1), rtol=1e-9)


def test_at_the_centre_the_circle_has_no_direction_and_no_effect() -> None:
    qp = written(problem(BOTH), np.zeros(12), np.zeros((N, 4)), np.zeros((N, 2)))
    assert not qp.varying.any()
    assert np.isfinite(qp.output).all()


def test_printed_braking_rows_lack_the_position() -> None:
    C = {kind: problem((SURGE_PITCH,), braking=kind).structure.C for kind in BrakingRows}
    assert_allclose(C[BrakingRows.POSITION][-2] - C[BrakingRows.PRINTED][-2], C[BrakingRows.NONE][3])
    assert_allclose(C[BrakingRows.POSITION][-1] - C[BrakingRows.PRINTED][-1], C[BrakingRows.NONE][1])
    assert len(C[BrakingRows.NONE]) == len(C[BrakingRows.PRINTED]) - 2


@pytest.mark.parametrize(("blocks", "last"), [((), N - 1), ((1, 1, N - 2), 1)])
def test_terminal_rows_hold_at_the_last_hard_stage_only_and_are_those_of_the_sets(
    blocks: tuple[int, ...], last: int
) -> None:
    """Of surge a, q, v + 2 T a and q + τ w; of the tilt, whose commands have no bound, the last three."""
    of = problem((SURGE_PITCH,), braking=BrakingRows.NONE, terminal=True, blocks=blocks)
    lower, upper = of.bounds()
    added = slice(5, 12)
    assert np.isinf(np.delete(upper, last, axis=0)[:, added]).all()
    assert_allclose(upper[last, added], [5.0, 0.5, 7.2, 0.5, *np.deg2rad([30.0, 3.0, 30.0])], atol=1e-5)
    assert_allclose(lower[last, added], -upper[last, added])
    ahead = 0.25 * 1.1**6  # less than next to braking rows
    s, v, a = of.structure.C[added][3, [3, 2, 4]]
    assert (s, a / v) == pytest.approx((1.0, 0.01 * ahead / (0.01 + ahead)), abs=1e-12)


def test_terminal_rows_need_firm_blocks_of_one_step() -> None:
    """Else the plan of one period, shifted, is none of the next."""
    with pytest.raises(InputError, match="blocks"):
        MpcSettings(horizon=N, blocks=(1, 2, N - 3), terminal=True)


def test_soft_rows_carry_their_penalty() -> None:
    penalty = problem(BOTH, soft={"tilt_rate": 100.0}).structure.penalty
    assert (np.isfinite(penalty).sum(axis=1) == 2).all()


def test_soft_is_what_the_next_node_may_violate_not_what_later_ones_plan() -> None:
    """With blocks, rows of later nodes are soft throughout; the platform moves to the next node only."""
    assert problem(BOTH).soft == frozenset()
    blocks = (1,) * (N - 2) + (2,)
    assert problem(BOTH, blocks=blocks).soft == frozenset()
    each: tuple[dict[str, Any], ...] = ({}, {"blocks": blocks})
    for options in each:
        soft = problem(BOTH, soft={"tilt_rate": 100.0, "circle": 10.0}, **options).soft
        assert soft == {"surge-pitch tilt_rate", "sway-roll tilt_rate", "circle"}


def test_weights_follow_eq_4_12() -> None:
    weight = WashoutWeight(on="position", of="position", coefficients=(0.01, 20.0, 20.0, 20.0), scale=0.5)
    x = np.array([0, 0, 0, -0.4, 0, 0])
    qp = written(problem((SURGE_PITCH,), washout=(weight,)), x, np.zeros((N, 2)), np.zeros((N, 1)))
    assert_allclose(qp.state_weight, weight.at(x))


def test_whoever_keeps_the_rows_can_stop_where_they_are_on_the_leading_motion() -> None:
    """Then every decision is held to it by the stopping law; an axis of its own always has such rows."""
    for kind in BrakingRows:
        assert problem((SURGE_PITCH,), braking=kind).can_stop == (kind in ("stopping", "leading"))
        assert Problem(load("davsi"), (HEAVE,), MpcSettings(horizon=N, braking=kind)).can_stop
