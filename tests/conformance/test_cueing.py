"""What every cueing algorithm of the registry promises, whatever it is."""

import numpy as np
import pytest

from otolith import metrics, registry
from otolith.core.frames import SURGE_PITCH
from otolith.interfaces import PlatformState, Reference
from otolith.mpc.design import Design
from otolith.plant import Ideal
from otolith.platforms import load
from otolith.scenarios import SCENARIOS, scenario
from otolith.simulate import Run, simulate

THESIS = load("thesis")
DESIGN = Design(platform=THESIS)
EVERY = pytest.mark.parametrize("name", registry.CUEING)


def close_the_loop(name: str, scenario_name: str) -> Run:
    plant = registry.PLANTS[registry.CUEING[name].plant].load()()
    cueing = registry.CUEING[name].load()(DESIGN)
    return simulate(cueing, plant, scenario(scenario_name), platform=THESIS, pairs=("surge-pitch",))


@EVERY
def test_after_reset_the_same_run_comes_out_bit_for_bit(name: str) -> None:
    cueing = registry.CUEING[name].load()(DESIGN)
    runs = [
        simulate(
            cueing,
            Ideal(),
            scenario("sine:frequency=0.5,duration=2"),
            platform=THESIS,
            pairs=("surge-pitch",),
        )
        for _ in range(2)
    ]
    np.testing.assert_array_equal(runs[0].command, runs[1].command)
    np.testing.assert_array_equal(runs[0].changes, runs[1].changes)


@EVERY
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e300])
def test_step_never_raises_and_never_commands_what_is_not_finite(name: str, bad: float) -> None:
    cueing = registry.CUEING[name].load()(DESIGN)
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
    result = close_the_loop(name, "step-0.5")
    idle = [i for i in range(6) if i not in (SURGE_PITCH.translation, SURGE_PITCH.rotation)]
    assert not result.command[:, idle].any()
    assert not result.pose[:, idle].any()


@EVERY
@pytest.mark.parametrize("scenario_name", SCENARIOS)
def test_every_limit_holds_at_every_node_of_every_scenario(name: str, scenario_name: str) -> None:
    result = close_the_loop(name, scenario_name)
    assert set(result.status) == {"optimal"}
    assert not result.guess_missed.any() or name.startswith("hybrid")
    for excess in metrics.excesses(result):
        assert excess.at_nodes < 1e-6, excess
