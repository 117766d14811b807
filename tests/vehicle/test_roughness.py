import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy import signal

from otolith.core.errors import InputError
from otolith.vehicle import road
from otolith.vehicle.roughness import CLASSES, coherence, roughened

LONG = road("straight:length=20000")


@pytest.fixture(scope="module")
def profile() -> np.ndarray:
    rough = roughened(LONG, "B", np.random.default_rng(1)).profile
    assert rough is not None
    return rough[:-1]


def test_the_density_is_that_of_its_class(profile: np.ndarray) -> None:
    """Welch's estimate in octaves about 0.05 … 1.6 1/m, against G_d(n) = G_d(n₀) (n/n₀)⁻²."""
    n, G = signal.welch(profile, fs=len(profile) / 20000, nperseg=8192, axis=0)
    for middle in 0.05 * 2.0 ** np.arange(6):
        octave = (n > middle / np.sqrt(2.0)) & (n < middle * np.sqrt(2.0))
        assert_allclose(np.mean(G[octave] * (n[octave, None] / 0.1) ** 2), CLASSES["B"], rtol=0.15)


def test_the_two_tracks_belong_to_one_isotropic_surface(profile: np.ndarray) -> None:
    n, measured = signal.coherence(profile[:, 0], profile[:, 1], fs=len(profile) / 20000, nperseg=2048)
    band = (n > 0.02) & (n < 0.6)
    assert_allclose(measured[band], coherence(n[band]) ** 2, atol=0.12)
    assert coherence(np.zeros(1)) == 1.0


def test_the_surface_closes_and_chance_is_an_argument() -> None:
    profiles = [roughened(LONG, "A", np.random.default_rng(seed)).profile for seed in (1, 1, 2)]
    rough = [profile for profile in profiles if profile is not None]
    assert len(rough) == 3
    assert_allclose(rough[0][0], rough[0][-1])
    assert_allclose(rough[0], rough[1])
    assert np.abs(rough[0] - rough[2]).max() > 1e-3


def test_an_unknown_class_is_refused() -> None:
    with pytest.raises(InputError, match="roughness is 'Z', must be one of A, B, C, D, E"):
        roughened(LONG, "Z", np.random.default_rng(1))
