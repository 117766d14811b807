"""Otolith organs: from specific force [m/s²] to perceived specific force [m/s²].

Notation (thesis, eq. B.2, and eq. 6.4 for Telban's): k (T_a s + 1) / ((T_L s + 1)(T_S s + 1)). A sustained
force is perceived at k times its size, a quick one at k T_a / T_L, so the initial state matters.
"""

from dataclasses import dataclass

import numpy as np

from otolith.core.lti import StateSpace


@dataclass(frozen=True, slots=True, kw_only=True)
class OtolithParameters:
    """Gain and time constants of eq. B.2."""

    k: float  # steady-state gain
    T_a: float  # [s] time constant of the lead
    T_L: float  # [s] time constant of the long lag
    T_S: float  # [s] time constant of the short lag

    def system(self) -> StateSpace:
        """Return the organ as a continuous system."""
        return StateSpace.from_polynomials(
            [self.k * self.T_a, self.k], np.polymul([self.T_L, 1.0], [self.T_S, 1.0]).tolist()
        )


# Thesis, Table B.3, after Telban & Cardullo (NASA CR-2005-213747) and the review of Asadi et al. (2016).
TELBAN = OtolithParameters(k=0.4, T_a=10.0, T_L=5.0, T_S=0.016)
YOUNG = OtolithParameters(k=0.4, T_a=13.2, T_L=5.3, T_S=0.66)
ORMSBY = OtolithParameters(k=0.4, T_a=10.1, T_L=7.51, T_S=0.51)
# Fitted to direction-detection thresholds: Soyka et al. (2011), doi 10.1007/s00221-010-2523-9, in the
# form given by Nash, Cole & Bigler (2016), doi 10.1007/s00422-016-0682-x.
FROM_THRESHOLDS = OtolithParameters(k=0.0225, T_a=22.05, T_L=0.62, T_S=0.016)


def telban() -> StateSpace:
    """Return Telban & Cardullo's otolith, the thesis's choice (eq. 6.4)."""
    return TELBAN.system()


def young() -> StateSpace:
    """Return Young & Meiry's otolith."""
    return YOUNG.system()


def ormsby() -> StateSpace:
    """Return Ormsby's otolith."""
    return ORMSBY.system()


def from_thresholds() -> StateSpace:
    """Return the otolith that explains measured detection thresholds."""
    return FROM_THRESHOLDS.system()
