from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from otolith.core.arrays import Vec
from otolith.vehicle import Road, road
from otolith.vehicle.profile import SLOWEST, Limits, Plan, plan_speed
from otolith.vehicle.road import from_clothoids

STRONG = {"power": 1e9, "mass": 1000.0}


def plan(path: Road, limits: Limits | None = None, *, standing: bool = False, **car: float) -> Plan:
    return plan_speed(path, limits or Limits(), **{**STRONG, **car}, standing=standing)


def test_a_standing_start_follows_torricelli() -> None:
    """v² = v₀² + 2 a s, exactly."""
    path = road("straight:length=200").limited(30.0)
    speed = plan(path, standing=True).speed
    assert_allclose(speed, np.minimum(np.sqrt(SLOWEST**2 + 6.0 * path.way), 30.0), rtol=1e-12)


def test_braking_to_rest_follows_torricelli() -> None:
    path = road("braking:run=100,stop=300").limited(30.0)
    rest = path.way[path.speed_limit == 0.0][0]
    speed = plan(path).speed
    assert_allclose(speed, np.minimum(np.sqrt(8.0 * np.maximum(rest - path.way, 0.0)), 30.0), atol=1e-6)


def test_power_limits_what_is_gained() -> None:
    """m v dv/dt = P: v³ = v₀³ + 3 P s/m."""
    path = road("straight:length=1000")
    speed = plan(path, Limits(drive=50.0), standing=True, power=50e3).speed
    expected = np.cbrt(20.0**3 + 3.0 * 50.0 * (path.way - np.interp(20.0, speed, path.way)))
    fast = speed > 20.0
    assert_allclose(speed[fast], expected[fast], rtol=2e-3)


def test_a_constant_radius_is_driven_at_the_lateral_limit() -> None:
    path = road("circle:radius=50").limited(99.0)
    settled = path.way > 120.0
    assert_allclose(plan(path).speed[settled], np.sqrt(4.0 * 50.0), rtol=1e-9)


@st.composite
def curvy(draw: st.DrawFn) -> Road:
    ends = [0.0, *draw(st.lists(st.floats(-0.08, 0.08), min_size=2, max_size=6)), 0.0]
    return from_clothoids(np.array([[40.0, a, b] for a, b in pairwise(ends)]), name="r")


def used(path: Road, w: Vec, limits: Limits) -> tuple[Vec, Vec]:
    """Share of the limits used between nodes, driving (at the step's start) and braking (at its end)."""
    a = np.diff(w) / (2.0 * path.step)
    lateral = w * np.abs(path.curvature) / limits.lateral
    p = limits.exponent
    return (
        (np.maximum(a, 0.0) / limits.drive) ** p + lateral[:-1] ** p,
        (np.maximum(-a, 0.0) / limits.brake) ** p + lateral[1:] ** p,
    )


@given(path=curvy(), exponent=st.sampled_from([1.0, 1.5, 2.0, 4.0]))
def test_the_plan_keeps_the_limits_and_none_is_faster(path: Road, exponent: float) -> None:
    """Feasible everywhere; and raised at any node, it would break a limit there or beside it."""
    limits = Limits(exponent=exponent)
    path = path.limited(25.0)
    w = plan(path, limits).speed ** 2
    drive, brake = used(path, w, limits)
    assert max(drive.max(), brake.max()) < 1.0 + 1e-9
    for i in range(5, len(w) - 5, 37):
        if w[i] > 25.0**2 * (1.0 - 1e-3):
            continue
        raised = w.copy()
        raised[i] *= 1.001
        assert max(u.max() for u in used(path, raised, limits)) > 1.0 + 1e-9


def test_a_closed_road_has_no_seam() -> None:
    """Started elsewhere on the ring, the plan is the same."""
    lap = road("hockenheim").limited(120 / 3.6)
    here = plan(lap).speed
    shift = 7000
    turned = replace(lap, curvature=np.r_[lap.curvature[shift:-1], lap.curvature[: shift + 1]])
    there = plan(turned).speed
    assert_allclose(np.r_[there[-shift - 1 : -1], there[: -shift - 1]], here[:-1], rtol=1e-9)
    assert here[0] == here[-1]


def test_planned_accelerations_belong_to_the_planned_speeds() -> None:
    speed, a = plan(road("hockenheim").limited(100 / 3.6))
    assert_allclose(
        np.sum(a[1:-1]) * road("hockenheim").step, 0.5 * (speed[-1] ** 2 - speed[0] ** 2), atol=1.0
    )
    assert a.max() == pytest.approx(3.0, abs=0.01)
    assert a.min() == pytest.approx(-4.0, abs=0.01)
