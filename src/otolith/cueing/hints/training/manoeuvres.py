"""Manoeuvres on which hints are trained, and others on which they are judged.

Both sets contain the shapes of which drives consist: pulses, random steps, sines, sums of sines, chirps, and
random drives (accelerate, brake, turn, with the road's vibration). No amplitude, frequency, jump time or seed
of one set occurs in the other. The held-out set also has shapes that training never shows (a sawtooth, faster
sines, three pulses in a row, denser multisines).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from otolith.core.frames import Dof
from otolith.scenarios import Scenario
from otolith.scenarios.sampled import Sampled
from otolith.scenarios.waves import Along, Chirp, Pulse, Sine, Sum, Wave

PERIOD: Final = 0.01  # [s] sampling period of a random drive


@dataclass(frozen=True, slots=True)
class Manoeuvre:
    """What one axis should feel, and for how long."""

    name: str
    duration: float  # [s]
    wave: Wave


@dataclass(frozen=True, slots=True)
class Sawtooth:
    """A signal that rises from −amplitude to +amplitude over each `cycle` [s], then falls at once."""

    amplitude: float  # [m/s²]
    cycle: float  # [s]

    def __call__(self, t: np.ndarray) -> np.ndarray:
        """Return the values [m/s²] at times [s]."""
        return self.amplitude * (2.0 * np.mod(t / self.cycle, 1.0) - 1.0)


@dataclass(frozen=True, slots=True)
class Recorded:
    """One column of samples as a wave."""

    samples: Sampled

    def __call__(self, t: np.ndarray) -> np.ndarray:
        """Return the values [m/s²] at times [s]."""
        return self.samples(t)[:, 0]


def training() -> list[Manoeuvre]:
    """Return about 120 manoeuvres, 20 minutes in all."""
    made = [_sine(a, f) for a in (0.3, 0.5, 0.75, 1.0, 1.4, 2.0, 2.5) for f in (0.07, 0.1, 0.2, 0.4)]
    made += [_pulses((a, 1.0, 5.0), duration=9.0) for a in (-2.0, -1.0, -0.5, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0)]
    made += [_chirp(a, low, high) for a, low, high in ((0.5, 0.05, 0.6), (1.0, 0.1, 1.0), (1.6, 0.03, 0.5))]
    levels = (0.3, 0.6, 1.0, 1.6)
    made += [_multisine(seed, levels[seed % 4], highest=(1.0, 2.0)[seed % 2]) for seed in range(24)]
    made += [_random_steps(100 + seed, levels[seed % 4]) for seed in range(28)]
    return made + [_drive(200 + seed, (0.5, 1.0, 1.5)[seed % 3]) for seed in range(18)]


def unseen() -> list[Manoeuvre]:
    """Return the held-out manoeuvres, at least 190 s for each axis."""
    made = [_sine(0.9, 0.27, start=0.4), _sine(1.7, 0.55, start=0.4), _sine(0.62, 0.13, start=0.8)]
    made += [_pulses((0.8, 0.77, 3.1), (-1.2, 4.4, 6.0), (1.7, 7.2, 9.1), duration=12.0)]
    made += [_pulses((-1.3, 1.31, 4.27), duration=9.0), _pulses((0.9, 0.63, 5.4), duration=9.0)]
    made += [Manoeuvre("sawtooth", 12.0, Sawtooth(1.2, 3.3)), _chirp(0.8, 0.04, 0.76)]
    made += [_multisine(801, 0.5, count=12, highest=2.5), _multisine(802, 1.2, count=12, highest=2.5)]
    made += [_random_steps(901, 0.8), _random_steps(902, 1.3)]
    return made + [_drive(seed, level, duration=30.0) for seed, level in ((951, 0.4), (952, 0.8), (953, 1.3))]


def along(manoeuvres: Sequence[Manoeuvre], pairs: Sequence[Dof], *, seed: int = 0) -> list[Scenario]:
    """Return one scenario per manoeuvre; further axes get another manoeuvre or, one time in four, nothing."""
    rng = np.random.default_rng(seed)
    made = [_scenario(one, pairs[0]) for one in manoeuvres]
    for pair in pairs[1:]:
        others = [manoeuvres[i] for i in rng.permutation(len(manoeuvres))]
        still = rng.uniform(size=len(made)) < 0.25
        made = [
            one if idle else one.combined_with(_scenario(other, pair))
            for one, other, idle in zip(made, others, still, strict=True)
        ]
    return made


def _scenario(one: Manoeuvre, pair: Dof) -> Scenario:
    return Scenario(
        name=one.name,
        duration=one.duration,
        specific_force=Along(pair.translation, one.wave),
        origin="formula",
    )


def _sine(amplitude: float, frequency: float, *, start: float = 1.0) -> Manoeuvre:
    duration = 10.0 if frequency < 0.2 else 7.0
    return Manoeuvre(f"sine {amplitude:g} at {frequency:g} Hz", duration, Sine(amplitude, frequency, start))


def _pulses(*pulses: tuple[float, float, float], duration: float) -> Manoeuvre:
    return Manoeuvre(f"{len(pulses)} pulses", duration, Sum(tuple(Pulse(*pulse) for pulse in pulses)))


def _chirp(amplitude: float, low: float, high: float) -> Manoeuvre:
    return Manoeuvre(f"chirp of {amplitude:g}", 12.0, Chirp(amplitude, low, high, 0.5, 12.0))


def _multisine(seed: int, rms: float, *, count: int = 6, highest: float) -> Manoeuvre:
    """Return sines with random phases, weaker at higher frequencies; it starts with a jump."""
    rng = np.random.default_rng(seed)
    f = np.exp(rng.uniform(np.log(0.03), np.log(highest), count))
    a = rng.normal(size=count) / np.sqrt(f / f.min())
    a *= np.sqrt(2.0) * rms / np.linalg.norm(a)
    phase = rng.uniform(0.0, 2.0 * np.pi, count)
    sines = tuple(Sine(*(float(v) for v in (a[i], f[i], 0.0, phase[i]))) for i in range(count))
    return Manoeuvre(f"multisine {seed}", 12.0, Sum(sines))


def _random_steps(seed: int, level: float) -> Manoeuvre:
    """Return eight jumps to random levels at random times."""
    rng = np.random.default_rng(seed)
    times = [*np.sort(rng.uniform(0.3, 10.0, 8)), 11.0]
    levels = level * rng.normal(size=8)
    pulses = tuple(
        Pulse(float(a), float(t), float(e)) for a, t, e in zip(levels, times, times[1:], strict=False)
    )
    return Manoeuvre(f"random steps {seed}", 10.0, Sum(pulses))


def _drive(seed: int, level: float, *, duration: float = 15.0) -> Manoeuvre:
    """Return random holds of 0.5 s to 4 s joined by ramps of 0.1 s to 0.8 s, with vibration up to 5 Hz."""
    rng = np.random.default_rng(seed)
    t, value = [0.0], [0.0]
    while t[-1] < duration:
        t += [t[-1] + rng.uniform(0.5, 4.0)]
        value += [value[-1]]
        t += [t[-1] + rng.uniform(0.1, 0.8)]
        value += [level * rng.normal() if rng.uniform() < 0.8 else 0.0]
    grid = np.arange(round(duration / PERIOD) + 1) * PERIOD
    smooth = np.interp(grid, t, value) + 0.08 * level * _vibration(rng, len(grid))
    return Manoeuvre(f"drive {seed}", duration, Recorded(Sampled(PERIOD, np.tile(smooth[:, None], (1, 3)))))


def _vibration(rng: np.random.Generator, n: int) -> np.ndarray:
    """Return white noise of unit variance through two first-order low-passes of 5 Hz."""
    noise, pole = rng.normal(size=n), np.exp(-2.0 * np.pi * 5.0 * PERIOD)
    for _ in range(2):
        for k in range(1, n):
            noise[k] = pole * noise[k - 1] + (1.0 - pole) * noise[k]
    shaken: np.ndarray = noise / np.std(noise)
    return shaken
