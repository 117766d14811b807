"""Constant weights by optimisation."""

import math

import numpy as np
import pytest

from otolith.core.errors import InputError
from otolith.platforms import load
from otolith.scenarios import scenario
from otolith.tuning import BOUNDS, Tuned, tune

SHORT = [scenario("step:amplitude=1,duration=1.5,end=1.3")]


@pytest.fixture(scope="module")
def tuned() -> tuple[Tuned, list[float]]:
    told: list[float] = []
    found = tune(
        load("thesis"), ["velocity", "position"], SHORT, evaluations=12, progress=lambda _, J: told.append(J)
    )
    return found, told


def test_the_best_that_was_met_is_kept(tuned: tuple[Tuned, list[float]]) -> None:
    found, told = tuned
    assert len(told) <= 14  # a simplex may finish its move
    assert found.objective == min(told)
    assert told[found.evaluations - 1] == found.objective
    assert found.objective < told[0]
    assert all(BOUNDS[0] <= weight <= BOUNDS[1] for weight in found.weights.values())


def test_the_objective_is_that_of_its_definition(tuned: tuple[Tuned, list[float]]) -> None:
    found, _ = tuned
    ((name, (rmse, travel)),) = found.by_scenario.items()
    t = np.arange(0.0, 1.5, 0.01)
    size = math.sqrt(np.mean(SHORT[0].specific_force(t)[:, 0] ** 2))
    assert name == SHORT[0].name
    assert found.objective == pytest.approx(math.log(rmse / size) + 0.5 * travel / 0.5)
    assert found.as_json()["scenarios"][name]["rmse"] == rmse


@pytest.mark.parametrize(
    ("states", "evaluations", "sentence"),
    [((), 9, "at least one"), (("speed",), 9, "speed"), (("velocity", "position"), 2, "at least 3")],
)
def test_what_cannot_be_tuned_is_refused(states: tuple[str, ...], evaluations: int, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        tune(load("thesis"), states, SHORT, evaluations=evaluations)


@pytest.mark.parametrize("price", [math.nan, math.inf, -0.1])
def test_a_price_that_is_none_is_refused(price: float) -> None:
    with pytest.raises(InputError, match=r"--price is .*, must be 0 to 1000"):
        tune(load("thesis"), ["position"], SHORT, price=price)


def test_processes_that_share_the_scenarios_find_the_same() -> None:
    scenarios = [*SHORT, scenario("sine:amplitude=0.5,frequency=0.5,duration=2"), scenario("step-1")]
    states = ["velocity", "position"]  # as above: another choice would be another problem to compile
    found = [tune(load("thesis"), states, scenarios, evaluations=3, jobs=jobs) for jobs in (1, 2)]
    assert found[0] == found[1]
    assert list(found[1].by_scenario) == [one.name for one in scenarios]
