"""Lag and rebound of signals whose answer is known in closed form."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from otolith.core.arrays import Vec
from otolith.loop import Run
from otolith.metrics.false_cues import KINDS, FalseCue, false_cues
from otolith.metrics.unwanted import neutral_crossings, seconds, turns_against, unwanted_cues, unwanted_totals

PERIOD = 0.01
THRESHOLD = 0.17
CONSTANT = (HealthCheck.function_scoped_fixture,)  # a run is a value: no example changes it


def felt_instead(run: Run, wanted: Vec, felt: Vec) -> Run:
    """The run with other forces along x, sampled every 10 ms."""
    forces = [np.zeros((len(wanted), 3)) for _ in range(2)]
    for force, series in zip(forces, (wanted, felt), strict=True):
        force[:, 0] = series
    time = np.arange(1, len(wanted) + 1, dtype=float) * PERIOD
    return replace(run, time=time, plant_period=PERIOD, reference_force=forces[0], felt_force=forces[1])


def at(seconds: float) -> Vec:
    return np.arange(1, round(seconds / PERIOD) + 1, dtype=float) * PERIOD - 1e-9


def test_a_late_step_lags_by_its_delay_and_never_rebounds(handmade: Run) -> None:
    t = at(10.0)
    wanted, felt = (np.where((t > a) & (t <= a + 4.0), 2.0, 0.0) for a in (1.0, 1.3))
    run = felt_instead(handmade, wanted, felt)
    found = unwanted_totals(run)["surge-pitch"]
    assert found["lag"] == {
        "count": 1,
        "duration_s": pytest.approx(0.3),
        "peak": pytest.approx(2.0),
        "mean": pytest.approx(2.0),
    }
    assert found["rebound"] == {"count": 0, "duration_s": 0.0, "peak": 0.0, "mean": 0.0}
    assert [cue.start for cue in unwanted_cues(run)] == [pytest.approx(5.0)]


@settings(derandomize=True, max_examples=60, suppress_health_check=CONSTANT)
@given(delay=st.floats(0.0, 0.9), frequency=st.floats(0.05, 0.5), amplitude=st.floats(0.2, 5.0))
def test_no_delay_of_less_than_half_a_period_rebounds(
    handmade: Run, delay: float, frequency: float, amplitude: float
) -> None:
    t = at(30.0)

    def sine(t: Vec) -> Vec:
        return amplitude * np.sin(2.0 * np.pi * frequency * t) * (t > 0.0)

    late = felt_instead(handmade, sine(t), sine(t - delay))
    assert all(cue.kind == "lag" for cue in unwanted_cues(late))


def test_the_lag_of_a_late_ramp_is_its_slope_times_the_delay(handmade: Run) -> None:
    """While a force fades by 2 m/s³ and is felt 0.2 s late, 0.4 m/s² too much are felt."""
    t = at(12.0)
    wanted, felt = (np.interp(t - d, (1.0, 2.0, 6.0, 8.0), (0.0, 4.0, 4.0, 0.0)) for d in (0.0, 0.2))
    (cue,) = unwanted_cues(felt_instead(handmade, wanted, felt))
    assert cue.kind == "lag"
    assert cue.peak == pytest.approx(0.4)
    # from where the difference reaches the threshold to where the felt force falls below it
    assert cue.start == pytest.approx(6.0 + THRESHOLD / 2.0, abs=PERIOD)
    assert cue.end == pytest.approx(8.2 - THRESHOLD / 2.0, abs=PERIOD)


def test_a_washed_out_step_rebounds_for_as_long_as_its_exponential_says(handmade: Run) -> None:
    """High-pass of first order: after the step of A over D the force is −A (1 − e^(−D/T)) e^(−t/T)."""
    t, A, D, T = at(20.0), 2.0, 4.0, 1.5
    wanted = np.where((t > 1.0) & (t <= 1.0 + D), A, 0.0)
    felt = A * (np.exp(-(t - 1.0) / T) * (t > 1.0) - np.exp(-(t - 1.0 - D) / T) * (t > 1.0 + D))
    (cue,) = unwanted_cues(felt_instead(handmade, wanted, felt))
    first = A * (1.0 - np.exp(-D / T))
    assert cue.kind == "rebound"
    assert cue.start == pytest.approx(1.0 + D)
    assert cue.duration == pytest.approx(T * np.log(first / THRESHOLD), abs=2 * PERIOD)
    assert cue.peak == pytest.approx(first, rel=PERIOD / T)
    assert cue.integral == pytest.approx(T * (first - THRESHOLD), abs=2 * PERIOD)


def test_what_swings_back_rebounds_and_what_returns_lags(handmade: Run) -> None:
    """A damped swing after a stop: half-waves against the braking rebound, those along it last too long."""
    t = at(12.0)
    braking = np.where(t <= 4.0, -3.0, 0.0)
    swing = -3.0 * np.exp(-0.4 * (t - 4.0)) * np.cos(np.pi * (t - 4.0))
    cues = unwanted_cues(felt_instead(handmade, braking, np.where(t <= 4.0, braking, swing)))
    assert [cue.kind for cue in cues[:4]] == ["lag", "rebound", "lag", "rebound"]
    zeros = [4.5, 5.5, 6.5]
    assert [cue.start for cue in cues[1:4]] == [pytest.approx(zero, abs=0.06) for zero in zeros]


@pytest.mark.parametrize(
    ("felt", "kinds"),
    [
        (-1.0, ["rebound"]),  # against what is wanted
        (0.2, []),  # too small
        (3.0, []),  # too large: of the wrong size, but not late
    ],
)
def test_while_something_is_wanted(handmade: Run, felt: float, kinds: list[str]) -> None:
    n = len(handmade.time)
    assert [c.kind for c in unwanted_cues(felt_instead(handmade, np.ones(n), np.full(n, felt)))] == kinds


def test_the_size_of_a_rebound_is_what_is_felt_and_not_what_is_missing(handmade: Run) -> None:
    n = len(handmade.time)
    (cue,) = unwanted_cues(felt_instead(handmade, np.full(n, -8.0), np.full(n, 0.5)))
    assert (cue.kind, cue.peak) == ("rebound", pytest.approx(0.5))


def test_a_direction_is_forgotten_when_the_other_was_wanted_and_felt(handmade: Run) -> None:
    t = at(8.0)
    wanted = np.select([t <= 2.0, t <= 4.0], [1.0, -1.0], 0.0)
    felt = np.select([t <= 2.5, t <= 4.0, t <= 6.0], [1.0, -1.0, 1.0], 0.0)
    late, stray = unwanted_cues(felt_instead(handmade, wanted, felt))
    assert (late.kind, late.start, late.end) == ("lag", pytest.approx(2.0), pytest.approx(2.5))
    assert (stray.kind, stray.start, stray.end) == ("rebound", pytest.approx(4.0), pytest.approx(6.0))


def test_what_is_felt_before_anything_was_wanted_rebounds(handmade: Run) -> None:
    t = at(2.0)
    (cue,) = unwanted_cues(felt_instead(handmade, np.where(t > 1.0, 1.0, 0.0), np.ones(len(t))))
    assert (cue.kind, cue.end) == ("rebound", pytest.approx(1.0))


FORCE = st.floats(-2.0, 2.0) | st.sampled_from([0.0, THRESHOLD, -THRESHOLD])


@settings(derandomize=True, max_examples=200, suppress_health_check=CONSTANT)
@given(st.lists(st.tuples(FORCE, FORCE), min_size=1, max_size=40))
def test_inverted_and_unwanted_cues_are_lag_or_rebound_and_both_ways_are_alike(
    handmade: Run, pairs: list[tuple[float, float]]
) -> None:
    """By brute force over samples, whatever the signals."""
    wanted, felt = np.array(pairs).T
    run, mirrored = felt_instead(handmade, wanted, felt), felt_instead(handmade, -wanted, -felt)
    samples = _samples(unwanted_cues(run, shortest=0.0), len(wanted))
    kinds = _samples(false_cues(run, shortest=0.0), len(wanted))
    for k, (w, f) in enumerate(pairs):
        if kinds[k] in KINDS[:2]:
            assert samples[k] in ("lag", "rebound")
        if samples[k] == "rebound":
            assert kinds[k] in KINDS[:2]
        if samples[k]:
            assert abs(f) >= THRESHOLD
            assert np.sign(f) * (f - w) >= THRESHOLD
    assert samples == _samples(unwanted_cues(mirrored, shortest=0.0), len(wanted))


def _samples(cues: list[FalseCue], n: int) -> list[str]:
    kinds = [""] * n
    for cue in cues:
        for k in range(round(cue.start / PERIOD), round(cue.end / PERIOD)):
            kinds[k] = cue.kind
    return kinds


def test_what_is_not_a_number_counts_as_rebound(handmade: Run) -> None:
    n = len(handmade.time)
    (cue,) = unwanted_cues(felt_instead(handmade, np.ones(n), np.full(n, np.nan)))
    assert cue.kind == "rebound"


def test_times_add_up_over_axes(handmade: Run) -> None:
    n = len(handmade.time)
    run = felt_instead(handmade, np.zeros(n), np.ones(n))
    felt = np.array(run.felt_force)
    felt[: n // 2, 1] = -1.0
    both = unwanted_totals(replace(run, felt_force=felt, dofs=("surge-pitch", "sway-roll")))
    assert seconds("rebound", both) == pytest.approx(1.5)
    assert seconds("lag", both) == 0.0


def test_turns_against_what_is_still_wanted_are_counted_once_each(handmade: Run) -> None:
    t = at(20.0)
    bend = np.select([t <= 1.0, t <= 17.0], [0.0, 2.0], -2.0)
    swing = np.cos(2.0 * np.pi * (t - 1.0) / 8.0)  # against it from 3 to 7 and from 11 to 15 s
    assert turns_against(felt_instead(handmade, bend, swing)) == {"surge-pitch": 2}
    assert turns_against(felt_instead(handmade, -bend, -swing)) == {"surge-pitch": 2}
    assert turns_against(felt_instead(handmade, bend, 0.16 * swing)) == {"surge-pitch": 0}
    assert turns_against(felt_instead(handmade, bend, bend)) == {"surge-pitch": 0}


def test_what_is_wanted_too_shortly_to_be_a_cue_is_turned_against_by_none(handmade: Run) -> None:
    """Chatter of 12.5 Hz, felt three quarters of a period late."""
    t = at(4.0)
    chatter, late = (2.0 * np.sign(np.sin(2.0 * np.pi * 12.5 * (t - d) - 1e-6)) for d in (0.0, 0.06))
    run = felt_instead(handmade, chatter, late)
    assert turns_against(run) == {"surge-pitch": 0}
    assert turns_against(run, shortest=0.03)["surge-pitch"] > 0


def test_an_axis_crosses_neutral_where_it_leaves_one_percent_of_its_reach(handmade: Run) -> None:
    """The platform of the thesis reaches 0.5 m and 30 deg."""
    n = len(handmade.time)
    t = np.linspace(0.0, 1.0, n)
    pose = np.zeros((n, 6))
    pose[:, 0] = 0.1 * np.sin(2.0 * np.pi * 2.5 * t)  # five half-waves
    pose[:, 4] = np.radians(0.29) * np.sin(2.0 * np.pi * 2.5 * t)
    assert neutral_crossings(replace(handmade, pose=pose)) == {"surge": 4, "pitch": 0}
    pose[:, 4] *= 1.1
    assert neutral_crossings(replace(handmade, pose=pose)) == {"surge": 4, "pitch": 4}
