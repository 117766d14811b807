"""The limits that one planned motion may have, so that both parts of its split keep theirs."""

import math

import pytest

from otolith.core.errors import InputError
from otolith.core.frames import SURGE_PITCH, YAW
from otolith.cueing.design import Design, predictive
from otolith.cueing.split import TIME, Split, as_one
from otolith.platforms import load


def test_a_planned_motion_is_limited_by_what_both_parts_can_do() -> None:
    """ultimate by hand: 2.6 m of the rail; 0.25 m, 0.7 m/s and 5 m/s² of the hexapod take the rest."""
    assert pytest.approx(0.0795775) == TIME
    travel, _ = as_one(load("ultimate"), (SURGE_PITCH,)).limits(SURGE_PITCH)
    assert travel.position == (-2.6, 2.6)
    assert travel.velocity == pytest.approx(min(3.0, 0.25 / TIME))
    assert travel.acceleration == pytest.approx(min(5.0, 0.7 / TIME, 2.5))
    (turn,) = as_one(load("tripod"), (YAW,)).limits(YAW)
    assert math.degrees(turn.position[1]) == pytest.approx(20.0)
    assert math.degrees(turn.velocity) == pytest.approx(2.0 / TIME)
    assert math.degrees(turn.acceleration) == pytest.approx(30.0)
    square = as_one(load("tripod"), (SURGE_PITCH,)).limits(SURGE_PITCH)[0]
    assert square.velocity == pytest.approx(0.165 / math.sqrt(2.0) / TIME)


def test_without_a_base_nothing_is_split() -> None:
    with pytest.raises(InputError, match=r"\[base\] of platform thesis is missing"):
        Split(predictive(Design(platform=load("thesis"))), load("thesis"), (SURGE_PITCH,))
