"""Rows of an axis of its own, judged by the law that stops a platform."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from otolith.core.frames import DOFS, HEAVE, SURGE_PITCH
from otolith.core.lti import zero_order_hold
from otolith.cueing.mpc.axis_sets import axis_sets
from otolith.cueing.mpc.motion import dynamics, stacked
from otolith.cueing.mpc.rows import BrakingRows, command_bounds, rows_of
from otolith.platforms import load
from otolith.safety.law import safe
from otolith.safety.stopping import Stopping

DAVSI = load("davsi")
SHARES = st.floats(-1.0, 1.0, allow_nan=False, width=32)


@pytest.mark.parametrize("kind", [BrakingRows.STOPPING, BrakingRows.POSITION])
@pytest.mark.parametrize("axis", ["heave", "yaw"])
@given(lag=st.sampled_from([0.01, 0.05]), shares=st.tuples(SHARES, SHARES), upper=st.booleans())
@settings(max_examples=60, deadline=None)
def test_whoever_keeps_the_rows_of_an_axis_alone_can_stop_inside(
    kind: BrakingRows, axis: str, lag: float, shares: tuple[float, float], upper: bool
) -> None:
    """Also from the very end of the position's row, at the largest speed that the others allow."""
    dof = DOFS[axis]
    (limits,), (i,) = DAVSI.limits(dof), dof.axes
    sets = axis_sets(DAVSI, dof, kind, lag=lag, period=0.01)
    speed, position = rows_of(dof, (limits,), DAVSI.braking, kind=kind, sets=sets, terminal=False)
    velocity, leading = limits.velocity * np.array(shares)  # v, and v + 2 T a, which the other row limits
    most = limits.acceleration
    acceleration = np.clip((leading - velocity) / speed.coefficients[2], -most, most)
    moving = np.array([velocity, 0.0, acceleration])
    place = (position.upper if upper else position.lower) - position.coefficients @ moving
    motion = np.zeros((3, 6))
    motion[:, i] = place / position.coefficients[1], velocity, acceleration
    led = motion[0, i] + lag * motion[1, i]
    if not limits.position[0] <= led <= limits.position[1]:
        return  # this end's row lets it be beyond the other end, which the other end's row does not
    stopping = Stopping(DAVSI, (dof,), lag=lag, period=0.01)
    assert safe(motion, stopping.reach)


def test_next_to_rows_on_the_leading_motion_a_command_keeps_the_acceleration_as_well() -> None:
    """A file may allow greater commands than accelerations; rows at the nodes keep the two apart."""
    travel, tilt = DAVSI.limits(SURGE_PITCH)
    limits = (replace(travel, acceleration=4.0, command=9.0), tilt)
    turning = tilt.acceleration
    for kind, bound in ((BrakingRows.STOPPING, 4.0), (BrakingRows.LEADING, 4.0), (BrakingRows.POSITION, 9.0)):
        assert command_bounds(SURGE_PITCH, limits, kind).tolist() == [turning, bound]
    (heave,) = DAVSI.limits(HEAVE)
    alone = (replace(heave, acceleration=2.0, command=3.0),)
    assert command_bounds(HEAVE, alone, BrakingRows.POSITION).tolist() == [2.0]


def test_braking_rows_let_the_acceleration_pay_for_the_speed_and_leading_rows_do_not() -> None:
    """A state that keeps eq. C.2 and all limits and cannot stop inside, whatever is asked.

    So the thesis's braking rows are no invariant set, and imply no terminal rows. The terminal rows and the
    default ones, both of a set that is proved, refuse it.
    """
    travel, _ = limits = DAVSI.limits(SURGE_PITCH)
    x, lag, period = np.array([0.0, 0.0, -0.81, -0.5, 1.44, 0.0]), 0.01, 0.01  # [ω θ v s a_tran a_rot]

    def broken(kind: BrakingRows, *, terminal: bool = False) -> list[str]:
        sets = axis_sets(DAVSI, SURGE_PITCH, kind, lag=lag, period=period)
        rows = rows_of(SURGE_PITCH, limits, DAVSI.braking, kind=kind, sets=sets, terminal=terminal)
        return [row.name for row in rows if not row.lower <= row.coefficients @ x <= row.upper]

    assert broken(BrakingRows.POSITION) == []
    assert broken(BrakingRows.POSITION, terminal=True) == ["terminal_position_wedge"]
    assert broken(BrakingRows.STOPPING) == ["position"]
    A, B = zero_order_hold(*dynamics(stacked((SURGE_PITCH,)), lag), period)
    braked = [x]
    while braked[-1][2] < 0.0:
        braked.append(A @ braked[-1] + B @ [0.0, travel.command])
    assert braked[1][3] == pytest.approx(-0.508, abs=5e-4)
    assert min(state[3] for state in braked) < travel.position[0] - 0.04
