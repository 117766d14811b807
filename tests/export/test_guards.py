"""The gate and the supervisor as programs: what Python's pass on, bit for bit, whatever is asked."""

from pathlib import Path

import numpy as np
import pytest

from otolith import files
from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError
from otolith.export.guards import (
    LAW,
    STEP,
    SetPoints,
    gating,
    program_of_guard,
    supervising,
    vectors_of_guard,
)
from otolith.live.core.gate import Gate
from otolith.live.core.rollout import Rollout
from otolith.platforms import load
from otolith.safety.supervisor import Supervisor
from tests.export.in_c import Stepper, needs_compiler
from tests.export.sanitized import Sanitized, hostile
from tests.platforms.cranks import machine

STRICT = ("-O2", "-ffp-contract=off")


MADE = {
    "gate": lambda: gating(load("davsi")),
    "supervisor of poses": lambda: supervising(load("davsi").six_legs(), "davsi"),
    "supervisor of legs": lambda: supervising(
        load("davsi").six_legs(), "davsi", set_points=SetPoints.LEGS, period=0.002
    ),
    "supervisor of cranks": lambda: supervising(machine(), "cranks", set_points=SetPoints.LEGS),
}


@needs_compiler
@pytest.mark.parametrize("made", MADE)
def test_its_vectors_hold_bit_for_bit_and_sanitizers_find_nothing(made: str, tmp_path: Path) -> None:
    guard = MADE[made]()
    program = program_of_guard(guard, "guard")
    expected = vectors_of_guard(guard, 1000)
    status, out = Sanitized(program, tmp_path).run(expected.inputs)
    np.testing.assert_array_equal(out, expected.outputs)
    assert 0 in status  # it passed …
    assert len(np.unique(status)) > 2  # … and more was asked than it could give, of several kinds
    np.testing.assert_array_equal(status, out[:, -2])


@needs_compiler
def test_the_gate_passes_on_what_live_set_points_are(tmp_path: Path) -> None:
    platform = load("davsi")
    commands = hostile(vectors_of_guard(gating(platform), 1000).inputs, seed=1)
    _, out = Stepper(program_of_guard(gating(platform), "gate"), tmp_path, *STRICT).run(commands)
    gate = Gate(platform, lag=platform.actuators.lag_s, period=LAW)
    rollout, motion = Rollout(gate), np.empty((len(commands), 18))
    for k, command in enumerate(commands):
        verdict = rollout.follow(command, STEP)
        motion[k] = rollout.motion.ravel()
        assert (verdict.refusal, verdict.index + 1 if not verdict.passes else 0) == tuple(out[k, 18:])
    np.testing.assert_array_equal(out[:, :18], motion)


@needs_compiler
def test_the_supervisor_keeps_the_legs_whatever_it_is_told(tmp_path: Path) -> None:
    """Judged by the lengths alone, and by those of Python's supervisor."""
    legs, random = load("davsi").six_legs(), np.random.default_rng(2)
    told = hostile(random.uniform(-3.0, 3.0, (1000, 12)), seed=3, share=0.3)
    program = program_of_guard(supervising(legs, "davsi", set_points=SetPoints.LEGS), "legs")
    _, out = Sanitized(program, tmp_path).run(told)
    supervisor = Supervisor(legs, period=STEP)
    expected = [_followed(supervisor, row) for row in told]
    np.testing.assert_array_equal(out[:, :6], expected)
    assert legs.stroke[0] <= out[:, :6].min() <= out[:, :6].max() <= legs.stroke[1]
    assert np.abs(np.diff(out[:, :6], axis=0)).max() <= legs.speed * STEP * (1.0 + 1e-9)


def _followed(supervisor: Supervisor, told: Vec) -> Vec:
    supervisor.follow(told[:6], told[6:])
    return supervisor.lengths.copy()


@needs_compiler
def test_poses_and_their_legs_lead_to_the_same(tmp_path: Path) -> None:
    legs = load("davsi").six_legs()
    programs = [program_of_guard(supervising(legs, "davsi", set_points=one), one.value) for one in SetPoints]
    poses = vectors_of_guard(supervising(legs, "davsi"), 500).inputs
    poses = poses[np.isfinite(poses).all(axis=1)]
    motions = [legs.leg_motion(row[:6], row[6:], np.zeros(6)) for row in poses]
    told = np.array([np.concatenate([one.length, one.speed]) for one in motions])
    (_, by_pose), (_, by_legs) = (
        Stepper(program, tmp_path, *STRICT).run(given)
        for program, given in zip(programs, (poses, told), strict=True)
    )
    np.testing.assert_array_equal(by_pose, by_legs)


@pytest.mark.parametrize("period", [0.0, -0.001, 1.0, np.nan])
def test_a_period_that_is_none_is_refused(period: float) -> None:
    with pytest.raises(InputError, match=r"--period is .* s between two set-points"):
        gating(files.read_platform("davsi"), period=period)


def test_what_begins_within_the_legs_begins_at_their_lengths() -> None:
    legs = machine()
    program = program_of_guard(supervising(legs, "cranks"), "begun")
    told: Mat = legs.positions(np.zeros(6))
    assert [port.start for port in program.outputs[:6]] == list(told)
    assert {port.unit for port in program.outputs[:12]} == {"rad", "rad/s"}
