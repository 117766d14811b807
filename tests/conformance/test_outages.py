"""What every cueing algorithm does while its reference fails, and after: stop inside, then come back."""

from collections.abc import Iterator
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from otolith import metrics, registry
from otolith.core.arrays import Vec
from otolith.core.frames import DOFS
from otolith.core.frames import SURGE_PITCH as PAIR
from otolith.cueing.design import Design
from otolith.interfaces import Command, Cueing, Plant, PlatformState, Reference
from otolith.loop import Run, simulate
from otolith.loop.interrupted import Interrupted, Outage
from otolith.platforms import Platform, load
from otolith.scenarios import scenario
from tests.cueing.hints.training.tiny import tiny_hint

ALL = {name: entry for name, entry in registry.CUEING.items() if entry.extra != "check"}  # these are slow
# In the other order than `test_cueing`, which runs beside this: else both compile the same at the same time.
EVERY = pytest.mark.parametrize("name", list(reversed(ALL)))
BAD = (np.nan, np.inf, -np.inf, 1e7)
LIMITED = [name for name, entry in ALL.items() if entry.limited]
SOFT_RATE = np.deg2rad(0.2)  # [rad/s] that a real servo may pass the rate that nobody notices


@cache
def moved(name: str, platform: str, plant: str) -> tuple[Cueing, Plant]:
    """An algorithm and what it moves, made once."""
    of, entry = load(platform), registry.CUEING[name]
    plant = entry.plant if entry.plant == "ideal-no-lag" and plant == "ideal" else plant
    made: Plant = registry.PLANTS[plant].load()(of)
    hint = tiny_hint() if platform == "thesis" else None
    return registry.make_cueing(name, Design(platform=of, hint=hint), dead_time=made.dead_time), made


def drive(cueing: Cueing, plant: Plant, duration: float, platform: str, period: float = 0.01) -> Run:
    wanted = scenario(f"sine:amplitude=1,frequency=0.2,duration={duration:g}")
    return simulate(
        cueing, plant, wanted, platform=load(platform), dofs=("surge-pitch",), plant_period=period
    )


def within_limits(run: Run, *, limited: bool, exact: bool = True) -> None:
    """Hard limits at every node; the rate of tilt within what a servo adds. Washouts know the tilt's only."""
    for excess in metrics.excesses(run):
        if "tilt_rate" in excess.quantity:
            assert excess.at_nodes < (1e-6 if exact else SOFT_RATE), excess
        elif limited or excess.quantity.endswith(" tilt"):
            assert excess.at_nodes < 1e-6, excess


@EVERY
def test_it_stops_inside_within_a_second_and_comes_back_as_if_nothing_had_been(name: str) -> None:
    """Outages of one decision to ten seconds, repeated, of every kind; the last 10 s are as undisturbed."""
    limited = registry.CUEING[name].limited
    cueing, plant = moved(name, "thesis", "ideal")
    outages = [
        Outage(start=2.0, end=2.0 + 0.9 * cueing.period, value=np.nan),
        Outage(start=3.0, end=3.5, value=np.inf),
        Outage(start=3.6, end=3.7, value=1e7),
        Outage(start=4.0, end=14.0, value=np.nan),
    ]
    without = drive(cueing, plant, 50.0, "thesis")
    run = drive(Interrupted(cueing, outages), plant, 50.0, "thesis")
    within_limits(run, limited=limited)
    stopped = (run.time > 5.0) & (run.time <= 14.0)
    assert np.abs(run.twist[stopped]).max() < 1e-9
    statuses = np.array(run.status)[(run.command_time >= 4.0) & (run.command_time < 13.99)]
    assert set(statuses) == {"invalid"}  # and never "optimal", which is what is certified
    assert last_error(run) == pytest.approx(last_error(without), rel=0.01)


@pytest.mark.parametrize("plant", ["actuator", "hexapod"])
@pytest.mark.parametrize("platform", ["davsi", "davsi-4dof"])
def test_so_it_does_on_plants_that_are_not_the_model(platform: str, plant: str) -> None:
    cueing, what = moved("implicit", platform, plant)
    outages = [Outage(start=1.0 + k, end=1.0 + k + 0.05 * (k + 1), value=bad) for k, bad in enumerate(BAD)]
    without = drive(cueing, what, 32.0, platform, 1e-3)
    run = drive(Interrupted(cueing, [*outages, Outage(start=6.0, end=9.0)]), what, 32.0, platform, 1e-3)
    within_limits(run, limited=True, exact=False)
    stopped = (run.time > 7.0) & (run.time <= 9.0)
    assert np.abs(run.twist[stopped]).max() < 1e-3  # the observer settles
    assert last_error(run) == pytest.approx(last_error(without), rel=0.01)
    assert "infeasible" not in run.status


def last_error(run: Run) -> float:
    """RMSE of the last 10 s [m/s²]."""
    last = run.time > run.time[-1] - 10.0
    return float(np.sqrt(np.mean((run.felt_force - run.reference_force)[last, 0] ** 2)))


@pytest.mark.parametrize("name", ["implicit", "linear-mpc", "explicit"])
@pytest.mark.parametrize("seed", range(3))
def test_any_order_of_good_and_bad_references_and_measurements_stays_inside(name: str, seed: int) -> None:
    """Jumps up to absurd forces, outages from one decision on, measurements that are no numbers."""
    rng = np.random.default_rng(seed)
    cueing, plant = moved(name, "thesis", "ideal")
    (travel, tilt), state = load("thesis").limits(PAIR), PlatformState()
    cueing.reset(state)
    plant.reset(state)
    force, left = np.zeros(3), 0
    for _ in range(1500):
        if left == 0:
            left = int(rng.integers(1, 60))
            force = np.full(3, rng.choice([0.0, 0.5, -1.0, 3.0, -20.0, 400.0, np.nan, np.inf, 1e7, -1e7]))
        left -= 1
        measured = state if rng.random() > 0.02 else PlatformState(pose=np.full(6, rng.choice(BAD)))
        command = cueing.step(measured, Reference(specific_force=force))
        if measured is not state or not np.abs(force).max() <= 1e6:
            assert command.outcome.status == "invalid"
        state = plant.step(command, cueing.period)
        assert travel.position[0] - 1e-6 <= state.pose[0] <= travel.position[1] + 1e-6
        assert tilt.position[0] - 1e-6 <= -state.pose[4] <= tilt.position[1] + 1e-6
        assert abs(state.twist[0]) <= travel.velocity + 1e-6
        assert abs(state.twist[4]) <= tilt.velocity + 1e-6


@EVERY
@pytest.mark.parametrize("at", [0.5, 1.4])
def test_who_follows_the_last_plan_alone_comes_to_rest_inside(name: str, at: float) -> None:
    """A command is the last one that arrives: its plan is followed to its end, and then nothing."""
    cueing, plant = moved(name, "thesis", "ideal")
    state = PlatformState()
    cueing.reset(state)
    plant.reset(state)
    for _ in range(round(at / cueing.period)):
        command = cueing.step(state, Reference(specific_force=np.array([1.0, 0.0, 0.0])))
        state = plant.step(command, cueing.period)
    reached = [state.pose]
    for acceleration in (*command.plan, *np.zeros((20, 6))):
        state = plant.step(following(command, acceleration), cueing.period)
        reached.append(state.pose)
    assert np.abs(state.twist).max() < 1e-6
    if registry.CUEING[name].limited:
        assert np.abs(np.array(reached)[:, 0]).max() <= 0.5 + (1e-6 if name != "explicit" else 1e-2)


def following(command: Command, acceleration: Vec) -> Command:
    return replace(command, acceleration=acceleration)


STARTS = [
    ("davsi", ("surge-pitch",)),
    ("davsi", ("surge-pitch", "sway-roll", "heave", "yaw")),
    ("thesis", ("surge-pitch", "sway-roll")),
]


@cache
def implicit_on(platform: str, dofs: tuple[str, ...]) -> Cueing:
    cued = tuple(DOFS[name] for name in dofs)
    return registry.make_cueing("implicit", Design(platform=load(platform), dofs=cued))


def limits_of(platform: str, dofs: tuple[str, ...]) -> Iterator[tuple[int, int, float, float, float]]:
    """Axis, derivative (0 place, 1 speed, 2 acceleration), side, bound, and what a share of it is of."""
    of = load(platform)
    for dof in dofs:
        for axis in DOFS[dof].axes:
            low, high, speed, acceleration = bounds(of, dof, axis)
            if axis < 2 and len(dofs) > 1 and of.circle is not None:
                low, high = max(low, -of.circle), min(high, of.circle)
            for side in (-1.0, 1.0):
                yield axis, 0, side, high if side > 0.0 else -low, 0.5 * (high - low)
                yield axis, 1, side, speed, speed
                if np.isfinite(acceleration):
                    yield axis, 2, side, acceleration, acceleration


def bounds(of: Platform, dof: str, axis: int) -> tuple[float, float, float, float]:
    which = DOFS[dof].axes.index(axis)
    limits, sign = of.limits(DOFS[dof])[which], DOFS[dof].signs[which]
    low, high = sorted(sign * bound for bound in limits.position)
    return low, high, limits.velocity, limits.acceleration


@pytest.mark.parametrize("share", [0.001, 0.05])
@pytest.mark.parametrize(("platform", "dofs"), STARTS)
def test_a_start_beyond_any_limit_comes_back_inside_monotonically(
    platform: str, dofs: tuple[str, ...], share: float
) -> None:
    """Before, a start 1 mm beyond its 0.5 m, at rest, left the platform there for ever."""
    cueing, plant = implicit_on(platform, dofs), registry.PLANTS["ideal"].load()(load(platform))
    for axis, derivative, side, bound, whole in limits_of(platform, dofs):
        motion = np.zeros((3, 6))
        motion[derivative, axis] = side * (bound + share * whole)
        state = PlatformState(pose=motion[0], twist=motion[1], acceleration=motion[2])
        cueing.reset(state)
        plant.reset(state)
        seen = [motion]
        while side * seen[-1][derivative, axis] > bound and len(seen) < 300:
            command = cueing.step(state, Reference(specific_force=np.zeros(3)))
            state = plant.step(command, cueing.period)
            seen.append(np.stack([state.pose, state.twist, state.acceleration]))
        values = side * np.array(seen)[:, derivative, axis]
        assert (np.diff(values) <= 1e-12).all(), (axis, derivative, side)
        assert values[-1] <= bound, (axis, derivative, side)
