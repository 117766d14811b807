"""Judge data and answers. The arithmetic is strict: a NaN must never pass for a number.

A maximum ignores NaN. So every test is written to *accept* (`x < limit`), and acceptances are counted.
"""

from otolith.core.arrays import Vec
from otolith.qp.structured.kernels.kernel_symbols import (
    ACCUMULATOR,
    GRADIENT,
    HI,
    HUGE,
    INFINITY,
    INPUTS,
    LANES,
    LO,
    LOWER,
    MULTIPLIER,
    NUMBERS,
    NX,
    REACH,
    ROWS,
    SOFT,
    STAGE_ROWS,
    START,
    STATE_WEIGHT,
    STATE_WEIGHTS,
    UPPER,
    VALUE,
    N,
    jit_fused,
    jit_inlined,
    kernel,
    least_of_rows,
    rollout,
    stationarity,
)
from otolith.qp.structured.kernels.reductions import clear_lanes, fold_maximum, largest, smallest
from otolith.qp.structured.kernels.working import FAR

# --- pasted into the generated module ---

HARD = 1e9  # penalties from this value on mean that the row is hard
PROOF = 1e-9  # relative margin by which infeasibility must be proved


@kernel
def well_posed(W: Vec) -> bool:
    """Check a problem: numbers finite, weights not negative, lower ≤ upper. Sets the bounds that are used."""
    good = 0
    for i in range(NUMBERS):
        good += 1 if abs(W[i]) < HUGE else 0
    for i in range(STATE_WEIGHTS):
        good += 1 if W[STATE_WEIGHT + i] >= 0.0 else 0
    for i in range(ROWS):
        good += 1 if W[LOWER + i] <= W[UPPER + i] else 0
        good += 1 if W[SOFT + i] > 0.0 else 0
        W[LO + i] = largest(W[LOWER + i], -FAR)
        W[HI + i] = smallest(W[UPPER + i], FAR)
    return good == NUMBERS + STATE_WEIGHTS + 2 * ROWS


@jit_fused
def reach_of_rows(W: Vec) -> None:
    """Compute the largest |value| of each row over all stages; zero for the padding."""
    for r in range(STAGE_ROWS):
        W[REACH + r] = 0.0
    for k in range(N):
        for r in range(STAGE_ROWS):
            W[REACH + r] = largest(W[REACH + r], abs(W[VALUE + k * STAGE_ROWS + r]))
    for k in range(1, N):
        for r in range(STAGE_ROWS):
            W[REACH + k * STAGE_ROWS + r] = W[REACH + r]


@kernel
def judge_rows(W: Vec, whole: float) -> float:
    """Compute the rows' part of the certificate, as `otolith.qp.relative.row_residual`; infinite if not
    finite.

    Multipliers are judged relative to `whole`, see `otolith.qp.stage.stage_residual`.
    """
    good = 0
    reach_of_rows(W)
    clear_lanes(W)
    for block in range(ROWS // LANES):
        for j in range(LANES):
            i = block * LANES + j
            r, y, w, low, high = W[VALUE + i], W[MULTIPLIER + i], W[SOFT + i], W[LOWER + i], W[UPPER + i]
            size_above, size_below = W[REACH + i] + abs(high), W[REACH + i] + abs(low)
            above, below = r - high, low - r
            violation = largest(above, below)
            violation = violation / (size_above if above > below else size_below) if violation > 0.0 else 0.0
            size, gap = (size_above, -above) if y > 0.0 else (size_below, -below)
            pull = abs(y)
            idle = smallest(largest(gap, 0.0) / size, pull * size / whole) if y != 0.0 else 0.0
            unpaid = smallest(violation, abs(w - (y if above > 0.0 else -y)) / w)
            soft = largest(unpaid, (pull - w) / w)
            bad = largest(idle, violation if w >= HARD else soft)
            good += 1 if abs(r) < HUGE and pull < HUGE and bad < HUGE and idle < HUGE else 0
            W[ACCUMULATOR + j] = largest(W[ACCUMULATOR + j], bad)
    worst = fold_maximum(W)
    return worst if good == ROWS else INFINITY


@jit_inlined
def certificate(W: Vec) -> float:
    """Compute `otolith.qp.stage.stage_residual` of U and MULTIPLIER, starting from the inputs alone."""
    rollout(W)
    for i in range(ROWS):
        W[GRADIENT + i] = W[MULTIPLIER + i]
    _, of_inputs, whole = stationarity(W)
    of_rows = judge_rows(W, whole)
    return of_rows if of_inputs <= of_rows else of_inputs


@kernel
def impossible(W: Vec) -> bool:
    """True when the multipliers prove that no inputs within their bounds satisfy the hard rows.

    For any y, Σ y r ≤ Σ y⁺ u − y⁻ l holds at a feasible point. If even the least value of Σ y r over the
    inputs' box exceeds the right-hand side, no feasible point exists. The y that is tried omits soft rows,
    inputs, and multipliers that point to sides without a bound; pivot rows take the share of inputs without
    bounds. The proof must exceed PROOF times the sizes of all terms added and removed; otherwise it could be
    rounding.
    """
    weight = 0.0  # sum over all y, including those that pivots cancel, since these leave rounding errors
    size = 0.0
    for i in range(ROWS):
        y = W[MULTIPLIER + i]
        of_input = i % STAGE_ROWS >= STAGE_ROWS - INPUTS
        b = W[UPPER + i] if y > 0.0 else W[LOWER + i]
        y = 0.0 if of_input or W[SOFT + i] < HARD or not abs(b) < FAR else y
        W[GRADIENT + i] = y
        weight += abs(y)
        size += abs(y) * largest(1.0, abs(b)) if y != 0.0 else 0.0
    least, size_of_inputs = least_of_rows(W)
    most = 0.0
    for i in range(ROWS):
        y = W[GRADIENT + i]
        b = W[UPPER + i] if y > 0.0 else W[LOWER + i]
        if y != 0.0:
            most += y * b if W[SOFT + i] >= HARD else INFINITY
            weight += abs(y)
            size += abs(y) * largest(1.0, abs(b))
    for i in range(NX):
        size += weight * abs(W[START + i])
    return least > most + PROOF * (size + size_of_inputs)
