"""Signals of one axis as functions of time: (n,) [s] -> (n,) [m/s²].

All are right-continuous and zero before their start. They are values that compare and pickle, so a study can
send them to its workers.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from otolith.core.arrays import Vec

Wave = Callable[[Vec], Vec]


@dataclass(frozen=True, slots=True)
class Sine:
    """The signal a sin(2π f (t − start) + phase) from `start` on."""

    amplitude: float  # [m/s²]
    frequency: float  # [Hz]
    start: float = 0.0  # [s]
    phase: float = 0.0  # [rad]

    def __call__(self, t: Vec) -> Vec:
        """Return the values [m/s²] at times [s]."""
        angle = 2.0 * math.pi * self.frequency * (t - self.start) + self.phase
        return np.where(t >= self.start, self.amplitude * np.sin(angle), 0.0)


@dataclass(frozen=True, slots=True)
class Pulse:
    """A constant amplitude in [start, end), zero elsewhere, with optional linear ramps.

    With a rise it grows from `start` on; with a fall it decays from `end` on.
    """

    amplitude: float  # [m/s²]
    start: float  # [s]
    end: float  # [s]
    rise: float = 0.0  # [s]
    fall: float = 0.0  # [s]

    def __call__(self, t: Vec) -> Vec:
        """Return the values [m/s²] at times [s]."""
        corners = self.start, self.start + self.rise, self.end, self.end + self.fall
        ramps = np.interp(t, corners, (0.0, self.amplitude, self.amplitude, 0.0))
        held = (t >= corners[1]) & (t < corners[2])
        outside = (t < corners[0]) | (t >= corners[3])
        return np.where(held, self.amplitude, np.where(outside, 0.0, ramps))


@dataclass(frozen=True, slots=True)
class Chirp:
    """A sine from `start` on whose frequency grows linearly from `low` to `high`, reached at `end`."""

    amplitude: float  # [m/s²]
    low: float  # [Hz]
    high: float  # [Hz]
    start: float  # [s]
    end: float  # [s]

    def __call__(self, t: Vec) -> Vec:
        """Return the values [m/s²] at times [s]."""
        tau = t - self.start
        growth = (self.high - self.low) / (self.end - self.start)  # [Hz/s]
        cycles = self.low * tau + 0.5 * growth * tau**2
        return np.where(tau >= 0.0, self.amplitude * np.sin(2.0 * math.pi * cycles), 0.0)


@dataclass(frozen=True, slots=True)
class FadeIn:
    """A wave that is faded in over `rise` seconds after `start` by a raised cosine."""

    wave: Wave
    start: float  # [s]
    rise: float  # [s]

    def __call__(self, t: Vec) -> Vec:
        """Return the values [m/s²] at times [s]."""
        fraction = np.clip((t - self.start) / self.rise, 0.0, 1.0)
        return self.wave(t) * 0.5 * (1.0 - np.cos(math.pi * fraction))


@dataclass(frozen=True, slots=True)
class Sum:
    """The sum of several waves."""

    waves: tuple[Wave, ...]

    def __call__(self, t: Vec) -> Vec:
        """Return the values [m/s²] at times [s]."""
        total = np.zeros(np.shape(t))
        for wave in self.waves:
            total = total + wave(t)
        return total


@dataclass(frozen=True, slots=True)
class Scaled:
    """A wave times a constant."""

    wave: Wave
    factor: float  # [unit wanted per m/s²]

    def __call__(self, t: Vec) -> Vec:
        """Return the values, in the scaled unit, at times [s]."""
        return self.factor * self.wave(t)


@dataclass(frozen=True, slots=True)
class Along:
    """A wave along one of three axes: (n,) [s] -> (n, 3), a specific force [m/s²] or a rate [rad/s]."""

    index: int  # force: 0 longitudinal, 1 lateral, 2 vertical; rate: 0 roll, 1 pitch, 2 yaw
    wave: Wave

    def __call__(self, t: Vec) -> Vec:
        """Return the values (n, 3) at times (n,) [s]."""
        force = np.zeros((len(t), 3))
        force[:, self.index] = self.wave(np.asarray(t, dtype=np.float64))
        return force
