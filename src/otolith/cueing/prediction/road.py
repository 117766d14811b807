"""A prediction that is given the forces ahead of it, and believes them as far as they have come true.

Notation, per axis: a(τ) what is foreseen for the time τ ahead, b(τ) what the adaptive prediction says; then

    f̂(τ) = b(τ) + γ (a(τ) − b(τ)),   0 ≤ γ ≤ 1,

and b(τ) beyond the last time that is foreseen. The trust γ is learned by least squares from what came true:
of all moments t in the past, weighted by exp(−age/memory), it minimises
Σ (f(t) − b − γ (a − b))² + ridge (1 − γ)², where a and b were said of t a lead before. So the wrong road, or
a driver who drives otherwise, turns what is foreseen off by itself; until something is known, it is believed.
"""

from dataclasses import dataclass

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError
from otolith.cueing.prediction.adaptive import Adaptive
from otolith.cueing.prediction.simple import now
from otolith.interfaces import Reference
from otolith.safety.stopping import HUGE

_FORCES = 3  # of the six columns; the rates are the adaptive prediction's


@dataclass(frozen=True, slots=True, kw_only=True)
class Road:
    """Parameters of the prediction from `Reference.preview`, which an earlier drive of the road gives.

    Raises
    ------
    InputError : a parameter is beyond its bound.
    """

    time: float = 5.0  # [s] that are foreseen at most
    lead: float = 2.0  # [s] after which what was foreseen is compared with what came true
    memory: float = 20.0  # [s] of the learning
    ridge: float = 0.1  # [m²/s³] of the learning: how much must have come otherwise before it is doubted

    def __post_init__(self) -> None:
        for name, unit in (("time", " s"), ("lead", " s"), ("memory", " s"), ("ridge", " m²/s³")):
            value = getattr(self, name)
            if not 0.0 < value < np.inf:
                raise InputError(f"{name} of the road", f"{value}{unit}", "greater than 0 and finite")
        if not self.lead <= self.time:
            raise InputError("lead of the road", f"{self.lead} s", f"at most its time, {self.time:g} s")

    @property
    def foresees(self) -> float:
        """How far ahead the loop has to say what is coming [s]."""
        return self.time

    def begin(self) -> "RoadPredictor":
        """Make a predictor that has seen nothing yet."""
        return RoadPredictor(self)


class RoadPredictor:
    """The prediction from what is foreseen at work."""

    def __init__(self, parameters: Road) -> None:
        self.parameters = parameters
        self._otherwise = Adaptive().begin()
        self.reset()

    def reset(self) -> None:
        """Forget the past."""
        self._otherwise.reset()
        self._both, self._square = np.zeros(_FORCES), np.zeros(_FORCES)
        self._said: list[tuple[Vec, Vec]] = []  # a − b and b of the coming lead, oldest first

    @property
    def trust(self) -> Vec:
        """γ of each force (3,), between 0 and 1."""
        ridge = self.parameters.ridge
        trust: Vec = np.clip((self._both + ridge) / (self._square + ridge), 0.0, 1.0)
        return trust

    def ahead(self, reference: Reference, dt: float, n: int) -> Mat:
        """Predict what will be wanted at the ends of the next n periods of dt [s], (n, 6)."""
        lead = max(1, round(self.parameters.lead / dt))
        coming = self._otherwise.ahead(reference, dt, max(n, lead))
        foreseen = np.empty((0, _FORCES)) if reference.preview is None else reference.preview
        foreseen = foreseen[: round(self.parameters.time / dt)]
        self._learn(now(reference)[:_FORCES], lead, dt)
        known = min(len(foreseen), len(coming))
        more = np.zeros((len(coming), _FORCES))
        more[:known] = foreseen[:known] - coming[:known, :_FORCES]
        more[~(np.abs(more) <= HUGE)] = 0.0  # what is no number is not foreseen
        self._said.append((more[lead - 1].copy(), coming[lead - 1, :_FORCES].copy()))
        coming[:, :_FORCES] += self.trust * more
        return coming[:n]

    def _learn(self, force: Vec, lead: int, dt: float) -> None:
        """Compare the force (3,) that came true with what was said of it a lead before."""
        if len(self._said) < lead:
            return
        more, otherwise = self._said.pop(0)
        keep, error = np.exp(-dt / self.parameters.memory), force - otherwise
        more, error = (np.where(np.abs(error) <= HUGE, one, 0.0) for one in (more, error))
        self._square = keep * self._square + dt * more * more
        self._both = keep * self._both + dt * more * error
