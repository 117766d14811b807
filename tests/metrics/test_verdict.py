"""What went wrong, in words: which limit, how often, by how much in its own unit, hard or soft."""

import json
from dataclasses import replace

import numpy as np
import pytest

from otolith import metrics
from otolith.loop import Run
from otolith.platforms import load


def hurt(run: Run, **fields: object) -> Run:
    """The pitch rate by 0.05 deg/s beyond its 3 deg/s at two nodes, surge at 0.68 m of 0.5 m at one."""
    pose, twist = run.pose.copy(), run.twist.copy()
    twist[[39, 49], 4] = np.deg2rad([3.05, -3.01])
    pose[59, 0] = 0.68
    return replace(run, pose=pose, twist=twist, **fields)  # type: ignore[arg-type]


def test_comfort_and_collision_share_no_word(handmade: Run) -> None:
    run = hurt(handmade, soft=("surge-pitch tilt_rate",), platform=load("thesis"))
    collision, comfort = metrics.breaches(metrics.summarise(run))
    assert collision == "hard limit broken: surge position by up to 0.18 m beyond ±0.5 m, at 1 of 10 nodes"
    assert comfort == (
        "soft comfort threshold exceeded: pitch rate by up to 0.05 deg/s beyond ±3 deg/s, at 2 of 10 nodes"
    )
    words = [set(text.partition(":")[0].split()) for text in (collision, comfort)]
    assert not words[0] & words[1]


def test_hard_and_soft_are_counted_apart(handmade: Run) -> None:
    hard = metrics.summarise(hurt(handmade))
    soft = metrics.summarise(hurt(handmade, soft=("surge-pitch tilt_rate",)))
    assert (hard["violations"], hard["soft_exceeded"]) == (3, 0)
    assert (soft["violations"], soft["soft_exceeded"]) == (1, 2)
    assert soft["limits"]["surge-pitch tilt_rate"] == {
        "name": "pitch rate",
        "soft": True,
        "comfort": True,
        "unit": "deg/s",
        "low": pytest.approx(-3.0),
        "high": pytest.approx(3.0),
        "nodes_beyond": 2,
        "excess": pytest.approx(0.05),
        "excess_between_nodes": pytest.approx(0.05),
    }


def test_a_soft_limit_of_a_pair_says_nothing_about_heave(handmade: Run) -> None:
    run = replace(
        handmade, platform=load("davsi"), dofs=("surge-pitch", "heave"), soft=("surge-pitch velocity",)
    )
    soft = {one.quantity for one in metrics.excesses(run) if one.soft}
    assert soft == {"surge-pitch velocity"}


def test_a_rate_that_the_machine_itself_limits_is_no_matter_of_comfort(handmade: Run) -> None:
    machine = load("davsi").model_dump(mode="json")
    machine["pitch"] |= {"rate_degps": 2.0}  # less than the 3 deg/s that are noticed
    run = replace(handmade, platform=load("davsi").model_validate(machine))
    (rate,) = [one for one in metrics.excesses(run) if one.quantity.endswith("tilt_rate")]
    assert not rate.comfort
    assert rate.limit[1] == pytest.approx(np.deg2rad(2.0))


def test_what_stands_between_nodes_is_said_beside(handmade: Run) -> None:
    pose = handmade.pose.copy()
    pose[42, 0] = -0.55
    summary = metrics.summarise(replace(handmade, pose=pose))
    assert metrics.breaches(summary) == []
    assert metrics.between_nodes(summary) == ["between nodes surge position by up to 0.05 m beyond ±0.5 m"]


def test_what_rounding_leaves_is_not_worth_a_word(handmade: Run) -> None:
    pose = handmade.pose.copy()
    pose[[42, 49], 0] = 0.5 + 1e-7
    summary = metrics.summarise(replace(handmade, pose=pose))
    assert metrics.breaches(summary) == metrics.between_nodes(summary) == []
    assert summary["limits"]["surge-pitch position"]["excess_between_nodes"] == 0.0


def test_motion_that_is_no_number_is_a_violation_and_still_json(handmade: Run) -> None:
    pose = handmade.pose.copy()
    pose[59, 0] = np.nan
    summary = metrics.summarise(replace(handmade, pose=pose))
    assert json.dumps(summary["limits"], allow_nan=False)
    assert metrics.breaches(summary) == [
        "hard limit broken: surge position by no number beyond ±0.5 m, at 1 of 10 nodes"
    ]


def test_every_decision_that_failed_is_counted_with_its_kind(handmade: Run) -> None:
    solver = ("optimal",) * 3 + ("infeasible",) * 3 + ("limit", "uncertified", "optimal", "")
    status = ("decided",) * 3 + ("fallback",) * 5 + ("refused", "invalid")
    assert metrics.failures(metrics.summarise(replace(handmade, status=status, solver=solver))) == [
        "3 of 10 decisions fell back to braking: the problem had no solution",
        "1 of 10 decisions fell back to braking: the solver ended without a solution",
        "1 of 10 decisions fell back to braking: the solver's answer did not stand the test",
        "1 of 10 decisions fell back to braking: the answer led to where the platform could not stop",
        "1 of 10 decisions went without their input, which held no number or one beyond all reason",
    ]
    assert metrics.failures({"status": {"decided": 3, "odd": 1}}) == ["1 of 4 decisions ended as odd"]


def test_asymmetric_and_radial_limits_are_written_as_they_are(handmade: Run) -> None:
    pose = handmade.pose.copy()
    pose[59, :2] = -0.6
    run = replace(handmade, pose=pose, platform=load("davsi"), dofs=("surge-pitch", "sway-roll"))
    surge, sway, circle = metrics.breaches(metrics.summarise(run))
    assert "surge position by up to 0.09 m beyond −0.51 … 0.63 m" in surge
    assert "sway position by up to 0.09 m beyond ±0.51 m" in sway
    assert "distance of surge and sway by up to 0.349 m beyond 0.5 m" in circle
