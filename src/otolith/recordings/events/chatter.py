"""Chatter in a recorded drive: forces that vibrate faster than a vehicle moves."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from otolith.core.arrays import Bools, Vec
from otolith.recordings.channels import FORCE, Channel
from otolith.recordings.events.event import Event, stretches

FAST: Final = 15.0  # [Hz] above which a force counts as chatter …
CALM: Final = 10.0  # [Hz] … and below which a drive keeps most of its energy
SMOOTHED: Final = 5.0  # [Hz] cut-off of the low-pass that is proposed
RMS: Final = 0.7  # [m/s²] least RMS of chatter that is reported
SHARE: Final = 0.5  # least share of chatter in the energy of the second around it
LENGTH: Final = 0.5  # [s] least duration of chatter that is reported …
NEAR: Final = 1.0  # … and longest calm within one stretch
TAPER: Final = 0.25  # [s] over which a smoothed stretch is blended into the rest


def find_chatter(felt: Sequence[Channel]) -> list[Event]:
    """Find stretches in which most of a force's energy lies above 15 Hz; they are reported, never refused."""
    events = []
    for channel in felt:
        if channel.key in FORCE and channel.step < 0.5 / FAST:
            events += _chatter_of(channel)
    return events


def energy_notes(felt: Sequence[Channel]) -> list[str]:
    """Note forces with most of their energy above 10 Hz, and what a low-pass would leave of them."""
    notes = []
    for channel in felt:
        if channel.key not in FORCE or channel.step >= 0.5 / CALM:
            continue
        frequency, power = _spectrum(channel)
        whole = float(power.sum())
        share = float(power[frequency > CALM].sum()) / whole if whole > 0.0 else 0.0
        if share > SHARE and np.sqrt(whole) > 0.3:
            left = float(np.sqrt((power / (1.0 + (frequency / SMOOTHED) ** 4) ** 2).sum()))
            notes.append(
                f"{channel.key}: {100.0 * share:.0f} % of its energy lies above {CALM:g} Hz "
                f"({np.sqrt(whole):.3g} m/s² rms in all); --lowpass {SMOOTHED:g} leaves {left:.3g} m/s² rms"
            )
    return notes


def without_chatter(channel: Channel, events: Sequence[Event]) -> Channel:
    """Return the channel with the part above 10 Hz removed in the given stretches."""
    if not events or channel.step >= 0.5 / CALM:
        return channel
    fast = np.interp(channel.t, *_above(channel, CALM))
    share = np.zeros(len(channel.t))
    for event in events:
        near = channel.within(event.start - TAPER, event.end + TAPER)
        t = channel.t[near]
        inside = np.clip(np.minimum(t - event.start, event.end - t) / TAPER + 1.0, 0.0, 1.0)
        share[near] = np.maximum(share[near], inside)
    return replace(channel, values=channel.values - share * fast)


def _chatter_of(channel: Channel) -> list[Event]:
    t, fast = _above(channel, FAST)
    step = float(t[1] - t[0])
    whole = channel.on(t)
    level = _moving(whole, step)
    shaking = _moving(fast**2, step)
    varying = _moving((whole - level) ** 2, step)
    loud = (shaking > RMS**2) & (shaking > SHARE * varying)
    events = []
    for first, last in _joined(loud, round(NEAR / step)):
        if (last - first) * step < LENGTH:
            continue
        part = fast[first:last]
        loudest = int(np.argmax(np.abs(np.fft.rfft(part))))
        size = f"{channel.key} shakes at about {loudest / (len(part) * step):.2g} Hz, "
        size += f"{np.sqrt(shaking[first:last].max()):.2g} m/s² rms"
        events.append(Event("chatter", float(t[first]), float(t[min(last, len(t) - 1)]), size, sure=False))
    return events


def _joined(loud: Bools, near: int) -> list[tuple[int, int]]:
    joined: list[tuple[int, int]] = []
    for first, last in stretches(loud):
        if joined and first - joined[-1][1] <= near:
            joined[-1] = (joined[-1][0], last)
        else:
            joined.append((first, last))
    return joined


def _even(channel: Channel) -> tuple[Vec, Vec]:
    """Resample the channel on an even grid of its median step, with at most twice as many samples."""
    duration = float(channel.t[-1] - channel.t[0])
    step = max(channel.step, 0.5 * duration / len(channel.t))
    count = int(np.floor(duration / step)) + 1
    t: Vec = float(channel.t[0]) + step * np.arange(count, dtype=np.float64)
    return t, np.asarray(channel.on(t), dtype=np.float64)


def _above(channel: Channel, frequency: float) -> tuple[Vec, Vec]:
    """Return the part of a channel above a frequency [Hz], on an even grid, mirrored at the ends."""
    t, values = _even(channel)
    mirrored = np.r_[values, values[::-1]]
    spectrum = np.fft.rfft(mirrored)
    spectrum[np.fft.rfftfreq(len(mirrored), float(t[1] - t[0])) <= frequency] = 0.0
    return t, np.fft.irfft(spectrum, len(mirrored))[: len(values)]


def _spectrum(channel: Channel) -> tuple[Vec, Vec]:
    """Return frequencies [Hz] and the contribution of each to the variance [m²/s⁴]."""
    t, values = _even(channel)
    mirrored = np.r_[values, values[::-1]]
    amplitude = np.abs(np.fft.rfft(mirrored - np.mean(mirrored))) / len(mirrored)
    frequency = np.asarray(np.fft.rfftfreq(len(mirrored), float(t[1] - t[0])), dtype=np.float64)
    return frequency, np.asarray(2.0 * amplitude**2, dtype=np.float64)


def _moving(values: Vec, step: float) -> Vec:
    """Return the mean over about one second around each value, over less at the ends."""
    half = max(1, round(0.5 / step))
    area = np.r_[0.0, np.cumsum(values)]
    index = np.arange(len(values))
    low, high = np.maximum(index - half, 0), np.minimum(index + half + 1, len(values))
    return np.asarray((area[high] - area[low]) / (high - low), dtype=np.float64)
