"""Motion sickness after ISO 2631-1: acceleration weighted with W_f, and its dose.

W_f = H_h H_l H_t H_s with the parameters of ISO 8041 (the same weighting): band limits f₁, f₂ of second order
with Q = 1/√2, the transition f₄, Q₄ with infinite f₃, and the upward step f₅, Q₅ to f₆, Q₆.
"""

import math
from collections.abc import Iterable
from typing import Final

import numpy as np

from otolith.core.arrays import Vec
from otolith.core.filter import Filter
from otolith.core.lti import StateSpace, series

BAND: Final = (0.08, 0.63)  # f₁, f₂ [Hz]
TRANSITION: Final = (0.25, 0.86)  # f₄ [Hz], Q₄
STEP: Final = ((0.0625, 0.80), (0.10, 0.80))  # f₅ [Hz], Q₅; f₆ [Hz], Q₆
ILLNESS: Final = 1.0 / 3.0  # K_m [% per m/s^1.5] for a mixed, unadapted population


def sickness_weighting() -> StateSpace:
    """Return the weighting W_f as a continuous system from acceleration to weighted acceleration [m/s²]."""
    (f5, Q5), (f6, Q6) = STEP
    ratio = (f5 / f6) ** 2
    return series(
        StateSpace.from_polynomials([1.0, 0.0, 0.0], _resonator(BAND[0], math.sqrt(0.5), monic=True)),
        StateSpace.from_polynomials([1.0], _resonator(BAND[1], math.sqrt(0.5))),
        StateSpace.from_polynomials([1.0], _resonator(*TRANSITION)),
        StateSpace.from_polynomials([ratio * c for c in _resonator(f5, Q5)], _resonator(f6, Q6)),
    )


def sickness_dose(acceleration: Vec, period: float) -> float:
    """Return the motion sickness dose value √(∫ a_w² dt) [m/s^1.5].

    ISO 2631-1 defines it for vertical motion. Along other axes it serves by analogy, only to compare runs.
    The filter starts at rest, with zero acceleration before.

    Parameters
    ----------
    acceleration : (n,) [m/s²] sampled with `period` [s].
    """
    return dose_in_parts([np.asarray(acceleration)], period)


def dose_in_parts(acceleration: Iterable[Vec], period: float) -> float:
    """Return the dose of an acceleration that is given in consecutive parts; see `sickness_dose`."""
    weighting, total = Filter(sickness_weighting().discretise(period, hold="first")), 0.0
    for part in acceleration:
        weighted = weighting.simulate(part[:, None])[:, 0]
        total += float(weighted @ weighted)
    return math.sqrt(total * period)


def illness_percent(dose_vertical: float) -> float:
    """Return the share of people who may vomit [%], K_m · MSDV_z with K_m = 1/3 (ISO 2631-1, annex D).

    The formula holds for exposures of 20 minutes to 6 hours. K_m is quoted from general knowledge of the
    standard.
    """
    return ILLNESS * dose_vertical


def _resonator(frequency: float, Q: float, *, monic: bool = False) -> list[float]:
    """Return the coefficients of 1 + s/(Q ω) + (s/ω)², or ω² times that, for ω = 2π · frequency [Hz]."""
    omega = 2.0 * math.pi * frequency
    coefficients = [1.0 / omega**2, 1.0 / (Q * omega), 1.0]
    return [c * omega**2 for c in coefficients] if monic else coefficients
