"""Declarations of what the generated module provides to the kernels, for readers and type checkers.

Each part of the workspace is represented by its offset in the flat vector W, see
`otolith.qp.structured.layout`.
"""

from otolith.core.arrays import Vec
from otolith.core.jit import jit_fused, jit_inlined, jit_inner, kernel

__all__ = ["jit_fused", "jit_inlined", "jit_inner", "kernel"]

N = ROWS = STAGE_ROWS = LANES = HORIZON_ROWS = NUMBERS = INPUTS = NX = START = 0
LOWER = UPPER = SOFT = LO = HI = RHO = VALUE = MULTIPLIER = SET = DIAGONAL = GRADIENT = MARK = EXCESS = (
    PULL
) = 0
REACH = STATE_WEIGHT = STATE_WEIGHTS = 0
HINT = OTHER_SET = OTHER_MULTIPLIER = OFFERED = NEEDED = DOUBTED = 0
DISTANCE = T = LAMBDA = SIGMA = NU = INV_LAMBDA = INV_NU = DELTA = E1 = E2 = SCRATCH = 0
STEP_STATE = ALL_STEPS = 0
U = PLAN = INSIDE = ACCUMULATOR = SETTING = INFO = 0
HUGE = INFINITY = 0.0
GROUPS: tuple[int, ...] = ()
LENGTHS: tuple[int, ...] = ()


def factor(W: Vec, last: int) -> None:
    """See `otolith.qp.structured.emit.factor`, which generates this function."""


def backward(W: Vec, first: int) -> None:
    """See `otolith.qp.structured.emit.backward`, which generates this function."""


def forward(W: Vec) -> None:
    """See `otolith.qp.structured.emit.forward`, which generates this function."""


def end_arcs(W: Vec) -> None:
    """See `otolith.qp.structured.arcs.end_arcs`, which generates this function."""


def condense_blocks(W: Vec) -> None:
    """See `otolith.qp.structured.blocks.condense_blocks`, which generates it; does nothing without blocks."""


def states_within(W: Vec) -> None:
    """See `otolith.qp.structured.blocks.states_within`, which generates it; does nothing without blocks."""


def rollout(W: Vec) -> None:
    """See `otolith.qp.structured.emit.rollout`, which generates this function."""


def stationarity(W: Vec) -> tuple[float, float, float]:
    """See `otolith.qp.structured.emit.stationarity`, which generates this function."""
    raise NotImplementedError


def least_of_rows(W: Vec) -> tuple[float, float]:
    """See `otolith.qp.structured.emit.least_of_rows`, which generates this function."""
    raise NotImplementedError
