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
from otolith.studies.inverse import Recovered, recover, standard_errors

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


def noisy(pose: np.ndarray, seed: int) -> np.ndarray:
    """The motion with a millimetre of noise on every sample."""
    return pose + 1e-3 * np.random.default_rng(seed).standard_normal(pose.shape)


def test_with_a_millimetre_of_noise_errors_are_as_large_as_the_standard_errors_say(pose: np.ndarray) -> None:
    square = []
    for seed in range(5):
        found = recover(noisy(pose, seed), DESIGN, WANTED.along(DESIGN), TRUE)
        assert found.weights == pytest.approx(TRUE, rel=0.05)
        assert not found.untold
        square += [(np.log(found.weights[state] / TRUE[state]) / found.spread[state]) ** 2 for state in TRUE]
        for state, (low, high) in found.intervals.items():
            assert np.log(high / low) == pytest.approx(2.0 * 1.96 * found.spread[state])
            assert low < found.weights[state] < high
    assert 1.5 < sum(square) < 28.0  # of χ² with ten degrees of freedom, 99.9 % is within


def test_a_weight_that_the_motion_does_not_tell_is_named_with_what_would() -> None:
    weak = {"velocity": 0.411, "position": 0.0131}
    design = replace(DESIGN, mpc=replace(DESIGN.mpc, washout=constant(weak)))
    motion = Experiment(wanted=WANTED, cueing="implicit", design=design).run().pose
    found = recover(noisy(motion, 0), DESIGN, WANTED.along(DESIGN), weak)
    assert list(found.untold) == ["position"]
    assert found.untold["position"] == pytest.approx((found.spread["position"] / 0.05) ** 2)
    low, high = found.intervals["position"]
    assert low < 0.0131 < high
    assert high / low > 1.5


def test_a_weight_without_any_effect_is_not_told_at_all() -> None:
    slopes = np.array([[1.0, 0.0, 2.0, 4.0], [0.5, 0.0, 1.0, 2.0], [3.0, 0.0, 5.0, 10.0]])
    errors = standard_errors(slopes[:, :2], 4.0)
    assert errors[0] == pytest.approx(2.0 / np.linalg.norm(slopes[:, 0]))
    assert errors[1] == np.inf
    inverse = np.linalg.inv(slopes[:, [0, 2]].T @ slopes[:, [0, 2]])
    assert standard_errors(slopes[:, [0, 2]], 4.0) == pytest.approx(2.0 * np.sqrt(np.diag(inverse)))
    together = standard_errors(slopes[:, 2:], 4.0)  # of two that act alike only the product is told
    assert together.min() > 1e6
    assert (
        Recovered(weights={"a": 1.0}, spread={"a": np.inf}, difference=0.0, loops=1).intervals["a"][1] > 1e20
    )


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
