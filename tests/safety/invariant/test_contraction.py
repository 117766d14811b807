"""Sets of axes, judged by linear programs, brute force and closed forms."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from otolith.core.arrays import Vec
from otolith.platforms import AxisLimits
from otolith.safety.invariant.axis import Axis, AxisRow, AxisSet
from otolith.safety.invariant.contraction import CONTRACTION, _judged, cells, certified_ahead, cut, shrink
from otolith.safety.invariant.polytope import halfspaces
from otolith.safety.law import move

SURGE = Axis(
    limits=AxisLimits(position=(-0.51, 0.63), velocity=0.81, acceleration=7.1, command=7.1),
    lag=0.01,
    period=0.01,
    slowing=(AxisRow("braking", 1.0, 2.5, 1.40625, -0.51, 0.63),),
)
SHARED = replace(SURGE, shares_circle=True)
HEAVE = Axis(
    limits=AxisLimits(position=(-0.42, 0.42), velocity=0.61, acceleration=10.0, command=10.0),
    lag=0.01,
    period=0.01,
)
FAST = replace(HEAVE, limits=replace(HEAVE.limits, velocity=7.2, command=5.0))


def proved(axis: Axis, least: float = 0.01) -> AxisSet:
    ahead = certified_ahead((axis,), least)
    assert ahead is not None
    return AxisSet(axis, ahead)


def moved(axis: Axis, x: Vec, u: float) -> Vec:
    motion, commands = np.zeros((3, 6)), np.zeros(6)
    motion[:, 0], commands[0] = x, u
    move(motion, commands, axis.lag, axis.period)
    return motion[:, 0]


@pytest.mark.parametrize("axis", [SURGE, SHARED, HEAVE, FAST, replace(FAST, shares_circle=True)])
@pytest.mark.parametrize("share", [1.0, 0.5])
def test_the_best_command_of_a_vertex_is_that_of_a_linear_program(axis: Axis, share: float) -> None:
    """Also in sets that are not proved; HiGHS minimises λ over (u, λ) at every vertex."""
    of = AxisSet(axis, share * proved(axis).ahead)
    C, b = halfspaces(of.rows)
    A, B = axis.dynamics()
    z = C[len(of.rows) - 1]
    for cell, shrinks in _judged(of):
        for x, found in zip(cell.vertices, shrinks, strict=True):
            rows, bounds = [np.column_stack([C @ B / b, -np.ones(len(b))])], [-(C @ A @ x) / b]
            if cell.side:  # |z⁺| ≤ (1 − μ) |z|
                side = cell.side * np.array([[z @ B, 0.0], [-z @ B, 0.0]])
                near = (1.0 - axis.towards_centre) * cell.side * z @ x
                then = cell.side * z @ A @ x
                rows, bounds = [*rows, side], [*bounds, np.array([near - then, near + then])]
            lp = linprog(
                [0.0, 1.0],
                A_ub=np.vstack(rows),
                b_ub=np.concatenate(bounds),
                bounds=[(-axis.command, axis.command), (None, None)],
            )
            assert (lp.status == 0) == math.isfinite(found)
            assert lp.status != 0 or lp.fun == pytest.approx(found, abs=1e-6)


@pytest.mark.parametrize("axis", [SURGE, HEAVE, FAST])
def test_states_of_a_proved_set_have_a_command_and_some_of_a_shorter_wedge_have_none(axis: Axis) -> None:
    """Brute force: vertices and random states of the boundary, all commands of a fine grid, and the stopping
    law's own model of a period, which is affine in the command.
    """
    rng = np.random.default_rng(3)
    grid = np.linspace(-axis.command, axis.command, 4001)
    by_u = moved(axis, np.zeros(3), 1.0)

    def stuck(of: AxisSet) -> int:
        C, b = halfspaces(of.rows)
        corners = np.vstack([cell.vertices for cell in cells(of)])
        X = np.vstack([corners, rng.dirichlet(np.full(len(corners), 0.15), 100) @ corners])
        X /= (X @ C.T / b).max(axis=1)[:, None]
        missed = np.abs(C @ by_u / b).max() * (grid[1] - grid[0]) / 2.0  # between two commands of the grid
        after = [moved(axis, x, 0.0)[:, None] + by_u[:, None] * grid for x in X]
        return sum((C @ one / b[:, None]).max(axis=0).min() > 1.0 + missed for one in after)

    of = proved(axis)
    assert stuck(of) == 0
    assert stuck(of._replace(ahead=0.4 * of.ahead)) > 0


def test_the_wedge_of_an_axis_alone_is_as_long_as_its_commands_can_follow() -> None:
    """On z = q + τ w at its end, z⁺ = z + Δ w + (Δ²/2 + τ Δ) u, so U (τ + Δ/2) must not be less than w."""
    of = proved(HEAVE)
    needed = HEAVE.limits.velocity / HEAVE.command - HEAVE.period / 2
    assert needed <= of.ahead <= 1.1 * needed
    assert shrink(of._replace(ahead=0.98 * needed)) > 1.0
    assert shrink(of._replace(ahead=1.02 * needed)) < 1.0


def test_the_counter_example_lies_outside() -> None:
    """It keeps eq. C.2 and all limits, and is beyond the reach one period later whatever is commanded."""
    x = np.array([-0.5, -0.81, 1.44])
    kept = {row.name: row.lower <= x @ row[1:4] <= row.upper for row in proved(SURGE).rows}
    assert [name for name, keeps in kept.items() if not keeps] == ["wedge"]


def test_next_to_eq_c_2_the_set_needs_a_longer_wedge_than_without() -> None:
    """That row limits how soon the acceleration may turn against the speed."""
    alone = replace(SURGE, slowing=())
    assert proved(alone, 0.25).ahead == 0.25
    assert shrink(AxisSet(alone, 0.25)) < 1.0 < shrink(AxisSet(SURGE, 0.25))
    assert proved(SURGE, 0.25).ahead < proved(SHARED, 0.25).ahead


@given(
    reach=st.floats(0.01, 10.0),
    other=st.floats(0.2, 1.0),
    velocity=st.floats(0.05, 8.0),
    command=st.floats(0.3, 15.0),
    lag=st.floats(1e-3, 0.1),
    law=st.none() | st.tuples(st.floats(0.5, 4.0), st.floats(2.0, 4.0)),
    shared=st.booleans(),
)
@settings(max_examples=20, deadline=None)
def test_every_sensible_axis_has_a_set(
    reach: float,
    other: float,
    velocity: float,
    command: float,
    lag: float,
    law: tuple[float, float] | None,
    shared: bool,
) -> None:
    """With any braking law that is slower than the axis."""
    low, high = -reach, other * reach
    slowing: tuple[AxisRow, ...] = ()
    if law is not None:
        T, ratio = law
        slowing = (AxisRow("braking", 1.0, T, 0.5 * T * T / ratio, low, high),)
    limits = AxisLimits(position=(low, high), velocity=velocity, acceleration=command, command=command)
    axis = Axis(limits=limits, lag=lag, period=0.01, slowing=slowing, shares_circle=shared)
    of = proved(axis)
    assert shrink(of) <= 1.0 - CONTRACTION
    for cell in cells(of):
        C, b = cut(of, cell.side)
        assert (cell.vertices @ C.T <= b + 1e-7 * np.abs(C * axis.scale).max(axis=1)).all()
        assert np.isfinite(cell.commands).all()


def test_a_law_that_asks_for_more_than_the_axis_can_do_has_none() -> None:
    """Braking within 26 ms by an axis that lags by 220 ms and is weak: no wedge is long enough."""
    hasty = AxisRow("braking", 1.0, 0.026, 1e-4, -0.0118, 0.00085)
    weak = AxisLimits(position=(-0.012, 0.00095), velocity=4.9, acceleration=0.108, command=0.108)
    axis = Axis(limits=weak, lag=0.22, period=0.01, slowing=(hasty,))
    assert certified_ahead((axis,), 0.01) is None
    assert certified_ahead((replace(axis, slowing=()),), 0.01) is not None
