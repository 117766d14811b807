"""The response at one frequency, read from a recorded series."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from otolith.core.arrays import Mat, Vec

HARMONICS = 5  # fitted beside the sinusoid, so that distortion does not pass for drift


@dataclass(frozen=True, slots=True, kw_only=True)
class Harmonic:
    """A series' part at one frequency: Re(amplitude e^{jωt})."""

    amplitude: complex  # in the unit of the series; mean over the periods
    spread: float  # largest distance of one period's amplitude from the mean: what has not settled
    distortion: float  # RMS of the rest over RMS of the harmonic: what is not linear


@dataclass(frozen=True, slots=True, kw_only=True)
class Fidelity:
    """A grade for responses at 1 rad/s with at least this gain and at most this phase error."""

    grade: str
    least_gain: float
    largest_phase_deg: float


def harmonic(time: Vec, series: Vec, omega: float) -> Harmonic:
    """Fit the whole periods at the series' end one by one, by least squares, beside drift and harmonics.

    Parameters
    ----------
    time : (n,) [s], evenly spaced; series : (n,).
    omega : [rad/s].

    Raises
    ------
    ValueError : the series is shorter than two periods.
    """
    dt = float(time[1] - time[0])
    length = 2.0 * np.pi / (omega * dt)  # [samples] of a period, seldom a whole number
    periods = int((len(time) + 1e-9) // length)
    if periods < 2:
        raise ValueError(f"{len(time) * dt:.3g} s are less than two periods at {omega:.3g} rad/s")
    starts = np.rint(len(time) - length * np.arange(periods, -1, -1)).astype(int)
    level = series - _drift(time[starts[0] :], series[starts[0] :], omega) * time
    fits = [_fit(time[a:b], level[a:b], omega) for a, b in itertools.pairwise(starts)]
    amplitudes, rests = (np.array(part) for part in zip(*fits, strict=True))
    mean = complex(np.mean(amplitudes))
    size = abs(mean) / np.sqrt(2.0)
    rest = float(np.sqrt(np.mean(rests)))
    return Harmonic(
        amplitude=mean,
        spread=float(np.max(np.abs(amplitudes - mean))),
        distortion=rest / size if size > 0.0 else float("nan"),
    )


def graded(gain: float, phase_deg: float, grades: Sequence[Fidelity]) -> str:
    """Sinacori's and Schroeder's judgement of the high-pass path by its gain and phase at 1 rad/s.

    The boundaries differ between sources, so none are built in: the first of `grades` whose bounds hold
    is the answer, "none" if there is none. Phases count to either side.
    """
    for grade in grades:
        if gain >= grade.least_gain and abs(phase_deg) <= grade.largest_phase_deg:
            return grade.grade
    return "none"


def _fit(t: Vec, y: Vec, omega: float) -> tuple[complex, float]:
    """Complex amplitude of one stretch, and the mean square of what is left of it."""
    basis = _waves(t, omega)
    coefficients = np.linalg.lstsq(basis, y, rcond=None)[0]
    rest = y - basis[:, :3] @ coefficients[:3]  # offset and the sinusoid itself; its harmonics are rest
    return complex(coefficients[1], -coefficients[2]), float(np.mean(rest**2))


def _drift(t: Vec, y: Vec, omega: float) -> float:
    """Slope of the straight line on which the series' periods stand."""
    basis = np.column_stack([_waves(t, omega), t - np.mean(t)])
    return float(np.linalg.lstsq(basis, y, rcond=None)[0][-1])


def _waves(t: Vec, omega: float) -> Mat:
    """Columns 1, cos ωt, sin ωt, cos 2ωt, sin 2ωt, … up to the last harmonic."""
    angles = omega * t[:, None] * np.arange(1, HARMONICS + 1)
    waves = np.stack([np.cos(angles), np.sin(angles)], axis=2).reshape(len(t), -1)
    return np.column_stack([np.ones_like(t), waves])
