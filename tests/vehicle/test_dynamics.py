"""The car against closed forms: what must come out whatever the details of the tyres."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from otolith.core.arrays import Mat, Vec
from otolith.core.frames import GRAVITY
from otolith.vehicle import Road, load_car, road
from otolith.vehicle.car import CarNumbers
from otolith.vehicle.closed_loop import road_numbers
from otolith.vehicle.dynamics import EXTRAS, STATES, RoadNumbers, advance, rates, tyre
from otolith.vehicle.profile import Plan

CAR = load_car()
P = CAR.numbers()
FLAT = road("straight:length=5000")


def numbers(path: Road = FLAT) -> RoadNumbers:
    zero = np.zeros(len(path.curvature))
    return road_numbers(path, Plan(zero, zero))


def coast(
    x: Vec,
    command: tuple[float, float],
    seconds: float,
    dt: float = 1e-3,
    path: Road = FLAT,
    p: CarNumbers = P,
) -> Mat:
    """States (n + 1, 26) of a car left alone with a held command."""
    states, work, way = [x.copy()], np.zeros((6, STATES)), numbers(path)
    for _ in range(round(seconds / dt)):
        advance(x, np.array(command), way, p, dt, work)
        states.append(x.copy())
    return np.array(states)


def extras(x: Vec, path: Road = FLAT) -> Vec:
    dx, extra = np.zeros(STATES), np.zeros(EXTRAS)
    rates(x, np.zeros(2), numbers(path), P, dx, extra)
    return extra


def rolling(v: float) -> Vec:
    x = np.zeros(STATES)
    x[3] = v
    return x


def holding(v: float) -> float:
    """Acceleration that makes up for drag and rolling."""
    return P.drag * v * v / P.m + P.roll_resistance * GRAVITY


def test_a_car_at_rest_stays_at_rest() -> None:
    dx, extra = np.ones(STATES), np.zeros(EXTRAS)
    rates(np.zeros(STATES), np.zeros(2), numbers(), P, dx, extra)
    assert_allclose(dx, 0.0, atol=1e-12)
    assert_allclose(extra[6:], [P.F_f, P.F_f, P.F_r, P.F_r])


def test_coasting_follows_the_closed_form() -> None:
    """m v̇ = −(A + B v²): v(t) = √(A/B) tan(φ₀ − √(A B) t/m)."""
    A, B = P.roll_resistance * P.m * GRAVITY, P.drag
    seconds, v0 = 10.0, 30.0
    v = coast(rolling(v0), (0.0, 0.0), seconds)[-1, 3]
    expected = math.sqrt(A / B) * math.tan(
        math.atan(v0 * math.sqrt(B / A)) - math.sqrt(A * B) / P.m * seconds
    )
    assert v == pytest.approx(expected, rel=1e-6)


def test_energy_lost_is_the_work_of_the_resistances() -> None:
    states = coast(rolling(30.0), (0.0, 0.0), 5.0)
    way, v = states[:, 0], states[:, 3]
    work = np.trapezoid(P.roll_resistance * P.m * GRAVITY + P.drag * v**2, way)
    assert 0.5 * P.m * (v[0] ** 2 - v[-1] ** 2) == pytest.approx(work, rel=1e-6)


def test_power_bounds_the_force() -> None:
    """m v v̇ ≤ P − (A + B v²) v, reached when more is asked for."""
    x = rolling(60.0)
    x[13] = 5.0
    dx = np.zeros(STATES)
    rates(x, np.array([0.0, 5.0]), numbers(), P, dx, np.zeros(EXTRAS))
    assert P.m * dx[3] == pytest.approx(P.P / 60.0 - P.m * holding(60.0), rel=1e-9)


@pytest.mark.parametrize(("v", "ay"), [(10.0, 0.2), (20.0, 0.3), (30.0, 0.3)])
def test_a_gentle_steady_turn_has_the_closed_forms_understeer(v: float, ay: float) -> None:
    """δ = κ L + K a_y, with what is not linear vanishing as a_y²; turning costs a little speed.

    Without resistances: the force against them would move load from the front axle to the rear.
    """
    kappa = ay / v**2
    delta = kappa * CAR.wheelbase + CAR.understeer_gradient * ay
    free = P._replace(drag=0.0, roll_resistance=0.0)
    x = coast(rolling(v), (delta, 0.0), 8.0, p=free)[-1]
    v = x[3]
    assert x[5] == pytest.approx(v * delta / (CAR.wheelbase + CAR.understeer_gradient * v * v), rel=2e-3)


def test_load_moves_as_statics_demands() -> None:
    """Σ y ΔF_z = −(h F_y + m g (h − h_r) φ) and Σ x ΔF_z = −h F_x of the tyres, in a steady turn."""
    v = 20.0
    x = coast(rolling(v), (0.02, holding(v)), 8.0)[-1]
    extra = extras(x)
    left, right = extra[[6, 8]].sum(), extra[[7, 9]].sum()
    front, rear = extra[[6, 7]].sum(), extra[[8, 9]].sum()
    Fy = P.m * extra[1]
    assert abs(extra[1]) > 2.0
    expected = -(P.h * Fy + P.m * GRAVITY * (P.h - P.h_r) * x[8])
    assert 0.5 * P.B * (left - right) == pytest.approx(expected, rel=1e-3)
    Fx = P.m * (extra[0] + P.drag * v * v / P.m + P.roll_resistance * GRAVITY)
    assert P.l_f * front - P.l_r * rear == pytest.approx(-P.h * Fx, abs=15.0)
    assert extra[6:].sum() == pytest.approx(P.m * GRAVITY, rel=1e-6)
    assert x[8] > 0.0  # it leans outwards


def test_braking_loads_the_front_and_dips_the_nose() -> None:
    x = rolling(40.0)
    x = coast(x, (0.0, -4.0), 3.0)[-1]
    extra = extras(x)
    front, rear = extra[[6, 7]].sum(), extra[[8, 9]].sum()
    Fx = -4.0 * P.m
    assert P.l_f * front - P.l_r * rear == pytest.approx(-P.h * Fx, rel=2e-3)
    assert x[10] > 0.0  # positive pitch is nose-down


def test_left_and_right_are_mirror_images() -> None:
    left = coast(rolling(25.0), (0.03, 0.5), 3.0)[-1]
    right = coast(rolling(25.0), (-0.03, 0.5), 3.0)[-1]
    sides = [0, 3, 6, 7, 10, 11, 13]
    turns = [1, 2, 4, 5, 8, 9, 12]
    assert_allclose(right[sides], left[sides], rtol=1e-10, atol=1e-12)
    assert_allclose(right[turns], -left[turns], rtol=1e-10, atol=1e-12)
    assert_allclose(right[[15, 17, 19, 21]], np.array([-1, -1, 1, 1]) * left[[14, 16, 18, 20]], atol=1e-12)


def test_the_integration_is_of_fourth_order() -> None:
    """Halving the step divides the error by 16, on a smooth command."""
    x0 = coast(rolling(20.0), (0.01, holding(20.0)), 2.0)[-1]

    def end(dt: float) -> Vec:
        return coast(x0.copy(), (0.015, holding(20.0)), 0.64, dt)[-1]

    exact = end(0.25e-3)
    errors = [np.abs(end(dt) - exact).max() for dt in (8e-3, 4e-3, 2e-3)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (orders > 3.7).all()
    assert errors[-1] < 1e-6


def test_on_a_banked_road_gravity_pulls_and_the_sensor_feels_the_tyres() -> None:
    """Left side up by β: a car held straight feels +g sin β, as if it were rolled."""
    beta = math.radians(5.0)
    banked = replace(FLAT, banking=np.full(len(FLAT.curvature), beta))
    x = rolling(20.0)
    v = 20.0
    delta = CAR.understeer_gradient * GRAVITY * math.sin(beta)  # tyres must carry it without turning
    x = coast(x, (delta, holding(v)), 6.0, path=banked)[-1]
    extra = extras(x, banked)
    assert extra[1] - x[3] * x[5] == pytest.approx(GRAVITY * math.sin(beta), rel=1e-2)
    assert extra[6:].sum() == pytest.approx(P.m * GRAVITY * math.cos(beta), rel=2e-3)


def test_a_slope_takes_its_share_of_gravity() -> None:
    alpha = math.radians(4.0)
    hill = replace(FLAT, elevation=FLAT.way * math.tan(alpha))
    states = coast(rolling(20.0), (0.0, 0.0), 0.1, path=hill)
    lost = -(states[-1, 3] - 20.0) / 0.1
    expected = (
        GRAVITY * math.sin(alpha) + P.drag * 400.0 / P.m + P.roll_resistance * GRAVITY * math.cos(alpha)
    )
    assert lost == pytest.approx(expected, rel=2e-3)


def test_a_dip_presses_the_car_into_the_road() -> None:
    """Vertical acceleration v² z″ for z = ½ c s²: load and felt force grow by it."""
    c, v = 1.0 / 800.0, 20.0
    dip = replace(FLAT, elevation=0.5 * c * (FLAT.way - 2500.0) ** 2)
    x = rolling(v)
    x[0] = 2400.0
    x[6] = 0.0
    x = coast(x, (0.0, holding(v)), 5.0, path=dip)[-1]
    extra = extras(x, dip)
    assert abs(x[0] - 2500.0) < 20.0
    assert x[3] > v  # downhill so far
    assert extra[6:].sum() / P.m - GRAVITY == pytest.approx(x[3] ** 2 * c, rel=0.02)
    assert extra[2] == pytest.approx(x[3] ** 2 * c, rel=0.02)


@pytest.mark.parametrize("load", [1000.0, 5170.0, 9000.0])
def test_a_tyres_slope_and_peak_are_those_of_its_formula(load: float) -> None:
    static, K = P.F_f, P.K_f
    small, D = tyre(1e-6, load, static, K, P)
    assert -small / 1e-6 == pytest.approx(K * static * math.sin(2.0 * math.atan(load / (P.z_stiff * static))))
    slips = np.linspace(0.0, 1.0, 4001)
    forces = np.array([-tyre(float(slip), load, static, K, P)[0] for slip in slips])
    assert forces.max() == pytest.approx(D, rel=1e-4)
    assert pytest.approx(P.mu * load * (1.0 - P.mu_z * (load / static - 1.0))) == D


def test_more_load_gives_more_force_but_not_in_proportion() -> None:
    one, two = (tyre(0.1, load, P.F_f, P.K_f, P)[0] for load in (4000.0, 8000.0))
    assert 1.0 < two / one < 2.0


def test_a_wheel_without_load_gives_no_force() -> None:
    assert tyre(0.1, 0.0, P.F_f, P.K_f, P) == (0.0, 0.0)
