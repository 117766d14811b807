"""Washout weights: how strongly an MPC pulls the platform home, by the name of the state.

A weight multiplies the square of one state in the stage cost. It is a polynomial of the present magnitude of
a state, W = w₁ + w₂ r + w₃ r² + w₄ r⁴ with r = |state| / w₅ (thesis, eq. 4.12), and is held over the horizon;
constant weights have w₂ = w₃ = w₄ = 0.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi
from typing import Final

from otolith.core.arrays import Vec
from otolith.core.errors import InputError, one_of
from otolith.core.frames import Dof
from otolith.cueing.mpc.motion import STATES, states

# Least and largest weight in the cost. Between them the cost keeps its digits beside the force that is
# tracked, whose weight is 1; far beyond, at 1e20, no engine can certify an answer any more.
WEIGHTS: Final = (1e-12, 1e12)
_WEIGHTED: Final = STATES[:4]


@dataclass(frozen=True, slots=True, kw_only=True)
class WashoutWeight:
    """Weight on the square of state `on` that grows with the magnitude of state `of`."""

    on: str  # a name of otolith.cueing.mpc.motion.STATES, SI units in the cost
    of: str
    coefficients: tuple[float, float, float, float]  # w₁ … w₄, for r⁰, r¹, r², r⁴
    scale: float  # w₅, magnitude of `of` at which r = 1, SI units
    base: str = ""  # name of the only axis of a base that it weighs; else all but those of a base

    def weighs(self, dof: Dof) -> bool:
        """Return whether the weight is for a degree of freedom, which has both states."""
        return self.base == (dof.name if dof.is_base else "") and {self.on, self.of} <= set(states(dof))

    def at(self, x: Vec) -> float:
        """Return the weight at state x (6,)."""
        w1, w2, w3, w4 = self.coefficients
        r = abs(x[STATES.index(self.of)]) / self.scale
        return float(w1 + w2 * r + w3 * r**2 + w4 * r**4)


_POSITION_POLYNOMIAL: Final = (0.01, 20.0, 20.0, 20.0)  # eq. 4.12, with w₅ = 0.5 m
_TILT_RATE_POLYNOMIAL: Final = (0.0001, 0.7, 0.7, 0.7)  # eq. 4.12, with w₅ = 3 deg/s
_W5_POSITION: Final = 0.5  # [m]
_W5_TILT_RATE: Final = 3.0 * pi / 180.0  # [rad/s]


def check_weight(name: str, weight: float, *, otherwise: str = "") -> None:
    """Refuse a weight outside `WEIGHTS`; the error names it `name`, and its bound begins with `otherwise`."""
    least, largest = WEIGHTS
    if not least <= weight <= largest:
        raise InputError(name, f"{weight:g}", f"{otherwise}from {least:g} to {largest:g}")


def constant(weights: Mapping[str, float], *, base: str = "") -> tuple[WashoutWeight, ...]:
    """Return constant weights by state name, e.g. {"tilt_rate": 0.001, "position": 0.9} (Table 5.3).

    Parameters
    ----------
    base : as of `WashoutWeight`.

    Raises
    ------
    InputError : an unknown state, or a weight other than 0 that is outside `WEIGHTS`.
    """
    for state, weight in weights.items():
        if state not in _WEIGHTED:
            raise InputError("weight", repr(state), "on " + one_of(_WEIGHTED, state))
        if weight != 0.0:
            check_weight(f"weight {state}", weight, otherwise="0, or ")
    return tuple(
        WashoutWeight(on=state, of=state, coefficients=(weight, 0.0, 0.0, 0.0), scale=1.0, base=base)
        for state, weight in weights.items()
    )


PRESETS: Final[dict[str, tuple[WashoutWeight, ...]]] = {
    # Eqs. 4.12 and 4.13 as printed: tilt rate and position.
    "printed": (
        WashoutWeight(
            on="tilt_rate", of="tilt_rate", coefficients=_TILT_RATE_POLYNOMIAL, scale=_W5_TILT_RATE
        ),
        WashoutWeight(on="position", of="position", coefficients=_POSITION_POLYNOMIAL, scale=_W5_POSITION),
    ),
    # The reading that comes closest to the thesis's tables: the first weight acts on the velocity,
    # as if the state order of the generated solver differed from the one that eq. 4.13 assumes.
    "thesis-fit": (
        WashoutWeight(on="velocity", of="tilt_rate", coefficients=_TILT_RATE_POLYNOMIAL, scale=_W5_TILT_RATE),
        WashoutWeight(on="position", of="position", coefficients=_POSITION_POLYNOMIAL, scale=_W5_POSITION),
    ),
    "none": (),
    # Constant weights for all signals of Table 5.3 together; the hand-tuned table has a pair for each:
    # the best of `otolith tune --on STATES --evaluations 26` (objective: `otolith.tuning`), in both readings.
    "constant-fit": constant({"velocity": 0.411, "position": 0.0131}),  # J = -1.667
    "constant-printed": constant({"tilt_rate": 0.00339, "position": 10.2}),  # J = -1.325
}


def preset(name: str) -> tuple[WashoutWeight, ...]:
    """Look up one of `PRESETS`, or refuse an unknown name with a list of those that exist.

    Raises
    ------
    InputError : there is no such preset.
    """
    if name not in PRESETS:
        raise InputError("washout", repr(name), one_of(PRESETS, name))
    return PRESETS[name]
