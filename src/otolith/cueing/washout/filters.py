"""The washouts' filters as linear systems, and a bank that runs many of them together.

Notation: ω_n natural frequency, ζ damping, ω_b washout frequency, T period.

    translation   H(s) = s² / (s² + 2ζω_n s + ω_n²) · s / (s + ω_b)        eq. 2.2
    rotation      R(s) = s² / (s² + 2ζω_n s + ω_n²)                         eq. 2.4
    tilt          L(s) = ω_n² / (s² + 2ζω_n s + ω_n²)

The numerators printed in eqs. 2.2 and 2.4, ω_n² ω_w and ω_n², belong to low-passes, while the text requires
high-passes of third and second order: a misprint. In H all three zeros are at s = 0, so that velocity H/s and
travel H/s² return to zero under a constant acceleration, which is the purpose of a third-order filter.

The states are physical: velocity, travel and its integral of a translation, angle and its integral of a
rotation, rate and angle of a tilt. So a coefficient may change while a filter runs (`Bank.take`): what has
been reached stays, and only how it goes on is different.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple, Self

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.filter import advance
from otolith.core.jit import kernel
from otolith.core.lti import StateSpace, diagonal
from otolith.cueing.washout.tuning import SecondOrder, ThirdOrder


def denominator(tuning: SecondOrder) -> list[float]:
    """Return the coefficients of s² + 2ζω_n s + ω_n², highest power first."""
    return [1.0, 2.0 * tuning.damping * tuning.natural_radps, tuning.natural_radps**2]


def outputs(numerators: Sequence[Sequence[float]], denominator_: Sequence[float]) -> StateSpace:
    """Return a system of one input and several outputs that share one denominator and its states."""
    systems = [StateSpace.from_polynomials(numerator, denominator_) for numerator in numerators]
    return replace(systems[0], C=np.vstack([s.C for s in systems]), D=np.vstack([s.D for s in systems]))


def translation(tuning: ThirdOrder) -> StateSpace:
    """Return the system from acceleration [m/s²] to the velocity [m/s] of its high-passed part, H(s)/s."""
    third = np.polymul(denominator(tuning), [1.0, tuning.washout_radps])
    return StateSpace.from_polynomials([1.0, 0.0, 0.0], [float(c) for c in third])


def rotation(tuning: SecondOrder) -> StateSpace:
    """Return the system from angular rate to its high-passed part, R(s)."""
    return StateSpace.from_polynomials([1.0, 0.0, 0.0], denominator(tuning))


def tilt(tuning: SecondOrder) -> StateSpace:
    """Return the system from a signal to its low-passed part and the derivative of that, L(s) and s L(s)."""
    _, damping, stiffness = denominator(tuning)
    A = np.array([[-damping, -stiffness], [1.0, 0.0]])
    return StateSpace(A=A, B=np.array([[stiffness], [0.0]]), C=np.eye(2)[::-1], D=np.zeros((2, 1)))


def at_period_ends(system: StateSpace, period: float) -> StateSpace:
    """Return a discrete system whose output k is the continuous one at t = (k+1) T, before input k+1 acts.

    It is exact for inputs held over the period. A controller needs this value at time k T: it is where the
    motion should be when its command ends.
    """
    held = system.discretise(period)
    return replace(held, C=held.C @ held.A, D=held.C @ held.B + held.D)


def one_period_late(system: StateSpace, period: float) -> StateSpace:
    """Return a discrete system whose output k is the continuous one at t = k T, exact for linear inputs.

    It suits filters that pass jumps: with held inputs they would jump at the end of every period, and the
    value before the jump would be neither that of the filter then nor that of one period ago.
    """
    return system.discretise(period, hold="first")


class Bank(NamedTuple):
    """Discrete filters in parallel, each with its own input, run as one system in kernels."""

    A: Mat  # (nx, nx)
    B: Mat
    C: Mat
    D: Mat
    x: Vec  # (nx,)
    u: Mat  # (1, nu)
    y: Mat  # (1, ny)

    @classmethod
    def of(cls, systems: Sequence[StateSpace]) -> Self:
        """Combine filters in parallel."""
        s = diagonal(*systems) if systems else StateSpace.gain(np.zeros((0, 0)))
        nx, nu, ny = s.sizes
        A, B, C, D = (np.array(matrix, order="C") for matrix in (s.A, s.B, s.C, s.D))
        return cls(A, B, C, D, np.zeros(nx), np.zeros((1, nu)), np.zeros((1, ny)))

    def take(self, systems: Sequence[StateSpace]) -> None:
        """Go on as other filters of the same orders, from the states that have been reached."""
        s = diagonal(*systems) if systems else StateSpace.gain(np.zeros((0, 0)))
        for matrix, other in zip((self.A, self.B, self.C, self.D), (s.A, s.B, s.C, s.D), strict=True):
            matrix[:] = other

    def reset(self) -> None:
        """Start from rest."""
        self.x[:] = 0.0

    def step(self, inputs: Vec) -> Vec:
        """Return all outputs (ny,) under the present inputs (nu,)."""
        self.u[0] = inputs
        run(self)
        y: Vec = self.y[0].copy()
        return y


@kernel
def run(bank: Bank) -> None:
    """Advance a bank by one sample: from its inputs `u` to its outputs `y`."""
    advance(bank.A, bank.B, bank.C, bank.D, bank.x, bank.u, bank.y)
