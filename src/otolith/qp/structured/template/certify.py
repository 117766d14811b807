"""Judge data and answers. Strict arithmetic: nothing here may take a NaN for a number.

A maximum forgets NaN; so every test is written to *accept* (`x < limit`), and acceptances are counted.
"""

from otolith.core.arrays import Vec
from otolith.qp.structured.template.given import (
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
    ROWS,
    SOFT,
    STAGE_ROWS,
    START,
    UPPER,
    VALUE,
    kernel,
    least_of_rows,
    rollout,
    stationarity,
    woven,
)
from otolith.qp.structured.template.lanes import clear_lanes, fold_maximum, largest, smallest
from otolith.qp.structured.template.working import FAR

# --- template ---

HARD = 1e9  # penalties from here on mean that the row is hard
PROOF = 1e-9  # relative margin by which infeasibility must be proved


@kernel
def well_posed(W: Vec) -> bool:
    """True when all numbers are finite, no bound is NaN, and lower ≤ upper; sets the bounds in use."""
    good = 0
    for i in range(NUMBERS):
        good += 1 if abs(W[i]) < HUGE else 0
    for i in range(ROWS):
        good += 1 if W[LOWER + i] <= W[UPPER + i] else 0
        good += 1 if W[SOFT + i] > 0.0 else 0
        W[LO + i] = largest(W[LOWER + i], -FAR)
        W[HI + i] = smallest(W[UPPER + i], FAR)
    return good == NUMBERS + 2 * ROWS


@kernel
def judge_rows(W: Vec) -> float:
    """The rows' part of the certificate: `otolith.qp.problem.row_residual`, infinity if not finite."""
    good = 0
    clear_lanes(W)
    for block in range(ROWS // LANES):
        for j in range(LANES):
            i = block * LANES + j
            r, y, w = W[VALUE + i], W[MULTIPLIER + i], W[SOFT + i]
            above, below = r - W[UPPER + i], W[LOWER + i] - r
            side = -above if y > 0.0 else -below
            held = abs(y) * largest(side, 0.0) if y != 0.0 else 0.0
            violation = largest(largest(above, below), 0.0)
            unpaid = w - y if above > 0.0 else w + y
            hard = violation * largest(abs(y), 1.0)
            soft = largest(violation * abs(unpaid), abs(y) - w)
            bad = largest(held, hard if w >= HARD else soft)
            good += 1 if abs(r) < HUGE and abs(y) < HUGE and bad < HUGE else 0
            W[ACCUMULATOR + j] = largest(W[ACCUMULATOR + j], bad)
    worst = fold_maximum(W)
    return worst if good == ROWS else INFINITY


@woven
def certificate(W: Vec) -> float:
    """`otolith.qp.stage.stage_residual` of U and MULTIPLIER, from the inputs alone."""
    rollout(W)
    for i in range(ROWS):
        W[GRADIENT + i] = W[MULTIPLIER + i]
    of_rows = judge_rows(W)
    of_inputs = stationarity(W)
    return of_rows if of_inputs <= of_rows else of_inputs


@kernel
def impossible(W: Vec) -> bool:
    """True when the multipliers prove that no inputs within their bounds satisfy the hard rows.

    For any y, Σ y r ≤ Σ y⁺ u − y⁻ l at a feasible point; so when already the least value of Σ y r over
    the inputs' box exceeds that, there is none. y is tried with the soft rows' and inputs' part removed, and
    with what points to sides without bound; pivot rows take the part of inputs without bounds. The proof
    must exceed PROOF times the sizes of all that was added and taken away, or it is rounding.
    """
    weight = 0.0  # of all y, also of those that pivots cancel: what is left of them is rounding
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
