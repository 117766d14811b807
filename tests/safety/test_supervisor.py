"""No command whatever breaks a limit, and a command within them passes as it is."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError
from otolith.platforms import load
from otolith.platforms.unreachable import LegOutsideStroke
from otolith.safety.supervisor import Reason, Supervisor

DAVSI = load("davsi").six_legs()
DT = 1e-3
LOW, HIGH = DAVSI.stroke
STILL = np.zeros(6)


def passed_on(supervisor: Supervisor, lengths: Mat, speeds: Mat) -> Mat:
    """(n + 1, 6) lengths that the servos are given, the first before any command."""
    given = [supervisor.lengths.copy()]
    for length, speed in zip(lengths, speeds, strict=True):
        supervisor.follow(length, speed)
        given.append(supervisor.lengths.copy())
    return np.array(given)


def assert_within_limits(given: Mat, slack: float = 1e-9) -> None:
    """Judged by the lengths alone: with even acceleration over a period, v = Δℓ/Δ at its middle."""
    assert given.min() >= LOW
    assert given.max() <= HIGH
    speeds = np.diff(given, axis=0) / DT
    assert np.abs(speeds).max() <= DAVSI.speed * (1 + slack)
    accelerations = np.diff(speeds, axis=0, prepend=0.0 * speeds[:1]) / DT
    assert np.abs(accelerations).max() <= DAVSI.acceleration * (1 + 1e-6)


def poses(t: Vec, scale: float) -> tuple[Mat, Mat]:
    """Leg set-points and their speeds of a smooth path along all axes."""
    rates = 2 * np.pi * np.array([0.2, 0.3, 0.25, 0.15, 0.35, 0.1])
    size = scale * np.array([0.12, 0.1, 0.1, 0.08, 0.08, 0.1])
    pose = size * (1 - np.cos(rates * t[:, None]))
    twist = size * rates * np.sin(rates * t[:, None])
    motion = [DAVSI.leg_motion(p, v, STILL) for p, v in zip(pose, twist, strict=True)]
    return np.array([m.length for m in motion]), np.array([m.speed for m in motion])


def test_a_command_within_the_limits_passes_unchanged() -> None:
    lengths, speeds = poses(np.arange(1, 4001, dtype=float) * DT, 0.5)
    supervisor = Supervisor(DAVSI)
    given = passed_on(supervisor, lengths, speeds)
    assert_allclose(given[1:], lengths, atol=1e-6)
    assert supervisor.interventions == ()


def test_ten_times_beyond_the_workspace_no_limit_breaks_and_it_comes_back() -> None:
    lengths, speeds = poses(np.arange(1, 20001, dtype=float) * DT, 10.0)
    supervisor = Supervisor(DAVSI)
    given = passed_on(supervisor, lengths, speeds)
    assert_within_limits(given)
    home = np.tile(DAVSI.lengths(STILL), (4000, 1))
    back = passed_on(supervisor, home, np.zeros_like(home))
    assert_within_limits(np.vstack([given, back[1:]]))
    assert_allclose(back[-1], home[-1], atol=1e-9)


hostile = st.one_of(
    st.floats(-3.0, 5.0),
    st.sampled_from([np.nan, np.inf, -np.inf, 1e300, -1e300, 0.0, LOW, HIGH]),
)


@settings(derandomize=True, max_examples=60, deadline=None)
@given(
    st.lists(
        st.tuples(st.integers(1, 400), st.tuples(*[hostile] * 6), st.tuples(*[hostile] * 6)),
        min_size=1,
        max_size=6,
    )
)
def test_no_command_whatever_breaks_a_limit(stretches: list[tuple[int, Vec, Vec]]) -> None:
    """Steps to anywhere, held for a while: far lengths, false speeds, no numbers at all."""
    supervisor = Supervisor(DAVSI)
    lengths = np.vstack([np.tile(length, (ticks, 1)) for ticks, length, _ in stretches])
    speeds = np.vstack([np.tile(speed, (ticks, 1)) for ticks, _, speed in stretches])
    assert_within_limits(passed_on(supervisor, lengths, speeds))


@pytest.mark.parametrize("seed", range(4))
def test_noise_at_every_tick_breaks_no_limit(seed: int) -> None:
    rng = np.random.default_rng(seed)
    lengths = rng.uniform(LOW - 0.5, HIGH + 0.5, (20_000, 6))
    speeds = rng.normal(0.0, 10.0**seed, (20_000, 6))
    assert_within_limits(passed_on(Supervisor(DAVSI), lengths, speeds))


def test_all_legs_are_slowed_in_proportion_along_the_way() -> None:
    """Towards a step of the set-point the legs stay on the straight line between the two."""
    start, goal = DAVSI.lengths(STILL), DAVSI.lengths(np.array([0.2, 0.1, 0.05, 0.05, 0.1, 0.0]))
    supervisor = Supervisor(DAVSI)
    given = passed_on(supervisor, np.tile(goal, (3000, 1)), np.zeros((3000, 6)))
    way = goal - start
    share = (given - start) @ way / (way @ way)
    assert_allclose(given - start, share[:, None] * way, atol=1e-9)
    assert_allclose(given[-1], goal, atol=1e-9)
    assert (np.diff(share) > -1e-12).all()  # and never back


def test_it_says_when_and_why_it_acted() -> None:
    supervisor = Supervisor(DAVSI)
    goal = np.tile(DAVSI.lengths(STILL), (1500, 1))
    passed_on(supervisor, goal[:500], 0 * goal[:500])
    assert not supervisor.interventions
    goal[500:, 2] = 3.0
    passed_on(supervisor, goal[500:], 0 * goal[500:])
    last = supervisor.interventions[-1]
    assert last.reason is Reason.STROKE
    assert last.leg == 3
    assert 0.5 < last.start < last.end == pytest.approx(1.5)
    assert last.behind == pytest.approx(3.0 - HIGH, abs=1.0)
    assert {i.reason for i in supervisor.interventions} > {Reason.STROKE}
    assert "slowed for the stroke of leg 3" in str(last)
    supervisor.follow(np.full(6, np.nan), STILL)
    assert str(supervisor.interventions[-1]).endswith("braked, for a set-point that is no number")
    supervisor.reset(STILL, STILL)
    assert not supervisor.interventions


def test_an_intervention_lasts_from_its_first_period_to_its_last() -> None:
    """Two periods of nonsense after three of rest: from 3 ms to 5 ms."""
    supervisor, home = Supervisor(DAVSI), DAVSI.lengths(STILL)
    for wanted in (home, home, home, np.full(6, np.nan), np.full(6, np.nan), home):
        supervisor.follow(wanted, STILL)
    (only,) = supervisor.interventions
    assert (only.start, only.end) == (pytest.approx(3e-3), pytest.approx(5e-3))


def test_what_it_remembers_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("otolith.safety.supervisor.KEPT", 2)
    supervisor, home = Supervisor(DAVSI), DAVSI.lengths(STILL)
    for _ in range(4):
        supervisor.follow(np.full(6, np.nan), STILL)
        for _ in range(400):
            supervisor.follow(home, STILL)
    assert len(supervisor.interventions) == 2


def test_it_starts_only_from_where_it_can_stop() -> None:
    with pytest.raises(LegOutsideStroke):
        Supervisor(DAVSI).reset(np.array([0, 0, 0.9, 0, 0, 0.0]), STILL)
    with pytest.raises(InputError, match=r"leg speed to start with is 3\.\d+ m/s, must be one that can stop"):
        Supervisor(DAVSI).reset(STILL, np.array([0, 0, 4.0, 0, 0, 0]))
