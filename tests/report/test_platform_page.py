"""The picture of a platform: what is drawn is what the legs do."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import qmc

from otolith.loop import Run
from otolith.platforms import load, parse_platform
from otolith.platforms.geometry import JointAngles
from otolith.platforms.reach import reach
from otolith.platforms.template import template
from otolith.report.platform_page import (
    file_share,
    platform_figure,
    platform_page,
    platform_summary,
    range_lines,
    sentences,
    together_sentence,
    tour,
)

DAVSI = load("davsi")
LEGS = DAVSI.six_legs()


def test_the_summary_is_plain_json_in_shown_units() -> None:
    summary = platform_summary(DAVSI)
    assert json.loads(json.dumps(summary)) == summary
    assert summary["ranges"]["surge"]["file_m"] == [-0.51, 0.63]
    assert summary["ranges"]["pitch"]["reach_deg"] == pytest.approx(np.degrees(reach(LEGS)["pitch"]))
    assert 0.01 < summary["reachable_share_of_box"] < 0.03
    assert summary["together"]["circle_m"] == pytest.approx(0.1654, abs=1e-4)
    assert "0.165 m around neutral with ±8.04 deg" in together_sentence(summary)
    assert len(summary["servo_frequencies_hz"]) == 6


def test_cranks_are_described_and_drawn() -> None:
    platform = parse_platform(template("cranks"), "cranks.toml")
    summary = platform_summary(platform)
    assert json.loads(json.dumps(summary)) == summary
    assert summary["crank_range_deg"] == pytest.approx([-60.0, 60.0])
    described = sentences(summary)
    assert described[1].startswith("Cranks of 184.15 mm with rods of 723.9 mm turn from -60 to 60 deg; in")
    assert "they stand at 0 deg" in described[1]
    assert described[2].startswith("Rods lean up to 35 deg out of their cranks' planes")
    figure = platform_figure(platform)
    assert len(figure.axes[0].lines) == 12 + 2  # cranks, rods, and two outlines
    assert '"radius": 0.18415' in platform_page(platform, summary, figure)


def test_without_a_sheet_of_accelerations_the_sentence_says_so() -> None:
    thesis = load("thesis")
    assert thesis.hexapod is not None
    own = thesis.model_copy(update={"hexapod": thesis.hexapod.model_copy(update={"lent": False})})
    sentence = together_sentence(platform_summary(own))
    assert sentence.endswith("accelerations are unknown, for the file gives none of roll or pitch.")
    assert together_sentence({"together": None}) == ""


def test_lent_legs_are_not_shown_as_the_platforms_own() -> None:
    """No machine has the limits of the thesis's simulations; the plants take the legs of `davsi`."""
    platform = load("thesis")
    summary, figure = platform_summary(platform), platform_figure(platform)
    (sentence,) = sentences(summary)
    assert sentence.startswith(
        "No legs of its own are documented, and none are shown: those in the file (lent by davsi"
    )
    assert len(figure.axes) == 1
    assert "<canvas" not in platform_page(platform, summary, figure)


def test_a_platform_without_legs_shows_none() -> None:
    platform = load("benchmark")
    summary, figure = platform_summary(platform), platform_figure(platform)
    assert summary["legs"] is None
    assert summary["ranges"]["surge"] == {"file_m": [-2.6, 2.6]}
    assert summary["ranges"]["pitch"] == {"file_deg": pytest.approx([-10.0, 10.0])}
    assert len(figure.axes) == 1
    page = platform_page(platform, summary, figure)
    assert "The file describes no legs" in page
    assert "<canvas" not in page
    assert range_lines(summary)[1:] == ["pitch: -10.000 to 10.000 deg (the file)"]


def test_a_file_whose_box_leaves_the_reach_is_told_so_axis_by_axis_and_at_once() -> None:
    alone, at_once = sentences(platform_summary(DAVSI))[2:4]
    assert alone.startswith("Alone, the file allows more than the legs reach of surge −0.510 … +0.630 m (")
    assert "pitch" not in alone
    assert at_once.startswith("All at once, the file's limits leave the legs' reach: of the poses that they")
    assert "3.4 %" in at_once
    within = sentences(platform_summary(load("davsi-4dof")))
    assert any("limits stay within the legs' reach, in every pose that was tried" in one for one in within)
    assert not any("Alone" in sentence for sentence in within)


def test_the_share_of_the_file_is_that_of_poses_drawn_otherwise() -> None:
    """A Halton sequence instead of random numbers, the circle by rejection."""
    low = np.array([-0.51, -0.51, -0.42, -24.3, -24.3, -25.0])
    high = np.array([0.63, 0.51, 0.42, 24.3, 24.3, 25.0])
    poses = qmc.scale(qmc.Halton(6, seed=1).random(20_000), low, high)
    poses[:, 3:] = np.radians(poses[:, 3:])
    poses = poses[np.hypot(poses[:, 0], poses[:, 1]) <= 0.5]
    assert file_share(DAVSI) == pytest.approx(LEGS.reaches(poses).mean(), abs=0.004)


def test_joint_angles_are_told_where_they_are_given() -> None:
    legs = DAVSI.hexapod
    assert legs is not None
    leaning = legs.model_copy(update={"joint_angles": JointAngles(base_deg=12.0)})
    bound = DAVSI.model_copy(update={"hexapod": leaning})
    summary = platform_summary(bound)
    assert "Legs lean up to 12 deg at the base's joints, 180 deg at the platform's." in sentences(summary)
    assert "Joint angles are not given: reach ends with" in " ".join(sentences(platform_summary(DAVSI)))
    assert any("leaning as far as its base joint allows" in line for line in range_lines(summary))


def test_the_tour_goes_to_every_end_and_never_beyond() -> None:
    time, poses, captions = tour(LEGS)
    assert len(time) == len(poses) == len(captions)
    assert LEGS.reaches(0.9999 * poses).all()
    for i, ends in enumerate(reach(LEGS).values()):
        np.testing.assert_allclose([poses[:, i].min(), poses[:, i].max()], ends, rtol=1e-9)


def test_the_page_is_complete_in_itself(handmade: Run) -> None:
    summary, figure = platform_summary(DAVSI), platform_figure(DAVSI)
    hostile = DAVSI.model_copy(update={"name": "<b>&"})
    run = replace(handmade, scenario="</script><b>", platform=hostile)
    for page in (platform_page(hostile, summary, figure), platform_page(hostile, summary, figure, run=run)):
        assert not re.findall(r'(?:src|href)="(?!#|data:)', page)
        assert "<b>" not in page
        assert "−0.496 … +0.627 m" in page
        assert "2.1 %" in page
    assert "nobody on" in page


def test_the_figure_shows_ranges_and_cuts() -> None:
    figure = platform_figure(DAVSI)
    labels = {ax.get_xlabel() for ax in figure.axes}
    assert {"surge [m]", "roll [deg]", "heave [m]"} <= labels
    shown = [text.get_text() for ax in figure.axes for text in ax.texts]
    assert any("−0.496 m" in text for text in shown)
