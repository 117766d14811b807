"""A prediction of what the driver in the car perceives: the organs first, then another prediction.

It is the way of the reference in Khusro et al. (2020), as the thesis describes it (section 2.4.2): forces and
rates in the driver's frame pass the vestibular system of Telban & Cardullo before the controller sees them.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from otolith.core.arrays import Mat
from otolith.core.filter import Filter
from otolith.cueing.prediction.named import Prediction
from otolith.cueing.prediction.simple import now
from otolith.interfaces import Predictor, Reference
from otolith.perception import Vestibular
from otolith.perception.models import sensing
from otolith.safety.law import HUGE


@dataclass(frozen=True, slots=True, kw_only=True)
class Perceived:
    """The prediction `of` what the organs make of a reference."""

    of: Prediction
    organs: Vestibular = field(default_factory=Vestibular)

    @property
    def foresees(self) -> float:
        """Return how far ahead the loop must give forces [s]."""
        return self.of.foresees

    def begin(self) -> "PerceivedPredictor":
        """Make a predictor whose driver has been at rest for long."""
        return PerceivedPredictor(self.of.begin(), self.organs)


class PerceivedPredictor:
    """The predictor; forces that are foreseen pass the organs, too."""

    def __init__(self, of: Predictor, organs: Vestibular) -> None:
        self._of, self._organs = of, organs
        self._period = 0.0  # [s] of the filters, which are made when it is known
        self._otolith: Filter
        self._canal: Filter

    def reset(self) -> None:
        """Discard the past: the driver has been at rest for long."""
        self._period = 0.0
        self._of.reset()

    def ahead(self, reference: Reference, dt: float, n: int) -> Mat:
        """Return what will be perceived at the ends of the next n periods of dt [s], (n, 6).

        An implausible reference is passed on unchanged, because the organs would remember it.
        """
        if not (np.abs(now(reference)) <= HUGE).all():
            return self._of.ahead(reference, dt, n)
        if dt != self._period:
            self._period, still = dt, np.zeros(3)
            self._otolith = sensing(self._organs.otolith, dt, before=still)
            self._canal = sensing(self._organs.canal, dt, before=still)
        force = self._otolith.step(reference.specific_force)
        foreseen, here = None, self._otolith.state
        if reference.preview is not None:
            foreseen = self._otolith.simulate(reference.preview)
            self._otolith.state = here
        felt = replace(
            reference,
            specific_force=force,
            angular_rate=self._canal.step(reference.angular_rate),
            preview=foreseen,
        )
        return self._of.ahead(felt, dt, n)
