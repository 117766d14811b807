"""What every cueing algorithm promises: those of the registry, of installed packages, and one's own file."""

import time
from dataclasses import replace
from functools import cache
from importlib.resources import files as package_files

import numpy as np
import pytest

from otolith import metrics, registry
from otolith.compiled import offered
from otolith.core.arrays import Mat, Vec
from otolith.core.frames import SURGE_PITCH
from otolith.cueing.ahead import Ahead
from otolith.cueing.design import Design
from otolith.interfaces import Cueing, PlatformState, Reference, Status
from otolith.loop import Run, simulate
from otolith.plant import Ideal
from otolith.platforms import load
from otolith.scenarios import SCENARIOS, Scenario, scenario
from tests.cueing.hints.training.tiny import tiny_hint

THESIS = load("thesis")
OWN_FILE = f"{package_files('otolith.cli') / 'samples' / 'washout.py'}:HighPass"
# References of the extra `check` need a second for a decision, and have tests of their own
NAMES = [*(name for name, entry in registry.CUEING.items() if entry.extra != "check"), OWN_FILE]
EVERY = pytest.mark.parametrize("name", NAMES, ids=lambda name: name.rpartition(":")[2])
LIMITED = [name for name in NAMES if registry.cueing_named(name).limited]
UNLIMITED = [name for name, entry in registry.CUEING.own.items() if not entry.limited]
PUBLISHED = [name for name, entry in SCENARIOS.items() if entry.source.startswith("thesis")]
OWN = [
    name for name in SCENARIOS if name not in PUBLISHED
]  # long: only the default and the washouts take them


@cache
def design() -> Design:
    """What every algorithm may need; the hint is made on first use."""
    return Design(platform=THESIS, hint=tiny_hint())


@cache
def algorithm(name: str) -> Cueing:
    """Made once; every run resets it, and that this leaves nothing of the past has a test of its own."""
    return registry.make_cueing(name, design())


def close_the_loop(name: str, wanted: Scenario) -> Run:
    """Sampled at 100 Hz: the ideal plants are solved exactly, so that nodes do not depend on it."""
    plant = registry.PLANTS[registry.cueing_named(name).plant].load()(THESIS)
    return simulate(
        algorithm(name),
        plant,
        wanted,
        platform=THESIS,
        dofs=("surge-pitch",),
        plant_period=0.01,
    )


@EVERY
def test_after_reset_the_same_run_comes_out_bit_for_bit(name: str) -> None:
    cueing = algorithm(name)
    runs = [
        simulate(
            cueing,
            Ideal(),
            scenario("sine:frequency=0.5,duration=2"),
            platform=THESIS,
            dofs=("surge-pitch",),
        )
        for _ in range(2)
    ]
    np.testing.assert_array_equal(runs[0].command, runs[1].command)
    np.testing.assert_array_equal(runs[0].changes, runs[1].changes)


def troubled(t: Vec) -> Mat:
    """A jump that no limit allows, then nothing that is a number, then rest."""
    f = np.zeros((len(t), 3))
    f[:, 0] = np.where(t < 0.5, 0.0, 6.0)
    f[(t > 0.8) & (t < 0.9)] = np.nan
    f[t >= 1.2] = 0.0
    return f


@EVERY
@pytest.mark.parametrize("late", [False, True], ids=["as modelled", "late"])
def test_a_loop_that_is_compiled_gives_the_numbers_of_the_one_in_python(name: str, late: bool) -> None:
    """Bit for bit, fallbacks and all; a clock of one's own keeps the loop in Python."""
    plant_name = "actuator" if late else registry.cueing_named(name).plant
    cueing, plant = algorithm(name), registry.make_plant(plant_name, THESIS)
    if late:
        cueing = Ahead(cueing, lag=0.01, dead_time=plant.dead_time or 0.0)
    wanted = Scenario(name="trouble", duration=1.6, specific_force=troubled)
    compiled, plain = (
        simulate(cueing, plant, wanted, platform=THESIS, dofs=("surge-pitch",), clock=clock)
        for clock in (time.thread_time, lambda: 0.0)
    )
    for series in ("pose", "twist", "acceleration", "felt_force", "command", "changes", "residual"):
        np.testing.assert_array_equal(getattr(compiled, series), getattr(plain, series), err_msg=series)
    assert compiled.outcomes == plain.outcomes
    assert {Status.DECIDED, Status.INVALID} <= set(compiled.status)


def test_the_algorithms_that_need_nothing_from_python_offer_a_method() -> None:
    for name in ("implicit", "predictive", "hybrid-all", "linear-mpc"):
        assert offered(algorithm(name)) is not None, name


@EVERY
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e300])
def test_step_never_raises_and_never_commands_what_is_not_finite(name: str, bad: float) -> None:
    cueing = algorithm(name)
    for state in (
        PlatformState(),
        PlatformState(pose=np.full(6, bad)),
        PlatformState(twist=np.full(6, bad)),
        PlatformState(acceleration=np.full(6, bad)),
    ):
        cueing.reset(PlatformState())
        command = cueing.step(state, Reference(specific_force=np.full(3, bad)))
        assert np.isfinite(command.acceleration).all()
        assert np.isfinite(command.plan).all()


@EVERY
def test_untouched_axes_stay_still(name: str) -> None:
    result = close_the_loop(name, scenario("step-0.5"))
    idle = [i for i in range(6) if i not in (SURGE_PITCH.translation, SURGE_PITCH.rotation)]
    assert not result.command[:, idle].any()
    assert not result.pose[:, idle].any()


@pytest.mark.parametrize("name", UNLIMITED)
@pytest.mark.parametrize("scenario_name", SCENARIOS)
def test_a_washout_keeps_the_tilt_threshold_and_comes_home_after_every_scenario(
    name: str, scenario_name: str
) -> None:
    """It knows no other limit; what it leaves of the reach, or takes beyond it, is for metrics to say."""
    drive = scenario(scenario_name)
    then_still = replace(
        drive,
        duration=drive.duration + 40.0,
        specific_force=lambda t: drive.specific_force(t) * (t < drive.duration)[:, None],
    )
    result = close_the_loop(name, then_still)
    assert set(result.status) == {Status.DECIDED}
    for excess in metrics.excesses(result):
        if "tilt" in excess.quantity:
            assert excess.between_nodes < 1e-6, excess
    assert np.abs(result.pose).max() < 1.0
    assert np.abs(result.pose[-1]).max() < 0.05 * max(0.1, np.abs(result.pose).max())


@pytest.mark.parametrize(
    ("name", "scenario_name"),
    [(name, one) for name in LIMITED for one in PUBLISHED] + [("predictive", one) for one in OWN],
)
def test_every_limit_holds_at_every_node_of_every_scenario(name: str, scenario_name: str) -> None:
    result = close_the_loop(name, scenario(scenario_name))
    assert set(result.status) == {Status.DECIDED}
    assert not result.guess_missed.any() or name.startswith("hybrid")
    for excess in metrics.excesses(result):
        assert excess.at_nodes < 1e-6, excess
