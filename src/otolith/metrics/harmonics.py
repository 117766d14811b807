"""The response at one frequency, estimated from a recorded series."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from otolith.core.arrays import Mat, Vec

HARMONICS = 5  # fitted together with the sinusoid, so that distortion is not taken for drift


@dataclass(frozen=True, slots=True, kw_only=True)
class Harmonic:
    """The component of a series at one frequency: Re(amplitude e^{jωt})."""

    amplitude: complex  # mean over the periods, in the unit of the series
    spread: float  # largest distance of a period's amplitude from the mean: what has not settled
    distortion: float  # RMS of the rest over RMS of the component: what is not linear


@dataclass(frozen=True, slots=True, kw_only=True)
class Fidelity:
    """A grade for responses at 1 rad/s, with its least gain and its largest phase error."""

    grade: str
    least_gain: float
    largest_phase_deg: float


def harmonic(time: Vec, series: Vec, omega: float) -> Harmonic:
    """Fit each whole period at the end of a series by least squares, together with drift and harmonics.

    Parameters
    ----------
    time : (n,) [s], evenly spaced.
    series : (n,) in any unit.
    omega : [rad/s] frequency of the component.

    Raises
    ------
    ValueError : the series is shorter than two periods.
    """
    dt = float(time[1] - time[0])
    length = 2.0 * np.pi / (omega * dt)  # [samples] length of a period, rarely a whole number
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
    """Grade the high-pass path by its gain and phase at 1 rad/s, after Sinacori and Schroeder.

    Sources disagree on the boundaries, so none are built in. The result is the first of `grades` whose bounds
    hold, "none" if there is none. The phase counts in both directions.
    """
    for grade in grades:
        if gain >= grade.least_gain and abs(phase_deg) <= grade.largest_phase_deg:
            return grade.grade
    return "none"


def _fit(t: Vec, y: Vec, omega: float) -> tuple[complex, float]:
    """Return the complex amplitude of one stretch, and the mean square of the rest."""
    basis = _waves(t, omega)
    coefficients = np.linalg.lstsq(basis, y, rcond=None)[0]
    rest = y - basis[:, :3] @ coefficients[:3]  # without offset and sinusoid; harmonics belong to the rest
    return complex(coefficients[1], -coefficients[2]), float(np.mean(rest**2))


def _drift(t: Vec, y: Vec, omega: float) -> float:
    """Return the slope of the linear drift under the periods of a series."""
    basis = np.column_stack([_waves(t, omega), t - np.mean(t)])
    return float(np.linalg.lstsq(basis, y, rcond=None)[0][-1])


def _waves(t: Vec, omega: float) -> Mat:
    """Return the columns 1, cos ωt, sin ωt, cos 2ωt, sin 2ωt, … up to the last harmonic."""
    angles = omega * t[:, None] * np.arange(1, HARMONICS + 1)
    waves = np.stack([np.cos(angles), np.sin(angles)], axis=2).reshape(len(t), -1)
    return np.column_stack([np.ones_like(t), waves])
