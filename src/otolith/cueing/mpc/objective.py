"""What the MPC tracks: felt quantities, either physical or as the driver's vestibular organs perceive them.

A *channel* is one felt quantity of one degree of freedom: its specific force f = a + g sin(tilt), or an
angular rate. Without an organ the channel is physical. With an organ, a copy of it is part of the prediction,
and what it perceives in the simulator follows what the same organ would perceive in the car.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.frames import GRAVITY, Dof, bases_of
from otolith.core.lti import StateSpace, first_order_hold, zero_order_hold
from otolith.cueing.mpc.motion import ACCELERATION, TILT, TILT_RATE, chains, states
from otolith.perception import Vestibular

FORCE_WEIGHT: Final = 1.0  # weight of the squared error of a force [(m/s²)⁻²]
TILTING_WEIGHT: Final = 0.1  # of a perceived rate that tilting causes and that is unwanted [(rad/s)⁻²]
RATE_WEIGHT: Final = 100.0  # of a wanted rate: (10 m/s)², from the force on a car that turns at 36 km/h


@dataclass(frozen=True, slots=True, kw_only=True)
class Objective:
    """Weights of the squared errors, and whether the errors are of what is perceived."""

    senses: Vestibular | None = None  # None to track physical quantities
    tilts: bool = False  # whether the rate of a tilt is tracked, too, if it is physical
    force: float = FORCE_WEIGHT  # [(m/s²)⁻²]
    tilting: float = TILTING_WEIGHT  # [(rad/s)⁻²], of a tilt's rate where it is tracked
    rate: float = RATE_WEIGHT  # [(rad/s)⁻²]


@dataclass(frozen=True, slots=True, kw_only=True)
class Channel:
    """One felt quantity."""

    of: int  # index of the degree of freedom
    row: Vec  # (states,) linear in its states: g θ for the gravity of a tilt
    weight: float  # weight of the squared error
    organ: StateSpace | None
    is_rate: bool
    index: int  # index among the three specific forces or angular rates
    sign: float = 1.0  # sign of the model's rate relative to the driver's
    tilt: int = -1  # state whose sine gives gravity; -1 for none

    @property
    def column(self) -> int:
        """Return the index of the predictor's column, of six, that this channel follows."""
        return self.index + (3 if self.is_rate else 0)


def channels(dofs: Sequence[Dof], objective: Objective) -> list[Channel]:
    """Return the channels of degrees of freedom, in their order.

    An axis of a base has none of its own if what it carries is among them: both serve one channel.
    """
    return [
        channel
        for p, dof in enumerate(dofs)
        if not (dof.is_base and carried_by(dof, dofs) >= 0)
        for channel in _of_dof(p, dof, objective)
    ]


def carried_by(base: Dof, dofs: Sequence[Dof]) -> int:
    """Return the index of the degree of freedom that an axis of a base carries, or −1."""
    return next((p for p, dof in enumerate(dofs) if bases_of([dof]) == (base,)), -1)


def _of_dof(p: int, dof: Dof, objective: Objective) -> list[Channel]:
    senses, row = objective.senses, np.zeros(len(states(dof)))
    otolith, canal = (None, None) if senses is None else (senses.otolith, senses.canal)
    if dof.feels_rate:
        row[chains(dof)[0].speed] = 1.0
        return [Channel(of=p, row=row, weight=objective.rate, organ=canal, is_rate=True, index=dof.felt)]
    if not dof.is_pair:
        row[chains(dof)[0].acceleration] = 1.0
        return [Channel(of=p, row=row, weight=objective.force, organ=otolith, is_rate=False, index=dof.felt)]
    row[ACCELERATION], row[TILT] = 1.0, GRAVITY
    force = Channel(
        of=p, row=row, weight=objective.force, organ=otolith, is_rate=False, index=dof.felt, tilt=TILT
    )
    if canal is None and not objective.tilts:
        return [force]
    turning = np.zeros(len(row))
    turning[TILT_RATE] = 1.0
    rate = Channel(
        of=p,
        row=turning,
        weight=objective.tilting,
        organ=canal,
        is_rate=True,
        index=dof.rotation - 3,
        sign=dof.sign,
    )
    return [force, rate]


@dataclass(frozen=True, slots=True)
class Organ:
    """An organ in discrete time, for inputs that are held over a period or linear in it."""

    A: Mat  # (n, n)
    B: Vec  # (n,) for a held input
    B0: Vec  # (n,) for a linear input: the value at the beginning of the period
    B1: Vec  # (n,) and the value at its end
    C: Vec  # (n,)
    D: float

    @classmethod
    def of(cls, system: StateSpace, period: float) -> "Organ":
        """Discretise a system of one input and one output, exactly."""
        A, B = zero_order_hold(system.A, system.B, period)
        _, B0, B1 = first_order_hold(system.A, system.B, period)
        return cls(A, B[:, 0], B0[:, 0], B1[:, 0], system.C[0], system.D.item())
