"""Reference signals from parameters: steps, sines, their sums, chirps and random multisines.

The thesis's tables can be read in several ways; these readings reproduce its results: every sine starts at
zero phase, after one second of rest (text of Table 5.1), and the "step from 1 to 4 seconds" is a pulse that
ends at 5 s.

Along "yaw" a signal of a [m/s²] is the rate a / (10 m/s), that of a car at 36 km/h with the lateral
acceleration a. So one line of text drives every axis, and lateral force and yaw belong to one bend.
"""

import math
from typing import Final

import numpy as np

from otolith.core.errors import InputError
from otolith.scenarios.scenario import Scenario
from otolith.scenarios.waves import Along, Chirp, FadeIn, Pulse, Scaled, Sine, Sum, Wave

FORCES: Final = {"longitudinal": 0, "lateral": 1, "vertical": 2}  # name -> index of the specific force
AXES: Final = (*FORCES, "yaw")
TURNING_SPEED: Final = 10.0  # [m/s] speed of the turning car
STEP_END: Final = 5.0  # [s] end of the thesis's steps, which reproduces its results
STEP_END_LITERAL: Final = 4.0  # [s] end as printed
TABLE_5_1_WAVES: Final = ((1.0, 0.1), (0.8, 0.15), (0.1, 0.2), (0.6, 0.5))  # ([m/s²], [Hz])
SECTION_6_1_WAVES: Final = ((0.5, 1.0), (0.6, 0.1), (0.1, 0.2), (0.8, 0.15))  # ([m/s²], [Hz])

MAX_AMPLITUDE: Final = 30.0  # [m/s²]
MAX_FREQUENCY: Final = 50.0  # [Hz]
DURATIONS: Final = (0.1, 3600.0)  # [s]
NOTHING: Final = Sum(())
RISE: Final = 1.0  # [s] over which a multisine fades in


def sine(
    amplitude: float = 1.0,
    frequency: float = 0.1,
    *,
    duration: float = 10.0,
    start: float = 1.0,
    axis: str = "longitudinal",
) -> Scenario:
    """Return a sine at zero phase from `start` [s] on; amplitude [m/s²], frequency [Hz].

    Raises
    ------
    InputError : a parameter is not finite or out of bounds.
    """
    _times(duration, start)
    _amplitude(amplitude)
    _frequency(frequency)
    return _scenario(Sine(amplitude, frequency, start), duration, axis, f"sine of {amplitude:g} m/s²")


def step(
    amplitude: float = 1.0,
    *,
    start: float = 1.0,
    end: float = STEP_END,
    rise: float = 0.0,
    fall: float = 0.0,
    duration: float = 10.0,
    axis: str = "longitudinal",
) -> Scenario:
    """Return a pulse of `amplitude` [m/s²] in [start, end) [s].

    Parameters
    ----------
    rise : [s] of linear growth from `start` on; at most until `end`.
    fall : [s] of linear decay from `end` on.

    Raises
    ------
    InputError : a parameter is not finite or out of bounds.
    """
    _pulse(duration, start, end)
    _amplitude(amplitude)
    _within(
        "rise", rise, (0.0, end - start), "s", f"from 0 s to what lies from start to end, {end - start:g} s"
    )
    _within("fall", fall, (0.0, DURATIONS[1]), "s")
    wave = Pulse(amplitude, start, end, rise, fall)
    return _scenario(wave, duration, axis, f"step of {amplitude:g} m/s²")


def step_sine(
    amplitude: float = 1.0,
    frequency: float = 0.1,
    *,
    end: float = STEP_END,
    sine_start: float = 10.0,
    duration: float = 20.0,
    axis: str = "longitudinal",
) -> Scenario:
    """Return a pulse in [1, end) [s], then a sine of the same amplitude that starts at `sine_start` [s].

    Raises
    ------
    InputError : a parameter is not finite or beyond its bound.
    """
    start = 1.0
    _pulse(duration, start, end)
    _times(duration, sine_start, "sine_start")
    _amplitude(amplitude)
    _frequency(frequency)
    wave = Sum((Pulse(amplitude, start, end), Sine(amplitude, frequency, sine_start)))
    return _scenario(wave, duration, axis, f"step, then sine, of {amplitude:g} m/s²")


def combined(
    waves: tuple[tuple[float, float], ...] = TABLE_5_1_WAVES,
    *,
    scale: float = 0.3,
    duration: float = 10.0,
    start: float = 1.0,
    axis: str = "longitudinal",
) -> Scenario:
    """Return a sum of sines (amplitude [m/s²], frequency [Hz]), scaled (eqs. 5.1 and 6.1).

    Raises
    ------
    InputError : a parameter is not finite or out of bounds.
    """
    _times(duration, start)
    _within("scale", scale, (-10.0, 10.0), "")
    for amplitude, frequency in waves:
        _amplitude(scale * amplitude)
        _frequency(frequency)
    sines = tuple(Sine(scale * amplitude, frequency, start) for amplitude, frequency in waves)
    return _scenario(Sum(sines), duration, axis, f"{len(waves)} sines, scaled by {scale:g}")


def multisine(
    seed: int = 0,
    amplitude: float = 1.0,
    *,
    low: float = 0.05,
    high: float = 1.0,
    count: int = 8,
    duration: float = 20.0,
    axis: str = "longitudinal",
) -> Scenario:
    """Return a random sum of `count` sines between `low` and `high` [Hz], from 1 s on.

    Equal seeds give equal signals. The logarithmic frequency range is divided evenly, with one random
    frequency in each part; weights and phases are random. The RMS is that of one sine of `amplitude` [m/s²].
    A raised cosine fades the signal in over the first second, because random phases would start with a jump.

    Raises
    ------
    InputError : a parameter is not finite or out of bounds.
    """
    start = 1.0
    _times(duration, start)
    _amplitude(amplitude)
    _band(low, high)
    _within("seed", seed, (0, 2**63), "")
    _within("count", count, (1, 100), "")
    rng = np.random.default_rng(int(seed))
    shares = (np.arange(count) + rng.uniform(size=count)) / count
    frequencies = low * (high / low) ** shares
    weights = rng.uniform(0.3, 1.0, size=count)
    amplitudes = amplitude * weights / np.linalg.norm(weights)
    phases = rng.uniform(0.0, 2.0 * math.pi, size=count)
    sines = tuple(
        Sine(float(a), float(f), start, float(p))
        for a, f, p in zip(amplitudes, frequencies, phases, strict=True)
    )
    return _scenario(FadeIn(Sum(sines), start, RISE), duration, axis, f"random multisine, seed {seed}")


def chirp(
    amplitude: float = 1.0,
    *,
    low: float = 0.05,
    high: float = 1.0,
    duration: float = 20.0,
    start: float = 1.0,
    axis: str = "longitudinal",
) -> Scenario:
    """Return a sine whose frequency grows linearly from `low` at `start` to `high` [Hz] at the end.

    Raises
    ------
    InputError : a parameter is not finite or out of bounds.
    """
    _times(duration, start)
    _amplitude(amplitude)
    _band(low, high)
    wave = Chirp(amplitude, low, high, start, duration)
    return _scenario(wave, duration, axis, f"chirp of {amplitude:g} m/s²")


def _scenario(wave: Wave, duration: float, axis: str, name: str) -> Scenario:
    if axis not in AXES:
        raise InputError("axis", repr(axis), f"one of {', '.join(AXES)}")
    if axis in FORCES:
        force, rate = Along(FORCES[axis], wave), Along(0, NOTHING)
    else:
        force, rate = Along(0, NOTHING), Along(2, Scaled(wave, 1.0 / TURNING_SPEED))
    return Scenario(
        name=name, duration=float(duration), specific_force=force, angular_rate=rate, origin="formula"
    )


def _amplitude(value: float) -> None:
    _within("amplitude", value, (-MAX_AMPLITUDE, MAX_AMPLITUDE), "m/s²")


def _frequency(value: float, name: str = "frequency") -> None:
    bound = f"greater than 0 and at most {MAX_FREQUENCY:g} Hz"
    _within(name, value, (math.nextafter(0.0, 1.0), MAX_FREQUENCY), "Hz", bound)


def _band(low: float, high: float) -> None:
    _frequency(low, "low")
    _frequency(high, "high")
    if low > high:
        raise InputError("low", f"{low:g} Hz", f"at most high, {high:g} Hz")


def _times(duration: float, start: float, name: str = "start") -> None:
    _within("duration", duration, DURATIONS, "s")
    before = math.nextafter(duration, 0.0)
    _within(name, start, (0.0, before), "s", f"at least 0 s and before the duration, {duration:g} s")


def _pulse(duration: float, start: float, end: float) -> None:
    _times(duration, start)
    after = math.nextafter(start, math.inf)
    _within(
        "end",
        end,
        (after, DURATIONS[1]),
        "s",
        f"after the start, {start:g} s, and at most {DURATIONS[1]:g} s",
    )


def _within(name: str, value: float, range_: tuple[float, float], unit: str, bound: str = "") -> None:
    """Refuse what is not finite or outside the range; `bound` words it where two numbers would not."""
    low, high = range_
    if not math.isfinite(value) or not low <= value <= high:
        raise InputError(
            name, f"{value:g} {unit}".strip(), bound or f"between {low:g} and {high:g} {unit}".strip()
        )
