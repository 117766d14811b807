"""Weights that are read off a motion are those that made it."""

from dataclasses import replace

import numpy as np
import pytest

from otolith.core.errors import InputError
from otolith.core.frames import SURGE_PITCH
from otolith.cueing.design import Design
from otolith.cueing.mpc.washout_weights import constant
from otolith.experiment import Experiment, Wanted
from otolith.platforms import load
from otolith.studies.inverse import recover

WANTED = Wanted(scenario="multisine:seed=5,amplitude=1,duration=10")
DESIGN = Design(platform=load("thesis"), dofs=(SURGE_PITCH,))
TRUE = {"velocity": 0.05, "position": 0.2}


@pytest.fixture(scope="module")
def pose() -> np.ndarray:
    design = replace(DESIGN, mpc=replace(DESIGN.mpc, washout=constant(TRUE)))
    return Experiment(wanted=WANTED, cueing="implicit", design=design).run().pose


@pytest.mark.parametrize("start", [{"velocity": 0.3, "position": 0.3}, {"velocity": 1.0, "position": 0.01}])
def test_known_weights_are_recovered(start: dict[str, float], pose: np.ndarray) -> None:
    found = recover(pose, DESIGN, WANTED.along(DESIGN), start)
    assert found.weights == pytest.approx(TRUE, rel=1e-6)
    assert found.difference < 1e-6


def test_with_a_millimetre_of_noise_they_are_within_5_percent_and_the_spread_says_so(
    pose: np.ndarray,
) -> None:
    noise = 1e-3 * np.random.default_rng(2).standard_normal(pose.shape)
    found = recover(pose + noise, DESIGN, WANTED.along(DESIGN), {"velocity": 0.3, "position": 0.3})
    assert found.weights == pytest.approx(TRUE, rel=0.05)
    for state, weight in TRUE.items():
        assert abs(found.weights[state] / weight - 1.0) < 4.0 * found.spread[state]


def test_what_shows_no_weights_is_refused(pose: np.ndarray) -> None:
    scenario = WANTED.along(DESIGN)
    for start in ({}, {"velocity": 0.0}):
        with pytest.raises(InputError, match="must be greater than 0"):
            recover(pose, DESIGN, scenario, start)
    with pytest.raises(InputError, match="must be one that moves a cued axis"):
        recover(0.0 * pose, DESIGN, scenario, TRUE)
    with pytest.raises(InputError, match="9990 samples, must be 10000"):
        recover(pose[:-10], DESIGN, scenario, TRUE)
    with pytest.raises(InputError, match="did you mean velocity"):
        recover(pose, DESIGN, scenario, {"velocit": 1.0})
