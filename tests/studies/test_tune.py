"""One algorithm tuned to one platform and drive: never worse than before where it is trained."""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from otolith.core.errors import InputError
from otolith.core.frames import SURGE_PITCH, SWAY_ROLL, YAW
from otolith.cueing.design import Design
from otolith.cueing.washout.tuning import Classical
from otolith.platforms import load
from otolith.scenarios import scenario
from otolith.studies.executors import Processes
from otolith.studies.jobs import JUDGING, TRAINING, Done, Job, do
from otolith.studies.problem import problem
from otolith.studies.results import Trial, allowed, values
from otolith.studies.spaces import SPACES, started
from otolith.studies.tune import Tuned, pieces, study_for, tuned

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


SURGE = "tuning.classical.surge.natural_radps"


def decided(
    monkeypatch: pytest.MonkeyPatch, measures: Callable[[str, float], dict[str, float]], price: float = 0.0
) -> Tuned:
    """What is decided where measures are a formula of the set of references and one setting, x."""

    def formula(shared: Any, asked: tuple[str, Job]) -> Done:
        kind, job = asked
        found = measures(kind, float(dict(job.settings)[SURGE]))
        return Done({"travel": 0.5, "violations": 0.0, "noticed": 0.0, "peak": 0.5} | found)

    monkeypatch.setattr("otolith.studies.tune.work", formula)
    monkeypatch.setattr("otolith.studies.tune.do", lambda of, job: formula(None, (TRAINING, job)))
    study = study_for("classical", DESIGN, 40, SHORT)
    references = {TRAINING: SHORT, JUDGING: SHORT[:1]}
    return tuned(study, DESIGN, "ideal", references, lambda problems: Processes(1, problems), price=price)


BEGIN = float(study_for("classical", DESIGN, 10, SHORT).start[0][SURGE])


def varied(trial: Trial) -> float:
    return float(trial.settings[SURGE])


def test_settings_that_are_worse_on_what_was_held_out_are_not_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    found = decided(
        monkeypatch, lambda kind, x: {"tracking": 1.0 / x if kind == TRAINING else 0.3 + abs(x - BEGIN)}
    )
    assert found.kept
    assert found.after.number == found.before.number == 0
    assert varied(found.best) > 5.0 * BEGIN
    assert found.best.judging[0].measures["tracking"] > found.before.judging[0].measures["tracking"]


def test_of_good_settings_the_best_is_taken_that_keeps_the_limits_on_what_was_held_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    most = 4.0 * BEGIN
    found = decided(
        monkeypatch,
        lambda kind, x: {"tracking": 1.0 / x, "violations": float(kind == JUDGING and x > most)},
    )
    tried = [varied(one) for one in found.trials]
    assert not found.kept
    assert varied(found.best) == max(x for x in tried if x <= most) > BEGIN
    assert max(tried) > most


def test_settings_that_pass_limits_give_way_to_any_that_keep_them(monkeypatch: pytest.MonkeyPatch) -> None:
    found = decided(
        monkeypatch,
        lambda kind, x: {"tracking": x, "violations": float(kind == JUDGING and x <= 1.5 * BEGIN)},
    )
    assert found.after.judging[0].measures["tracking"] > found.before.judging[0].measures["tracking"]
    assert varied(found.after) > 1.5 * BEGIN


def test_a_washout_leaves_a_margin_to_limits_that_it_does_not_know(monkeypatch: pytest.MonkeyPatch) -> None:
    found = decided(monkeypatch, lambda kind, x: {"tracking": 1.0 / x, "peak": 0.1 * x})
    peaks = [one.training[0].measures["peak"] for one in found.trials]
    assert found.after.training[0].measures["peak"] == max(one for one in peaks if one <= 0.9)
    assert max(peaks) > 0.9


def test_less_travel_is_no_reason_for_more_error(monkeypatch: pytest.MonkeyPatch) -> None:
    found = decided(monkeypatch, lambda kind, x: {"tracking": 1.0 / x, "travel": x}, price=1.0)
    assert found.kept
    assert min(x - math.log(x) for x in map(varied, found.trials)) < BEGIN - math.log(BEGIN)


def test_pieces_in_which_nothing_is_wanted_are_left_out() -> None:
    drive = scenario("step:amplitude=1,start=1,end=100,duration=400")
    trained, held_out = pieces(drive, DESIGN.dofs)
    assert [one.name.split(", ")[1] for one in trained] == ["0 to 56 s", "56 to 112 s"]
    assert held_out == []
    with pytest.raises(InputError, match=r"specific force of .* is none, must be wanted within the first"):
        pieces(scenario("step:amplitude=1,start=90,end=99,duration=100"), DESIGN.dofs)
    with pytest.raises(InputError, match="--dofs is yaw, must be one with a specific force"):
        pieces(drive, (YAW,))


def test_pieces_of_a_drive_do_not_overlap_and_the_end_is_held_out() -> None:
    drive = scenario("multisine:seed=4,amplitude=1,duration=1000")
    trained, held_out = pieces(drive, DESIGN.dofs)
    assert [one.duration for one in trained] == [60.0] * 5
    assert [one.duration for one in held_out] == pytest.approx([60.0] * 5)
    t = np.linspace(0.0, 59.0, 60)
    assert np.array_equal(trained[0].specific_force(t), drive.specific_force(t))
    assert np.allclose(trained[4].specific_force(t), drive.specific_force(t + 640.0))
    assert np.allclose(held_out[0].specific_force(t), drive.specific_force(t + 700.0))
    assert np.allclose(held_out[4].specific_force(t), drive.specific_force(t + 940.0))
    trained, held_out = pieces(scenario("sine-1"), DESIGN.dofs)
    assert [one.duration for one in (*trained, *held_out)] == pytest.approx([7.0, 3.0])


def test_a_small_platform_without_a_tuning_begins_with_faster_filters() -> None:
    thesis = load("thesis")
    assert thesis.surge is not None
    surge = thesis.surge.model_copy(update={"position_m": (-0.125, 0.15)})
    small = thesis.model_copy(update={"name": "small", "surge": surge})
    made = started("classical", Design(platform=small, dofs=(SURGE_PITCH,))).tuning.of(Classical)
    assert made.surge.natural_radps == pytest.approx(2.0 * DESIGN.tuning.of(Classical).surge.natural_radps)
    assert made.sway == DESIGN.tuning.of(Classical).sway


@pytest.mark.parametrize("cueing", SPACES)
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
