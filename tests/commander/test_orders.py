"""Orders and the pace, without processes."""

import os
from collections.abc import Iterator

import pytest

from otolith.commander.orders import AGAIN, KEPT, Inbox, Orders
from otolith.commander.pace import Pace
from otolith.live.shell.memory import Channel


@pytest.fixture
def name() -> Iterator[str]:
    made = f"otolith-test-orders-{os.getpid()}"
    with Channel(made, create=True):
        yield made


def test_every_order_arrives_once_in_its_sequence(name: str) -> None:
    with Channel(name) as there, Channel(name) as here:
        orders, inbox = Orders(there), Inbox(here, 0)
        assert inbox.new() == ()
        for word in ("pause", "resume", "pause"):
            orders.give(word, {})
        orders.give("change", {"scale": 0.5})
        got = inbox.new()
        assert [(one.number, one.word) for one in got] == [
            (1, "pause"),
            (2, "resume"),
            (3, "pause"),
            (4, "change"),
        ]
        assert got[-1].values == {"scale": 0.5}
        assert inbox.new() == ()


def test_a_flood_of_stops_displaces_nothing_and_a_later_stop_is_another(name: str) -> None:
    now = [0.0]
    with Channel(name) as there, Channel(name) as here:
        orders, inbox = Orders(there, lambda: now[0]), Inbox(here, 0)
        orders.give("pause", {})
        numbers = {orders.give("stop", {}) for _ in range(10 * KEPT)}
        assert numbers == {2}
        assert [one.word for one in inbox.new()] == ["pause", "stop"]
        now[0] = 1.01 * AGAIN  # whether or not the first was carried out
        assert orders.give("stop", {}) == 3
        assert [one.word for one in inbox.new()] == ["stop"]


def test_a_server_that_comes_back_goes_on_counting_and_a_worker_does_nothing_twice(name: str) -> None:
    with Channel(name) as first, Channel(name) as second, Channel(name) as here:
        Orders(first).give("run", {"scale": 1.0})
        inbox = Inbox(here, 0)
        assert len(inbox.new()) == 1
        again = Orders(second)
        assert again.give("stop", {}) == 2
        assert [one.word for one in inbox.new()] == ["stop"]
        with Channel(name) as other:
            assert Inbox(other, 2).new() == []  # another worker, that was told what was reached


def test_the_pace_follows_real_time_and_gives_up_what_is_lost() -> None:
    now = [10.0]
    pace = Pace(2.0, lambda: now[0])
    now[0] = 10.5
    assert pace.due() == pytest.approx(1.0)
    pace.reached(1.0)
    assert (pace.behind, pace.missed) == (0.0, 0)
    assert pace.wait(1.02) == pytest.approx(0.01)
    now[0] = 10.6
    pace.reached(1.0)  # 0.1 s late
    assert (pytest.approx(pace.behind), pace.missed) == (0.1, 1)
    pace.reached(1.0)
    assert pace.missed == 1  # still the same delay
    now[0] = 12.0
    pace.reached(1.0)
    assert pace.due() == pytest.approx(1.0)  # it does not race after 1.5 s
    assert Pace(0.0).wait(1e9) == 0.0
