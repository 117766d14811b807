"""Silence is measured in the watcher's own time."""

import numpy as np

from otolith.live.core.watchdog import ControllerWatch, Silence
from otolith.live.messages import Plan, Rung

MS = 1_000_000


def plan(sequence: int) -> Plan:
    return Plan(
        sequence=sequence, generation=0, time_ns=0, period_ns=10 * MS, stages=np.empty((0, 6)), rung=Rung.NONE
    )


def test_silence_grows_until_any_sign_changes() -> None:
    silence = Silence(10 * MS)
    assert [silence.look(k * MS, 5, 7) for k in range(4)] == [0, MS, 2 * MS, 3 * MS]
    assert silence.look(4 * MS, 6, 7) == 0
    assert silence.look(5 * MS, 6, 7) == MS
    assert silence.look(6 * MS, 6, 6) == 0  # a count that goes back is news too


def test_a_stall_of_the_watcher_counts_no_more_than_it_may() -> None:
    silence = Silence(10 * MS)
    silence.look(0, 1)
    assert silence.look(35 * MS, 1) == 10 * MS
    assert silence.look(36 * MS, 1) == 11 * MS


def test_a_controller_is_dead_after_two_periods_of_which_the_output_was_awake() -> None:
    watch, held = ControllerWatch(), plan(1)
    assert watch.look(0, 0, None).rung is Rung.RETURN
    awake = next(k for k in range(1, 100) if watch.look(k * MS, 1, held).rung is Rung.RETURN)
    assert awake == 22  # the first look at 1 ms took in the sign; 20 ms later nothing is wrong yet
    watch, now = ControllerWatch(), 0
    watch.look(now, 1, held)
    assert watch.look(35 * MS, 1, held).rung is Rung.NONE  # the machine was held up
    assert watch.look(36 * MS, 2, plan(2)).rung is Rung.NONE


def test_a_controller_that_is_alive_without_plans_is_given_up_after_ten_periods() -> None:
    watch, held = ControllerWatch(), plan(1)
    ended = next(k for k in range(1, 1000) if watch.look(k * MS, k, held).rung is Rung.RETURN)
    assert ended == 102
