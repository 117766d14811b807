"""A recorded drive as a scenario: filtered, resampled to the controller's period, and scaled."""

import math
from pathlib import PurePath
from typing import Final

import numpy as np

from otolith.core.arrays import Mat
from otolith.core.errors import InputError
from otolith.recordings.channels import FELT
from otolith.recordings.logs import Log
from otolith.recordings.span import rate
from otolith.scenarios.sampled import Sampled
from otolith.scenarios.scenario import Scenario

ANTI_ALIAS: Final = 0.4  # cut-off of the anti-alias filter as a share of the new sampling frequency
ANTI_ALIAS_ORDER: Final = 8
LOWPASS_ORDER: Final = 2
MAX_SCALE: Final = 10.0


def log_scenario(
    log: Log,
    *,
    period: float = 0.01,
    lowpass_hz: float | None = None,
    causal: bool = False,
    scale: float = 1.0,
    rate_scale: float = 1.0,
    start: float = 0.0,
    duration: float | None = None,
) -> Scenario:
    """Turn the drive, or a window of it, into a scenario of what the driver should feel.

    Each channel is interpolated linearly on an even grid and filtered there; then every k-th sample is kept.
    Where the log is faster than `period`, an 8th-order Butterworth anti-alias filter at 0.4/period comes
    first. The whole log is filtered before the window is cut, so the window has no transient of its own. The
    drive may begin with a nonzero force; no fade-in is added.

    Parameters
    ----------
    period : [s] of the controller, 1 ms to 1 s.
    lowpass_hz : cut-off of a 2nd-order Butterworth low-pass [Hz]; None for no low-pass.
    causal : whether both filters run once, forward, as in a live system, from a steady initial state (−3 dB
        at the cut-off, and a delay of about 0.23/lowpass_hz at low frequencies); otherwise they run forward
        and backward, without delay (−6 dB at the cut-off).
    scale, rate_scale : factors on specific force and on angular rate, greater than 0.
    start, duration : window [s] from the first row; it extends to the last row if no duration is given. The
        duration is cut to whole periods.

    Raises
    ------
    InputError : a parameter is not finite or out of bounds, or the window is not within the log or is shorter
        than two periods.
    """
    _within("period", period, 1e-3, 1.0, "s")
    _within("scale", scale, 1e-3, MAX_SCALE, "")
    _within("rate_scale", rate_scale, 1e-3, MAX_SCALE, "")
    fine = period / _oversampling(log, period)
    _within("lowpass_hz", 1.0 if lowpass_hz is None else lowpass_hz, 0.01, 0.45 / fine, "Hz")
    count = _periods(log, period, start, duration)

    k = round(period / fine)
    lead = math.floor(start / fine + 1e-9)  # fine steps from the log's beginning to the window
    tail = max(count * k, math.floor((log.duration - start) / fine + 1e-9))
    grid = start + np.arange(-lead, tail + 1, dtype=np.float64) * fine  # (m,)
    felt = log.felt(grid)  # (m, 6), each channel from its own clock
    if k > 1:
        felt = _lowpass(felt, ANTI_ALIAS_ORDER, ANTI_ALIAS / period, fine, causal)
    if lowpass_hz is not None:
        felt = _lowpass(felt, LOWPASS_ORDER, lowpass_hz, fine, causal)
    window = felt[lead : lead + count * k + 1 : k]  # (count + 1, 6)
    return Scenario(
        name=PurePath(log.source).stem or "log",
        duration=round(count * period, 9),
        specific_force=Sampled(period, scale * window[:, :3]),
        angular_rate=Sampled(period, rate_scale * window[:, 3:]),
        origin=_origin(log, lowpass_hz, causal, scale, start),
    )


def _oversampling(log: Log, period: float) -> int:
    """Return how many fine steps per period make the grid as dense as the fastest channel, within 10 %."""
    fastest = min(1.0 / rate(one) for key, one in log.channels.items() if key in FELT)
    return max(1, math.ceil(period / fastest - 0.1))


def _periods(log: Log, period: float, start: float, duration: float | None) -> int:
    """Return the number of whole periods in the window."""
    last = log.duration
    if not 0.0 <= start < last:
        raise InputError(
            "start", f"{start:g} s", f"at least 0 s and less than {last:g} s, the length of {log.source}"
        )
    rest = last - start
    wanted = rest if duration is None else duration
    if not 0.0 < wanted <= rest + 1e-9:
        bound = f"greater than 0 s and at most {rest:g} s, what {log.source} has from {start:g} s on"
        raise InputError("duration", f"{wanted:g} s", bound)
    count = math.floor(wanted / period + 1e-9)
    if count < 2:
        raise InputError(
            f"length of {log.source}", f"{wanted:g} s", f"at least two periods, {2 * period:g} s"
        )
    return count


def _lowpass(values: Mat, order: int, cutoff: float, dt: float, causal: bool) -> Mat:
    """Apply a Butterworth low-pass along axis 0, forward from a steady state or in both directions."""
    from scipy import signal  # imported here: it takes most of a second, which other runs do not need

    sos = signal.butter(order, cutoff, fs=1.0 / dt, output="sos")
    if not causal:
        pad = min(len(values) - 1, math.ceil(2.0 / (cutoff * dt)))
        return np.asarray(signal.sosfiltfilt(sos, values, axis=0, padlen=pad), dtype=np.float64)
    steady = signal.sosfilt_zi(sos)[:, :, None] * values[0]  # (sections, 2, columns)
    filtered, _ = signal.sosfilt(sos, values, axis=0, zi=steady)
    return np.asarray(filtered, dtype=np.float64)


def _origin(log: Log, lowpass_hz: float | None, causal: bool, scale: float, start: float) -> str:
    parts = [log.source]
    if start > 0.0:
        parts.append(f"from {start:g} s")
    if lowpass_hz is not None:
        parts.append(f"{'causal' if causal else 'zero-phase'} low-pass {lowpass_hz:g} Hz")
    if scale != 1.0:
        parts.append(f"scaled by {scale:g}")
    return ", ".join(parts)


def _within(name: str, value: float, low: float, high: float, unit: str) -> None:
    if not low <= value <= high:
        bound = f"between {low:g} and {high:g} {unit}".strip()
        raise InputError(name, f"{value:g} {unit}".strip(), bound)
