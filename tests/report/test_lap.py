"""The map: what is drawn is where the car was."""

import numpy as np
import pytest
from matplotlib.collections import LineCollection
from matplotlib.text import Annotation
from numpy.testing import assert_allclose

from otolith.report.lap import KINDS, Marked, false_cue_map, lap_figure
from otolith.vehicle import Driver, Lap, drive, load_car, road


@pytest.fixture(scope="module")
def lap() -> Lap:
    return drive(road("slalom:cones=3").limited(15.0), load_car(), Driver())


def test_the_map_shows_the_way_and_its_speed(lap: Lap) -> None:
    top, speed, acceleration = lap_figure(lap).axes[:3]
    (colored,) = [c for c in top.collections if isinstance(c, LineCollection)]
    starts = np.array([segment[0] for segment in colored.get_segments()])
    assert_allclose(starts, lap.position[:-1, :2])
    assert_allclose(np.asarray(colored.get_array()), 3.6 * lap.velocity[:-1, 0])
    assert_allclose(np.asarray(speed.lines[0].get_ydata()), 3.6 * lap.velocity[:, 0])
    assert_allclose(np.asarray(acceleration.lines[1].get_ydata()), lap.acceleration[:, 1])
    assert [text.get_text() for text in top.texts] == ["start"]


def test_false_cues_lie_where_the_car_was_then(lap: Lap) -> None:
    cues = [Marked("inverted", 2.0, 2.5), Marked("inverted", 5.0, 5.003), Marked("scaled", 1.0, 3.0)]
    axes = false_cue_map(lap.time, lap.position[:, :2], cues, numbered=2).axes[0]
    by_label = {c.get_label(): c for c in axes.collections if isinstance(c, LineCollection)}
    assert set(by_label) == {"inverted: 2, 0.5 s", "scaled: 1, 2.0 s"}
    long, short = by_label["inverted: 2, 0.5 s"].get_segments()
    at = [np.interp([2.0, 2.5], lap.time, lap.position[:, k]) for k in range(2)]
    assert_allclose(np.array([long[0], long[-1]]).T, at)
    assert len(short) == 2
    numbers = {
        text.get_text(): text.xy
        for text in axes.texts
        if isinstance(text, Annotation) and text.get_text().isdecimal()
    }
    assert set(numbers) == {"1", "2"}
    assert_allclose(numbers["1"], long[0])
    legend = axes.get_legend()
    assert legend is not None
    assert len(legend.get_texts()) == 2


def test_a_run_without_false_cues_is_a_bare_map(lap: Lap) -> None:
    axes = false_cue_map(lap.time, lap.position[:, :2], []).axes[0]
    assert not [c for c in axes.collections if isinstance(c, LineCollection)]
    assert axes.get_legend() is None


def test_every_kind_of_false_cue_has_a_colour_of_its_own() -> None:
    assert len(set(KINDS.values())) == len(KINDS)
