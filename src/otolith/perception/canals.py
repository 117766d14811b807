"""Semicircular canals: from angular rate [rad/s] to perceived angular rate [rad/s].

Notation (thesis, eq. B.1): T_L T_a s² / ((T_L s + 1)(T_S s + 1)(T_a s + 1)). The canals respond only to
changes of the rate: the perception of a sustained rotation fades away.
"""

from dataclasses import dataclass

import numpy as np

from otolith.core.arrays import Vec
from otolith.core.lti import StateSpace


@dataclass(frozen=True, slots=True, kw_only=True)
class CanalParameters:
    """Time constants of eq. B.1."""

    T_a: float  # [s] time constant of the adaptation
    T_L: float  # [s] time constant of the cupula
    T_S: float = 0.0  # [s] time constant of the short lag

    def system(self) -> StateSpace:
        """Return the organ as a continuous system."""
        lags: Vec = np.ones(1)
        for T in (self.T_L, self.T_S, self.T_a):
            lags = np.polymul(lags, [T, 1.0]).astype(
                np.float64
            )  # T = 0 leaves a leading zero, which drops out
        return StateSpace.from_polynomials([self.T_L * self.T_a, 0.0, 0.0], lags.tolist())


# Thesis, Table B.1, after Telban & Cardullo (NASA CR-2005-213747), Reid & Nahon (UTIAS 296, 1985) and the
# review of Asadi et al. (2017).
TELBAN = CanalParameters(T_a=80.0, T_L=5.73)
REID = CanalParameters(T_a=30.0, T_L=5.3)
YOUNG = CanalParameters(T_a=30.0, T_L=16.0)
ORMSBY = CanalParameters(T_a=30.0, T_L=18.0)


def telban() -> StateSpace:
    """Return Telban & Cardullo's canals."""
    return TELBAN.system()


def reid() -> StateSpace:
    """Return Reid & Nahon's canals."""
    return REID.system()


def young() -> StateSpace:
    """Return Young & Oman's canals."""
    return YOUNG.system()


def ormsby() -> StateSpace:
    """Return Ormsby's canals."""
    return ORMSBY.system()


def from_thresholds() -> StateSpace:
    """Return canals that explain measured detection thresholds of yaw: one high-pass and a lead.

    2.2 s (1 + 0.014 s) / ((1 + 2.16 s)(1 + 0.005 s)): Soyka et al. (2012), doi 10.1007/s00221-012-3120-x, in
    the form of Nash, Cole & Bigler (2016), doi 10.1007/s00422-016-0682-x.
    """
    lags = np.polymul([2.16, 1.0], [0.005, 1.0])
    return StateSpace.from_polynomials([2.2 * 0.014, 2.2, 0.0], lags.tolist())
