"""Settings of the `predictive` algorithm: horizon, prediction, and a washout that scales with the reach.

The thesis holds the reference over half a second. What makes the difference is, in this order: that a force
is assumed to die away, so that a tilt whose rate is limited turns back in time; a horizon of 1.5 s, which
pays only then, in blocks; low washout weights; and the slope, as far as it can be trusted. The figures are
in docs/which-cueing.md.

The washout is the least that brings the platform home. With homing alone, min Σ a² + c ω² v² + ω⁴ s² makes
the place s follow s̈ = −2ζω ṡ − ω² s with 4ζ² = c + 2; c = 0.45 gives ζ = 0.78. The frequency ω is that at
which the platform is called home from the end of its reach S with the acceleration a_h, ω² S = a_h, so that a
small platform needs no other number than a large one. Half-way between the extremes of `liveliness`, a_h is
0.04 m/s², below what is felt (0.05 to 0.1 m/s²). A horizon of 1.5 s sees less of the gain than the regulator
does: the platform comes home in about 10 s, and would in 30 s with c = 5/4. An angle whose rate is tracked
(yaw) goes home as θ̇ = −ω θ, at 2 deg/s from its end.
"""

from collections.abc import Sequence
from dataclasses import replace
from math import radians
from typing import Final

from otolith.core.frames import Dof, pairs_of
from otolith.cueing.mpc.settings import BLOCKS, MpcSettings
from otolith.cueing.mpc.washout_weights import WashoutWeight, constant
from otolith.cueing.prediction.adaptive import Adaptive
from otolith.platforms import Platform

HOMING: Final = 0.0387  # a_h [m/s²] at a liveliness of 1/2
HOMING_RATE: Final = radians(2.0)  # [rad/s] of an angle whose rate is tracked
RANGE: Final = 30.0  # by which liveliness divides or multiplies the square of the homing, at most
DAMPING: Final = 0.45  # c
TILT_RATE: Final = 0.02  # weight on the rate of a tilt [(rad/s)⁻²]: so little that it only settles ties
CONTROL: Final = 3e-5  # R
DERIVED: Final = ("horizon", "blocks", "control_weight", "washout")  # what is not as chosen


def predictive_settings(
    chosen: MpcSettings, platform: Platform, dofs: Sequence[Dof], liveliness: float
) -> MpcSettings:
    """The settings for degrees of freedom that one MPC cues; solver, rows and prediction stay as chosen.

    Parameters
    ----------
    dofs : axis pairs, or one axis of its own.
    liveliness : 0 to 1; more of it spends more travel, and lets the platform come home later.

    Raises
    ------
    InputError : the platform lacks an axis of one of the degrees of freedom.
    """
    return replace(
        chosen,
        horizon=sum(BLOCKS),
        blocks=BLOCKS,
        control_weight=CONTROL,
        washout=_washout(platform, dofs, chosen, RANGE ** (1.0 - 2.0 * liveliness)),
        prediction=chosen.prediction or Adaptive(),
    )


def reach(platform: Platform, dof: Dof) -> float:
    """How far the first axis of a degree of freedom goes to the nearer side [m or rad]."""
    low, high = platform.limits(dof)[0].position
    return min(-low, high)


def _washout(
    platform: Platform, dofs: Sequence[Dof], chosen: MpcSettings, price: float
) -> tuple[WashoutWeight, ...]:
    """Weights on place and speed; `price` multiplies those on the place, its root those on the speed."""
    S = min(reach(platform, dof) for dof in dofs)
    if not pairs_of(dofs) and dofs[0].feels_rate:
        return constant({"position": chosen.objective.rate * price * (HOMING_RATE / S) ** 2})
    if pairs_of(dofs) and len(dofs) > 1 and platform.circle is not None:
        S = min(S, platform.circle)
    square = HOMING / S * price**0.5  # ω²
    weights = {"position": square**2, "velocity": DAMPING * square}
    return constant(weights | ({"tilt_rate": TILT_RATE} if pairs_of(dofs) else {}))
