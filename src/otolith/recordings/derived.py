"""Accelerations that were not measured, derived from speed and yaw rate on request.

The derivative of speed is a_x on a level road only, and it is noisy. Speed times yaw rate is a_y without the
car's slip. Notes state the noise of both, so that they are not mistaken for measurements.
"""

from collections.abc import Collection, Mapping
from typing import Final

import numpy as np

from otolith.core.arrays import Vec
from otolith.core.errors import InputError
from otolith.recordings.channels import Channel
from otolith.recordings.columns import DERIVATIONS, Column

WINDOW: Final = 0.5  # [s] of speed that is fitted by a straight line, whose slope is the acceleration


def asked(columns: Mapping[str, str]) -> dict[str, tuple[str, ...]]:
    """Return the quantities that the mapping asks to derive, and the quantities each is derived from."""
    sources = {"ax": ("vx",), "ay": ("vx", "yaw_rate")}
    return {
        key: sources[key] for key, word in DERIVATIONS.items() if columns.get(key, "").strip().lower() == word
    }


def check_sources(there: Collection[str], columns: Mapping[str, str], source: str) -> None:
    """Refuse a derivation whose source quantities are missing."""
    for key, needed in asked(columns).items():
        for other in needed:
            if other not in there:
                where = f"{key}={DERIVATIONS[key]} in {source}"
                raise InputError(where, f"without {other}", f"with a column for {other}")


def with_derived(channels: Mapping[str, Channel], columns: Mapping[str, str]) -> dict[str, Channel]:
    """Return the channels, with those added that ``ax=from-speed`` and ``ay=from-yaw-rate`` ask to derive.

    Raises
    ------
    InputError : a source channel is too short.
    """
    out = dict(channels)
    for key in asked(columns):
        out[key] = _from_speed(channels["vx"]) if key == "ax" else _from_turning(channels)
    return out


def _from_speed(speed: Channel) -> Channel:
    """Differentiate speed by a line fitted to half a second about each sample (Savitzky & Golay, 1964)."""
    from scipy.signal import savgol_filter  # imported here: it takes most of a second

    step = (speed.t[-1] - speed.t[0]) / (len(speed.t) - 1)
    width = max(5, 2 * round(0.5 * WINDOW / step) + 1)
    if len(speed.t) < width:
        raise InputError(f"number of samples of speed in {speed.source}", len(speed.t), f"at least {width}")
    even = speed.t[0] + step * np.arange(len(speed.t))
    values = speed.on(even)
    slope = savgol_filter(values, width, 1, deriv=1, delta=step)
    noise = _noise(values, width) * np.sqrt(12.0 / (width * (width**2 - 1.0))) / step
    note = (
        f"derived from {speed.column.name!r}: straight lines through {width * step:.2g} s, noise about "
        f"{noise:.2g} m/s²; nothing above {0.44 / (width * step):.2g} Hz is left, and "
        "slopes of the road are not felt"
    )
    return _made("ax", speed, even, np.asarray(slope, dtype=np.float64), note)


def _from_turning(channels: Mapping[str, Channel]) -> Channel:
    speed, turning = channels["vx"], channels["yaw_rate"]
    t = turning.t[speed.known(turning.t)]
    if len(t) < 2:
        raise InputError(f"time that speed and yaw rate of {speed.source} have in common", "none", "some")
    v, r = speed.on(t), turning.on(t)
    noise = float(np.hypot(np.median(np.abs(v)) * _noise(r, 5), np.median(np.abs(r)) * _noise(v, 5)))
    note = (
        f"derived, {speed.column.name!r} × {turning.column.name!r}, noise about {noise:.2g} m/s²; the "
        "car's drifting and the bank of the road are not in it"
    )
    return _made("ay", turning, t, v * r, note)


def _noise(values: Vec, width: int) -> float:
    """Return the standard deviation about a line fitted to `width` samples, or that of the rounding."""
    from scipy.signal import savgol_filter

    if len(values) < width:
        return 0.0
    left = values - savgol_filter(values, width, 1)
    steps = np.abs(np.diff(values))
    digits = float(steps[steps > 0.0].min()) / np.sqrt(12.0) if (steps > 1e-9).any() else 0.0
    return max(float(np.std(left)), min(digits, float(np.std(values))))


def _made(key: str, like: Channel, t: Vec, values: Vec, note: str) -> Channel:
    column = Column(key, -1, DERIVATIONS[key], 1.0, "m/s2", assumed=False)
    rows = np.interp(t, like.t, like.rows).astype(np.int64)
    return Channel(
        column=column, t=t, values=values, rows=rows, place=like.place, source=like.source, notes=(note,)
    )
