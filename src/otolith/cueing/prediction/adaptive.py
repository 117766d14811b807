"""A prediction that learns at run time how far the present slope of a force can be trusted.

Notation, per axis: f the present force, f' its slope through a low-pass with time constant T_f, τ the time
ahead;

    f̂(τ) = exp(−τ/T(|f|)) (f + γ s(τ) f'),   s(τ) = T_s (1 − exp(−τ/T_s)),
    T(r) = T_far + (T_near − T_far) max(0, 1 − r/r_far).

A force decays with T, and faster if it is large: small forces can be produced by tilt and last in practice,
while no platform can sustain large ones, and braking for their end must begin early. The slope continues for
T_s. The trust γ is learned by least squares from past predictions: over all past times t, weighted by
exp(−age/memory), it minimises Σ (f(t) − f(t−h) − γ s(h) f'(t−h))² + ridge γ². The slopes of noise do not
predict anything, so noise reduces the trust by itself; the ridge makes the trust start from zero. The
predictor is causal by construction, because it receives one reference after the other.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.errors import InputError
from otolith.core.jit import kernel
from otolith.cueing.prediction.simple import now
from otolith.interfaces import Reference
from otolith.safety.stopping import HUGE

_FORCES: Final = 3  # number of columns, of six, that are forces; rates are held
_STEEPEST: Final = 8.0  # [m/s³] bound of the slope, so that a jump is not a trend


@dataclass(frozen=True, slots=True, kw_only=True)
class Adaptive:
    """Parameters of the adaptive prediction, found on random references that no published table uses.

    Raises
    ------
    InputError : a parameter is out of bounds.
    """

    near: float = 1.3  # T_near [s] for a force near zero
    far: float = 0.6  # T_far [s] for a large force
    large: float = 1.5  # r_far [m/s²] from which a force is large
    slope: float = 0.35  # T_s [s] for which a slope continues
    smooth: float = 0.1  # T_f [s] of the slope's low-pass
    lead: float = 0.3  # h [s] after which a prediction is compared with the reference
    memory: float = 8.0  # [s] time constant of the learning
    ridge: float = 0.01  # [m²/s³] regularisation of the learning, which delays trust
    most: float = 1.32  # largest γ
    gain: float = 1.1  # factor on the learned γ: in closed loop a slightly larger γ is best

    def __post_init__(self) -> None:
        for name in ("near", "far", "large", "slope", "smooth", "lead", "memory", "ridge", "gain"):
            if not 0.0 < getattr(self, name) < np.inf:
                raise InputError(
                    f"{name} of the adaptive prediction", getattr(self, name), "greater than 0 and finite"
                )
        if not 0.0 <= self.most < np.inf:
            raise InputError("most of the adaptive prediction", self.most, "at least 0 and finite")

    @property
    def foresees(self) -> float:
        """Nothing ahead is needed: 0 s."""
        return 0.0

    def begin(self) -> "AdaptivePredictor":
        """Make a predictor without a past."""
        return AdaptivePredictor(self)


class AdaptivePredictor:
    """The predictor; `Adaptive` explains its `parameters`."""

    def __init__(self, parameters: Adaptive) -> None:
        self.parameters = parameters
        self._dt = 0.0
        self.reset()

    def reset(self) -> None:
        """Discard the past; the first value then has no slope."""
        self._seen = np.zeros(_FORCES, dtype=np.int64)
        self._last, self._slope, self._both, self._square = (np.zeros(_FORCES) for _ in range(4))
        self._past = np.zeros((1, 2, _FORCES))
        self._dt = 0.0  # the ring buffer is made when the period is known

    @property
    def trust(self) -> Vec:
        """Return γ of each force (3,), between 0 and `most`."""
        p = self.parameters
        trust: Vec = np.clip(p.gain * self._both / (self._square + p.ridge), 0.0, p.most)
        return trust

    def ahead(self, reference: Reference, dt: float, n: int) -> Mat:
        """Predict what will be wanted at the ends of the next n periods of dt [s], (n, 6)."""
        if dt != self._dt:
            self._begin(dt)
        coming = np.empty((n, 6))
        value = now(reference)
        _adapt(
            self._constants,
            self._seen,
            self._past,
            self._last,
            self._slope,
            self._both,
            self._square,
            value,
            coming,
        )
        return coming

    def _begin(self, dt: float) -> None:
        p, self._dt = self.parameters, dt
        self._past = np.zeros((max(1, round(p.lead / dt)), 2, _FORCES))
        self._seen[:] = 0
        lead = p.slope * (1.0 - np.exp(-p.lead / p.slope))
        self._constants = np.array(
            [
                dt,
                dt / (p.smooth + dt),
                np.exp(-dt / p.memory),
                lead,
                p.ridge,
                p.most,
                p.gain,
                p.near,
                p.far,
                p.large,
                p.slope,
            ]
        )


@kernel
def _adapt(
    constants: Vec,
    seen: Ints,
    past: Mat,
    last: Vec,
    slope: Vec,
    both: Vec,
    square: Vec,
    value: Vec,
    coming: Mat,
) -> None:
    """Learn from the present value (6,), and predict into `coming` (n, 6).

    An implausible value is passed on unchanged and not learned from, because it would be remembered for
    minutes.

    Parameters
    ----------
    past : (lead, 2, 3) ring buffer of values and slopes.
    """
    dt, share, keep, lead, ridge, most, gain, near, far, large, lasting = constants
    ring = past.shape[0]
    for i in range(6):
        f = value[i]
        if i >= _FORCES or not abs(f) <= HUGE:
            coming[:, i] = f
            continue
        if seen[i] == 0:
            last[i] = f
        rise = min(max((f - last[i]) / dt, -_STEEPEST), _STEEPEST)
        last[i] = f
        slope[i] += share * (rise - slope[i])
        place = seen[i] % ring
        if seen[i] >= ring:
            expected = lead * past[place, 1, i]
            square[i] = keep * square[i] + dt * expected * expected
            both[i] = keep * both[i] + dt * expected * (f - past[place, 0, i])
        past[place, 0, i], past[place, 1, i] = f, slope[i]
        seen[i] += 1
        trust = min(max(gain * both[i] / (square[i] + ridge), 0.0), most)
        decay = np.exp(-dt / (far + (near - far) * max(0.0, 1.0 - abs(f) / large)))
        fade = np.exp(-dt / lasting)
        level, remaining = 1.0, 1.0
        for k in range(coming.shape[0]):
            level *= decay
            remaining *= fade
            coming[k, i] = level * (f + trust * lasting * (1.0 - remaining) * slope[i])
