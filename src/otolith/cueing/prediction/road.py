"""A prediction that receives the coming forces and trusts them as far as they have come true.

Notation, per axis: a(τ) is the force foreseen for the time τ ahead, b(τ) the force of the adaptive
prediction. The result is

    f̂(τ) = b(τ) + γ (a(τ) − b(τ)),   0 ≤ γ ≤ 1,

and b(τ) beyond the last time that is foreseen. The trust γ is learned by least squares. Over all past moments
t, weighted by exp(−age/memory), it minimises Σ (f(t) − b − γ (a − b))² + ridge (1 − γ)², where a and b were
predicted for t one lead earlier. So the foreseen forces lose their influence on the wrong road, or with a
driver who drives differently. Until there is evidence, they are trusted.
"""

from dataclasses import dataclass

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError
from otolith.cueing.prediction.adaptive import Adaptive
from otolith.cueing.prediction.simple import now
from otolith.interfaces import Reference
from otolith.safety.law import HUGE

_FORCES = 3  # of the six columns; the rates are those of the adaptive prediction


@dataclass(frozen=True, slots=True, kw_only=True)
class Road:
    """Parameters of the prediction from `Reference.preview`, which an earlier drive of the road gives.

    Raises
    ------
    InputError : a parameter is beyond its bound.
    """

    time: float = 5.0  # [s] longest time that is foreseen
    lead: float = 2.0  # [s] after which what was foreseen is compared with what came true
    memory: float = 20.0  # [s] time constant of the learning
    ridge: float = 0.1  # [m²/s³] of the learning; the larger, the more evidence it takes to lower the trust

    def __post_init__(self) -> None:
        for name, unit in (("time", " s"), ("lead", " s"), ("memory", " s"), ("ridge", " m²/s³")):
            value = getattr(self, name)
            if not 0.0 < value < np.inf:
                raise InputError(f"{name} of the road", f"{value}{unit}", "greater than 0 and finite")
        if not self.lead <= self.time:
            raise InputError("lead of the road", f"{self.lead} s", f"at most its time, {self.time:g} s")

    @property
    def foresees(self) -> float:
        """Return how far ahead the loop must give forces [s]."""
        return self.time

    def begin(self) -> "RoadPredictor":
        """Return a predictor without a past."""
        return RoadPredictor(self)


class RoadPredictor:
    """A predictor at work, which learns how far to trust the foreseen forces."""

    def __init__(self, parameters: Road) -> None:
        self.parameters = parameters
        self._adaptive = Adaptive().begin()
        self.reset()

    def reset(self) -> None:
        """Forget the past."""
        self._adaptive.reset()
        self._both, self._square = np.zeros(_FORCES), np.zeros(_FORCES)
        self._predicted: list[tuple[Vec, Vec]] = []  # a − b and b of the coming lead, oldest first

    @property
    def trust(self) -> Vec:
        """Return γ of each force (3,), between 0 and 1."""
        ridge = self.parameters.ridge
        trust: Vec = np.clip((self._both + ridge) / (self._square + ridge), 0.0, 1.0)
        return trust

    def ahead(self, reference: Reference, dt: float, n: int) -> Mat:
        """Predict what will be wanted at the ends of the next n periods of dt [s], (n, 6)."""
        lead = max(1, round(self.parameters.lead / dt))
        coming = self._adaptive.ahead(reference, dt, max(n, lead))
        foreseen = np.empty((0, _FORCES)) if reference.preview is None else reference.preview
        foreseen = foreseen[: round(self.parameters.time / dt)]
        self._learn(now(reference)[:_FORCES], lead, dt)
        known = min(len(foreseen), len(coming))
        difference = np.zeros((len(coming), _FORCES))
        difference[:known] = foreseen[:known] - coming[:known, :_FORCES]
        difference[~(np.abs(difference) <= HUGE)] = 0.0  # a value that is not a number is not foreseen
        self._predicted.append((difference[lead - 1].copy(), coming[lead - 1, :_FORCES].copy()))
        coming[:, :_FORCES] += self.trust * difference
        return coming[:n]

    def _learn(self, force: Vec, lead: int, dt: float) -> None:
        """Compare the force (3,) that came true with what was predicted for it one lead earlier."""
        if len(self._predicted) < lead:
            return
        difference, adaptive = self._predicted.pop(0)
        keep, error = np.exp(-dt / self.parameters.memory), force - adaptive
        difference, error = (np.where(np.abs(error) <= HUGE, one, 0.0) for one in (difference, error))
        self._square = keep * self._square + dt * difference * difference
        self._both = keep * self._both + dt * difference * error
