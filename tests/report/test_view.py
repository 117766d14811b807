"""The moving picture: what is drawn is what the legs do, and a run's report has it where legs moved."""

import json
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from otolith.loop import Run
from otolith.metrics import summarise
from otolith.platforms import load, parse_platform
from otolith.platforms.template import template
from otolith.report import render, view
from otolith.report.view import bases_of, frames_of, platform_view
from tests.report.conftest import MakeRun
from tests.report.test_html import Page

LEGS = load("davsi").six_legs()


def drawn(view: str) -> dict[str, list[list[float]]]:
    found = re.search(r'<script type="application/json">(.*?)</script>', view, re.S)
    assert found is not None
    data: dict[str, list[list[float]]] = json.loads(found.group(1))
    return data


def test_the_picture_shows_the_legs_where_they_are() -> None:
    pose = np.array([0.1, -0.05, 0.1, 0.1, -0.1, 0.2])
    data = drawn(platform_view(LEGS, np.zeros(1), pose[None]))
    (place,) = data["places"]
    R = Rotation.from_quat(place[3:], scalar_first=True).as_matrix()
    ends = np.array(place[:3]) + np.array(data["joints"]) @ R.T
    lengths = np.linalg.norm(ends - np.array(data["anchors"]), axis=1)
    np.testing.assert_allclose(lengths, LEGS.lengths(pose), atol=5e-5)


def test_the_picture_shows_cranks_with_rods_of_their_length() -> None:
    """From what the page is given: each tip, a crank from its shaft, is a rod away from its joint."""
    hexapod = parse_platform(template("cranks"), "cranks.toml").six_legs()
    pose = np.array([0.03, -0.02, 0.03, 0.05, -0.05, 0.04])
    data: Any = drawn(platform_view(hexapod, np.zeros(1), pose[None]))
    (place,), cranks = data["places"], data["cranks"]
    R = Rotation.from_quat(place[3:], scalar_first=True).as_matrix()
    ends = np.array(place[:3]) + np.array(data["joints"]) @ R.T
    angles = hexapod.angles(hexapod.lengths(pose))[:, None]
    along = np.cos(angles) * cranks["zero"] + np.sin(angles) * cranks["quarter"]
    tips = np.array(data["anchors"]) + cranks["radius"] * along
    np.testing.assert_allclose(np.linalg.norm(ends - tips, axis=1), cranks["rod"], atol=5e-5)
    assert data["stroke"] == pytest.approx([-60.0, 60.0])


def test_a_runs_frames_are_its_poses(handmade: Run) -> None:
    time, poses = frames_of(handmade)
    np.testing.assert_allclose(np.diff(time), 0.04)
    np.testing.assert_allclose(poses[:, 0], 0.1 * time)


def test_a_base_is_shown_where_it_is(handmade: Run) -> None:
    """The points of the picture are those of the base's motion, at the times of the poses."""
    base = np.zeros((handmade.samples, 18))
    base[:, 0], base[:, 1], base[:, 5] = 0.5 * handmade.time, -0.2, 0.1
    run = replace(handmade, base=base, base_command=np.zeros((handmade.decisions, 6)))
    time, poses = frames_of(run)
    bases = bases_of(run)
    assert bases is not None
    np.testing.assert_allclose(bases, np.stack([0.5 * time, 0 * time - 0.2, 0 * time + 0.1], axis=1))
    np.testing.assert_allclose(
        drawn(platform_view(LEGS, time, poses, bases=bases))["bases"], bases, atol=1e-5
    )
    assert bases_of(handmade) is None
    assert drawn(platform_view(LEGS, time, poses))["bases"] == []


def test_a_long_run_is_shown_with_fewer_frames(handmade: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = frames_of(handmade)[0]
    monkeypatch.setattr(view, "FRAMES", 10)
    time, poses = frames_of(handmade)
    assert 5 <= len(time) == len(poses) <= 10 < len(whole)
    np.testing.assert_allclose(poses[:, 0], 0.1 * time)


def test_the_report_of_a_run_on_legs_shows_them_move(make_run: MakeRun) -> None:
    run = make_run()
    on_legs = replace(run, plant="hexapod")
    page, plain = (render(one, summarise(one)) for one in (on_legs, run))
    Page(page)  # well-formed
    shown = drawn(page[page.index('class="platform-view"') :])
    poses = np.array(shown["places"])[:, :3]
    np.testing.assert_allclose(poses, frames_of(run)[1][:, :3], atol=1e-6)
    assert ".platform-view" in page
    assert 'class="platform-view"' not in plain
