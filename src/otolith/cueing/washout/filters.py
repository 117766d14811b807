"""The washouts' filters as linear systems, and a bank that runs many of them at once.

Notation: ω_n natural frequency, ζ damping, ω_b washout frequency, T period.

    translation   H(s) = s² / (s² + 2ζω_n s + ω_n²) · s / (s + ω_b)        eq. 2.2
    rotation      R(s) = s² / (s² + 2ζω_n s + ω_n²)                         eq. 2.4
    tilt          L(s) = ω_n² / (s² + 2ζω_n s + ω_n²)

The numerators printed in eqs. 2.2 and 2.4, ω_n² ω_w and ω_n², belong to low-passes, while the text
asks for high-passes of third and second order: a misprint. In H all three zeros are at s = 0, so that
velocity H/s and travel H/s² return to zero under a constant acceleration, which is what makes the
filter of third order.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from otolith.core.arrays import Vec
from otolith.core.filter import Filter
from otolith.core.lti import StateSpace, diagonal
from otolith.cueing.washout.tuning import SecondOrder, ThirdOrder


def denominator(tuning: SecondOrder) -> list[float]:
    """Coefficients of s² + 2ζω_n s + ω_n², highest power first."""
    return [1.0, 2.0 * tuning.damping * tuning.natural_radps, tuning.natural_radps**2]


def outputs(numerators: Sequence[Sequence[float]], denominator_: Sequence[float]) -> StateSpace:
    """One input, several outputs, one denominator: they share their states."""
    systems = [StateSpace.from_polynomials(numerator, denominator_) for numerator in numerators]
    return replace(systems[0], C=np.vstack([s.C for s in systems]), D=np.vstack([s.D for s in systems]))


def translation(tuning: ThirdOrder) -> StateSpace:
    """From acceleration [m/s²] to the velocity [m/s] of its high-passed part, H(s)/s."""
    third = np.polymul(denominator(tuning), [1.0, tuning.washout_radps])
    return StateSpace.from_polynomials([1.0, 0.0, 0.0], [float(c) for c in third])


def rotation(tuning: SecondOrder) -> StateSpace:
    """From angular rate to its high-passed part, R(s)."""
    return StateSpace.from_polynomials([1.0, 0.0, 0.0], denominator(tuning))


def tilt(tuning: SecondOrder) -> StateSpace:
    """From a signal to its low-passed part and that one's derivative, L(s) and s L(s)."""
    omega2 = tuning.natural_radps**2
    return outputs([[omega2], [omega2, 0.0]], denominator(tuning))


def at_period_ends(system: StateSpace, period: float) -> StateSpace:
    """Discrete system whose output k is the continuous one's at t = (k+1) T, before input k+1 counts.

    Exact for inputs held over the period. A controller needs this value at time k T: where the motion
    should be when its command ends.
    """
    held = system.discretise(period)
    return replace(held, C=held.C @ held.A, D=held.C @ held.B + held.D)


def one_period_late(system: StateSpace, period: float) -> StateSpace:
    """Discrete system whose output k is the continuous one's at t = k T, exact for straight inputs between.

    For filters that pass jumps on: held inputs would have them jump at the end of every period, and what
    stands before the jump is neither the filter's value then nor that of a period ago.
    """
    return system.discretise(period, hold="first")


class Bank:
    """Discrete filters beside each other, each with its own input, run as one system."""

    def __init__(self, systems: Sequence[StateSpace], period: float) -> None:
        empty = replace(StateSpace.gain(np.zeros((0, 0))), period=period)
        self._filter = Filter(diagonal(*systems) if systems else empty)

    def reset(self) -> None:
        """Start from rest."""
        self._filter.reset()

    def step(self, inputs: Vec) -> Vec:
        """All outputs under the present inputs."""
        return self._filter.step(inputs)
