"""Observer, preview and fade."""

import numpy as np
import pytest

from otolith.live.core.reference import (
    CLIPPED,
    TIME_CONSTANT,
    Cued,
    Fader,
    Observer,
    clipped,
    reference,
)

MS = 1_000_000


def fed(values: dict[int, np.ndarray]) -> Observer:
    observer = Observer()
    for time_ns, wanted in values.items():
        observer.sample(time_ns, wanted)
    return observer


def test_a_ramp_is_followed_without_error_and_foreseen_for_40_ms() -> None:
    slope = np.array([3.0, -2.0, 1.0, 0.1, 0.2, -0.3])
    times = [round(k * 1e9 / 60) for k in range(90)]
    observer = fed({t: 1e-9 * t * slope for t in times})
    now = times[-1] + 5 * MS
    np.testing.assert_allclose(observer.wanted(now), 1e-9 * now * slope, atol=1e-9)
    np.testing.assert_allclose(observer.wanted(now, 0.02), (1e-9 * now + 0.02) * slope, atol=1e-9)
    last = 1e-9 * times[-1] + CLIPPED
    np.testing.assert_allclose(observer.wanted(now, 1.0), last * slope, atol=1e-9)


def test_a_step_is_followed_as_the_two_equal_poles_say() -> None:
    """After a step the error of a critically damped alpha-beta filter is θ²ᵏ-like: (1 + k (1 − θ)/θ) θᵏ…"""
    dt = 10 * MS
    observer = Observer()
    for k in range(20):
        observer.sample(k * dt, np.zeros(6))
    theta = np.exp(-1e-9 * dt / TIME_CONSTANT)
    # x_k = x + s, r = z − x; poles of [[1 − α, 1 − α], [−β, 1 − β]] are both θ
    A = np.array([[theta**2, theta**2], [-((1 - theta) ** 2), 1 - (1 - theta) ** 2]])
    np.testing.assert_allclose(np.linalg.eigvals(A), [theta, theta], atol=1e-6)
    state = np.array([-1.0, 0.0])  # error of the level, and slope per period
    for k in range(20, 40):
        observer.sample(k * dt, np.ones(6))
        state = A @ state
        np.testing.assert_allclose(observer.wanted(k * dt), 1.0 + state[0], atol=1e-12)


def test_silence_holds_for_30_ms_and_then_decays() -> None:
    observer = fed({k * 10 * MS: np.ones(6) for k in range(20)})
    last = 19 * 10 * MS
    level = observer.wanted(last + 30 * MS)[0]
    assert level == pytest.approx(1.0, abs=1e-6)
    values = [observer.wanted(last + age * MS)[0] for age in range(30, 1000, 10)]
    assert all(np.diff(values) < 0.0)
    assert values[-1] < 0.03


def test_a_pause_makes_the_observer_begin_anew_and_no_jump_is_integrated() -> None:
    observer = fed({k * 10 * MS: np.full(6, 5.0) for k in range(20)})
    observer.sample(2_000 * MS, np.full(6, -5.0))
    np.testing.assert_array_equal(observer.wanted(2_000 * MS), np.full(6, -5.0))
    np.testing.assert_array_equal(observer.wanted(2_000 * MS, 0.04), np.full(6, -5.0))


def test_the_weight_never_jumps_and_needs_its_time() -> None:
    fader = Fader()
    weights: list[float] = []
    for up in [True] * 250 + [False] * 60 + [True] * 120:
        weights.append(fader.step(0.01, up=up, rise=2.0 if len(weights) < 250 else 1.0))
    assert weights[198] < 1.0
    assert weights[200] == 1.0
    assert weights[250 + 50] == 0.0
    assert weights[-1] == 1.0
    assert np.abs(np.diff(weights)).max() <= 0.5 * np.pi * 0.01 / 0.5


def test_a_force_is_clipped_in_its_own_direction() -> None:
    wanted = clipped(np.array([30.0, 40.0, 0.0, 1.0, 2.0, 3.0]), 10.0)
    np.testing.assert_allclose(wanted, [6.0, 8.0, 0.0, 1.0, 2.0, 3.0])


def test_a_reference_is_weighted_and_previewed() -> None:
    observer = fed({k * 10 * MS: np.ones(6) for k in range(20)})
    found = reference(observer, 190 * MS, Cued(steps=3), weight=0.5, period=0.01)
    np.testing.assert_allclose(found.specific_force, 0.5, atol=1e-6)
    assert found.preview is not None
    assert found.preview.shape == (3, 3)
    assert reference(observer, 190 * MS, Cued(), weight=0.5, period=0.01).preview is None


def test_a_reference_is_scaled_before_it_is_clipped() -> None:
    observer = fed({k * 10 * MS: np.full(6, 2.0) for k in range(20)})
    found = reference(observer, 190 * MS, Cued(scale=0.25), weight=1.0, period=0.01)
    np.testing.assert_allclose([*found.specific_force, *found.angular_rate], 0.5, atol=1e-6)
    clipped = reference(observer, 190 * MS, Cued(scale=0.5, largest=1.0), weight=1.0, period=0.01)
    assert np.linalg.norm(clipped.specific_force) == pytest.approx(1.0)
    np.testing.assert_allclose(clipped.angular_rate, 1.0, atol=1e-6)
