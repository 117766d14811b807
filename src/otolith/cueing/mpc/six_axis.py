"""Settings of the `six-axis` algorithm: one MPC over all axes of a hexapod, with its legs' limits as rows.

Horizon, blocks, prediction and the idea of the washout are those of `predictive`: the weights on position and
speed follow from the acceleration with which the platform returns from the end of its reach. The reach is
that of each degree of freedom's own limits, so a large machine is held as loosely, in relation, as a small
one. With one low weight for all, the large workspace that the legs leave would be used up to its edge.

Heave helps the legs to reach, and costs a false vertical force; its weight says how much is accepted.

The reference generator of Khusro et al. (2020), as the thesis describes it (section 2.4.2), is an option for
the nonlinear problem: accelerations and rates follow what Telban's organs perceive in the car, and all other
states have the reference zero. The thesis gives no weights. Here each of the other states weighs, at the end
of its reach, as much as the same small force: that with which the platform returns.
"""

from collections.abc import Sequence
from dataclasses import replace
from enum import StrEnum
from typing import Final

from otolith.core.errors import InputError, one_of
from otolith.core.frames import Dof
from otolith.cueing.mpc.body import Body
from otolith.cueing.mpc.objective import Objective
from otolith.cueing.mpc.predictive import CONTROL, HOMING, HOMING_RATE, RANGE, TILT_RATE, reach
from otolith.cueing.mpc.settings import BLOCKS, MpcSettings
from otolith.cueing.mpc.washout_weights import WashoutWeight, constant
from otolith.cueing.prediction.adaptive import Adaptive
from otolith.cueing.prediction.perceived import Perceived
from otolith.platforms import Platform
from otolith.qp.blocked_engine import BlockedEngine

HEAVE: Final = 0.05  # weight of the squared vertical force [(m/s²)⁻²]; that of the others is 1
YAW: Final = 10.0  # weight of the squared yaw rate [(rad/s)⁻²]
DAMPING: Final = 10.0  # c of `predictive`: slower, since legs leave room for speeds that cannot be kept up
STEPS: Final = 2  # Gauss-Newton steps in a period at most
MISJUDGED: Final = 8e-4  # share of the cost that the first has misjudged, from which a second one is taken


class Generator(StrEnum):
    """Where the references of the states come from."""

    PLAIN = "plain"  # force and yaw rate as they are wanted; tilts are free
    KHUSRO = "khusro"  # forces and rates as they are perceived, all other states zero


def parse_generator(name: str) -> Generator:
    """Return the generator of this name; another name is an InputError that lists the known ones."""
    try:
        return Generator(name)
    except ValueError:
        raise InputError("--generator", repr(name), one_of(Generator, name)) from None


def six_axis_settings(chosen: MpcSettings, generator: Generator = Generator.PLAIN) -> MpcSettings:
    """Return the settings of the MPC; period, lag, braking rows and prediction are kept."""
    prediction, perceived = chosen.prediction or Adaptive(), generator is Generator.KHUSRO
    return replace(
        chosen,
        horizon=sum(BLOCKS),
        blocks=BLOCKS,
        objective=Objective(tilts=perceived),
        control_weight=CONTROL,
        prediction=Perceived(of=prediction) if perceived else prediction,
        iterations=STEPS,
        engine=BlockedEngine,
        washout=(),
        soft={},
    )


def body_of(
    platform: Platform,
    dofs: Sequence[Dof],
    liveliness: float,
    *,
    period: float,
    lag: float,
    generator: Generator = Generator.PLAIN,
) -> Body:
    """Return the platform as one body, with the weights of a liveliness of 0 to 1 as in `predictive`.

    Raises
    ------
    InputError : the platform's file describes no legs, or lacks an axis of one of the degrees of freedom.
    """
    platform.six_legs()
    price = RANGE ** (1.0 - 2.0 * liveliness)
    return Body(
        platform=platform,
        washout={dof.name: _washout(platform, dof, price, generator) for dof in dofs},
        weights={"heave": HEAVE, "yaw": YAW},
        period=period,
        lag=lag,
        settled=MISJUDGED,
    )


def _washout(platform: Platform, dof: Dof, price: float, generator: Generator) -> tuple[WashoutWeight, ...]:
    """Return weights on position and speed; `price` multiplies those on position, its root those on speed."""
    S = reach(platform, dof)
    if dof.feels_rate:
        return constant({"position": YAW * price * (HOMING_RATE / S) ** 2})
    if dof.is_pair and platform.circle is not None:
        S = min(S, platform.circle)
    square, share = HOMING / S * price**0.5, 1.0 if dof.is_pair else HEAVE  # ω², and of its force's weight
    weights = {"position": share * square**2, "velocity": share * DAMPING * square}
    if not dof.is_pair:
        return constant(weights)
    if generator is Generator.PLAIN:
        return constant(weights | {"tilt_rate": TILT_RATE})
    low, high = platform.limits(dof)[1].position
    return constant(weights | {"tilt": price * (HOMING / min(-low, high)) ** 2})
