"""Series of motion as the vestibular organs pass them on."""

from dataclasses import dataclass, field

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.filter import Filter
from otolith.core.lti import StateSpace, diagonal
from otolith.perception import canals, otoliths


def sense(organ: StateSpace, motion: Mat, period: float, *, before: Vec) -> Mat:
    """Sensed motion (n, k) of the motion (n, k), sampled every `period` [s] and straight in between.

    Parameters
    ----------
    organ : a continuous system with one input and one output; each column passes one of its own.
    before : (k,) the constant motion that was felt for long before the first sample. It decides the
        initial state; a first sample that differs from it is reached over the one period before.
    """
    organs = diagonal(*[organ] * motion.shape[1]).discretise(period, hold="first")
    return Filter(organs).at_rest(before).simulate(motion)


@dataclass(frozen=True, slots=True, kw_only=True)
class Vestibular:
    """Both kinds of organ; by default Telban & Cardullo's, as the thesis prefers (appendix B.1)."""

    otolith: StateSpace = field(default_factory=otoliths.telban)
    canal: StateSpace = field(default_factory=canals.telban)

    def force(self, force: Mat, period: float, *, before: Vec | None = None) -> Mat:
        """Sensed specific force (n, 3) [m/s²] of the force (n, 3) [m/s²]; see `sense`.

        `before` (3,) is zero unless given: a driver at rest on level ground.
        """
        return sense(self.otolith, force, period, before=np.zeros(3) if before is None else before)

    def rate(self, rate: Mat, period: float) -> Mat:
        """Sensed angular rate (n, 3) [rad/s] of the rate (n, 3) [rad/s], from standstill."""
        return sense(self.canal, rate, period, before=np.zeros(3))
