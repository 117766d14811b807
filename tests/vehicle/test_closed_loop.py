"""Whole drives: the thesis's laps, their limits, and what must hold between the signals."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import cumulative_trapezoid

from otolith.core.errors import InputError
from otolith.core.frames import GRAVITY
from otolith.vehicle import Driver, Lap, Road, drive, load_car, road
from otolith.vehicle.centreline import smooth_path
from otolith.vehicle.closed_loop import LeftTheRoad, check_arrival
from otolith.vehicle.profile import Limits
from otolith.vehicle.road import from_clothoids, plain
from otolith.vehicle.roughness import roughened

CAR, DRIVER = load_car(), Driver()
CIRCUIT = road("hockenheim")


@pytest.fixture(scope="module")
def fast() -> Lap:
    return drive(CIRCUIT.limited(120 / 3.6), CAR, DRIVER)


@pytest.mark.parametrize(("speed", "seconds"), [(80, 240.0), (100, 218.0)])
def test_lap_times_and_limits_at_lower_speeds(speed: int, seconds: float) -> None:
    summary = drive(CIRCUIT.limited(speed / 3.6), CAR, DRIVER).summary(DRIVER.limits)
    assert summary["time_s"] == pytest.approx(seconds, rel=0.03)
    assert max(summary["limit_excess_percent"].values()) < 8.0


def test_the_lap_at_120_kmh_keeps_time_limits_and_path(fast: Lap) -> None:
    """206 s; the limits of eq. 6.3 within 8 %; never half a metre off the path."""
    summary = fast.summary(DRIVER.limits)
    assert summary["time_s"] == pytest.approx(206.0, rel=0.03)
    assert max(summary["limit_excess_percent"].values()) < 8.0
    assert summary["ax_mps2"]["max"] > 2.9
    assert summary["ay_mps2"]["max"] > 3.9
    assert np.abs(fast.offset).max() < 0.5
    assert_allclose(fast.velocity[:, 0], fast.planned_speed, atol=1.0)
    assert summary["estimated"]


def test_from_standstill_the_hairpin_after_the_parabolika_is_braked_for_at_80_s() -> None:
    """The thesis's section 6.3 sees its hardest braking 'at around 80 s'."""
    lap = drive(CIRCUIT.limited(120 / 3.6), CAR, DRIVER, standing=True)
    assert lap.velocity[0, 0] == 0.0
    hard = lap.time[lap.acceleration[:, 0] < -3.5]
    assert ((hard > 80.0) & (hard < 86.0)).sum() > 400
    assert max(lap.summary(DRIVER.limits)["limit_excess_percent"].values()) < 8.0


def bend(a: float, b: float, start: float) -> Road:
    """A closed road along an ellipse, from `start` [rad] of its parameter."""
    angle = start + np.linspace(0.0, 2.0 * np.pi, 401)
    points = np.stack([a * np.cos(angle), b * np.sin(angle)], axis=1)
    path, _ = smooth_path(points, closed=True, smoothing=0.0)
    return plain(path, name="ellipse", closed=True, source="")


@pytest.mark.parametrize("start", [0.0, 0.8, np.pi / 2])
@pytest.mark.parametrize(("a", "b"), [(150.0, 60.0), (100.0, 25.0)])
def test_a_lap_of_an_ellipse_keeps_the_limits_wherever_it_starts(a: float, b: float, start: float) -> None:
    """A flying start in a bend is in the bend already: put there straight, the car overshot by 22 %."""
    lap = drive(bend(a, b, start).limited(60 / 3.6), CAR, DRIVER)
    assert max(lap.summary(DRIVER.limits)["limit_excess_percent"].values()) < 1.0
    assert_allclose(lap.acceleration[0], lap.acceleration[-1], atol=0.05)  # the lap closes in what is felt
    assert_allclose(lap.rate[0], lap.rate[-1], atol=0.01)


def test_an_open_road_that_begins_in_a_bend_begins_in_a_steady_turn() -> None:
    """v²κ from the first sample on, as on a skid pad."""
    arc = from_clothoids(np.array([[200.0, 1 / 40.0, 1 / 40.0]]), name="arc").limited(10.0)
    lap = drive(arc, CAR, DRIVER)
    assert_allclose(lap.acceleration[:100, 1], 10.0**2 / 40.0, rtol=0.02)
    assert lap.way[0] == 0.0


def test_a_start_that_the_car_cannot_come_to_is_refused() -> None:
    arc = from_clothoids(np.array([[200.0, 1 / 20.0, 1 / 20.0]]), name="arc").limited(20.0)
    with pytest.raises(
        LeftTheRoad, match="did not arrive at the start: the road begins too steep or too tight"
    ):
        drive(arc, CAR, Driver(limits=Limits(lateral=18.0)))


def test_dead_reckoning_arrives_where_the_path_says(fast: Lap) -> None:
    """Positions come from the path; velocities and yaw, integrated on their own, lead to the same place."""
    yaw, (forward, left) = fast.attitude[:, 2], fast.velocity.T
    east = forward * np.cos(yaw) - left * np.sin(yaw)
    north = forward * np.sin(yaw) + left * np.cos(yaw)
    walked = cumulative_trapezoid(np.stack([east, north], axis=1), fast.time, axis=0, initial=0)
    assert_allclose(walked, fast.position[:, :2] - fast.position[0, :2], atol=0.05)
    turned = cumulative_trapezoid(fast.rate[:, 2], fast.time, initial=0)
    assert_allclose(turned, yaw - yaw[0], atol=2e-4)


def test_accelerations_belong_to_velocities_and_to_what_is_felt(fast: Lap) -> None:
    """a_x = v̇_x − r v_y, a_y = v̇_y + r v_x; the body's roll adds g sin φ to what is felt sideways."""
    rates, dt = fast.rate[:, 2], fast.time[1]
    ax = np.gradient(fast.velocity[:, 0], dt) - rates * fast.velocity[:, 1]
    ay = np.gradient(fast.velocity[:, 1], dt) + rates * fast.velocity[:, 0]
    assert np.sqrt(np.mean((ax - fast.acceleration[:, 0]) ** 2)) < 0.02
    assert np.sqrt(np.mean((ay - fast.acceleration[:, 1]) ** 2)) < 0.02
    leaning = fast.acceleration[:, 1] + GRAVITY * np.sin(fast.attitude[:, 0])
    assert np.sqrt(np.mean((fast.force[:, 1] - leaning) ** 2)) < 0.15
    assert np.corrcoef(fast.attitude[:, 0], fast.acceleration[:, 1])[0, 1] > 0.98
    assert np.corrcoef(fast.attitude[:, 1], fast.acceleration[:, 0])[0, 1] < -0.95
    assert np.abs(fast.load.sum(axis=1) / (CAR.body.mass_kg * GRAVITY) - 1.0).max() < 0.1


def test_results_converge_with_the_step() -> None:
    """Against 0.125 ms, every signal of a lane change; the default step is good to 1e-4 of its unit."""
    path = road("lane-change").limited(60 / 3.6)
    brisk = Driver(limits=Limits(lateral=8.0))
    exact = drive(path, CAR, brisk, step=0.125e-3)
    errors = []
    for step in (2e-3, 1e-3, 0.5e-3):
        lap = drive(path, CAR, brisk, step=step)
        n = min(len(lap.time), len(exact.time))
        errors.append(np.abs(lap.columns()[:n] - exact.columns()[:n]).max())
    assert errors[1] < 1e-4
    assert errors[2] < errors[0] / 4.0


def test_the_record_does_not_depend_on_its_rate() -> None:
    path = road("slalom").limited(50 / 3.6)
    slow, quick = (drive(path, CAR, DRIVER, rate_hz=rate) for rate in (100.0, 1000.0))
    assert_allclose(quick.columns()[::10][: len(slow.time)], slow.columns(), atol=1e-9)


def test_the_driver_keeps_his_bound_on_jerk(fast: Lap) -> None:
    slow = fast.acceleration[::5, 0]
    assert np.abs(np.diff(slow) / 0.05).max() < 1.3 * DRIVER.jerk


def test_the_car_stops_where_it_must() -> None:
    lap = drive(road("braking:run=100,stop=250").limited(100 / 3.6), CAR, DRIVER)
    assert lap.velocity[-1, 0] < 0.05
    assert 247.0 < lap.way[-1] < 250.0
    assert lap.acceleration[:, 0].min() > -4.3
    assert_allclose(lap.force[-1], 0.0, atol=0.2)


def test_roughness_is_felt_as_heave_and_grows_with_its_class() -> None:
    path = road("straight:length=1500").limited(25.0)
    shaken = []
    for grade in "ABC":
        lap = drive(roughened(path, grade, np.random.default_rng(4)), CAR, DRIVER)
        shaken.append(float(np.std(lap.force[500:, 2])))
    assert_allclose(np.array(shaken[1:]) / shaken[:-1], 2.0, rtol=0.1)  # a class is twice the amplitude
    assert 0.1 < shaken[0] < 1.0


def test_climbing_is_felt_as_leaning_back() -> None:
    path = road("straight:length=1500").limited(20.0)
    hill = replace(path, elevation=0.05 * path.way)
    lap = drive(hill, CAR, DRIVER)
    nose_up = -np.mean(lap.attitude[-500:, 1])  # the slope, and a little squat under the driving force
    assert np.mean(lap.force[-500:, 0]) == pytest.approx(GRAVITY * np.sin(nose_up), abs=2e-3)
    assert np.mean(lap.acceleration[-500:, 0]) == pytest.approx(0.0, abs=0.02)
    assert lap.attitude[-1, 1] == pytest.approx(-np.arctan(0.05), abs=5e-3)  # nose-up is negative


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"step": 3e-3}, "step is 0.003 s for 0.01 s, must be a whole number of steps"),
        ({"step": -1.0}, "step is -1 s for 0.01 s, must be a whole number of steps"),
        (
            {"rate_hz": 300.0},
            "rate is 300 Hz, must be 1000 Hz or a whole fraction of it, "
            "such as 1000, 500, 200, 100, 50, 20 Hz",
        ),
    ],
)
def test_a_step_that_does_not_divide_is_refused(options: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InputError) as caught:
        drive(road("slalom"), CAR, DRIVER, **options)
    assert str(caught.value) == sentence


def test_who_wants_more_than_the_tyres_give_leaves_the_road() -> None:
    wild = Driver(limits=Limits(lateral=15.0, brake=15.0))
    with pytest.raises(LeftTheRoad, match="off the path at"):
        drive(road("circle:radius=40").limited(40.0), CAR, wild)


def test_nothing_that_is_no_number_becomes_a_lap() -> None:
    with pytest.raises(LeftTheRoad, match="the car lost all grip"):
        check_arrival(np.full((5, 36), np.nan), CIRCUIT, 10)


def test_a_hill_too_steep_is_not_climbed() -> None:
    path = road("straight:length=1500").limited(20.0)
    with pytest.raises(LeftTheRoad, match="did not arrive"):
        drive(replace(path, elevation=1.2 * path.way), CAR, DRIVER)


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"limits": Limits(drive=0.1)}, "driver's drive limit is 0.1, must be between 0.5 and 20"),
        ({"jerk": 0.0}, "driver's jerk is 0, must be between 0.5 and 100"),
        ({"speed_preview": -1.0}, "driver's speed_preview is -1, must be between 0 and 2"),
        ({"correction": float("nan")}, "driver's correction is nan, must be between 0.05 and 50"),
    ],
)
def test_a_driver_beyond_all_bounds_is_refused(options: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InputError) as caught:
        Driver(**options)
    assert str(caught.value) == sentence
