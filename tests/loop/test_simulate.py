"""The closed loop itself, with a cueing algorithm and a clock made for the purpose."""

from dataclasses import replace
from itertools import count
from typing import Any

import numpy as np
import pytest

from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError
from otolith.core.frames import SURGE_PITCH
from otolith.cueing.mpc.controller import Mpc
from otolith.cueing.mpc.settings import MpcSettings
from otolith.cueing.prediction import Oracle
from otolith.interfaces import Command, Outcome, PlatformState, Reference, Status
from otolith.loop import simulate
from otolith.plant.ideal import Ideal, without_lag
from otolith.platforms import load
from otolith.qp.engines import CondensedEngine
from otolith.scenarios import Scenario


class Echo:
    """Commands the force wanted as acceleration: with no tilt and no lag it is felt exactly."""

    period = 0.1

    def __init__(self) -> None:
        self.seen: list[float] = []

    def reset(self, state: PlatformState) -> None:
        self.seen.clear()

    def step(self, state: PlatformState, reference: Reference) -> Command:
        self.seen.append(float(reference.specific_force[0]))
        acceleration = np.zeros(6)
        acceleration[:3] = reference.specific_force
        zero = np.zeros(6)
        outcome = Outcome(status=Status.DECIDED, changes=len(self.seen))
        return Command(
            acceleration=acceleration, pose=zero, twist=zero, plan=np.zeros((0, 6)), outcome=outcome
        )


def pulse(t: Vec) -> Mat:
    """1 m/s² from 0.3 s on; a jump that falls on a decision."""
    f = np.zeros((len(t), 3))
    f[:, 0] = t >= 0.3
    return f


PULSE = Scenario(name="pulse", duration=1.0, specific_force=pulse)


def close(cueing: Echo, plant_period: float = 1e-3, **options):
    return simulate(
        cueing,
        without_lag(),
        PULSE,
        platform=load("thesis"),
        dofs=("surge-pitch",),
        plant_period=plant_period,
        **options,
    )


@pytest.mark.parametrize("plant_period", [1e-3, 1e-2, 0.1 / 3])
def test_a_jump_on_a_decision_is_seen_by_it_and_felt_from_then_on(plant_period: float) -> None:
    """No sample is off by one, whatever the rounding of k·dt: wanted and felt agree everywhere."""
    cueing = Echo()
    run = close(cueing, plant_period)
    assert cueing.seen == [0.0] * 3 + [1.0] * 7
    np.testing.assert_array_equal(run.felt_force, run.reference_force)
    np.testing.assert_allclose(run.pose[-1, 0], 0.5 * 0.7**2, atol=1e-12)


def test_decisions_and_nodes_line_up() -> None:
    run = close(Echo())
    np.testing.assert_allclose(run.at_decisions(run.time), run.command_time + 0.1)
    assert list(run.changes) == list(range(1, 11))


def test_the_clock_is_an_argument_and_touches_nothing_else() -> None:
    ticks = count()
    run, again = close(Echo(), clock=lambda: float(next(ticks))), close(Echo())
    np.testing.assert_array_equal(run.step_time, 1.0)
    np.testing.assert_array_equal(run.pose, again.pose)


def test_progress_ends_at_one() -> None:
    fractions: list[float] = []
    close(Echo(), progress=fractions.append)
    assert fractions == sorted(fractions)
    assert fractions[-1] == 1.0


def test_periods_that_do_not_divide_are_refused() -> None:
    with pytest.raises(
        InputError, match=r"period of the controller is 0\.1 s, must be a multiple of 0\.03 s"
    ):
        close(Echo(), 0.03)


def test_what_a_plant_senses_is_what_was_felt() -> None:
    """With a head given, the run's force is the plant's; without one, the planar model's, as ever."""
    options: dict[str, Any] = {"platform": load("thesis"), "dofs": ("surge-pitch",)}
    planar = simulate(Echo(), Ideal(lag=0.0), PULSE, **options)
    sensed = simulate(Echo(), Ideal(lag=0.0, head=(0.0, 0.0, 0.9)), PULSE, **options)
    np.testing.assert_array_equal(planar.pose, sensed.pose)
    np.testing.assert_allclose(sensed.felt_force, planar.felt_force, atol=1e-12)  # nothing turned


def test_the_rate_felt_is_of_the_drivers_frame() -> None:
    run = close(Echo())
    rolled, yawing = np.zeros_like(run.pose), np.zeros_like(run.twist)
    rolled[:, 3], yawing[:, 5] = 0.2, 1.0
    turned = replace(run, pose=rolled, twist=yawing)
    np.testing.assert_allclose(turned.felt_rate, [[0.0, np.sin(0.2), np.cos(0.2)]] * len(run.time))


def test_what_a_scenario_foresees_is_what_a_controller_is_shown() -> None:
    """The coming forces themselves, said by the scenario, change nothing; that nothing comes, does."""

    def wanted(t: Vec) -> Mat:
        return np.stack([np.sin(t), 0.0 * t, 0.0 * t], axis=1)

    def known(now: float, dt: float, n: int) -> Mat:
        return wanted(now + 1e-9 + dt * np.arange(1.0, n + 1.0))

    def nothing(now: float, dt: float, n: int) -> Mat:
        return np.zeros((n, 3))

    plain = Scenario(name="sine", duration=0.4, specific_force=wanted)
    runs = []
    for foreseen in (None, known, nothing):
        platform = load("thesis")
        settings = MpcSettings(horizon=20, engine=CondensedEngine, prediction=Oracle())
        mpc = Mpc(platform, (SURGE_PITCH,), settings)
        scenario = replace(plain, foreseen=foreseen)
        runs.append(
            simulate(mpc, Ideal(), scenario, platform=platform, dofs=("surge-pitch",), preview=20).command
        )
    np.testing.assert_allclose(runs[1], runs[0], rtol=0.0, atol=1e-9)
    assert np.abs(runs[2] - runs[0]).max() > 0.01
