"""The picture of a platform: what is drawn is what the legs do."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from otolith.core.errors import InputError
from otolith.platforms import load
from otolith.platforms.reach import reach
from otolith.report.platform import platform_figure, platform_page, platform_summary, together_sentence, tour
from otolith.simulate import Run

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
    assert together_sentence(platform_summary(load("thesis"))) == ""
    assert len(summary["servo_frequencies_hz"]) == 6


def test_a_platform_without_legs_is_refused() -> None:
    with pytest.raises(InputError, match=r"\[hexapod\] of platform benchmark is missing"):
        platform_summary(load("benchmark"))


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
