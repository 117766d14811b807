"""Motion as the vestibular organs perceive it."""

from dataclasses import dataclass, field

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.filter import Filter
from otolith.core.lti import StateSpace, diagonal
from otolith.perception import canals, otoliths


def sensing(organ: StateSpace, period: float, *, before: Vec) -> Filter:
    """Return the filter with which `sense` makes the perceived motion (n, k) of a motion (n, k).

    It keeps its state, so a long motion may pass through it in parts.
    """
    organs = diagonal(*[organ] * len(before)).discretise(period, hold="first")
    return Filter(organs).at_rest(before)


def sense(organ: StateSpace, motion: Mat, period: float, *, before: Vec) -> Mat:
    """Return the perceived motion (n, k) of the motion (n, k), which is linear between samples.

    Parameters
    ----------
    organ : a continuous system with one input and one output; each column passes through a copy of it.
    period : [s] between samples.
    before : (k,) the constant motion long before the first sample, which determines the initial state. If the
        first sample differs from it, the motion changes linearly over the preceding period.
    """
    return sensing(organ, period, before=before).simulate(motion)


@dataclass(frozen=True, slots=True, kw_only=True)
class Vestibular:
    """Both kinds of organ; by default Telban & Cardullo's, which the thesis prefers (appendix B.1)."""

    otolith: StateSpace = field(default_factory=otoliths.telban)
    canal: StateSpace = field(default_factory=canals.telban)

    def force(self, force: Mat, period: float, *, before: Vec | None = None) -> Mat:
        """Return the perceived specific force (n, 3) [m/s²] of a force (n, 3) [m/s²]; see `sense`.

        Parameters
        ----------
        before : (3,) zero by default, for a driver at rest on level ground.
        """
        return sense(self.otolith, force, period, before=np.zeros(3) if before is None else before)

    def rate(self, rate: Mat, period: float) -> Mat:
        """Return the perceived angular rate (n, 3) [rad/s] of a rate (n, 3) [rad/s], from standstill."""
        return sense(self.canal, rate, period, before=np.zeros(3))
