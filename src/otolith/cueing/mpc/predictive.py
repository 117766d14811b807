"""Settings of the `predictive` algorithm: horizon, prediction, and a washout that scales with the reach.

The thesis holds the reference over half a second. The following changes matter, in this order: forces are
assumed to decay, so that a tilt with limited rate turns back in time; a horizon of 1.5 s in blocks, which is
useful only with that assumption; low washout weights; and the slope, as far as it can be trusted.
docs/which-cueing.md has the figures. Where the coming forces are foreseen, the horizon is 5 s: what lies
beyond 1.5 s shows where to wait for them.

The washout is the least that returns the platform. With homing alone, min Σ a² + c ω² v² + ω⁴ s² makes the
position s follow s̈ = −2ζω ṡ − ω² s with 4ζ² = c + 2; c = 0.45 gives ζ = 0.78. The frequency ω is chosen so
that from the end of its reach S the platform returns with the acceleration a_h, ω² S = a_h, and so one number
serves small and large platforms. Half-way between the extremes of `liveliness`, a_h is 0.04 m/s², below the
threshold of perception (0.05 to 0.1 m/s²). A horizon of 1.5 s sees less of the benefit than the
infinite-horizon regulator: the platform returns in about 10 s, and with c = 5/4 it would take 30 s. An angle
whose rate is tracked (yaw) returns as θ̇ = −ω θ, at 2 deg/s from its end.

A base has weights of its own by its own, larger reach. Of a return that takes half a minute the horizon sees
so little that with this ω a rail of 2.6 m is still half a metre from home a minute after 2 m. With four times
ω² on its position it is home to a millimetre in half a minute. The driver feels less than 0.01 m/s² of it,
since the platform and its tilt act against it, and errors change in the fourth digit
(benchmarks/redundant.py).
"""

from collections.abc import Sequence
from dataclasses import replace
from math import radians
from typing import Final

from otolith.core.frames import Dof, pairs_of
from otolith.cueing.mpc.settings import BLOCKS, FAR_BLOCKS, MpcSettings
from otolith.cueing.mpc.washout_weights import WashoutWeight, constant
from otolith.cueing.prediction.adaptive import Adaptive
from otolith.platforms import Platform

HOMING: Final = 0.0387  # a_h [m/s²] at a liveliness of 1/2
HOMING_RATE: Final = radians(2.0)  # [rad/s] for an angle whose rate is tracked
RETURN: Final = 4.0  # factor on ω² of a base in the weight of its position
RANGE: Final = 30.0  # largest factor by which liveliness changes the square of the homing
DAMPING: Final = 0.45  # c
TILT_RATE: Final = 0.05  # weight on the rate of a tilt [(rad/s)⁻²], small enough to decide only ties
CONTROL: Final = 2e-5  # R
DERIVED: Final = ("horizon", "blocks", "control_weight", "washout")  # settings that this algorithm replaces


def predictive_settings(
    chosen: MpcSettings, platform: Platform, dofs: Sequence[Dof], liveliness: float
) -> MpcSettings:
    """Return the settings for degrees of freedom of one MPC; solver, rows and prediction are kept.

    Parameters
    ----------
    dofs : axis pairs, or a single axis, and the axes of a base that carry them; or axes of a base alone.
    liveliness : 0 to 1; a larger value uses more travel and lets the platform return later.

    Raises
    ------
    InputError : the platform lacks an axis of one of the degrees of freedom.
    """
    prediction = chosen.prediction or Adaptive()
    foresees = any(not dof.feels_rate for dof in dofs) and prediction.foresees / chosen.period > sum(BLOCKS)
    blocks = FAR_BLOCKS if foresees else BLOCKS
    return replace(
        chosen,
        horizon=sum(blocks),
        blocks=blocks,
        control_weight=CONTROL,
        washout=_washout(platform, dofs, chosen, RANGE ** (1.0 - 2.0 * liveliness)),
        prediction=prediction,
    )


def reach(platform: Platform, dof: Dof) -> float:
    """Return how far the first axis of a degree of freedom moves to the nearer side [m or rad]."""
    low, high = platform.limits(dof)[0].position
    return min(-low, high)


def _washout(
    platform: Platform, dofs: Sequence[Dof], chosen: MpcSettings, price: float
) -> tuple[WashoutWeight, ...]:
    """Return weights on position and speed; `price` multiplies those on position, its root those on speed.

    Each axis of a base has weights of its own, by its own reach.
    """
    own = [dof for dof in dofs if not dof.is_base]
    weights = _weights(platform, own, chosen, price) if own else ()
    for dof in (dof for dof in dofs if dof.is_base):
        weights += _weights(platform, [dof], chosen, price)
    return weights


def _weights(
    platform: Platform, dofs: Sequence[Dof], chosen: MpcSettings, price: float
) -> tuple[WashoutWeight, ...]:
    """Return weights of degrees of freedom that share them, or of one axis of a base."""
    base = dofs[0].name if dofs[0].is_base else ""
    S = min(reach(platform, dof) for dof in dofs)
    if not pairs_of(dofs) and dofs[0].feels_rate:
        return constant({"position": chosen.objective.rate * price * (HOMING_RATE / S) ** 2}, base=base)
    if pairs_of(dofs) and len(dofs) > 1 and platform.circle is not None:
        S = min(S, platform.circle)
    more = RETURN if dofs[0].is_base else 1.0
    square = HOMING / S * price**0.5  # ω²
    weights = {"position": (more * square) ** 2, "velocity": DAMPING * square}
    return constant(weights | ({"tilt_rate": TILT_RATE} if pairs_of(dofs) else {}), base=base)
