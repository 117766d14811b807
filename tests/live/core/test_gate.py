"""The gate, against plain numpy and scipy, and against commands that want to break it."""

from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

from otolith.core.arrays import Mat, frozen_array
from otolith.live.audit import leg_lengths
from otolith.live.compilations import compiled
from otolith.live.core.bounds import dofs_of
from otolith.live.core.gate import MARGIN, Gate, Refusal, _way, _way_to_rest
from otolith.live.core.rollout import Rollout
from otolith.platforms import Platform, load

LEGS = {Refusal.LEG_LENGTH, Refusal.LEG_SPEED, Refusal.LEG_ACCELERATION}


def around(gate: Gate, rng: np.random.Generator, count: int) -> Mat:
    """Random motions (count, 3, 6), of which about half are beyond some limit."""
    b = gate.bounds
    size = np.stack([np.maximum(-b.low, b.high), b.twist, np.minimum(b.acceleration, 1e3)])
    return size * rng.uniform(-1.0, 1.0, (count, 3, 6)) * rng.uniform(0.3, 1.25, (count, 3, 1))


def by_numpy(motion: Mat, platform: Platform) -> bool:
    """Whether a motion is within the limits of axes and legs; legs by central differences of lengths."""
    for dof in dofs_of(platform):
        for axis, sign, limits in zip(dof.axes, dof.signs, platform.limits(dof), strict=True):
            low, high = sorted(sign * end for end in limits.position)
            machine = limits.velocity if axis < 3 else np.radians(11.5)  # not the threshold of perception
            leading = motion[1, axis] + 0.01 * motion[2, axis]  # where the speed goes, with the lag of 10 ms
            fastest = max(abs(motion[1, axis]), abs(leading))
            ahead = motion[0, axis] + 0.01 * motion[1, axis]
            if not (low <= min(motion[0, axis], ahead) <= max(motion[0, axis], ahead) <= high):
                return False
            if fastest > machine:
                return False
            if abs(motion[2, axis]) > max(limits.acceleration, limits.command):
                return False
    ahead = motion[0] + 0.01 * motion[1]
    if max(np.hypot(*motion[0, :2]), np.hypot(*ahead[:2])) > (platform.circle or np.inf):
        return False
    hexapod, h = platform.six_legs(), 1e-4
    times = np.array([-h, 0.0, h])[:, None]
    poses = motion[0] + times * motion[1] + 0.5 * times**2 * motion[2]
    lengths = leg_lengths(poses, hexapod.joints, hexapod.anchors)
    speed = (lengths[2] - lengths[0]) / (2 * h)
    strength = (lengths[2] - 2 * lengths[1] + lengths[0]) / h**2
    inside = (lengths[1] >= hexapod.stroke[0]).all() and (lengths[1] <= hexapod.stroke[1]).all()
    return bool(inside and abs(speed).max() <= hexapod.speed and abs(strength).max() <= hexapod.acceleration)


def test_the_gate_judges_a_motion_as_plain_numpy_does(gate: Gate, machine: Platform) -> None:
    motions = around(gate, np.random.default_rng(0), 4000)
    judged = np.array([gate.point(motion, motion, 0.0).passes for motion in motions])
    expected = np.array([by_numpy(motion, machine) for motion in motions])
    assert 0.05 < judged.mean() < 0.95
    assert (judged == expected).mean() > 0.999  # differences of lengths are good to 1e-6
    assert judged.sum() > 0
    assert (~judged).sum() > 0


@pytest.mark.parametrize("axis", [0, 1, 3, 4])
@pytest.mark.parametrize("row", [0, 1, 2])
def test_every_axis_is_checked_for_pose_speed_and_acceleration(gate: Gate, axis: int, row: int) -> None:
    b, motion = gate.bounds, np.zeros((3, 6))
    bound = (b.high, b.twist, b.acceleration)[row][axis]
    motion[row, axis] = 1.001 * bound
    motion[1, axis] -= 0.01 * motion[2, axis]  # the leading speed stays small
    verdict = gate.point(motion, motion, 0.0)
    expected = {
        0: {Refusal.POSE},
        1: {Refusal.TWIST},
        2: {Refusal.ACCELERATION},
    }[row]
    assert verdict.refusal in expected
    assert verdict.index == axis


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_what_is_no_number_is_refused_wherever_it_stands(gate: Gate, value: float) -> None:
    for row in range(3):
        for axis in range(6):
            motion = np.zeros((3, 6))
            motion[row, axis] = value
            assert gate.judge(motion).refusal is Refusal.NOT_FINITE


def test_a_jerk_beyond_what_the_lag_allows_is_refused(gate: Gate) -> None:
    before, after = np.zeros((3, 6)), np.zeros((3, 6))
    after[2, 0] = 0.9 * gate.bounds.acceleration[0]
    allowed = 2.0 * gate.bounds.acceleration[0] / 0.01
    assert gate.point(after, before, 1.01 * after[2, 0] / allowed).passes
    assert gate.point(after, before, 0.99 * after[2, 0] / allowed).refusal is Refusal.JERK


def test_legs_alone_refuse_a_pose_that_every_axis_allows() -> None:
    gate = Gate(load("davsi"), lag=0.01, period=0.01)  # whose box is not its workspace
    motion = np.zeros((3, 6))
    motion[0] = 0.9 * gate.bounds.high
    motion[0, :2] *= 0.5  # within the circle
    assert gate.point(motion, motion, 0.0).refusal is Refusal.LEG_LENGTH


def test_a_motion_that_cannot_stop_is_refused_though_it_is_within_all_limits(gate: Gate) -> None:
    motion = np.zeros((3, 6))
    motion[0, 0], motion[1, 0] = gate.bounds.high[0] - 3e-3, 0.9 * gate.bounds.twist[0]
    assert gate.point(motion, motion, 0.0).passes
    assert gate.judge(motion).refusal is Refusal.CANNOT_STOP


def test_no_command_whatever_leaves_the_limits(gate: Gate, machine: Platform) -> None:
    """Random and hostile commands, the gate before every step: what was sent is judged by plain numpy."""
    rng, rollout = np.random.default_rng(1), Rollout(gate)
    rollout.place(np.zeros(6))
    refused, sent = 0, []
    for _ in range(60):
        command = gate.reach.command * rng.choice([-1.0, 0.3, 1.0, 4.0]) * rng.uniform(-1.0, 1.0, 6)
        for _ in range(int(rng.integers(1, 120))):
            refused += not rollout.follow(command, 2e-3).passes
            sent.append(rollout.motion.copy())
    assert refused > 100
    assert max(abs(motion[0, 0]) for motion in sent) > 0.8 * gate.bounds.high[0]
    assert all(by_numpy(motion * (1.0 - 1e-5), machine) for motion in sent)


def test_a_plan_is_judged_as_its_own_roll_out(gate: Gate) -> None:
    rng, found = np.random.default_rng(2), set()
    for _ in range(60):
        stages = gate.reach.command * rng.uniform(-1.0, 1.0, 6) * rng.random() * np.ones((20, 1))
        motion, inside = np.zeros((3, 6)), True
        for stage in stages:
            for _ in range(2):
                gate.move(motion, stage, 5e-3)
                inside &= gate.point(motion, motion, 0.0).passes
        passes = gate.plan(np.zeros((3, 6)), np.ascontiguousarray(stages), 0.01).passes
        if passes:
            assert inside  # the gate also wants a margin of the legs, and a way to rest
        found.add(passes)
    assert found == {True, False}
    assert MARGIN < 0.05


@pytest.mark.parametrize(
    ("name", "breaks"),
    [("davsi", Refusal.LEG_LENGTH), ("davsi-4dof", Refusal.TWIST), ("thesis", Refusal.POSE)],
)
def test_a_plan_is_judged_by_bounds_as_it_is_sample_by_sample(name: str, breaks: Refusal) -> None:
    """Plans that pass, and plans that break a limit of an axis or of a leg somewhere on their way."""
    gate = Gate(load(name), lag=0.01, period=0.01)
    if name == "thesis":
        gate.bounds = gate.bounds._replace(joints=gate.bounds.joints[:0])  # axes alone
    rng, found, times = np.random.default_rng(6), set(), 0.01 * np.arange(90)[:, None]
    for k in range(300):
        size = np.minimum(gate.reach.command, 9.0) * rng.random(6) * rng.choice([0.02, 0.1, 0.4, 1.0])
        stages = size * np.sin(rng.uniform(1.0, 9.0, 6) * times + rng.uniform(0.0, 2.0 * np.pi, 6))
        if k % 50 == 0:
            stages[rng.integers(9), rng.integers(6)] = rng.choice([np.nan, np.inf])
        motion = np.zeros((3, 6))
        refusal, at = 0, 0
        for stage in stages:
            refusal, at = _way(motion, stage, 0.01, gate.bounds, gate.reach)
            if refusal:
                break
        if not refusal:
            refusal, at = _way_to_rest(motion, gate.bounds, gate.reach)
        verdict = gate.plan(np.zeros((3, 6)), stages, 0.01)
        assert (verdict.refusal, verdict.index) == (refusal, at)
        found.add(verdict.refusal)
    assert found >= {Refusal.NOTHING, Refusal.NOT_FINITE, breaks}, found


def test_nothing_is_compiled_for_commands_that_cannot_be_written_to(gate: Gate) -> None:
    """Numba compiles anew for read-only arrays, and plans are read-only: this took 40 s in a cold cache."""
    stages = frozen_array(np.zeros((4, 6)))
    rollout = Rollout(gate)
    before = compiled()
    motion = np.zeros((3, 6))
    gate.move(motion, stages[1], 1e-3)
    rollout.follow(stages[1], 1e-3)
    gate.plan(motion, stages[1:], 0.01)
    assert compiled() == before


def on_the_way(gate: Gate, motion: Mat) -> Mat:
    """Motions (n, 3, 6) every 5 ms on the way to rest, by the matrix exponential of the lagged model."""
    T, dt = gate.bounds.lag, 5e-3
    A = np.array([[0, 1, 0, 0], [0, 0, 1, 0], [0, 0, -1 / T, 1 / T], [0, 0, 0, 0]])  # p, v, a, u
    step = expm(A * dt)
    found, state = [motion], np.vstack([motion, np.zeros(6)])
    for u in gate.rest(motion):
        state[3] = u
        for _ in range(2):
            state = step @ state
            found.append(state[:3].copy())
    return np.array(found)


def test_the_way_to_rest_is_judged_as_plain_numpy_does() -> None:
    """On six legs that are shorter than the box of their axes; what is within 2 % of a limit is left out."""
    platform = load("davsi")
    gate = Gate(platform, lag=0.01, period=0.01)
    legs = platform.six_legs()
    rng, found = np.random.default_rng(3), {True: 0, False: 0}
    for motion in 0.45 * around(gate, rng, 500):
        if gate.judge(motion).refusal is Refusal.CANNOT_STOP or not by_numpy(motion, platform):
            continue
        lengths = leg_lengths(on_the_way(gate, motion)[:, 0], legs.joints, legs.anchors)
        room = min(float(lengths.min()) - legs.stroke[0], legs.stroke[1] - float(lengths.max()))
        speed = float(np.abs(np.diff(lengths, axis=0)).max()) / 5e-3
        width = legs.stroke[1] - legs.stroke[0]
        if room < 0.0 or speed > legs.speed:
            assert not gate.judge(motion).passes
            found[False] += 1
        elif room > 0.02 * width and speed < 0.9 * legs.speed:
            strength = np.abs(np.diff(lengths, n=2, axis=0)).max() / 25e-6
            if strength < 0.7 * legs.acceleration:
                assert gate.judge(motion).passes
                found[True] += 1
    assert min(found.values()) > 10, found


@pytest.mark.parametrize(
    "widened",
    [
        "low",
        "high",
        "twist",
        "acceleration",
        "circle",
        "shortest",
        "longest",
        "leg_speed",
        "leg_acceleration",
    ],
)
def test_a_check_that_is_left_out_is_missed(widened: str) -> None:
    """Mutation: the gate without one of its limits disagrees with plain numpy."""
    platform = load("davsi" if "leg" in widened or "est" in widened else "davsi-4dof")  # what meets it first
    gate = Gate(platform, lag=0.01, period=0.01)
    stroke, b = gate.bounds.stroke, gate.bounds
    wide: dict[str, Any] = {
        "low": b.low - 1e3,
        "high": b.high + 1e3,
        "twist": b.twist + 1e3,
        "acceleration": b.acceleration + 1e3,
    }
    name = {"shortest": "stroke", "longest": "stroke"}.get(widened, widened)
    value = {"shortest": (-9.0, stroke[1]), "longest": (stroke[0], 9.0)}.get(widened, wide.get(widened, 1e9))
    rng = np.random.default_rng(4)
    motions = around(gate, rng, 6000) * np.where(rng.random((6000, 1, 6)) < 0.7, 0.15, 1.0)
    disagree = []
    for bounds in (b, b._replace(**{name: value})):
        gate.bounds = bounds
        judged = np.array([gate.point(motion, motion, 0.0).passes for motion in motions])
        disagree.append(judged)
    changed = np.flatnonzero(disagree[0] != disagree[1])
    assert len(changed) > 0
    assert not any(by_numpy(motions[k] * (1.0 + 1e-5), platform) for k in changed[:20])
