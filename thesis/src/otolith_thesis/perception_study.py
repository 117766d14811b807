"""The thesis's study of perception models: Tables B.1 to B.4, figures B.1 to B.3, eqs. B.3 to B.5.

Its numbers agree digit for digit in the following reading, which was found by trial. Samples are 0.05 s
apart. The input is 1 from the sample at 2 s to the one at 15 s, both included, so it is held until 15.05 s.
The run ends at 45 s, and the "final value" is the last sample. The rise time is counted in samples, not in
seconds, and relates to that last value of a few thousandths, so it does not state how fast an organ responds.
In Table B.2 the columns of Young and Ormsby are exchanged, and Young's was computed with a short lag of 0.04
s where Table B.1 prints 0 (`YOUNG_IN_TABLE_B2`).
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Final

import numpy as np
from numpy.polynomial import Polynomial

from otolith.core.arrays import Vec
from otolith.core.filter import Filter
from otolith.core.lti import StateSpace
from otolith.perception import canals, otoliths
from otolith.perception.canals import CanalParameters
from otolith.perception.otoliths import OtolithParameters

PERIOD: Final = 0.05  # [s] sampling period of the thesis
START, END, DURATION = 2.0, 15.0, 45.0  # [s] start and end of the unit step, duration of the run
SETTLED: Final = 0.02  # share of the largest error below which a response has settled
OMEGA: Final = np.logspace(-3.0, 3.0, 301)  # [rad/s]

CANALS: Final[Mapping[str, CanalParameters]] = MappingProxyType(  # Table B.1
    {"telban": canals.TELBAN, "reid": canals.REID, "young": canals.YOUNG, "ormsby": canals.ORMSBY}
)
YOUNG_IN_TABLE_B2: Final = replace(canals.YOUNG, T_S=0.04)
OTOLITHS: Final[Mapping[str, OtolithParameters]] = MappingProxyType(  # Table B.3
    {"telban": otoliths.TELBAN, "young": otoliths.YOUNG, "ormsby": otoliths.ORMSBY}
)


@dataclass(frozen=True, slots=True, kw_only=True)
class StepCharacteristics:
    """The figures of a response in Tables B.2 and B.4."""

    rise_time: float  # [s] from 10 % to 90 % of a value
    settling_time: float  # [s] time from which the error stays within 2 % of its maximum
    minimum: float
    maximum: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Responses:
    """Step response and frequency response of one model in figures B.1 to B.3."""

    time: Vec  # (n,) [s]
    output: Vec  # (n,)
    omega: Vec  # (m,) [rad/s]
    magnitude_db: Vec  # (m,)
    phase_deg: Vec  # (m,) without jumps of 360°


@dataclass(frozen=True, slots=True, kw_only=True)
class Sensitivity:
    """Figure B.3: an otolith with its gain multiplied by a factor, and its sensitivity function."""

    factor: float
    otolith: Responses
    sensitivity: Responses


def table_b2() -> dict[str, StepCharacteristics]:
    """Compute Table B.2 from the parameters of Table B.1, by model; the rise time is in seconds."""
    return {name: in_thesis_reading(model.system()) for name, model in CANALS.items()}


def table_b4() -> dict[str, StepCharacteristics]:
    """Compute Table B.4 from the parameters of Table B.3, by model; the rise time is in seconds."""
    return {name: in_thesis_reading(model.system()) for name, model in OTOLITHS.items()}


def figure_b1() -> dict[str, Responses]:
    """Compute step and frequency responses of the semicircular canals."""
    return {name: responses(model.system()) for name, model in CANALS.items()}


def figure_b2() -> dict[str, Responses]:
    """Compute step and frequency responses of the otoliths."""
    return {name: responses(model.system()) for name, model in OTOLITHS.items()}


def figure_b3(factor: float, model: OtolithParameters = otoliths.TELBAN) -> Sensitivity:
    """Compute the otolith with its gain times `factor`: 0.5 in figure B.3a, probably 1.5 or 2 in B.3b."""
    system = replace(model, k=factor * model.k).system()
    return Sensitivity(factor=factor, otolith=responses(system), sensitivity=responses(sensitivity(system)))


def in_thesis_reading(system: StateSpace) -> StepCharacteristics:
    """Return the characteristics of Tables B.2 and B.4, but with the rise time in seconds.

    The thesis prints the number of samples, 20 times as much.
    """
    time, output = step_response(system, PERIOD, hold_last=True)
    return step_characteristics(time, output, towards=float(output[-1]))


def step_response(system: StateSpace, period: float, *, hold_last: bool = False) -> tuple[Vec, Vec]:
    """Return time and output (n,) for an input of 1 from 2 s to 15 s, exact at the samples.

    Parameters
    ----------
    hold_last : whether the sample at 15 s still has the input 1, which is then held for one more period.
    """
    time: Vec = np.arange(round(DURATION / period) + 1, dtype=np.float64) * period
    last = END + 0.5 * period if hold_last else END - 0.5 * period
    u = np.where((time > START - 0.5 * period) & (time < last), 1.0, 0.0)
    return time, Filter(system.discretise(period)).simulate(u[:, None])[:, 0]


def step_characteristics(time: Vec, output: Vec, *, towards: float) -> StepCharacteristics:
    """Return the characteristics of a sampled response that ends at its settled value.

    Between samples the response is linear.

    Parameters
    ----------
    towards : the value whose 10 % and 90 % bound the rise.
    """
    error = np.abs(output - output[-1])
    within = SETTLED * np.max(error)
    last = int(np.flatnonzero(error > within)[-1])
    return StepCharacteristics(
        rise_time=_first_crossing(time, output, 0.9 * towards) - _first_crossing(time, output, 0.1 * towards),
        settling_time=_crossing(time, error, last, within),
        minimum=float(np.min(output)),
        maximum=float(np.max(output)),
    )


def responses(system: StateSpace, *, period: float = 0.01, omega: Vec = OMEGA) -> Responses:
    """Return the response to a unit step from 2 s to 15 s, and Bode data, of a scalar system."""
    time, output = step_response(system, period)
    response = system.frequency_response(omega)[:, 0, 0]
    return Responses(
        time=time,
        output=output,
        omega=omega,
        magnitude_db=20.0 * np.log10(np.abs(response)),
        phase_deg=np.rad2deg(np.unwrap(np.angle(response))),
    )


def sensitivity(T: StateSpace) -> StateSpace:
    """Return 1 / (1 + T) (eq. B.3), the error u − y of T in unit feedback, for one input and one output."""
    K = 1.0 / (1.0 + T.D)  # (1, 1): e = K (u − C x)
    return replace(T, A=T.A - T.B @ K @ T.C, B=T.B @ K, C=-K @ T.C, D=K)


def sensitivity_extrema(model: OtolithParameters) -> list[tuple[float, float]]:
    """Return frequencies [rad/s] and values where |1 / (1 + T)| of an otolith is stationary (eq. B.5).

    They are exact: with |S|² = n(w) / d(w), w = ω², they are the positive roots of n' d − n d'.
    """
    den = Polynomial([1.0, model.T_S]) * Polynomial([1.0, model.T_L])
    n, d = _squared_modulus(den), _squared_modulus(den + Polynomial([model.k, model.k * model.T_a]))
    w = np.asarray((n.deriv() * d - n * d.deriv()).roots(), dtype=np.complex128)
    real = np.sort(w.real[(np.abs(w.imag) < 1e-9 * np.abs(w)) & (w.real > 0.0)])
    return [(float(np.sqrt(x)), float(np.sqrt(n(x) / d(x)))) for x in real]


def _squared_modulus(p: Polynomial) -> Polynomial:
    """Return |p(jω)|² of p = p₀ + p₁ s + p₂ s² as a polynomial in w = ω²: (p₀ − p₂ w)² + p₁² w."""
    p0, p1, p2 = (float(c) for c in np.asarray(p.coef, dtype=np.float64))
    return Polynomial([p0**2, p1**2 - 2.0 * p0 * p2, p2**2])


def _first_crossing(time: Vec, y: Vec, level: float) -> float:
    """Return the first time at which y passes `level`, in either direction."""
    passes = (y[:-1] - level) * (y[1:] - level) <= 0.0
    return _crossing(time, y, int(np.flatnonzero(passes & (y[:-1] != y[1:]))[0]), level)


def _crossing(time: Vec, y: Vec, k: int, level: float) -> float:
    """Return the time at which the straight line from sample k to the next passes `level`."""
    share = (level - y[k]) / (y[k + 1] - y[k])
    return float(time[k] + share * (time[k + 1] - time[k]))
