"""Synthetic road roughness (ISO 8608), which makes a car heave on a flat road.

Notation: n spatial frequency [1/m]; G_d(n) = G_d(n₀) (n/n₀)⁻² one-sided displacement density [m³] with n₀ =
0.1 1/m; classes A to E have geometric means of G_d(n₀) that are four times that of the class before. The
tracks under left and right wheels, B apart, are correlated like those of an isotropic surface: coherence γ(n)
= 2π n B K₁(2π n B), where K₁ is the modified Bessel function (Kamash & Robson, 1978, exponent 2).
"""

from dataclasses import replace
from typing import Final

import numpy as np
from scipy.special import k1

from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError, one_of
from otolith.vehicle.road import Road

CLASSES: Final = {"A": 16e-6, "B": 64e-6, "C": 256e-6, "D": 1024e-6, "E": 4096e-6}  # G_d(n₀) [m³]
REFERENCE: Final = 0.1  # n₀ [1/m]
BAND: Final = (0.011, 2.83)  # [1/m], band of ISO 8608
SPACING: Final = 0.1  # [m]: at least three points per shortest wave, 0.35 m
TRACK: Final = 1.6  # [m] between left and right wheels, for the coherence


def roughened(road: Road, grade: str, rng: np.random.Generator) -> Road:
    """Return the road with a random surface of class `grade`; on a closed road the surface is periodic.

    The surface is a sum of waves with the density's amplitude and random phase, all periodic in the road's
    length.

    Raises
    ------
    InputError : the class is not one of A to E.
    """
    if grade not in CLASSES:
        raise InputError("roughness", repr(grade), one_of(CLASSES, grade))
    m = round(road.length / SPACING)
    common, difference = (_surface(m, road.length, CLASSES[grade], rng) for _ in range(2))
    n = np.fft.rfftfreq(m, road.length / m).astype(np.float64)
    gamma = coherence(n)
    left = np.sqrt(0.5 * (1.0 + gamma)) * common
    right = np.sqrt(0.5 * (1.0 - gamma)) * difference
    profile = np.fft.irfft(np.stack([left + right, left - right]), m, axis=1).T  # (m, 2)
    return replace(road, profile=np.vstack([profile, profile[0]]))


def coherence(n: Vec) -> Vec:
    """Return the coherence γ (k,) of the two tracks at spatial frequencies (k,) [1/m]."""
    x = 2.0 * np.pi * n * TRACK
    return np.asarray(np.where(x > 0.0, x * k1(np.maximum(x, 1e-12)), 1.0), dtype=np.float64)


def _surface(m: int, length: float, density: float, rng: np.random.Generator) -> Mat:
    """Return the spectrum (m//2 + 1,) of one surface, in the scale of `numpy.fft.rfft`."""
    n = np.fft.rfftfreq(m, length / m)
    inside = (n >= BAND[0]) & (n <= BAND[1])
    G = np.where(inside, density * (np.maximum(n, BAND[0]) / REFERENCE) ** -2, 0.0)
    phase = rng.uniform(0.0, 2.0 * np.pi, len(n))
    amplitude = np.sqrt(2.0 * G / length)  # G Δn = amplitude²/2 with Δn = 1/length
    return np.asarray(0.5 * m * amplitude * np.exp(1j * phase))
