"""What the generated module provides to the kernels; declared here for readers and type checkers.

A part of the workspace is known by its offset in the flat vector W, see `otolith.qp.structured.layout`.
"""

from otolith.core.arrays import Vec
from otolith.core.jit import jit_fused, jit_inlined, kernel

__all__ = ["jit_fused", "jit_inlined", "kernel"]

N = ROWS = STAGE_ROWS = LANES = HORIZON_ROWS = NUMBERS = INPUTS = NX = START = 0
LOWER = UPPER = SOFT = LO = HI = RHO = VALUE = MULTIPLIER = SET = DIAGONAL = GRADIENT = MARK = EXCESS = 0
REACH = STATE_WEIGHT = STATE_WEIGHTS = 0
HINT = OTHER_SET = OTHER_MULTIPLIER = OFFERED = NEEDED = DOUBTED = 0
DISTANCE = T = LAMBDA = SIGMA = NU = INV_LAMBDA = INV_NU = DELTA = E1 = E2 = SCRATCH = 0
STEP_STATE = ALL_STEPS = 0
U = PLAN = ACCUMULATOR = SETTING = INFO = 0
HUGE = INFINITY = 0.0
GROUPS: tuple[int, ...] = ()


def factor(W: Vec, last: int) -> None:
    """`otolith.qp.structured.emit.factor`."""


def backward(W: Vec, first: int) -> None:
    """`otolith.qp.structured.emit.backward`."""


def forward(W: Vec) -> None:
    """`otolith.qp.structured.emit.forward`."""


def condense_blocks(W: Vec) -> None:
    """`otolith.qp.structured.blocks.condense_blocks`; nothing where the stages are steps."""


def states_within(W: Vec) -> None:
    """`otolith.qp.structured.blocks.states_within`; nothing where the stages are steps."""


def rollout(W: Vec) -> None:
    """`otolith.qp.structured.emit.rollout`."""


def stationarity(W: Vec) -> tuple[float, float, float]:
    """`otolith.qp.structured.emit.stationarity`."""
    raise NotImplementedError


def least_of_rows(W: Vec) -> tuple[float, float]:
    """`otolith.qp.structured.emit.least_of_rows`."""
    raise NotImplementedError
