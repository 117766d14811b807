"""A prediction that learns at run time how far the present slope of a force can be trusted.

Notation, per axis: f the present force, f' its slope through a low-pass with time constant T_f, τ the time
ahead;

    f̂(τ) = exp(−τ/T(|f|)) (f + γ s(τ) f'),   s(τ) = T_s (1 − exp(−τ/T_s)),
    T(r) = (T_far + (T_near − T_far) max(0, 1 − r/r_far)) min(1, (r_strong/r)²).

A force decays with T, and faster if it is large: small forces can be produced by tilt and last in practice,
while no platform can sustain large ones, and braking for their end must begin early. A strong force, of hard
braking, leaves a tilt that takes seconds to come down, so the tilt must be small when it ends. The slope
continues for T_s. The trust γ is learned by least squares from past predictions: over all past times t,
weighted by exp(−age/memory), it minimises Σ (f(t) − f(t−h) − γ s(h) f'(t−h))² + ridge γ². The slopes of noise
do not predict anything, so noise reduces the trust by itself; the ridge makes the trust start from zero. The
predictor is causal by construction, because it receives one reference after the other.
"""

from dataclasses import dataclass
from typing import Any, Final, NamedTuple

import numpy as np

from otolith.compiled import PREDICT
from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.errors import InputError
from otolith.core.jit import kernel
from otolith.core.methods import Bound
from otolith.cueing.prediction.simple import NO_PREVIEW, now
from otolith.interfaces import Reference
from otolith.safety.law import HUGE

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
    strong: float = 3.5  # r_strong [m/s²] from which a force is strong
    slope: float = 0.7  # T_s [s] for which a slope continues
    smooth: float = 0.05  # T_f [s] of the slope's low-pass
    lead: float = 0.3  # h [s] after which a prediction is compared with the reference
    memory: float = 8.0  # [s] time constant of the learning
    ridge: float = 0.01  # [m²/s³] regularisation of the learning, which delays trust
    most: float = 1.68  # largest γ
    gain: float = 1.4  # factor on the learned γ: in closed loop a larger γ than the signal's own is best

    def __post_init__(self) -> None:
        for name in ("near", "far", "large", "strong", "slope", "smooth", "lead", "memory", "ridge", "gain"):
            if not 0.0 < getattr(self, name) < np.inf:
                raise InputError(
                    f"{name} of the adaptive prediction", getattr(self, name), "greater than 0 and finite"
                )
        if not 0.0 <= self.most < np.inf:
            raise InputError("most of the adaptive prediction", self.most, "at least 0 and finite")

    @property
    def foresees(self) -> float:
        """Return 0 s, since no future forces are needed."""
        return 0.0

    def begin(self) -> "AdaptivePredictor":
        """Make a predictor without a past."""
        return AdaptivePredictor(self)


class _Memory(NamedTuple):
    """Constants of a predictor and what it has learned, one entry per force."""

    constants: Vec
    seen: Ints  # values so far
    past: Mat  # (lead, 2, 3) a ring buffer of values and slopes
    last: Vec
    slope: Vec
    both: Vec  # sums of the regression
    square: Vec


class AdaptivePredictor:
    """The predictor; `Adaptive` explains its `parameters`."""

    def __init__(self, parameters: Adaptive) -> None:
        self.parameters = parameters
        self._memory = self._sized(1.0)  # made anew when the period is known
        self._method: Bound | None = None

    def reset(self) -> None:
        """Discard the past; the first value then has no slope."""
        for series in self._memory[1:]:
            series[:] = 0

    @property
    def trust(self) -> Vec:
        """Return γ of each force (3,), between 0 and `most`."""
        p, memory = self.parameters, self._memory
        trust: Vec = np.clip(p.gain * memory.both / (memory.square + p.ridge), 0.0, p.most)
        return trust

    def ahead(self, reference: Reference, dt: float, n: int) -> Mat:
        """Predict what will be wanted at the ends of the next n periods of dt [s], (n, 6)."""
        coming = np.empty((n, 6))
        _adapt(self.compiled(dt).held, now(reference), NO_PREVIEW, coming)
        return coming

    def compiled(self, dt: float) -> Bound:
        """Return the method of this predictor; a change of the period dt [s] discards the past."""
        if self._method is None or dt != self._memory.constants[0]:
            self._memory = self._sized(dt)
            self._method = PREDICT.bind(_adapt, self._memory)
        return self._method

    def _sized(self, dt: float) -> "_Memory":
        p = self.parameters
        lead = p.slope * (1.0 - np.exp(-p.lead / p.slope))
        learning = (dt, dt / (p.smooth + dt), np.exp(-dt / p.memory), lead, p.ridge, p.most, p.gain)
        return _Memory(
            np.array([*learning, p.near, p.far, p.large, p.strong, p.slope]),
            np.zeros(_FORCES, dtype=np.int64),
            np.zeros((max(1, round(p.lead / dt)), 2, _FORCES)),
            *(np.zeros(_FORCES) for _ in range(4)),
        )


@kernel
def _adapt(of: Any, value: Vec, preview: Mat, coming: Mat) -> int:  # noqa: ARG001 (the role has it)
    """Learn from the present value (6,), and predict into `coming` (n, 6).

    An implausible value is passed on unchanged and not learned from, because it would be remembered for
    minutes.
    """
    dt, share, keep, lead, ridge, most, gain, near, far, large, strong, lasting = of.constants
    seen, past, last, slope = of.seen, of.past, of.last, of.slope
    both, square = of.both, of.square
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
        T = far + (near - far) * max(0.0, 1.0 - abs(f) / large)
        if abs(f) > strong:
            T *= (strong / f) ** 2
        decay = np.exp(-dt / T)
        fade = np.exp(-dt / lasting)
        level, remaining = 1.0, 1.0
        for k in range(coming.shape[0]):
            level *= decay
            remaining *= fade
            coming[k, i] = level * (f + trust * lasting * (1.0 - remaining) * slope[i])
    return 0
