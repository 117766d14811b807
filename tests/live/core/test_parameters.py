"""Parameters on their way: never faster than the slew, never beyond what is asked for."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from otolith.live.core.parameters import LONGEST_STEP, SLEW, Parameters, Tuned

SHARES = st.floats(0.0, 1.0)
SETS = st.builds(Parameters, scale=SHARES, liveliness=SHARES)


@given(start=SETS, asked=st.lists(st.none() | SETS, max_size=8), dt=st.floats(0.0, 1e3))
def test_no_value_moves_faster_than_the_slew_or_past_what_is_asked_for(
    start: Parameters, asked: list[Parameters | None], dt: float
) -> None:
    used: list[Parameters] = []
    tuned, target = Tuned(start, used.append), start
    for one in asked:
        before, target = tuned.now, target if one is None else one
        tuned.step(dt, one)
        for name in ("scale", "liveliness"):
            was, now, to = (getattr(of, name) for of in (before, tuned.now, target))
            assert abs(now - was) <= SLEW * min(dt, LONGEST_STEP) * (1 + 1e-9) + 1e-15
            assert min(was, to) - 1e-15 <= now <= max(was, to) + 1e-15
    assert used == [] or used[-1] == tuned.now


def test_the_whole_range_takes_five_seconds_and_is_reached_exactly() -> None:
    tuned, steps = Tuned(Parameters(scale=1.0, liveliness=0.0)), 0
    tuned.step(0.01, Parameters(scale=0.0, liveliness=1.0))
    while tuned.now != tuned.asked:
        tuned.step(0.01, None)
        steps += 1
    assert steps == pytest.approx(499, abs=2)
    assert tuned.now == Parameters(scale=0.0, liveliness=1.0)


def test_the_algorithm_is_told_only_while_something_changes() -> None:
    used: list[Parameters] = []
    tuned = Tuned(Parameters(), used.append)
    for _ in range(5):
        tuned.step(0.01, None)
    tuned.step(0.01, Parameters())
    assert used == []
    tuned.step(0.01, Parameters(liveliness=0.501))
    assert used == [Parameters(liveliness=0.501)]
    tuned.step(0.01, None)
    assert len(used) == 1
