"""What a perceiving MPC moves: axis pairs, and heave and yaw alone; how each is read, limited and felt.

Notation as in `otolith.mpc.model`. A *part* has states x and inputs u of its own; a *channel* is one
quantity that is felt, a row of x (force a + g θ, or rate), which one vestibular organ turns into what
is sensed.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.frames import AXES, GRAVITY, AxisPair
from otolith.core.lti import StateSpace
from otolith.interfaces import PlatformState, Reference
from otolith.mpc.model import (
    ACCELERATION,
    POSITION,
    STATES,
    TILT,
    TILT_RATE,
    VELOCITY,
    BrakingRows,
    Row,
    acceleration_rows,
    braking_rows,
    command_bound,
    implicit_dynamics,
    leading_rows,
    planar_state,
    state_rows,
    terminal_rows,
    time_to_stop,
)
from otolith.perception import Vestibular
from otolith.platforms import AxisLimits, PairLimits, Platform

SPEED, PLACE = range(2)  # states of an axis alone: speed, place, acceleration


@dataclass(frozen=True, slots=True, kw_only=True)
class Channel:
    """One felt quantity."""

    organ: StateSpace
    row: Vec  # (nx,) of the part's states
    weight: float  # of its squared error
    wanted: Callable[[Reference], Vec]  # (K,) over the known future, the present first where it is all


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """One axis pair, or one axis alone."""

    A: Mat  # (nx, nx) continuous
    B: Mat  # (nx, nu)
    rows: tuple[Row, ...]
    names: tuple[str, ...]  # of the states, as washout weights address them
    bounds: Vec  # (nu,) on the commands
    channels: tuple[Channel, ...]
    axes: tuple[int, ...]  # of a six-vector, per input
    signs: tuple[float, ...]  # of the platform's axis against the part's, per input
    speeds: tuple[int, ...]  # states that are the speed along each of them
    places: tuple[int, ...]  # and the place
    read: Callable[[PlatformState], Vec]  # (nx,)
    tilt: int = -1  # state that gives gravity, where there is one


@dataclass(frozen=True, slots=True, kw_only=True)
class PartSettings:
    """What parts depend on beside the platform."""

    lag: float  # [s]
    braking: BrakingRows
    terminal: bool
    force_weight: float
    rate_weight: float
    senses: Vestibular
    period: float  # [s]
    eased: bool = True  # whether the rows of eq. C.2 slow a pair down long before it must stop


def _force(axis: int) -> Callable[[Reference], Vec]:
    def wanted(reference: Reference) -> Vec:
        known = reference.specific_force[None] if reference.preview is None else reference.preview
        return known[:, axis]

    return wanted


def _rate(axis: int, sign: float) -> Callable[[Reference], Vec]:
    return lambda reference: sign * reference.angular_rate[axis : axis + 1]


def pair_part(platform: Platform, limits: PairLimits, pair: AxisPair, settings: PartSettings) -> Part:
    """An axis pair within the limits given, which may be narrower than the platform's own."""
    A, B = implicit_dynamics(settings.lag)
    felt, turning = np.zeros(6), np.zeros(6)
    felt[ACCELERATION], felt[TILT], turning[TILT_RATE] = 1.0, GRAVITY, 1.0
    stopping = settings.braking is BrakingRows.STOPPING
    if stopping:
        rows = leading_rows(limits, platform.braking, lag=settings.lag, period=settings.period)
    else:
        rows = state_rows(limits) + acceleration_rows(limits)
    rows += braking_rows(limits, platform.braking, settings.braking) if settings.eased else []
    rows += terminal_rows(limits) if settings.terminal else []
    return Part(
        A=A,
        B=B,
        rows=tuple(rows),
        names=STATES,
        bounds=np.array([limits.tilt_acceleration, command_bound(limits, settings.braking)]),
        channels=(
            Channel(
                organ=settings.senses.otolith,
                row=felt,
                weight=settings.force_weight,
                wanted=_force(pair.translation),
            ),
            Channel(
                organ=settings.senses.canal,
                row=turning,
                weight=settings.rate_weight,
                wanted=_rate(pair.rotation - 3, pair.sign),
            ),
        ),
        axes=(pair.rotation, pair.translation),
        signs=(pair.sign, 1.0),
        speeds=(TILT_RATE, VELOCITY),
        places=(TILT, POSITION),
        read=lambda state: planar_state(state, pair),
        tilt=TILT,
    )


def single_part(limits: AxisLimits, axis: str, settings: PartSettings) -> Part:
    """Heave, which is felt as a force, or yaw, which is felt as a rate."""
    index, translates = AXES.index(axis), AXES.index(axis) < 3
    A = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0 / settings.lag]])
    unit, T = np.eye(3), settings.lag
    speed = unit[0] + T * unit[2]  # leading, as in `otolith.mpc.model.leading_rows`
    ahead = time_to_stop(limits.position, limits.velocity, limits.acceleration, settings.period)
    rows = (
        Row("velocity", speed + T * unit[2], -limits.velocity, limits.velocity),
        Row("position", unit[1] + T * unit[0] + ahead * speed, *limits.position),
    )
    channel = Channel(
        organ=settings.senses.otolith if translates else settings.senses.canal,
        row=unit[2] if translates else unit[0],
        weight=settings.force_weight if translates else settings.rate_weight,
        wanted=_force(index) if translates else _rate(index - 3, 1.0),
    )
    return Part(
        A=A,
        B=np.array([[0.0], [0.0], [1.0 / settings.lag]]),
        rows=rows,
        names=("velocity", "position", "acceleration"),
        bounds=np.array([limits.acceleration]),
        channels=(channel,),
        axes=(index,),
        signs=(1.0,),
        speeds=(SPEED,),
        places=(PLACE,),
        read=lambda state: np.array([state.twist[index], state.pose[index], state.acceleration[index]]),
    )


def command_of(parts: Sequence[Part], plans: Sequence[Mat]) -> Mat:
    """(K, 6) accelerations of the platform from the parts' inputs (K, nu)."""
    command = np.zeros((len(plans[0]), 6))
    for part, plan in zip(parts, plans, strict=True):
        for i, (axis, sign) in enumerate(zip(part.axes, part.signs, strict=True)):
            command[:, axis] = sign * plan[:, i]
    return command
