"""Deciding for the moment at which a command acts, against plants whose motion is solved exactly."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from otolith import metrics
from otolith.core.errors import InputError
from otolith.core.frames import SURGE_PITCH
from otolith.cueing.ahead import SETTLING, Ahead
from otolith.cueing.design import Design, implicit
from otolith.interfaces import Command, Outcome, PlatformState, Reference, Status
from otolith.loop import simulate
from otolith.plant.actuator import Actuator
from otolith.platforms import load
from otolith.registry import make_cueing
from otolith.scenarios import scenario

T = 0.01
DAVSI = load("davsi")


class Told:
    """Commands given in advance; remembers what it was told."""

    period = T

    def __init__(self, commands: np.ndarray) -> None:
        self._commands = commands
        self.states: list[PlatformState] = []
        self.references: list[Reference] = []

    def reset(self, state: PlatformState) -> None:
        self.states, self.references = [], []

    def step(self, state: PlatformState, reference: Reference) -> Command:
        self.states.append(state)
        self.references.append(reference)
        acceleration = np.zeros(6)
        acceleration[0] = self._commands[len(self.states) - 1]
        zero = np.zeros(6)
        outcome = Outcome(status=Status.DECIDED)
        return Command(
            acceleration=acceleration, pose=zero, twist=zero, plan=np.zeros((0, 6)), outcome=outcome
        )


@pytest.mark.parametrize("dead_time", [0.0, 0.003, 0.01, 0.014, 0.05])
def test_what_is_told_is_where_the_platform_will_be_when_the_command_acts(dead_time: float) -> None:
    """Against the plant itself, sampled every millisecond and looked at a dead time later."""
    rng = np.random.default_rng(3)
    recorder = Told(rng.normal(size=60))
    ahead, plant = Ahead(recorder, lag=0.01, dead_time=dead_time), Actuator(0.01, dead_time)
    start = PlatformState(twist=np.array([0.1, 0, 0, 0, 0, 0]))
    ahead.reset(start)
    plant.reset(start)
    state, moved = start, [start]
    for _ in range(60):
        command = ahead.step(state, Reference(specific_force=np.zeros(3)))
        for _ in range(10):
            state = plant.step(command, 1e-3)
            moved.append(state)
    later = round(1e3 * dead_time)
    for k in range(54):
        there = moved[10 * k + later]
        for name in ("pose", "twist", "acceleration"):
            assert_allclose(getattr(recorder.states[k], name), getattr(there, name), atol=1e-12)


def test_a_difference_that_timing_may_explain_is_believed_slowly_and_any_other_at_once() -> None:
    recorder = Told(np.zeros(200))
    ahead = Ahead(recorder, lag=0.01, dead_time=0.01)
    ahead.reset(PlatformState())
    still = Reference(specific_force=np.zeros(3))
    ahead.step(PlatformState(), still)
    elsewhere = PlatformState(pose=np.array([0.1, 0, 0, 0, 0, 0]))
    ahead.step(elsewhere, still)  # at rest, without commands, no timing explains that
    assert recorder.states[-1].pose[0] == pytest.approx(0.1)

    recorder = Told(np.full(200, 2.0))
    ahead = Ahead(recorder, lag=0.01, dead_time=0.01)
    ahead.reset(PlatformState())
    believed = []
    for k in range(120):  # the platform is faster than it should be, by what half a dead time makes
        true = PlatformState(
            twist=np.array([0.01 + 2.0 * T * k - 0.04, 0, 0, 0, 0, 0]),
            acceleration=np.array([2.0, 0, 0, 0, 0, 0]),
            pose=ahead._believed[0],
        )
        ahead.step(true, still)
        believed.append(true.twist[0] - ahead._believed[1, 0])
    late = np.array(believed)[20:]
    shrinking = late[1:] / late[:-1]
    assert_allclose(shrinking, np.exp(-T / SETTLING), rtol=0.02)


def test_what_is_no_measurement_is_passed_on_as_none() -> None:
    recorder = Told(np.zeros(5))
    ahead = Ahead(recorder, lag=0.01, dead_time=0.01)
    ahead.step(PlatformState(pose=np.full(6, np.nan)), Reference(specific_force=np.zeros(3)))
    assert not np.isfinite(recorder.states[0].pose).any()
    ahead.step(PlatformState(), Reference(specific_force=np.zeros(3)))
    assert np.isfinite(recorder.states[1].pose).all()


def test_a_reference_is_passed_on_as_older_by_the_dead_time() -> None:
    recorder = Told(np.zeros(5))
    ahead = Ahead(recorder, lag=0.01, dead_time=0.015)
    ahead.step(PlatformState(), Reference(specific_force=np.ones(3), age=0.02))
    assert_allclose(recorder.references[0].age, 0.035)
    assert_allclose(recorder.references[0].specific_force, 1.0)


@pytest.mark.parametrize("dead_time", [-0.01, 1.5, float("nan")])
def test_dead_times_beyond_reason_are_refused(dead_time: float) -> None:
    with pytest.raises(InputError, match=r"dead time is .*, must be between 0 and 1 s"):
        Ahead(Told(np.zeros(1)), lag=0.01, dead_time=dead_time)


@pytest.mark.parametrize(("lag", "dead_time"), [(0.01, 0.01), (0.005, 0.015), (0.015, 0.015), (0.005, 0.005)])
def test_lag_and_dead_time_wrong_by_half_leave_every_decision_a_solution(
    lag: float, dead_time: float
) -> None:
    """Before, with the state taken as it is measured, 320 of these 1,000 decisions had none."""
    cueing = make_cueing("implicit", Design(platform=DAVSI), dead_time=0.01)
    run = simulate(
        cueing, Actuator(lag, dead_time), scenario("step-1"), platform=DAVSI, dofs=("surge-pitch",)
    )
    assert set(run.status) == {Status.DECIDED}
    for excess in metrics.excesses(run):
        assert excess.at_nodes < (np.deg2rad(0.2) if "tilt_rate" in excess.quantity else 1e-6), excess


def test_without_a_dead_time_it_decides_as_the_algorithm_alone() -> None:
    alone, wrapped = (
        implicit(Design(platform=DAVSI)),
        Ahead(implicit(Design(platform=DAVSI)), lag=0.01, dead_time=0.0),
    )
    runs = [
        simulate(one, Actuator(0.01, 0.0), scenario("step-1"), platform=DAVSI, dofs=(SURGE_PITCH.name,))
        for one in (alone, wrapped)
    ]
    assert_allclose(runs[0].pose, runs[1].pose, atol=1e-9)
