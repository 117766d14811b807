"""The features: mirrored motions, and their braking rows against the formula of eq. C.2."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from otolith.core.arrays import Vec
from otolith.core.frames import SURGE_PITCH, SWAY_ROLL
from otolith.cueing.hints import features as f
from otolith.cueing.mpc import motion
from otolith.platforms import load

BOTH = (SURGE_PITCH, SWAY_ROLL)


def described(x: Vec, wanted: Vec) -> Vec:
    out = np.empty(f.FEATURES * len(wanted))
    f.describe(x, wanted, f.braking_forms(load("thesis"), BOTH[: len(wanted)]), out)
    return out


@given(seed=st.integers(0, 10_000), pairs=st.sampled_from([1, 2]))
@settings(max_examples=50, deadline=None, derandomize=True)
def test_a_mirrored_motion_has_mirrored_features(seed: int, pairs: int) -> None:
    rng = np.random.default_rng(seed)
    x, wanted = rng.normal(size=6 * pairs), rng.normal(size=pairs)
    assert_allclose(described(-x, -wanted), f.mirror_signs(pairs) * described(x, wanted))


def test_features_are_what_the_page_says() -> None:
    w, tilt, v, s, a, alpha, r = 0.01, 0.1, 0.3, -0.2, 0.7, 0.4, 1.5
    found = described(np.array([w, tilt, v, s, a, alpha]), np.array([r]))
    gravity = 9.81 * np.sin(tilt)
    brake = [s + 2.5 * v + 0.5 * 0.45 * 2.5**2 * a, tilt + 0.5 * w + 0.5 * 0.45 * 0.5**2 * alpha]
    rest = [s + 0.5 * v, v + 0.5 * a, abs(w), abs(s)]
    assert_allclose(
        found, [w, tilt, v, s, a, alpha, r, r - a - gravity, r - gravity, *brake, *rest], rtol=1e-4
    )


@pytest.mark.parametrize("name", ["TILT_RATE", "TILT", "VELOCITY", "POSITION", "ACCELERATION"])
def test_the_states_stand_where_the_model_has_them(name: str) -> None:
    assert getattr(f, name) == getattr(motion, name)
