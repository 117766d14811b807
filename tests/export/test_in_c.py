"""Programs in C against the closed loop in Python, decision by decision."""

from pathlib import Path

import numpy as np
import pytest

from otolith import Run, files, registry
from otolith.compiled import STATUSES
from otolith.core.arrays import Mat
from otolith.core.errors import InputError
from otolith.core.frames import dofs_named
from otolith.cueing.design import Design
from otolith.export.make import Kind, program_of
from otolith.loop import simulate
from otolith.loop.simulate import EDGE
from otolith.scenarios import Scenario, scenario
from tests.export.in_c import Stepper, needs_compiler


def _design(platform: str = "thesis", dofs: str = "surge-pitch") -> Design:
    return Design(platform=files.read_platform(platform), dofs=dofs_named(dofs.split(",")))


def _simulated(design: Design, cueing: str, reference: Scenario) -> Run:
    plant = registry.make_plant(registry.cueing_named(cueing).plant, design.platform)
    algorithm = registry.make_cueing(cueing, design, dead_time=plant.dead_time)
    names = tuple(dof.name for dof in design.dofs)
    return simulate(algorithm, plant, reference, platform=design.platform, dofs=names)


def _wanted(run: Run, reference: Scenario, period: float) -> Mat:
    at = np.arange(run.decisions, dtype=np.float64) * period + EDGE
    return np.hstack([reference.specific_force(at), reference.angular_rate(at)])


def _measured(run: Run) -> Mat:
    """Return the motion (decisions, 18) that each decision saw."""
    motion = np.hstack([run.pose, run.twist, run.acceleration])
    every = run.samples // run.decisions
    return np.vstack([np.zeros(18), motion[every - 1 : -1 : every]])


@needs_compiler
@pytest.mark.parametrize("cueing", ["classical", "adaptive", "optimal", "optimal-nonlinear"])
def test_a_washout_moves_a_platform_as_in_python_bit_for_bit(cueing: str, tmp_path: Path) -> None:
    design = _design("davsi", "surge-pitch,sway-roll,heave,yaw")
    reference = scenario("sine-1")
    run = _simulated(design, cueing, reference)
    program = program_of(design, cueing, "moved", Kind.PLATFORM)
    status, out = Stepper(program, tmp_path, "-O1", "-ffp-contract=off").run(
        _wanted(run, reference, program.period)
    )
    ends = slice(run.samples // run.decisions - 1, None, run.samples // run.decisions)
    assert not status.any()
    np.testing.assert_array_equal(out[:, :6], run.pose[ends])
    np.testing.assert_array_equal(out[:, 12:18], run.acceleration[ends])
    np.testing.assert_array_equal(out[:, 18:21], run.felt_force[ends])


@needs_compiler
@pytest.mark.parametrize("cueing", ["implicit", "predictive"])
def test_an_mpc_decides_as_in_python(cueing: str, tmp_path: Path) -> None:
    """Both engines settle at 1e-9 of a bound; how sums are rounded on the way differs between compilers."""
    design, reference = _design(), scenario("sine-1")
    run = _simulated(design, cueing, reference)
    program = program_of(design, cueing, "decided", Kind.COMMAND)
    inputs = np.hstack([_wanted(run, reference, program.period), _measured(run)])
    status, out = Stepper(program, tmp_path, "-O1").run(inputs)
    assert [STATUSES[one] for one in status] == list(run.status)
    assert np.any(run.changes > 0)  # the working set was at work
    np.testing.assert_allclose(out[:, :6], run.command, atol=5e-9, rtol=0.0)


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


def test_what_needs_python_is_refused_with_the_reason() -> None:
    with pytest.raises(InputError, match="asks for the guess HeldPlan"):
        program_of(_design(), "implicit-trajectory", "refused", Kind.COMMAND)
