"""Scalars and reductions shared by all parts.

A maximum over many numbers does not vectorise by itself: it is kept in LANES accumulators that are
folded at the end.
"""

from otolith.core.arrays import Vec
from otolith.qp.structured.kernels.kernel_symbols import ACCUMULATOR, INFINITY, LANES, jit_fused

# --- pasted into the generated module ---


@jit_fused
def largest(a: float, b: float) -> float:
    """The larger of two numbers."""
    return a if a > b else b


@jit_fused
def smallest(a: float, b: float) -> float:
    """The smaller of two numbers."""
    return a if a < b else b


@jit_fused
def min_of(g: float, low: float, high: float) -> float:
    """Minimum of g u over low ≤ u ≤ high."""
    return g * high if g < 0.0 else (g * low if g > 0.0 else 0.0)


@jit_fused
def taken(g: float, reach: float, low: float, high: float) -> float:
    """What a row that moves by `reach` with the input takes of its pull g: all of it where no bound does."""
    unbounded = (g < 0.0 and high == INFINITY) or (g > 0.0 and low == -INFINITY)
    return -g / reach if unbounded else 0.0


@jit_fused
def clear_lanes(W: Vec) -> None:
    """Set both groups of accumulators to zero."""
    for j in range(2 * LANES):
        W[ACCUMULATOR + j] = 0.0


@jit_fused
def fold_maximum(W: Vec) -> float:
    """Maximum of the first group."""
    worst = 0.0
    for j in range(LANES):
        worst = largest(worst, W[ACCUMULATOR + j])
    return worst


@jit_fused
def fold_sum(W: Vec) -> float:
    """Sum of the second group."""
    total = 0.0
    for j in range(LANES):
        total += W[ACCUMULATOR + LANES + j]
    return total
