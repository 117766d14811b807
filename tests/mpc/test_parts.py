"""What a perceiving MPC is told of its axes, judged by the law that stops a platform."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from otolith.core.frames import AXES, SURGE_PITCH, SWAY_ROLL, AxisPair
from otolith.interfaces import Reference
from otolith.mpc.model import BrakingRows
from otolith.mpc.parts import Part, PartSettings, pair_part, single_part
from otolith.perception import Vestibular
from otolith.platforms import load
from otolith.stopping import Stopping, safe

DAVSI = load("davsi")
SHARES = st.floats(-1.0, 1.0, allow_nan=False, width=32)


def part_settings(lag: float = 0.01) -> PartSettings:
    return PartSettings(
        lag=lag,
        braking=BrakingRows.STOPPING,
        terminal=False,
        force_weight=1.0,
        rate_weight=1.0,
        senses=Vestibular(),
        period=0.01,
    )


@pytest.mark.parametrize("axis", ["heave", "yaw"])
@given(lag=st.sampled_from([0.01, 0.05]), shares=st.tuples(SHARES, SHARES), upper=st.booleans())
@settings(max_examples=60, deadline=None)
def test_whoever_keeps_the_rows_of_an_axis_alone_can_stop_inside(
    axis: str, lag: float, shares: tuple[float, float], upper: bool
) -> None:
    """Also from the very end of the position's row, at the largest speed that the others allow."""
    limits, i = DAVSI.axis_limits(axis), AXES.index(axis)
    speed, position = single_part(limits, axis, part_settings(lag)).rows
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
    stopping = Stopping(DAVSI, (), singles=(axis,), lag=lag, period=0.01)
    assert safe(motion, stopping.reach)


def rates_wanted(part: Part, rate: np.ndarray) -> np.ndarray:
    return part.channels[-1].wanted(Reference(specific_force=np.zeros(3), angular_rate=rate))


@pytest.mark.parametrize("pair", [SURGE_PITCH, SWAY_ROLL])
def test_the_rate_wanted_of_a_tilt_is_that_of_its_own_axis_now_and_of_no_other(pair: AxisPair) -> None:
    part = pair_part(DAVSI, DAVSI.pair_limits(pair), pair, part_settings())
    own = np.zeros(6)
    own[3:] = 0.1, 0.2, 0.3
    assert_allclose(rates_wanted(part, own[3:]), [pair.planar(own)[1]])  # (1,): no future of it is known
    own[pair.rotation] = 0.0
    assert_array_equal(rates_wanted(part, own[3:]), [0.0])


def test_the_rate_wanted_of_yaw_is_that_about_z() -> None:
    part = single_part(DAVSI.axis_limits("yaw"), "yaw", part_settings())
    assert_array_equal(rates_wanted(part, np.array([0.1, 0.2, 0.3])), [0.3])
