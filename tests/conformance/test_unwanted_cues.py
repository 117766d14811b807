"""What drivers complain of most: the default's unwanted cues beside those of the washouts."""

from functools import cache
from typing import Any

import pytest

from otolith import metrics, registry
from otolith.core.frames import DOFS
from otolith.cueing.design import Design
from otolith.loop import simulate
from otolith.platforms import load
from otolith.scenarios import scenario

PLATFORM = load("thesis")
AXES = {"bend": ("sway-roll", "lateral"), "stop": ("surge-pitch", "longitudinal")}


@cache
def cued(name: str, wanted: str) -> dict[str, Any]:
    """The summary of one algorithm, sampled at 100 Hz, which is exact for the ideal plant."""
    dof, axis = AXES[wanted]
    cueing = registry.make_cueing(name, Design(platform=PLATFORM, dofs=(DOFS[dof],)))
    plant = registry.make_plant("ideal", PLATFORM)
    run = simulate(
        cueing, plant, scenario(wanted, axis=axis), platform=PLATFORM, dofs=(dof,), plant_period=0.01
    )
    return metrics.summarise(run)


def unwanted(name: str, wanted: str) -> dict[str, float]:
    """Duration [s], peak [m/s²] and integral over time [m/s] of lag and rebound together."""
    (kinds,) = cued(name, wanted)["unwanted_cues"].values()
    return {
        "duration": sum(kind["duration_s"] for kind in kinds.values()),
        "peak": max(kind["peak"] for kind in kinds.values()),
        "integral": sum(kind["duration_s"] * kind["mean"] for kind in kinds.values()),
    }


@pytest.mark.parametrize("washout", ["classical", "adaptive", "optimal"])
def test_in_a_long_bend_the_default_has_shorter_and_smaller_unwanted_cues(washout: str) -> None:
    ours, theirs = unwanted("predictive", "bend"), unwanted(washout, "bend")
    assert all(ours[figure] < 0.85 * theirs[figure] for figure in ours)


@pytest.mark.parametrize("washout", ["classical", "adaptive", "optimal", "optimal-nonlinear"])
def test_braking_to_a_stop_its_unwanted_cues_are_smaller_and_never_rebound(washout: str) -> None:
    ours, theirs = unwanted("predictive", "stop"), unwanted(washout, "stop")
    assert ours["peak"] < theirs["peak"]
    assert ours["integral"] < 0.8 * theirs["integral"]
    (kinds,) = cued("predictive", "stop")["unwanted_cues"].values()
    assert kinds["rebound"]["duration_s"] == 0.0
    (others,) = cued(washout, "stop")["unwanted_cues"].values()
    assert others["rebound"]["duration_s"] > 0.1
