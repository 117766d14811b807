"""Programs in C against the closed loop in Python, decision by decision."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from otolith import files, registry
from otolith.compiled import STATUSES, offered
from otolith.core.errors import InputError
from otolith.core.frames import dofs_named
from otolith.core.methods import hold
from otolith.cueing.design import Design, mpcs_of
from otolith.export.make import Kind, decision_of, program_of
from otolith.export.step import decide_once
from otolith.export.vectors import drive, simulated, vectors
from otolith.qp.blocked_engine import BlockedEngine
from tests.export.in_c import Stepper, needs_compiler


def _design(platform: str = "thesis", dofs: str = "surge-pitch") -> Design:
    return Design(platform=files.read_platform(platform), dofs=dofs_named(dofs.split(",")))


@needs_compiler
@pytest.mark.parametrize("cueing", ["classical", "adaptive", "optimal", "optimal-nonlinear"])
def test_a_washout_moves_a_platform_as_in_python_bit_for_bit(cueing: str, tmp_path: Path) -> None:
    design = _design("davsi", "surge-pitch,sway-roll,heave,yaw")
    program = program_of(design, cueing, "moved", Kind.PLATFORM)
    expected = vectors(design, cueing, Kind.PLATFORM, drive(10.0))
    status, out = Stepper(program, tmp_path, "-O1", "-ffp-contract=off").run(expected.inputs)
    assert not status.any()
    np.testing.assert_array_equal(out, expected.outputs)


@needs_compiler
@pytest.mark.parametrize(
    ("cueing", "flags"),
    [("implicit", ["-O1"]), ("predictive", ["-O3"]), ("predictive", ["-Os", "-Ddecided_PLAIN"])],
)
def test_an_mpc_decides_as_in_python(cueing: str, flags: list[str], tmp_path: Path) -> None:
    """Both engines settle at 1e-9 of a bound; how sums are rounded on the way differs between compilers."""
    design = _design()
    program = program_of(design, cueing, "decided", Kind.COMMAND)
    expected = vectors(design, cueing, Kind.COMMAND, drive(20.0))
    _, out = Stepper(program, tmp_path, *flags).run(expected.inputs)
    status, changes = expected.outputs[:, 6], expected.outputs[:, 8]
    assert np.count_nonzero(changes) > 100  # the platform's limits were at work
    np.testing.assert_array_equal(out[:, 6], status)
    np.testing.assert_allclose(out[:, :6], expected.outputs[:, :6], atol=2e-8, rtol=0.0)


@needs_compiler
def test_the_blocked_engine_decides_as_in_python(tmp_path: Path) -> None:
    """Of a problem none of whose rows varies: what would write them is not reached, and compiles."""
    design = _design()
    design = replace(design, mpc=replace(design.mpc, engine=BlockedEngine))
    program = program_of(design, "predictive", "blocked", Kind.COMMAND)
    expected = vectors(design, "predictive", Kind.COMMAND, drive(8.0))
    _, out = Stepper(program, tmp_path, "-O1").run(expected.inputs)
    assert np.count_nonzero(expected.outputs[:, 8]) > 50
    np.testing.assert_array_equal(out[:, 6], expected.outputs[:, 6])
    np.testing.assert_allclose(out[:, :6], expected.outputs[:, :6], atol=2e-9, rtol=0.0)


@needs_compiler
def test_a_washout_moves_six_legs_with_servos_and_supervisor_as_in_python(tmp_path: Path) -> None:
    """Bit for bit, with the supervisor at work."""
    design = _design("davsi", "surge-pitch,sway-roll,heave,yaw")
    program = program_of(design, "classical", "legs", Kind.PLATFORM, plant="hexapod")
    mild = drive(4.0)
    wild = replace(mild, specific_force=lambda t: 3.0 * mild.specific_force(t))
    run, expected = simulated(design, "classical", Kind.PLATFORM, wild, plant="hexapod")
    assert run.interventions
    status, out = Stepper(program, tmp_path, "-O1", "-ffp-contract=off").run(expected.inputs)
    assert not status.any()
    np.testing.assert_array_equal(out, expected.outputs)


@needs_compiler
def test_six_axes_with_rows_of_legs_are_decided_as_in_python(tmp_path: Path) -> None:
    """The engine of few blocks and many rows, and the kinematics of the legs, in C."""
    design = _design("davsi", "surge-pitch,sway-roll,heave,yaw")
    program = program_of(design, "six-axis", "six", Kind.COMMAND)
    expected = vectors(design, "six-axis", Kind.COMMAND, drive(2.0))
    _, out = Stepper(program, tmp_path, "-O1").run(expected.inputs)
    assert np.count_nonzero(expected.outputs[:, 8]) > 50
    np.testing.assert_array_equal(out[:, 6], expected.outputs[:, 6])
    np.testing.assert_allclose(out[:, :6], expected.outputs[:, :6], atol=2e-9, rtol=0.0)


@needs_compiler
def test_what_is_not_plausible_is_answered_by_braking_and_forgotten(tmp_path: Path) -> None:
    program = program_of(_design(), "predictive", "braked", Kind.COMMAND)
    stepper = Stepper(program, tmp_path, "-O1")
    moving = np.zeros(24)
    moving[12], moving[0] = 0.4, 1.0  # 0.4 m/s forward, 1 m/s² wanted
    _, before = stepper.step(moving)
    for bad in (np.nan, np.inf, 1e7):
        moving[0] = bad
        status, out = stepper.step(moving)
        assert STATUSES[status] == "invalid"
        assert -5.0 <= out[0] < 0.0  # against the motion, within the limit
    stepper.begin()
    moving[0] = 1.0
    np.testing.assert_array_equal(stepper.step(moving)[1], before)


@needs_compiler
def test_from_any_motion_the_same_is_decided_and_for_the_same_reason(tmp_path: Path) -> None:
    """Motions beyond the limits too, where there is no plan, or none after which the platform could stop."""
    design, random = _design(), np.random.default_rng(5)
    stepper = Stepper(program_of(design, "implicit", "anywhere", Kind.COMMAND), tmp_path, "-O1")
    algorithm = registry.make_cueing("implicit", design)
    for mpc in mpcs_of(algorithm):
        mpc.unaided()
    method = offered(algorithm)
    assert method is not None
    decision = decision_of(method)
    held, _ = hold(decision)
    within, seen = [[0.6, 0.6], [3.0, 0.06], [6.0, 1.0]], set()  # positions, speeds, accelerations
    for _ in range(300):
        decision.wanted[0] = random.uniform(-6.0, 6.0)
        decision.measured[:, [0, 4]] = random.uniform(-1.0, 1.0, (3, 2)) * within
        status, out = stepper.step(np.concatenate([decision.wanted, decision.measured.ravel()]))
        assert status == decide_once(held)
        seen.add(STATUSES[status].value)
        np.testing.assert_allclose(out[:6], decision.command, atol=1e-6, rtol=0.0)
    assert seen >= {"decided", "fallback"}


@needs_compiler
def test_two_instances_know_nothing_of_each_other(tmp_path: Path) -> None:
    program = program_of(_design(), "classical", "twice", Kind.PLATFORM)
    one = Stepper(program, tmp_path)
    wanted = [1.0, 0, 0, 0, 0, 0]
    alone = [one.step(wanted)[1] for _ in range(20)]
    one.begin()
    (tmp_path / "other").mkdir()
    other = Stepper(program, tmp_path / "other")
    for expected in alone:
        other.step([-2.0, 0, 0, 0, 0, 0])
        np.testing.assert_array_equal(one.step(wanted)[1], expected)


@needs_compiler
def test_no_name_of_a_platform_ends_the_comment_that_holds_it(tmp_path: Path) -> None:
    design = _design()
    named = design.platform.model_copy(update={"name": "a */ int b; /* c"})
    program = program_of(replace(design, platform=named), "implicit", "quiet", Kind.COMMAND)
    assert "int b;" in program.header.split("*/")[0]
    Stepper(program, tmp_path)  # compiles without a warning


NOT_ALONE = [name for name, entry in registry.CUEING.own.items() if not entry.alone]


@pytest.mark.parametrize("name", NOT_ALONE)
def test_what_needs_python_is_refused_before_it_is_made(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Making some of them takes minutes of compiling."""
    monkeypatch.setattr(registry, "make_cueing", None)
    with pytest.raises(InputError, match=r"--cueing is .* must be one that decides without Python"):
        program_of(_design(), name, "refused", Kind.COMMAND)


def test_an_mpc_that_asks_python_says_what_for() -> None:
    for mpc in mpcs_of(registry.make_cueing("implicit-trajectory", _design())):
        with pytest.raises(InputError, match="asks for the guess HeldPlan"):
            mpc.unaided()
