import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.special import fresnel

from otolith.core.errors import InputError
from otolith.vehicle import road
from otolith.vehicle.road import from_clothoids


def test_a_clothoid_ends_where_fresnels_integrals_say() -> None:
    """κ = k s: x = √(π/k) C(s √(k/π)), y alike with S."""
    length, sharpness = 60.0, 0.1 / 60.0
    path = from_clothoids(np.array([[length, 0.0, 0.1]]), name="clothoid")
    S, C = fresnel(length * math.sqrt(sharpness / math.pi))
    assert_allclose(path.position[-1], math.sqrt(math.pi / sharpness) * np.array([C, S]), atol=1e-9)
    assert_allclose(path.heading[-1], 0.5 * sharpness * length**2, rtol=1e-12)


def test_the_nodes_lie_on_a_circle_where_the_curvature_is_constant() -> None:
    ring = road("circle:radius=50,turns=1,transition=1")
    on = ring.curvature == 0.02
    centre = ring.position[on] + 50.0 * np.stack(
        [-np.sin(ring.heading[on]), np.cos(ring.heading[on])], axis=1
    )
    assert on.sum() > 1000
    assert_allclose(centre, np.broadcast_to(centre[0], centre.shape), atol=1e-9)


def test_hockenheim_is_as_long_as_its_data_say_and_closes() -> None:
    lap = road("hockenheim")
    assert lap.length == pytest.approx(4565.3, abs=0.1)
    assert np.linalg.norm(lap.position[-1] - lap.position[0]) < 0.04
    assert math.degrees(lap.heading[-1] - lap.heading[0]) == pytest.approx(-360.0, abs=0.01)
    assert lap.closed
    assert "OpenStreetMap" in lap.source


def test_a_point_beside_the_road_is_at_a_right_angle_to_it() -> None:
    ring = road("circle:radius=50,turns=1,transition=1")
    s = np.array([100.0, 200.0])
    for offset in (-3.0, 2.0):
        shift = ring.place(s, np.full(2, offset)) - ring.place(s, np.zeros(2))
        assert_allclose(np.linalg.norm(shift, axis=1), abs(offset), rtol=1e-5)
    radius_inside = np.ptp(ring.place(np.linspace(60, 370, 400), np.full(400, 2.0))[:, 1]) / 2
    assert radius_inside == pytest.approx(48.0, abs=0.01)  # left of a left turn is inside


@pytest.mark.parametrize("closed", [False, True])
def test_grade_and_crest_are_derivatives_of_the_elevation(closed: bool) -> None:
    flat = replace(road("straight:length=500"), closed=closed)
    w = 2.0 * np.pi / 500.0
    hilly = replace(flat, elevation=3.0 * np.sin(w * flat.way))
    inner = slice(2, -2) if not closed else slice(None)
    assert_allclose(np.tan(hilly.grade)[inner], (3.0 * w * np.cos(w * flat.way))[inner], atol=1e-5)
    assert_allclose(hilly.crest[inner], (-3.0 * w**2 * np.sin(w * flat.way))[inner], atol=1e-5)


@pytest.mark.parametrize("name", ["lane-change", "avoidance"])
def test_a_lane_change_goes_through_the_middle_of_its_lanes(name: str) -> None:
    """ISO 3888: lengths of lanes and gaps, and where their middles are for a car 2 m wide."""
    lanes = {
        "lane-change": ((0, 15, 0.0), (45, 70, 3.5 + 0.5 * (2.65 - 2.45)), (95, 125, 0.5 * (2.85 - 2.45))),
        "avoidance": ((0, 12, 0.0), (25.5, 36.5, 0.5 * (2.45 + 3.0) + 1.0), (49, 61, 0.5 * (3.0 - 2.45))),
    }[name]
    x, y = road(f"{name}:width=2").position.T
    for first, last, middle in lanes:
        inside = (x >= first) & (x <= last)
        assert inside.sum() > 30
        assert_allclose(y[inside], middle, atol=0.02)
    assert x[-1] - lanes[-1][1] > 90.0


def test_a_slalom_passes_its_cones_on_alternate_sides() -> None:
    gap, offset = 18.0, 1.2
    x, y = road(f"slalom:gap={gap},offset={offset},cones=5").position.T
    passed = np.interp(gap * np.arange(1, 6), x, y)
    assert_allclose(passed, offset * np.array([1, -1, 1, -1, 1]), atol=0.01)
    path = road(f"slalom:gap={gap},offset={offset},cones=5")
    steepest = offset * (np.pi / gap) ** 2  # curvature of the cosine at a cone
    assert np.abs(path.curvature).max() < 1.01 * steepest  # the onset is no sharper
    assert np.abs(np.diff(path.curvature)).max() / path.step < 6.0 * steepest / gap


def test_the_braking_road_ends_in_rest() -> None:
    way = road("braking:run=100,stop=200")
    assert way.speed_limit[-1] == 0.0
    assert np.isinf(way.speed_limit[way.way < 190.0]).all()


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("hockenhiem", "or a file of points (.csv, .gpx) (did you mean hockenheim?)"),
        ("slalom:gap=-3", "gap is -3.0, must be greater than 0"),
        ("slalom:gap=much", "gap is 'much', must be a number"),
        ("slalom:cone=3", "parameter of slalom is 'cone', must be one of gap, offset, cones"),
        ("hockenheim:laps=3", "parameter of hockenheim is 'laps', must be left out: it has none"),
        ("circle:radius=3", "radius of road circle at 90.2 m is 3 m, must be at least 4 m"),
        ("straight:length=5", "length of road straight is 5 m, must be between 20 and 100000 m"),
        ("braking:run=300,stop=200", "stop is -100.0, must be greater than 0"),
    ],
)
def test_a_road_that_cannot_be_is_refused(text: str, sentence: str) -> None:
    with pytest.raises(InputError) as caught:
        road(text)
    assert sentence in str(caught.value)
