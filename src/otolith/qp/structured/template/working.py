"""Solve for a given working set, and exchange its rows until the optimality conditions hold.

Every row has a state σ: 0 free, ±1 active at its upper or lower side b, ±2 saturated (soft, violated,
y = ±w). Active rows enter the stage problem as an augmented Lagrangian

    y (r − b) + ½ ρ (r − b)²,        y ← y + ρ (r − b),

saturated ones as ± w r. One factorisation serves all multiplier steps of one working set; each step
shrinks r − b by about 1 / (1 + ρ c), c the row's compliance, so that one or two suffice.

Exchange (primal-dual active set, Hintermüller, Ito & Kunisch, 2002): drop active rows whose sign is
wrong, add free rows that are violated, saturate soft rows whose |y| exceeds w, release saturated ones
that are satisfied; all at once. When the number of changes does not fall, rows are only dropped as
long as there is a wrong sign, which ends the cycles seen in practice; the interior point covers the
rest. Stages after the last change keep their factors.
"""

from otolith.core.arrays import Vec
from otolith.qp.structured.template.given import (
    ACCUMULATOR,
    DIAGONAL,
    GRADIENT,
    HI,
    HINT,
    INFO,
    LANES,
    LO,
    MARK,
    MULTIPLIER,
    OFFERED,
    OTHER_MULTIPLIER,
    OTHER_SET,
    RHO,
    ROWS,
    SET,
    SOFT,
    STAGE_ROWS,
    VALUE,
    N,
    backward,
    factor,
    forward,
    pure,
    woven,
)
from otolith.qp.structured.template.lanes import clear_lanes, fold_maximum, fold_sum, largest

CHANGES = FACTORISATIONS = REFINEMENTS = HINTED = 0

# --- template ---

FAR = 1e6  # bounds beyond this are not imposed; the certificate still sees them
PRIMAL = 1e-9  # a row is violated beyond this, in its own unit
DUAL = 1e-9  # a multiplier has the wrong sign beyond this
GREAT = 500.0  # multipliers above this ask for smaller distances, so that y (r − b) is small too
STEPS = 20  # multiplier steps at most for one working set
PATIENCE = 5  # exchanges without progress that are borne


@pure
def impose(W: Vec) -> None:
    """Write the working set into the stage problem; multipliers of free rows become zero."""
    for i in range(ROWS):
        sigma = W[SET + i]
        active = 1.0 if abs(sigma) == 1.0 else 0.0
        saturated = 1.0 if abs(sigma) == 2.0 else 0.0
        b = W[HI + i] if sigma > 0.0 else W[LO + i]
        rho = active * W[RHO + i]
        y = active * W[MULTIPLIER + i] + 0.5 * saturated * sigma * W[SOFT + i]
        W[MULTIPLIER + i] = y
        W[DIAGONAL + i] = rho
        W[GRADIENT + i] = y - rho * b


@pure
def step_multipliers(W: Vec) -> float:
    """One step y ← y + ρ (r − b) on active rows; the largest |r − b|, times |y| / GREAT above it."""
    clear_lanes(W)
    for block in range(ROWS // LANES):
        for j in range(LANES):
            i = block * LANES + j
            sigma = W[SET + i]
            b = W[HI + i] if sigma > 0.0 else W[LO + i]
            off = W[VALUE + i] - b if abs(sigma) == 1.0 else 0.0
            y = W[MULTIPLIER + i] + W[RHO + i] * off
            W[MULTIPLIER + i] = y
            W[GRADIENT + i] += W[RHO + i] * off
            W[ACCUMULATOR + j] = largest(W[ACCUMULATOR + j], abs(off) * largest(1.0, abs(y) / GREAT))
    return fold_maximum(W)


@pure
def wrong_signs(W: Vec) -> float:
    """Number of active rows whose multiplier points the wrong way."""
    count = 0.0
    for i in range(ROWS):
        sigma = W[SET + i]
        pull = sigma * W[MULTIPLIER + i]
        count += 1.0 if pull < -DUAL else 0.0
    return count


@pure
def exchange_rows(W: Vec, adding: float) -> float:
    """One exchange, without additions when `adding` is 0.0; the number of rows that changed, also in MARK."""
    clear_lanes(W)
    for block in range(ROWS // LANES):
        for j in range(LANES):
            i = block * LANES + j
            sigma, r, y, low, high = W[SET + i], W[VALUE + i], W[MULTIPLIER + i], W[LO + i], W[HI + i]
            above = adding if r > high + PRIMAL else 0.0
            below = adding if r < low - PRIMAL else 0.0
            dropped = -sigma if low == high else 0.0  # an equality changes sides instead
            active = sigma if sigma * y >= -DUAL else dropped
            active = 2.0 * sigma if sigma * y > W[SOFT + i] else active
            b = high if sigma > 0.0 else low
            saturated = sigma if sigma * (r - b) >= -2.0 * PRIMAL else 0.5 * sigma
            new = above - below if sigma == 0.0 else active
            new = saturated if abs(sigma) == 2.0 else new
            change = 1.0 if new != sigma else 0.0
            W[SET + i] = new
            W[MARK + i] = change
            W[ACCUMULATOR + LANES + j] += change
    return fold_sum(W)


@pure
def last_changed_stage(W: Vec) -> int:
    """The last stage with a changed row; there must be one."""
    i = N * STAGE_ROWS - 1
    while W[MARK + i] == 0.0:
        i -= 1
    return i // STAGE_ROWS


@woven
def review(W: Vec, cautious: bool) -> float:
    """Exchange rows at the present point; when cautious, add none while there are wrong signs."""
    adding = 0.0 if cautious and wrong_signs(W) > 0.0 else 1.0
    return exchange_rows(W, adding)


@woven
def refine(W: Vec) -> float:
    """One more multiplier step with the factors at hand."""
    backward(W, 0)
    forward(W)
    W[INFO + REFINEMENTS] += 1.0
    return step_multipliers(W)


@woven
def attempt(W: Vec, last: int, cautious: bool) -> tuple[float, float]:
    """Solve for the set at hand, whose stages after `last` have factors; largest |r − b|, and changes made."""
    impose(W)
    factor(W, last)
    forward(W)
    W[INFO + FACTORISATIONS] += 1.0
    off = step_multipliers(W)
    return off, review(W, cautious)


@pure
def try_hint(W: Vec) -> None:
    """Put the hint in the place of the set, and that aside; sides without a bound are not held."""
    for i in range(ROWS):
        sigma, set_, y = W[HINT + i], W[SET + i], W[MULTIPLIER + i]
        W[OTHER_SET + i], W[OTHER_MULTIPLIER + i] = set_, y
        bound = W[HI + i] if sigma > 0.0 else -W[LO + i]
        sigma = sigma if bound < FAR else 0.0
        W[SET + i] = sigma
        W[MULTIPLIER + i] = y if sigma * y > 0.0 else 0.0


@pure
def give_hint_up(W: Vec) -> None:
    """Take the set back that was put aside; no stage has factors of it any more."""
    for i in range(ROWS):
        W[SET + i], W[MULTIPLIER + i] = W[OTHER_SET + i], W[OTHER_MULTIPLIER + i]
    W[MARK + N * STAGE_ROWS - 1] = 1.0


@woven
def consider_hint(W: Vec, changes: float) -> tuple[float, float]:
    """Try the hint against a set that needs `changes`; what `attempt` says of the one that stays."""
    try_hint(W)
    W[OFFERED] = 0.0
    off, of_hint = attempt(W, N - 1, False)
    if of_hint < changes:
        W[INFO + HINTED] = 1.0
        return off, of_hint
    give_hint_up(W)
    return FAR, changes


@woven
def settle(W: Vec, limit: int, patience: int) -> bool:
    """Exchange from the working set in SET; True when it has settled on a stationary feasible point."""
    last, fewest, stalled = N - 1, 1e9, 0
    for _ in range(limit):
        off, changes = attempt(W, last, stalled > 0)
        if W[OFFERED] > 0.0 and changes > 0.0:
            off, changes = consider_hint(W, changes)
        steps = 0
        while changes == 0.0 and not off < PRIMAL and steps < STEPS:
            off, changes, steps = refine(W), review(W, stalled > 0), steps + 1
        if changes == 0.0:
            return off < PRIMAL
        W[INFO + CHANGES] += changes
        last = last_changed_stage(W)
        if changes < fewest:
            fewest = changes
        else:
            stalled += 1
            if stalled >= patience:
                return False
    return False
