"""The adaptive washout (thesis, section 2.2.3; Parrish et al., 1975; Nahon & Reid, 1990).

This is the classical washout with high-passes whose input gains P adapt, while the tilt's low-pass stays
fixed. Notation: a, q wanted acceleration and rate of an axis, s its travel, P its gain, P₀ = 1; primes are
time derivatives. Per axis

    s'' = P a − 2ζω_n s' − ω_n² s,    rotation R(s) P q,    P' = −K ∂J/∂P within [P_min, P_max],
    2 J = W₁ (a − s'')² + W₃ s'² + W₄ s² + W₇ (P − P₀)²,    for rotations W₂ (q − φ')² + W₈ (P − P₀)².

The derivatives of s and φ with respect to P obey the same filters with the input a or q (as if P were
constant, which is the usual approximation). Eq. 2.6 sums its last term over i = 1, 2 and eq. 2.7 counts i = 1
… 6. Both hold if the sum is over the two gains of one axis pair and the count over all axes, 2 + 2 + 1 + 1.
The pull back to P₀ that the literature adds to eq. 2.7 is the gradient of that last term. The motion is
bounded whatever the adaptation does: it is the output of stable linear filters with inputs bounded by P_max
a.
"""

import numpy as np

from otolith.core.arrays import Vec
from otolith.core.frames import AXES, pairs_of
from otolith.core.lti import StateSpace
from otolith.cueing.washout import tuning as tables
from otolith.cueing.washout.classical import coordinate
from otolith.cueing.washout.feedforward import PERIOD, Demand, Motion, Task, Washout, cued
from otolith.cueing.washout.filters import (
    Bank,
    at_period_ends,
    denominator,
    one_period_late,
    outputs,
    rotation,
    tilt,
)
from otolith.cueing.washout.tuning import SecondOrder

NEUTRAL = 1.0  # P₀


def _travel(tuning: SecondOrder) -> StateSpace:
    """Return the system from acceleration to high-passed travel, velocity and acceleration."""
    return outputs([[1.0], [1.0, 0.0], [1.0, 0.0, 0.0]], denominator(tuning))


class AdaptiveChannels:
    """High-passes with adapting gains, and low-pass tilts."""

    def __init__(self, task: Task, period: float) -> None:
        self._of, mask, self._period = task.tuning.of(tables.Adaptive), cued(task), period
        self._pairs = pairs_of(task.dofs)
        self._moved, self._turned = np.flatnonzero(mask[:3]), np.flatnonzero(mask[3:])
        travels = [at_period_ends(_travel(getattr(self._of, AXES[i])), period) for i in self._moved]
        turns = [one_period_late(rotation(self._of.rotation), period) for _ in self._turned]
        self._travel, self._travel_by_gain = Bank(travels, period), Bank(travels, period)
        self._turn, self._turn_by_gain = Bank(turns, period), Bank(turns, period)
        self._tilt = Bank([at_period_ends(tilt(self._of.tilt), period) for _ in self._pairs], period)
        self.reset()

    def reset(self) -> None:
        """Discard the past; gains become neutral."""
        for bank in (self._travel, self._travel_by_gain, self._turn, self._turn_by_gain, self._tilt):
            bank.reset()
        self.gains, self.rate_gains = (np.full(len(i), NEUTRAL) for i in (self._moved, self._turned))

    def step(self, demand: Demand) -> Motion:
        """Filter one demand and adapt the gains."""
        motion = Motion()
        motion.velocity[self._moved] = self._translate(demand.acceleration_world[self._moved])
        motion.turning[self._turned] = self._rotate(demand.rate_world[self._turned])
        low = np.array([demand.force_driver[pair.translation] for pair in self._pairs])
        coordinate(motion, self._pairs, self._tilt.step(low))
        return motion

    def _translate(self, a: Vec) -> Vec:
        of, P = self._of, self.gains
        s, v, acceleration = self._travel.step(P * a).reshape(-1, 3).T
        s_P, v_P, a_P = self._travel_by_gain.step(a).reshape(-1, 3).T
        slope = -of.force_weight * (a - acceleration) * a_P + of.velocity_weight * v * v_P
        slope += of.position_weight * s * s_P + of.gain_weight * (P - NEUTRAL)
        self.gains = self._adapted(P, of.speed * slope)
        return v

    def _rotate(self, q: Vec) -> Vec:
        of, P = self._of, self.rate_gains
        turning, turning_P = self._turn.step(P * q), self._turn_by_gain.step(q)
        slope = -of.rate_weight * (q - turning) * turning_P + of.gain_weight * (P - NEUTRAL)
        self.rate_gains = self._adapted(P, of.rate_speed * slope)
        return turning

    def _adapted(self, gains: Vec, fall: Vec) -> Vec:
        """Return the gains after one Euler step down the gradient, within the bounds."""
        of = self._of
        return np.clip(gains - self._period * fall, of.least_gain, of.largest_gain)


def adaptive(task: Task) -> Washout:
    """Make the adaptive washout."""
    return Washout(task, AdaptiveChannels(task, PERIOD))
