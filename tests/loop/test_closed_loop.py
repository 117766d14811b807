"""A closed loop in parts: however it is cut, the numbers are the same; changes act at the next decision."""

from dataclasses import replace

import numpy as np
import pytest

from otolith.core.errors import InputError
from otolith.core.frames import SURGE_PITCH, Dof
from otolith.cueing.design import Design, predictive, reweigh
from otolith.cueing.mpc.washout_weights import constant
from otolith.cueing.washout.classical import classical
from otolith.cueing.washout.tuning import Corners
from otolith.interfaces import Cueing
from otolith.loop import ClosedLoop, simulate
from otolith.plant.actuator import Actuator
from otolith.plant.ideal import Ideal
from otolith.platforms import load
from otolith.scenarios import scenario
from tests.loop.test_simulate import PULSE, Echo

DAVSI = load("davsi")
DESIGN = Design(platform=DAVSI)


def loop_of(
    cueing: Cueing, name: str = "step-1", plant=None, dofs: tuple[Dof, ...] = (SURGE_PITCH,)
) -> ClosedLoop:
    names = tuple(dof.name for dof in dofs)
    return ClosedLoop(cueing, plant or Ideal(), scenario(name), platform=DAVSI, dofs=names)


def test_parts_give_the_same_numbers_as_the_whole_bit_for_bit() -> None:
    whole = simulate(predictive(DESIGN), Ideal(), scenario("step-1"), platform=DAVSI, dofs=("surge-pitch",))
    loop = loop_of(predictive(DESIGN))
    for last in (1, 2, 40, 41, 333, 10_000):
        loop.advance(last)
    parts = loop.run()
    for name in ("time", "pose", "twist", "felt_force", "reference_force", "command", "changes", "residual"):
        np.testing.assert_array_equal(getattr(parts, name), getattr(whole, name))
    assert parts.solver == whole.solver


def test_a_stretch_is_the_same_rows_of_the_whole_in_python_too() -> None:
    loop = ClosedLoop(Echo(), Actuator(0.01, 0.0), PULSE, platform=DAVSI, dofs=("surge-pitch",))
    loop.advance(4)
    early = loop.run()
    loop.advance(7)
    late = loop.run(4)
    assert len(early.time) == 400
    assert len(late.time) == 300
    both = loop.run()
    np.testing.assert_array_equal(both.pose[400:], late.pose)
    np.testing.assert_array_equal(both.time[400:], late.time)
    assert late.command_time[0] == pytest.approx(0.4)
    assert late.status == both.status[4:]


def test_a_new_scale_acts_from_the_next_decision_on_and_stands_in_the_record() -> None:
    echo = Echo()
    loop = ClosedLoop(echo, Ideal(0.0), PULSE, platform=DAVSI, dofs=("surge-pitch",))
    loop.advance(5)
    loop.rescale(0.5)
    loop.advance(7)
    loop.rescale(3.0)
    loop.advance(10)
    assert echo.seen == [0.0] * 3 + [1.0] * 2 + [0.5] * 2 + [3.0] * 3
    wanted = loop.run().reference_force[:, 0]
    np.testing.assert_array_equal(wanted[[310, 499, 500, 699, 700, 999]], [1.0, 1.0, 0.5, 0.5, 3.0, 3.0])


def test_a_new_scale_in_compiled_code_is_the_scenario_of_that_scale() -> None:
    """From the start the change is the scaled scenario itself; the wanted forces then agree bit for bit."""
    loop = loop_of(predictive(DESIGN))
    loop.rescale(0.5)
    loop.advance(10_000)
    scaled = simulate(
        predictive(DESIGN), Ideal(), scenario("step-1").scaled(0.5), platform=DAVSI, dofs=("surge-pitch",)
    )
    np.testing.assert_allclose(loop.run().pose, scaled.pose, atol=1e-12)


def test_liveliness_that_is_changed_before_the_start_is_that_of_another_design() -> None:
    changed, lively = predictive(DESIGN), replace(DESIGN, liveliness=0.9)
    loop = loop_of(changed)
    reweigh(changed, "predictive", lively)
    loop.advance(10_000)
    other = loop_of(predictive(lively))
    other.advance(10_000)
    np.testing.assert_allclose(loop.run().pose, other.run().pose, atol=1e-9)
    still = loop_of(predictive(DESIGN))
    still.advance(10_000)
    assert np.abs(still.run().pose - loop.run().pose).max() > 1e-3


def test_corner_frequencies_change_in_compiled_code_without_a_jump() -> None:
    """From the change on it is another motion, and velocities go on from where they are: within 2 m/s²."""
    cueing, faster = classical(DESIGN), replace(DESIGN, corners=Corners(high_pass=2.0, low_pass=0.5))
    loop, still = loop_of(cueing), loop_of(classical(DESIGN))
    loop.advance(250)
    reweigh(cueing, "classical", faster)
    loop.advance(10_000)
    still.advance(10_000)
    changed, same = loop.run(), still.run()
    np.testing.assert_array_equal(changed.pose[:2500], same.pose[:2500])
    assert np.abs(changed.pose - same.pose).max() > 1e-3
    assert np.abs(np.diff(changed.twist[2400:2700], axis=0)).max() < 2e-3
    assert np.abs(np.diff(changed.pose[2400:2700], axis=0)).max() < 1e-3


def test_weights_on_other_states_are_refused_and_nothing_changes() -> None:
    cueing = predictive(DESIGN)
    loop = loop_of(cueing)
    wrong = replace(DESIGN, mpc=replace(DESIGN.mpc, washout=constant({"velocity": 1.0})))
    with pytest.raises(InputError, match="surge-pitch position"):
        reweigh(cueing, "implicit", wrong)
    loop.advance(200)
    other = loop_of(predictive(DESIGN))
    other.advance(200)
    np.testing.assert_array_equal(loop.run().pose, other.run().pose)
