"""The settings of an MPC, apart from the platform and the degrees of freedom that it cues."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Final

import numpy as np

from otolith.core.errors import InputError, one_of
from otolith.core.frames import Dof
from otolith.cueing.mpc.objective import Objective
from otolith.cueing.mpc.rows import BrakingRows
from otolith.cueing.mpc.washout_weights import PRESETS, WashoutWeight, check_weight
from otolith.cueing.prediction.named import Prediction
from otolith.platforms import Platform
from otolith.qp.blocked import Lengths
from otolith.qp.engines import StageEngine, StructuredEngine
from otolith.safety.invariant.axis import LEAST_LAG

HORIZON: Final = 50  # the thesis's N
LONGEST: Final = 1_000  # steps of a horizon; the condensed matrices of 4 DOF then take 0.4 GB
PERIODS: Final = (1e-4, 1.0)  # [s] shortest and longest time between two decisions
BLOCKS: Final = (1, 1, 2, 7, 12, 20, 28, 36, 43)  # 1.5 s in nine inputs
# 5 s in fourteen inputs, for a future that is foreseen
FAR_BLOCKS: Final = (1, 1, 2, 6, 10, 20, 30, 40, 50, 60, 70, 70, 70, 70)


class Entry(StrEnum):
    """How a guess of the controls enters the MPC."""

    REFERENCE = "reference"  # eq. 3.1 as printed, the guess is u_ref of the cost: changes the optimum
    PRIMAL = "primal"  # linearise about the guess: changes the iterations, hardly the result
    WORKING_SET = "working-set"  # start from its active rows: changes the iterations, never the result


def check_period(name: str, period: float) -> None:
    """Refuse a time between two decisions [s] that is outside `PERIODS`; the error names it `name`."""
    shortest, longest = PERIODS
    if not shortest <= period <= longest:
        raise InputError(name, f"{period:g} s", f"from {shortest:g} to {longest:g} s")


def parse_entry(name: str) -> Entry:
    """Return the entry of this name; another name is an InputError that lists the known ones."""
    try:
        return Entry(name)
    except ValueError:
        raise InputError("guess entry", repr(name), one_of(Entry, name)) from None


@dataclass(frozen=True, slots=True, kw_only=True)
class MpcSettings:
    """Horizon, weights, rows and solver of the MPC; the defaults are the thesis's, with adaptive washout.

    Raises
    ------
    InputError : a value is beyond its bound.
    """

    horizon: int = HORIZON  # N
    period: float = 0.01  # [s]
    # [s] between commanded and actual acceleration; None: that of the platform's file
    lag: float | None = None
    objective: Objective = field(default_factory=Objective)
    control_weight: float = 1e-3  # R
    washout: tuple[WashoutWeight, ...] = PRESETS["thesis-fit"]
    braking: BrakingRows = BrakingRows.STOPPING
    terminal: bool = False  # whether the last hard node lies in the axes' sets; with leading rows all do
    soft: Mapping[str, float] = field(default_factory=dict)  # penalty by row name: {"tilt_rate": 100.0}
    blocks: Lengths = ()  # steps of each block of constant inputs, N in total; empty: every step is a block
    firm: int = 2  # number of first blocks whose rows are hard, unless `soft` names them
    later_penalty: float = 1e3  # penalty of rows at the ends of all other blocks, which are soft
    linear: bool = False  # whether the gravity of a tilt θ is g θ throughout the prediction
    prediction: Prediction | None = None  # of what is wanted; None: the default of the algorithm, mostly hold
    iterations: int = 1  # largest number of Gauss-Newton steps per period; 1: real-time iteration
    tolerance: float = 1e-6  # largest certificate of a solution that is accepted
    engine: Callable[..., StageEngine] = StructuredEngine

    def __post_init__(self) -> None:
        if not 2 <= self.horizon <= LONGEST:
            raise InputError("implicit horizon", self.horizon, f"from 2 to {LONGEST:,} steps")
        if self.iterations < 1:
            raise InputError("iterations", self.iterations, "at least 1 per period")
        check_period("period", self.period)
        for name in ("lag", "tolerance"):
            value = getattr(self, name)
            if value is not None and not 0.0 < value < np.inf:
                raise InputError(name, value, "finite and greater than 0")
        check_weight("control_weight", self.control_weight)
        for name, penalty in self.soft.items():
            check_weight(f"penalty of {name}", penalty)
        self._check_blocks()

    def _check_blocks(self) -> None:
        if self.blocks and (min(self.blocks) < 1 or sum(self.blocks) != self.horizon):
            given = ",".join(map(str, self.blocks))
            raise InputError("blocks", given, f"of at least 1 step each, {self.horizon} in sum")
        if self.firm < 1:
            raise InputError("firm blocks", self.firm, "at least 1, for the next node")
        if self.terminal and self.blocks and max(self.blocks[: self.firm]) > 1:
            given = ",".join(map(str, self.blocks))
            raise InputError("blocks", given, "of one step each where firm, next to terminal rows")
        if not self.later_penalty > 0.0:
            raise InputError("later penalty", self.later_penalty, "greater than 0")

    @property
    def hard_steps(self) -> int:
        """Return the number of steps until the last node with hard rows: N, or those of the firm blocks."""
        return sum(self.blocks[: self.firm]) or self.horizon

    @property
    def lengths(self) -> Lengths:
        """Return the number of steps of each block of constant inputs; without blocks, one each."""
        return self.blocks or (1,) * self.horizon

    def lag_on(self, platform: Platform) -> float:
        """Return the lag T [s] of the model on a platform, which is at least `LEAST_LAG`."""
        return max(platform.actuators.lag_s, LEAST_LAG) if self.lag is None else self.lag

    def lag_of(self, platform: Platform, dof: Dof) -> float:
        """Return the lag T [s] of a degree of freedom; a base has one of its own."""
        return platform.base.lag_s if dof.is_base and platform.base is not None else self.lag_on(platform)
