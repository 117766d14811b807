"""One algorithm tuned to one platform and drive: never worse than before where it is trained."""

import math
from dataclasses import replace

import numpy as np
import pytest

from otolith.core.errors import InputError
from otolith.core.frames import SURGE_PITCH, SWAY_ROLL
from otolith.cueing.design import Design
from otolith.cueing.washout.tuning import Classical
from otolith.platforms import load
from otolith.scenarios import scenario
from otolith.studies.executors import Processes
from otolith.studies.jobs import JUDGING, TRAINING, Job, do
from otolith.studies.problem import problem
from otolith.studies.results import allowed, values
from otolith.studies.tune import TUNED, pieces, started, study_for, tuned

DESIGN = started("classical", Design(platform=load("thesis"), dofs=(SURGE_PITCH,)))
SHORT = [
    scenario("step:amplitude=1,duration=1.5,end=1.3"),
    scenario("sine:amplitude=1,frequency=0.5,duration=2"),
]


def test_what_is_found_is_at_least_as_good_as_before_by_the_stated_rule() -> None:
    study = study_for("classical", DESIGN, 20, SHORT)
    references = {TRAINING: SHORT, JUDGING: SHORT[:1]}
    found = tuned(study, DESIGN, "ideal", references, lambda problems: Processes(1, problems), price=0.5)
    assert len(study.parameters) == 6
    assert dict(found.before.settings) == dict(study.start[0])
    assert len(found.trials) == 20

    def J(trial: object) -> float:
        error, travel = values(study, trial.training)  # type: ignore[attr-defined]
        return math.log(error) + 0.5 * travel

    sound = [one for one in found.trials if allowed(study, one)]
    assert J(found.after) == min(J(one) for one in sound)
    assert J(found.after) < J(found.before)
    judged = found.as_json()
    assert judged["after"]["held_out"]["tracking"] == values(study, found.after.judging)[0]
    assert judged["before"]["held_out"] is not None


def test_pieces_of_a_drive_do_not_overlap_and_the_end_is_held_out() -> None:
    drive = scenario("multisine:seed=4,amplitude=1,duration=1000")
    trained, held_out = pieces(drive)
    assert [one.duration for one in trained] == [60.0] * 5
    assert [one.duration for one in held_out] == pytest.approx([60.0] * 5)
    t = np.linspace(0.0, 59.0, 60)
    assert np.array_equal(trained[0].specific_force(t), drive.specific_force(t))
    assert np.allclose(trained[4].specific_force(t), drive.specific_force(t + 640.0))
    assert np.allclose(held_out[0].specific_force(t), drive.specific_force(t + 700.0))
    assert np.allclose(held_out[4].specific_force(t), drive.specific_force(t + 940.0))
    trained, held_out = pieces(scenario("sine-1"))
    assert [one.duration for one in (*trained, *held_out)] == pytest.approx([7.0, 3.0])


def test_a_small_platform_without_a_tuning_begins_with_faster_filters() -> None:
    thesis = load("thesis")
    assert thesis.surge is not None
    surge = thesis.surge.model_copy(update={"position_m": (-0.125, 0.15)})
    small = thesis.model_copy(update={"name": "small", "surge": surge})
    made = started("classical", Design(platform=small, dofs=(SURGE_PITCH,))).tuning.of(Classical)
    assert made.surge.natural_radps == pytest.approx(2.0 * DESIGN.tuning.of(Classical).surge.natural_radps)
    assert made.sway == DESIGN.tuning.of(Classical).sway


@pytest.mark.parametrize("cueing", TUNED)
def test_every_space_begins_within_its_ranges(cueing: str) -> None:
    design = started(cueing, Design(platform=load("davsi"), dofs=(SURGE_PITCH, SWAY_ROLL)))
    study = study_for(cueing, design, 10, SHORT)
    assert set(study.start[0]) == set(study.parameters)
    for start in study.start:
        assert all(study.parameters[name].holds(value) for name, value in start.items())


def test_on_a_hard_drive_a_small_rig_begins_with_settings_that_keep_its_limits() -> None:
    thesis = load("thesis")
    assert thesis.surge is not None
    surge = thesis.surge.model_copy(update={"position_m": (-0.12, 0.15), "velocity_mps": 0.4})
    rig = thesis.model_copy(update={"name": "small", "surge": surge})
    design = started("classical", Design(platform=rig, dofs=(SURGE_PITCH,)))
    hard = [scenario("step:amplitude=4,duration=6,end=4")]
    study = study_for("classical", design, 10, hard)
    of = problem(study, design, "ideal", hard)
    usual, cautious = (do(of, Job(tuple(start.items()), 0)).measures for start in study.start)
    assert usual["violations"] > 0.0
    assert cautious["violations"] == 0.0


def test_what_cannot_be_tuned_is_refused() -> None:
    with pytest.raises(InputError, match="did you mean classical"):
        study_for("clasical", DESIGN, 20, SHORT)
    with pytest.raises(InputError, match="--evaluations is 5, must be at least 10"):
        study_for("classical", DESIGN, 5, SHORT)
    strong = [scenario("step:amplitude=9,duration=3,end=2.8")]
    surge = load("thesis").surge
    assert surge is not None
    short = surge.model_copy(update={"position_m": (-0.002, 0.002)})
    narrow = replace(DESIGN, platform=load("thesis").model_copy(update={"surge": short}))
    study = study_for("classical", narrow, 10, strong)
    with pytest.raises(InputError, match="settings within all limits is 0 of 10 tried"):
        tuned(study, narrow, "ideal", {TRAINING: strong, JUDGING: []}, lambda of: Processes(1, of))
