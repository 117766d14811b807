"""What should be felt now, and soon, from samples of telemetry: an observer, a preview, and a fade.

*Observer.* Level x and slope s of every wanted channel follow the samples z by an alpha-beta filter whose two
poles are equal (Benedict & Bordner, 1962, with critical damping): with θ = exp(−Δ/τ) and the residual
r = z − (x + s Δ),

    x ← x + s Δ + (1 − θ²) r,    s ← s + (1 − θ)² r / Δ,    τ = 25 ms.

*Preview.* x + s h for h up to 40 ms from the sample, then held. It brings the motion 20 to 25 ms nearer to
the vehicle than holding; its price is noise.

*Fade.* The reference is multiplied by a weight that falls to zero in 0.5 s where telemetry is bad, and rises
along a cosine in 2 s after engaging, and in 1 s after a disturbance. Two streams of poses are never blended:
the algorithm always decides from where the platform is.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.interfaces import Reference

TIME_CONSTANT: Final = 25e-3  # τ [s]
CLIPPED: Final = 40e-3  # [s] from the last sample to the end of the preview
FADE_OUT: Final = 0.5  # [s] to zero
FADE_IN: Final = 2.0  # [s] after engaging
BLEND_BACK: Final = 1.0  # [s] after a disturbance
HELD: Final = 30e-3  # [s] age of the last sample from which it decays …
DECAY: Final = 0.25  # [s] … with this time constant
_LONGEST: Final = 0.1  # [s] between two samples from which the observer starts anew


class Observer:
    """Level and slope of six channels: wanted specific force (3,) [m/s²] and angular rate (3,) [rad/s]."""

    def __init__(self) -> None:
        self._level, self._slope = np.zeros(6), np.zeros(6)
        self._time_ns: int | None = None

    def reset(self) -> None:
        """Forget all samples."""
        self._level[:] = self._slope[:] = 0.0
        self._time_ns = None

    def sample(self, now_ns: int, wanted: Vec) -> None:
        """Take in one sample (6,) that arrived now."""
        since = math.inf if self._time_ns is None else 1e-9 * (now_ns - self._time_ns)
        if since <= 0.0:
            return
        self._time_ns = now_ns
        if since > _LONGEST:
            self._level[:], self._slope[:] = wanted, 0.0
            return
        theta = math.exp(-since / TIME_CONSTANT)
        self._level += since * self._slope
        residual = wanted - self._level
        self._level += (1.0 - theta * theta) * residual
        self._slope += (1.0 - theta) ** 2 / since * residual

    def wanted(self, now_ns: int, ahead: float = 0.0) -> Vec:
        """Return the six channels as they are expected `ahead` seconds from now."""
        if self._time_ns is None:
            return np.zeros(6)
        age = 1e-9 * (now_ns - self._time_ns)
        decayed = math.exp(-max(0.0, age - HELD) / DECAY)
        wanted: Vec = decayed * (self._level + min(age + ahead, CLIPPED) * self._slope)
        return wanted


class Fader:
    """The weight of the reference between 0 and 1; it never jumps.

    Its phase runs evenly, down in `FADE_OUT` and up in the time asked for; the weight is a cosine of it.
    """

    def __init__(self) -> None:
        self._phase = 0.0

    def reset(self) -> None:
        """Start from zero."""
        self._phase = 0.0

    def step(self, dt: float, *, up: bool, rise: float) -> float:
        """Go on by dt [s], up within `rise` [s] or down, and return the weight."""
        self._phase += dt / rise if up else -dt / FADE_OUT
        self._phase = min(1.0, max(0.0, self._phase))
        return 0.5 - 0.5 * math.cos(math.pi * self._phase)


def clipped(wanted: Vec, largest: float) -> Vec:
    """Return wanted channels (6,) whose specific force is at most `largest` [m/s²], in its own direction."""
    force = float(np.linalg.norm(wanted[:3]))
    if force <= largest:
        return wanted
    return np.concatenate([wanted[:3] * (largest / force), wanted[3:]])


@dataclass(frozen=True, slots=True, kw_only=True)
class Cued:
    """How much of what is wanted is cued."""

    scale: float = 1.0  # of force and rate
    largest: float = 12.0  # [m/s²] force that is cued at most, after scaling; a crash is a crash, not a cue
    steps: int = 0  # number of future periods for which a preview is given


def reference(observer: Observer, now_ns: int, cued: Cued, *, weight: float, period: float) -> Reference:
    """Return the reference for a decision now.

    Parameters
    ----------
    weight : of the fade.
    period : [s] of the algorithm.
    """

    def at(ahead: float) -> Vec:
        return weight * clipped(cued.scale * observer.wanted(now_ns, ahead), cued.largest)

    now = at(0.0)
    preview: Mat | None = None
    if cued.steps > 0:
        preview = np.array([at((k + 1) * period)[:3] for k in range(cued.steps)])
    return Reference(specific_force=now[:3], angular_rate=now[3:], preview=preview)
