"""Tables, figures and studies put together from closed loops that never ran.

The loops' figures are made up from their names, so that what a table says about them is known beforehand.
"""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from otolith.cueing.mpc.washout_weights import PRESETS
from otolith_thesis import ITEMS, Outcome
from otolith_thesis.braking import Attack
from otolith_thesis.emulator_tables import Emulated
from otolith_thesis.explicit import Case
from otolith_thesis.hint_loops import Hinted
from otolith_thesis.laps import Braking, Drive, Driven, HintedLaps, Lap, LapOnLegs, OnLegs
from otolith_thesis.loop import MODELS, Closed, Loop, Motion
from otolith_thesis.outcome import Bearing
from otolith_thesis.published import published
from otolith_thesis.regions import CHOSEN, DEFINITIONS
from otolith_thesis.studies import explicit_signals
from otolith_thesis.studies.redundant import Carried
from otolith_thesis.studies.regions import OPEN_ROWS, Proof, Reach

T = np.linspace(0.0, 10.0, 101)
MOTION = Motion(
    time=T,
    wanted=-np.sin(T),
    felt=np.sin(T),
    translation=np.sin(T),
    tilt_part=0.0 * T,
    tilt_deg=T,
    tilt_rate_deg=0.0 * T,
    position=0.1 * T,
    velocity=0.1 + 0.0 * T,
)
CLOSED = Closed(
    rmse={"surge-pitch": 0.1, "sway-roll": 0.2},
    decided={"surge-pitch": 0.1, "sway-roll": 0.2},
    travel={"surge-pitch": 0.05, "sway-roll": 0.05},
    changes=np.resize([0, 0, 0, 4], len(T)),
    step_us={"mean": 5.0, "median": 4.0, "p99": 9.0, "max": 10.0},
    unsolved=0,
    missed=0,
    cues={"scaled": 2},
    excess={"surge-pitch tilt_rate": 0.01},
    motion={"surge-pitch": MOTION, "sway-roll": MOTION},
)
# The published counts and errors, as if our loops had found exactly them: axes, and whether weights adapt.
COUNTS = {
    "table-5.5": (("surge-pitch",), True),
    "table-5.9": (("surge-pitch", "sway-roll"), True),
    "table-c.4": (("surge-pitch",), False),
}


def _printed(table: str, scenario: str, model: str) -> float:
    return next(float(row[model]) for row in published(table).rows if row["scenario"] == scenario)


class MadeUp(dict[Any, Any]):
    """Answers to any job."""

    def __missing__(self, job: Any) -> Any:
        if isinstance(job, Loop):
            return _loop(job)
        if isinstance(job, Hinted):
            return {scenario: replace(CLOSED, changes=np.array([0, 1])) for scenario in job.scenarios}
        if isinstance(job, Lap):
            size = job.speed / 1000.0
            return replace(CLOSED, rmse={"surge-pitch": size, "sway-roll": size})
        if isinstance(job, LapOnLegs):
            one = self[Lap(job.speed, job.cueing)]
            broken = {"surge-pitch tilt_rate": 7, "circle": 2}
            return OnLegs(closed=one, interventions=3, broken=broken, seconds=1.0)
        if isinstance(job, HintedLaps):
            return {speed: replace(CLOSED, changes=np.array([0, 1])) for speed in job.speeds}
        if isinstance(job, Drive):
            braking = Braking(start=7.0 if job.standing else 80.2, end=9.0, fast=30.0, slow=10.0)
            return Driven(time=T, place=np.column_stack([T, T**2]), braking=braking, harshest=11.0)
        if isinstance(job, Emulated):
            factor = 2.0 if job.case.where == "emulator" else 1.0
            return {"rmse": 0.01 * factor, "changes": {"mean": 0.5}, "unsolved": 0, "motion": MOTION}
        if isinstance(job, Attack):
            return dict.fromkeys(("constant", "reversing", "random"), 0.5 if job.ratio >= 2.0 else 0.6)
        if isinstance(job, Reach):
            printed = {row["constraints"]: row["regions"] for row in published("table-c.1").rows}
            lacking = 3000 if job.reach < 100.0 else 0
            return {"regions": printed[job.constraints] - lacking, "overlapping": 100}
        return _other(job)


def _other(job: Any) -> Any:
    if isinstance(job, Carried):
        return {"rmse": 0.5, "changes": 0.1, "variables": 18, "microseconds": 5.0, "broken": 0}
    if isinstance(job, Proof):
        return _proof()
    assert isinstance(job, Case)
    printed = job.printed
    ours = {key: printed[key] for key in ("regions", "rmse", "rmse_without", "rmse_with") if key in printed}
    return {
        "parts": "1 × 1",
        "seconds": 1.0,
        "rmse": 1.0,
        "regions": 5,
        "travel": 1.0,
        "violations": 0,
        "counts": {one.label: _made_up_count(one, printed) for one in DEFINITIONS},
    } | ours


def _made_up_count(definition: Any, printed: dict[str, Any]) -> int:
    """The published count by the toolbox's rule, and twice as many by any other."""
    return int(printed.get("regions", 1)) * (1 if definition == CHOSEN else 2)


def _proof() -> Any:
    class Verified:
        regions, samples, missing, max_overlap, max_law_error = 7000, 100, 0, 0, 1e-12

    return Verified()


def _loop(job: Loop) -> Closed:
    kind = (job.dofs, job.washout in PRESETS.values())
    for table in (name for name, of_table in COUNTS.items() if of_table == kind):
        if any(row["scenario"] == job.scenario for row in published(table).rows):
            mean = _printed(table, job.scenario, job.cueing) if job.cueing in MODELS else 1.0
            return replace(CLOSED, changes=np.full(len(T), mean))
    return CLOSED


@pytest.fixture(scope="module")
def built() -> dict[str, Outcome]:
    return {name: item.build(MadeUp()) for name, item in ITEMS.items()}


def test_every_item_can_be_put_together_and_says_what_it_is(built: dict[str, Outcome]) -> None:
    for name, outcome in built.items():
        assert outcome.name == name
        assert outcome.title
        assert outcome.section
        assert outcome.numbers or outcome.panels or outcome.grids or outcome.claims
        assert all(reason in ITEMS for reason in outcome.reasons), name
        assert set(outcome.as_json()) >= {"agree", "total", "conclusion_holds"}


@pytest.mark.parametrize("table", ["table-5.5", "table-5.9"])
def test_the_published_counts_agree_with_themselves_and_bear_out_the_thesis(
    built: dict[str, Outcome], table: str
) -> None:
    outcome = built[table]
    assert outcome.counts()["agrees"] == len(outcome.numbers) == 4 * len(published(table).rows)
    fewest = outcome.claims[0]
    assert fewest.holds
    assert f"on {len(published(table).rows)} of" in fewest.figures


def test_percentages_are_signed_where_the_thesis_prints_magnitudes(built: dict[str, Outcome]) -> None:
    outcome = built["table-5.10"]
    worse = next(n for n in outcome.numbers if (n.row, n.column) == ("sine-1", "implicit-trajectory"))
    assert (worse.published, round(worse.ours, 2)) == (4.63, -4.63)
    assert worse.verdict == "differs"
    average = next(n for n in outcome.numbers if (n.row, n.column) == ("average", "implicit-trajectory"))
    assert average.ours == pytest.approx(9.25, abs=0.01)


def test_a_certified_guess_stands_beside_the_four_models(built: dict[str, Outcome]) -> None:
    pooled = built["table-5.5"].grids[1]
    assert [row[0] for row in pooled.rows] == [*MODELS, "certified guess"]
    assert pooled.rows[-1][1] == pytest.approx(0.5)


def test_laps_grow_worse_with_speed_and_save_nothing_when_counts_are_equal(built: dict[str, Outcome]) -> None:
    assert built["table-6.5"].claims[0].holds
    assert not built["table-6.4"].claims[0].holds


def test_a_lap_on_the_hexapod_stands_beside_the_ideal_one(built: dict[str, Outcome]) -> None:
    """Limits that were broken are told apart from the soft one, and only laps that are run are judged."""
    rows = [number.row for number in built["table-6.5"].numbers]
    assert rows.count("120 km/h lateral, hexapod") == len(MODELS)
    assert rows.count("80 km/h lateral, hexapod") == 1
    legs = built["table-6.4"].grids[1]
    assert {row[legs.header.index("nodes beyond another limit")] for row in legs.rows} == {2}
    assert {row[legs.header.index("supervisor acted")] for row in legs.rows} == {3}


def test_a_certified_guess_stands_beside_the_models_of_every_lap(built: dict[str, Outcome]) -> None:
    grid = built["table-6.4"].grids[0]
    assert [row[1] for row in grid.rows] == [*MODELS, "certified guess"] * 3
    assert grid.rows[4][grid.header.index("mean")] == pytest.approx(0.5)


def test_what_is_at_80_s_is_asked_of_either_start(built: dict[str, Outcome]) -> None:
    braked, tilted, travelled, _ = built["figure-6.4"].claims
    assert (braked.holds, tilted.holds, travelled.holds) == (True, False, False)
    assert "7.0 s (standing start), 80.2 s (flying start)" in braked.figures
    assert built["figure-6.3"].panels[0].equal


def test_the_emulator_tracks_worse_than_the_ideal_platform(built: dict[str, Outcome]) -> None:
    assert built["table-6.3"].claims[0].holds


def test_readings_that_give_the_same_loops_fit_alike(built: dict[str, Outcome]) -> None:
    for name in ("study-weights", "study-terminal", "study-step", "study-explicit-signals"):
        fits = [row[1] for row in built[name].grids[0].rows if row[0] != "published"]
        assert len(fits) >= 2
        assert len(set(fits)) == 1


def test_the_definition_that_gives_the_published_counts_is_found(built: dict[str, Outcome]) -> None:
    one_radius, toolbox = built["study-tolerance"].claims
    assert (one_radius.holds, toolbox.holds) == (False, True)
    assert "100.0 %" in one_radius.figures
    assert built["study-tolerance"].grids[0].rows[-1][2:].count("0.0 %") == 1


def test_open_parameters_explain_what_overlaps_do_not(built: dict[str, Outcome]) -> None:
    assert [claim.holds for claim in built["study-open-parameters"].claims] == [False, True]
    assert [claim.holds for claim in built["study-overlaps"].claims] == [False, False, False]


def test_the_toolbox_s_rule_counts_the_blocked_law_of_horizon_five() -> None:
    """Table 5.2 prints 938; far out nothing is added, and a small box lacks what lies beyond it."""
    found = Case("table-5.2", 3).run()
    assert (found["regions"], found["in the unit box"]) == (953, 953)
    near, wide = (Reach(OPEN_ROWS[0], reach).run() for reach in (20.0, 500.0))
    assert near["regions"] == pytest.approx(7049, rel=2e-3)
    assert wide["regions"] == pytest.approx(9363, rel=2e-3)
    assert wide["overlapping"] == pytest.approx(516, abs=10)


def test_a_reading_is_near_where_its_numbers_are_those_of_the_table() -> None:
    """The waves of section 6.1 are made to give the published numbers, all other readings far less."""
    little = {"surge-pitch": 0.01}
    answers = {loop: replace(CLOSED, rmse=little, decided=little) for loop in explicit_signals.jobs()}
    waves = explicit_signals.READINGS[4]
    for signal, column in explicit_signals.CELLS:
        printed = next(row for row in published("table-c.2").rows if row["scenario"] == signal)[column]
        answers[waves.loop(signal, column)] = replace(CLOSED, rmse=little, decided={"surge-pitch": printed})
    decides, alone, all_five = explicit_signals.study(answers).claims
    assert (decides.holds, alone.holds, all_five.holds) == (True, True, True)  # steps are those of waves
    turned = {loop: replace(one, rmse=one.decided, decided=one.rmse) for loop, one in answers.items()}
    assert not explicit_signals.study(turned).claims[0].holds
    assert alone.figures == all_five.figures == waves.name


def test_counts_by_acado_s_start_are_judged_by_the_published_ones(built: dict[str, Outcome]) -> None:
    """All loops are made to have the published means, whatever counts them."""
    study = built["study-acado-start"]
    within, nearer, saves = study.claims
    assert (within.holds, nearer.holds, saves.holds) == (True, False, True)
    assert len(study.grids) == 3
    assert set(study.bears_on) == {
        "table-5.5",
        "table-5.6",
        "table-5.9",
        "table-5.10",
        "table-c.4",
        "table-c.5",
    }
    assert set(study.bears_on.values()) == {Bearing.EXCLUDED}
    active, last_look = built["study-mean"].claims
    assert (active.holds, last_look.holds) == (True, False)
    assert "0.4625" in last_look.figures
