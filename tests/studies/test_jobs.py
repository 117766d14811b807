"""A job is a value: its measures are those that the definitions say, whoever does it."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from otolith.core.frames import SURGE_PITCH
from otolith.cueing.design import Design
from otolith.experiment import Experiment, Wanted
from otolith.loop import Run
from otolith.metrics import perceived_rmse, tracking_rmse
from otolith.perception import otoliths, sense
from otolith.platforms import load
from otolith.scenarios import scenario
from otolith.studies import jobs
from otolith.studies.jobs import Done, Item, Job, Problem, closed, do
from otolith.studies.measures import AVERAGES, MEASURES

SHORT = "step:amplitude=1,duration=1.5,end=1.3"
PROBLEM = Problem(
    cueing="classical",
    design=Design(platform=load("thesis"), dofs=(SURGE_PITCH,)),
    plant="ideal",
    items=(Item(name=SHORT, scenario=scenario(SHORT), best=0.25),),
    measures=("tracking", "tracking-above-optimum", "perceived", "travel", "sickness", "violations"),
)
JOB = Job((("tuning.classical.surge.natural_radps", 2.5),), 0)


@pytest.fixture(scope="module")
def run() -> Run:
    return closed(PROBLEM, JOB)


def test_a_job_is_the_run_that_everybody_else_makes(run: Run) -> None:
    tuning = PROBLEM.design.tuning
    assert tuning.classical is not None
    surge = tuning.classical.surge.model_copy(update={"natural_radps": 2.5})
    own = tuning.model_copy(update={"classical": tuning.classical.model_copy(update={"surge": surge})})
    design = replace(PROBLEM.design, washout=own)
    other = Experiment(wanted=Wanted(scenario=SHORT), design=design, cueing="classical").run()
    assert np.array_equal(other.pose, run.pose)
    assert np.array_equal(other.felt_force, run.felt_force)


def test_measures_are_those_of_their_definitions(run: Run) -> None:
    found = do(PROBLEM, JOB).measures
    assert found == do(PROBLEM, JOB).measures
    wanted = run.reference_force[:, 0]
    rms = math.sqrt(np.mean(wanted**2))
    rmse = float(tracking_rmse(run)[0])
    assert found["tracking"] == pytest.approx(rmse / rms)
    assert found["tracking-above-optimum"] == pytest.approx((rmse - 0.25) / rms)
    sensed = sense(otoliths.telban(), wanted[:, None], run.plant_period, before=np.zeros(1))
    assert found["perceived"] == pytest.approx(float(perceived_rmse(run)[0]) / math.sqrt(np.mean(sensed**2)))
    assert found["travel"] == pytest.approx(np.percentile(np.abs(run.pose[:, 0]) / 0.5, 99.0))
    assert found["violations"] == 0.0


def test_a_passed_limit_is_counted(run: Run) -> None:
    narrow = replace(run, pose=run.pose * 50.0)
    assert MEASURES["violations"].of(narrow, 0.0) > 0.1
    surge = load("thesis").surge
    assert surge is not None
    assert MEASURES["peak"].of(narrow, 0.0) == pytest.approx(
        50.0 * np.abs(run.pose[9::10, 0]).max() / 0.5, rel=0.01
    )
    assert 0.01 < MEASURES["peak"].of(run, 0.0) < 1.0
    assert MEASURES["noticed"].of(run, 0.0) == 0.0
    fast = replace(run, twist=run.twist * 50.0)
    tilting = np.abs(fast.twist[:: round(run.period / run.plant_period), 4]) > np.deg2rad(3.0)
    assert MEASURES["noticed"].of(fast, 0.0) == pytest.approx(tilting.mean(), abs=2.0 / run.decisions)
    assert tilting.mean() > 0.1
    failed = replace(run, status=("fallback",) * 15 + run.status[15:])
    assert MEASURES["violations"].of(failed, 0.0) == pytest.approx(15 / run.decisions)


def test_a_setting_that_is_refused_is_a_result() -> None:
    done = do(PROBLEM, Job((("tuning.classical.surge.damping", 77.0),), 0))
    assert done == Done(refused=done.refused)
    assert "classical.surge.damping in tuning thesis as varied is 77" in done.refused


def test_an_error_is_relative_to_something_wanted() -> None:
    still = scenario("step:amplitude=1,start=1.2,duration=1.5,end=1.3").part(0.0, 1.0)
    done = do(replace(PROBLEM, items=(Item(name="still", scenario=still),)), JOB)
    assert "1 s is 0 m/s² throughout, must be one along a cued axis" in done.refused


def test_settings_that_are_tried_again_make_nothing_anew_and_change_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    made: list[Any] = []
    new = jobs._made

    def noted(problem: Problem, settings: Any) -> Any:
        made.append(settings)
        return new(problem, settings)

    monkeypatch.setattr(jobs, "_made", noted)
    two = replace(
        PROBLEM, items=(*PROBLEM.items, Item(name="sine", scenario=scenario("sine-1").part(0.0, 2.0)))
    )
    other = Job((("tuning.classical.surge.natural_radps", 4.0),), 0)
    asked = [JOB, replace(JOB, item=1), JOB, other, replace(other, item=1), JOB]
    found = [do(two, job) for job in asked]
    assert made == [JOB.settings, other.settings, JOB.settings]
    assert found == [do(replace(two), job) for job in asked]  # another problem each time, so all is made anew
    assert len(made) == 3 + len(asked)


def test_a_job_that_takes_too_long_is_rejected() -> None:
    late = do(replace(PROBLEM, timeout_s=1e-9), JOB)
    assert late.refused == "it took longer than 1e-09 s"


def test_a_part_of_a_scenario_is_what_is_wanted_then() -> None:
    whole = scenario("multisine:seed=4,amplitude=1,duration=20")
    part = whole.part(5.0, 12.5)
    t = np.linspace(0.0, 7.5, 31)
    assert part.duration == 7.5
    assert np.array_equal(part.specific_force(t), whole.specific_force(t + 5.0))
    assert np.array_equal(part.angular_rate(t), whole.angular_rate(t + 5.0))


def test_averages() -> None:
    assert AVERAGES["mean"]([1.0, 3.0]) == 2.0
    assert AVERAGES["worst"]([1.0, 3.0]) == 3.0
    assert AVERAGES["geometric"]([1.0, 4.0]) == pytest.approx(2.0)
