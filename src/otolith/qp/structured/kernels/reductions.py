"""Scalar functions and reductions that all kernels share.

A maximum over many numbers is not vectorised by the compiler. So it is kept in LANES accumulators, which are
combined at the end.
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
    """The part of an input's pull g that is passed to a row which moves by `reach` with the input.

    It is all of g where the input has no bound in that direction, else zero.
    """
    unbounded = (g < 0.0 and high == INFINITY) or (g > 0.0 and low == -INFINITY)
    return -g / reach if unbounded else 0.0


@jit_fused
def clear_lanes(W: Vec) -> None:
    """Set both groups of accumulators to zero."""
    for j in range(2 * LANES):
        W[ACCUMULATOR + j] = 0.0


@jit_fused
def fold_maximum(W: Vec) -> float:
    """Maximum over the first group of accumulators."""
    worst = 0.0
    for j in range(LANES):
        worst = largest(worst, W[ACCUMULATOR + j])
    return worst


@jit_fused
def fold_sum(W: Vec) -> float:
    """Sum over the second group of accumulators."""
    total = 0.0
    for j in range(LANES):
        total += W[ACCUMULATOR + LANES + j]
    return total
