"""Finding and cutting events takes work that grows with the rows, and gives what plain loops give."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from otolith.core.arrays import Vec
from otolith.recordings.channels import Channel
from otolith.recordings.columns import Column
from otolith.recordings.events import Event, after_cut, before_cut
from otolith.recordings.events.chatter import find_chatter
from otolith.recordings.events.event import apart, inside
from otolith.recordings.events.jumps import find_jumps

TIMES = st.integers(0, 40).map(lambda k: 0.25 * k)
SPANS = st.lists(st.tuples(TIMES, st.integers(0, 8)), max_size=8)


def events_of(spans: list[tuple[float, int]]) -> list[Event]:
    return [Event("pause", start, start + 0.25 * length, "", bridge=0.25) for start, length in spans]


def channel(key: str, t: Vec, values: Vec) -> Channel:
    column = Column(key, 0, key, 1.0, "m/s2", assumed=False)
    return Channel(column=column, t=t, values=values, rows=np.arange(len(t)), place="line", source="log.csv")


@given(spans=SPANS, others=SPANS)
def test_events_apart_share_no_time_with_any_other(
    spans: list[tuple[float, int]], others: list[tuple[float, int]]
) -> None:
    one, other = events_of(spans), events_of(others)
    expected = [e for e in one if not any(e.start < o.end and o.start < e.end for o in other)]
    assert apart(one, other) == expected


@given(spans=SPANS)
def test_a_sample_is_inside_an_event_between_its_ends(spans: list[tuple[float, int]]) -> None:
    t = 0.25 * np.arange(50, dtype=float)
    expected = np.zeros(50, dtype=np.bool_)
    for event in events_of(spans):
        expected |= (t > event.start) & (t < event.end)
    assert_array_equal(inside(t, events_of(spans)), expected)


@given(gaps=st.lists(st.tuples(st.integers(1, 4), st.integers(1, 8)), max_size=6))
def test_the_times_of_a_cut_drive_lead_back_to_the_whole_one(gaps: list[tuple[int, int]]) -> None:
    events, end = [], 0.0
    for calm, length in gaps:
        events.append(Event("pause", end + calm, end + calm + length, "", bridge=0.5))
        end += calm + length
    t = np.array([k for k in 0.25 * np.arange(200) if not any(e.start < k < e.end for e in events)])
    expected = t - np.array([sum(e.end - e.start - e.bridge for e in events if e.end <= k) for k in t])
    assert_allclose(after_cut(t, events), expected, atol=1e-12)
    assert_allclose(before_cut(after_cut(t, events), events), t, atol=1e-12)


@pytest.fixture
def counted(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], list[int]]:
    """Counts the values that a function of numpy is given."""

    def count(name: str) -> list[int]:
        module = np.fft if name == "rfft" else np
        seen, plain = [0], getattr(module, name)

        def counting(a: Vec, *rest: object, **more: object) -> object:
            seen[0] += np.size(a)
            return plain(a, *rest, **more)

        monkeypatch.setattr(module, name, counting)
        return seen

    return count


@pytest.mark.parametrize("what", ["median", "diff", "abs"])
def test_jumps_are_judged_by_what_lies_about_them(what: str, counted: Callable[[str], list[int]]) -> None:
    """Hundreds of them, by speed and by place: none looks at the whole drive again."""
    n = 20_000
    t, rng = 0.01 * np.arange(n, dtype=float), np.random.default_rng(0)
    still = {key: channel(key, t, rng.normal(0.0, 0.1, n)) for key in ("ax", "ay")}
    leaps = np.cumsum(np.where(np.arange(n) % 50 == 25, 20.0 * (-1.0) ** (np.arange(n) // 50), 0.0))
    place = {key: channel(key, t, 30.0 * np.cumsum(np.arange(n) % 77 == 0)) for key in ("x", "y")}
    seen = counted(what)
    found = find_jumps({**still, "vx": channel("vx", t, leaps), **place})
    assert len(found) >= 200
    assert seen[0] < 40 * n


def test_samples_in_bursts_are_not_spread_over_a_grid_of_their_least_step(
    counted: Callable[[str], list[int]],
) -> None:
    t = (0.1 * np.arange(1000)[:, None] + 0.0005 * np.arange(10)).ravel()
    ax = channel("ax", t, np.sin(t))
    seen = counted("rfft")
    assert find_chatter([ax, replace(ax, column=replace(ax.column, key="ay"))]) == []
    assert 0 < seen[0] < 10 * len(t)
