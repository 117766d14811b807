"""Solve for a given working set, and exchange its rows until the optimality conditions hold.

Every row has a state σ: 0 free, ±1 active at its upper or lower side b, ±2 saturated (soft, violated, y =
±w). Active rows enter the stage problem as an augmented Lagrangian

    y (r − b) + ½ ρ (r − b)²,        y ← y + ρ (r − b),

saturated rows as ± w r. One factorisation serves all multiplier steps of one working set. Each step shrinks r
− b by about 1 / (1 + ρ c), where c is the row's compliance, so one or two steps suffice. Active rows may
nearly depend on each other, as a limit and its braking rows do on an arc of contact; then a combination of
them has next to no compliance, and a step leaves a part q ≈ 1 of it. The remaining steps, q + q² + … = q / (1
− q), are then taken at once (Aitken, 1926). The steps end when y (r − b) is small: with G the sum of these
gaps, ½ (u − u*)ᵀ R (u − u*) ≤ G bounds how far the inputs are from the optimum.

The exchange (primal-dual active set, Hintermüller, Ito & Kunisch, 2002) drops active rows with the wrong
sign, adds free rows that are violated, saturates soft rows whose |y| exceeds w, and releases saturated rows
that are satisfied, all at once. When the number of changes does not fall, the exchange has *stalled*: from
then on rows with wrong signs are dropped first, and where a row is violated at several consecutive stages,
only the worst violation is added, since on an arc of contact the rows of neighbouring stages can replace each
other; if one row would enter and one would leave, the entering one is added alone. This ends the cycles seen
in practice; the interior point covers the remaining ones. Stages after the last change keep their factors.

An arc of contact is first taken too long, because all violated rows are added. Its end then holds the plan
back with a wrong sign, and once it is dropped, most of that multiplier passes on to its neighbour, which had
the right sign: dropping wrong signs alone, an arc would shrink by one stage per factorisation. So the wrong
pull is passed on at once, row by row inwards, and all rows are dropped whose own pull does not make up for
it (`end_arcs`). The share of 0.8 fits what was measured: of a dropped tilt-rate row the next one takes 0.7,
those after it 0.15 together. A row that is dropped too much is violated at the next point and returns. Only
the first exchanges pass pulls on, so that those that follow end cycles as described above.
"""

from otolith.core.arrays import Vec
from otolith.qp.structured.kernels.kernel_symbols import (
    ACCUMULATOR,
    DIAGONAL,
    DOUBTED,
    EXCESS,
    GRADIENT,
    GROUPS,
    HI,
    HINT,
    INFINITY,
    INFO,
    LANES,
    LENGTHS,
    LO,
    MARK,
    MULTIPLIER,
    OTHER_MULTIPLIER,
    OTHER_SET,
    PULL,
    RHO,
    ROWS,
    SET,
    SOFT,
    STAGE_ROWS,
    VALUE,
    N,
    backward,
    end_arcs,
    factor,
    forward,
    jit_fused,
    jit_inlined,
    jit_inner,
)
from otolith.qp.structured.kernels.reductions import clear_lanes, fold_maximum, fold_sum, largest, smallest

CHANGES = FACTORISATIONS = REFINEMENTS = HINTED = 0

# --- pasted into the generated module ---

FAR = 1e6  # bounds beyond this value are not imposed; the certificate still checks them
PRIMAL = 1e-9  # a row is violated when it is further outside, in its own unit
DUAL = 1e-9  # a multiplier has the wrong sign when it is further on the wrong side of zero
GREAT = 500.0  # for larger multipliers the distance must be smaller in proportion for the set to settle
STEPS = 20  # largest number of multiplier steps for one working set
FORESEEN = 100.0  # largest number of remaining steps that are taken at once
SLOW = 0.05  # remaining steps are taken at once when a step leaves more than this part of the distances
SHARE = 0.0 if LENGTHS else 0.8  # part of a wrong pull that the next row takes; blocks have unequal rows
RESTING = 1e12  # pull of rows that are not dropped, whatever their neighbours pass on
EARLY = 3  # exchanges after the first that pass wrong pulls on; later ones could only prolong a cycle
STUCK = 1e9  # number of changes that is reported for a set that does not converge


@jit_fused
def impose(W: Vec) -> None:
    """Write the working set into the stage problem; multipliers of free rows become zero."""
    for i in range(ROWS):
        sigma, low, high = W[SET + i], W[LO + i], W[HI + i]
        active = 1.0 if abs(sigma) == 1.0 else 0.0
        saturated = 1.0 if abs(sigma) == 2.0 else 0.0
        b = high if sigma > 0.0 else low
        rho = active * W[RHO + i]
        y = active * W[MULTIPLIER + i] + 0.5 * saturated * sigma * W[SOFT + i]
        W[MULTIPLIER + i] = y
        W[DIAGONAL + i] = rho
        W[GRADIENT + i] = y - rho * b


@jit_fused
def step_multipliers(W: Vec) -> float:
    """Take one step y ← y + ρ (r − b) on active rows; return the largest |r − b| max(1, |y|)."""
    clear_lanes(W)
    for block in range(ROWS // LANES):
        for j in range(LANES):
            i = block * LANES + j
            sigma, r, low, high = W[SET + i], W[VALUE + i], W[LO + i], W[HI + i]
            b = high if sigma > 0.0 else low
            off = r - b if abs(sigma) == 1.0 else 0.0
            y = W[MULTIPLIER + i] + W[RHO + i] * off
            W[MULTIPLIER + i] = y
            W[GRADIENT + i] += W[RHO + i] * off
            W[ACCUMULATOR + j] = largest(W[ACCUMULATOR + j], abs(off) * largest(1.0, abs(y)))
    return fold_maximum(W)


@jit_fused
def foresee(W: Vec, factor: float) -> None:
    """Extrapolate: repeat `factor` times the step that the multipliers of active rows have just made."""
    for i in range(ROWS):
        sigma, r, low, high = W[SET + i], W[VALUE + i], W[LO + i], W[HI + i]
        b = high if sigma > 0.0 else low
        step = factor * W[RHO + i] * (r - b) if abs(sigma) == 1.0 else 0.0
        W[MULTIPLIER + i] += step
        W[GRADIENT + i] += step


@jit_fused
def met(W: Vec) -> bool:
    """True when active rows are at their sides; the larger a multiplier, the closer its row must be."""
    worst = 0.0
    for i in range(ROWS):
        sigma, r, low, high = W[SET + i], W[VALUE + i], W[LO + i], W[HI + i]
        off = r - high if sigma > 0.0 else r - low
        off = abs(off) * largest(1.0, abs(W[MULTIPLIER + i]) / GREAT)
        worst = largest(worst, off if abs(sigma) == 1.0 else 0.0)
    return worst < PRIMAL


@jit_fused
def find_violations(W: Vec) -> float:
    """Write to EXCESS how far free rows are outside their bounds, set MARK to 1 there; return their
    number.
    """
    clear_lanes(W)
    for block in range(ROWS // LANES):
        for j in range(LANES):
            i = block * LANES + j
            sigma, r, low, high = W[SET + i], W[VALUE + i], W[LO + i], W[HI + i]
            excess = largest(r - high, low - r)
            out = 1.0 if sigma == 0.0 and excess > PRIMAL else 0.0
            W[EXCESS + i] = out * excess
            W[MARK + i] = out
            W[ACCUMULATOR + LANES + j] += out
    return fold_sum(W)


@jit_fused
def keep_peaks(W: Vec) -> None:
    """Unmark a violation if the same row is further outside at a neighbouring stage."""
    for i in range((N - 1) * STAGE_ROWS):
        here, next_ = W[EXCESS + i], W[EXCESS + STAGE_ROWS + i]
        W[MARK + i] = 0.0 if here <= next_ else W[MARK + i]
        W[MARK + STAGE_ROWS + i] = 0.0 if next_ < here else W[MARK + STAGE_ROWS + i]


@jit_fused
def wrong_signs(W: Vec) -> float:
    """Count the active rows whose multiplier has the wrong sign."""
    count = 0.0
    for i in range(ROWS):
        pull = W[SET + i] * W[MULTIPLIER + i]
        count += 1.0 if pull < -DUAL else 0.0
    return count


@jit_fused
def find_pulls(W: Vec) -> None:
    """Write to EXCESS the pull σ y of all active inequalities, and RESTING for all other rows."""
    for i in range(ROWS):
        sigma = W[SET + i]
        held = abs(sigma) == 1.0 and W[LO + i] < W[HI + i]
        W[EXCESS + i] = sigma * W[MULTIPLIER + i] if held else RESTING


@jit_fused
def exchange_rows(W: Vec, adding: float, dropping: float, passing: float) -> float:
    """Add the marked rows, drop those with wrong signs and those at their ends of arcs (PULL); MARK then
    marks the changes, the result counts them.
    """
    clear_lanes(W)
    for block in range(ROWS // LANES):
        for j in range(LANES):
            i = block * LANES + j
            sigma, r, y, low, high = W[SET + i], W[VALUE + i], W[MULTIPLIER + i], W[LO + i], W[HI + i]
            added = adding * W[MARK + i] * (1.0 if r > high else -1.0)
            turned = -sigma if low == high else (1.0 - dropping) * sigma  # an equality changes sides
            stays = sigma * y >= -DUAL and passing * W[PULL + i] >= -DUAL
            active = sigma if stays else turned
            active = 2.0 * sigma if sigma * y > W[SOFT + i] else active
            b = high if sigma > 0.0 else low
            saturated = sigma if sigma * (r - b) >= -2.0 * PRIMAL else 0.5 * sigma
            new = added if sigma == 0.0 else active
            new = saturated if abs(sigma) == 2.0 else new
            change = 1.0 if new != sigma else 0.0
            W[SET + i] = new
            W[MARK + i] = change
            W[ACCUMULATOR + LANES + j] += change
    return fold_sum(W)


@jit_fused
def last_changed_stage(W: Vec) -> int:
    """Return the last stage with a changed row; there must be one."""
    i = N * STAGE_ROWS - 1
    while W[MARK + i] == 0.0:
        i -= 1
    return i // STAGE_ROWS


@jit_inlined
def review(W: Vec, stalled: bool, passing: bool) -> float:
    """Exchange rows at the current point, as the module's docstring describes; return the number of
    changes.
    """
    violated, wrong = find_violations(W), wrong_signs(W)
    if stalled:
        keep_peaks(W)
    adding = dropping = 1.0
    if wrong == 0.0 or (stalled and violated == 1.0 and wrong == 1.0):
        dropping = 0.0
    elif stalled:
        adding = 0.0
    if passing and dropping > 0.0:
        find_pulls(W)
        end_arcs(W)
        return exchange_rows(W, adding, dropping, 1.0)
    return exchange_rows(W, adding, dropping, 0.0)


@jit_inlined
def refine(W: Vec) -> float:
    """Take one more multiplier step with the existing factors."""
    backward(W, 0)
    forward(W)
    W[INFO + REFINEMENTS] += 1.0
    return step_multipliers(W)


@jit_inlined
def attempt(W: Vec, last: int, stalled: bool, passing: bool) -> float:
    """Solve for the current set, reusing the factors of the stages after `last`, and exchange its rows.

    Returns the number of changes: zero when the set has settled, STUCK when its multipliers do not converge.
    """
    impose(W)
    factor(W, last)
    forward(W)
    W[INFO + FACTORISATIONS] += 1.0
    off, before, steps = step_multipliers(W), INFINITY, 0
    changes = review(W, stalled, passing)
    while changes == 0.0 and not off < PRIMAL and steps < STEPS:
        left, before = off / before, off
        if SLOW < left < 1.0:
            foresee(W, smallest(left / (1.0 - left), FORESEEN))
            before = INFINITY
        off, changes, steps = refine(W), review(W, stalled, passing), steps + 1
    return changes if changes > 0.0 or off < PRIMAL or met(W) else STUCK


@jit_inner
def attempt_all(W: Vec) -> float:
    """Attempt the current set with new factors of all stages, in one copy that all who begin so share."""
    return attempt(W, N - 1, False, True)


@jit_fused
def try_hint(W: Vec) -> None:
    """Replace the current set by the hint, in the groups of rows where the set was changed, and save the old
    one.

    Sides without a bound are not held.
    """
    for g in range(STAGE_ROWS):
        W[DOUBTED + g] = 0.0
    for i in range(N * STAGE_ROWS):
        W[DOUBTED + GROUPS[i % STAGE_ROWS]] += W[MARK + i]
    for i in range(ROWS):
        set_, y = W[SET + i], W[MULTIPLIER + i]
        sigma = W[HINT + i] if W[DOUBTED + GROUPS[i % STAGE_ROWS]] > 0.0 else set_
        W[OTHER_SET + i], W[OTHER_MULTIPLIER + i] = set_, y
        bound = W[HI + i] if sigma > 0.0 else -W[LO + i]
        sigma = sigma if bound < FAR else 0.0
        W[SET + i] = sigma
        W[MULTIPLIER + i] = y if sigma * y > 0.0 else 0.0


@jit_fused
def give_hint_up(W: Vec) -> None:
    """Restore the set that was saved; its factors are no longer valid at any stage."""
    for i in range(ROWS):
        W[SET + i], W[MULTIPLIER + i] = W[OTHER_SET + i], W[OTHER_MULTIPLIER + i]
    W[MARK + N * STAGE_ROWS - 1] = 1.0


@jit_inlined
def consider_hint(W: Vec, changes: float) -> float:
    """Try the hint instead of a set that needs `changes`; return how many changes the better of the two
    needs.
    """
    try_hint(W)
    of_hint = attempt_all(W)
    if of_hint < changes:
        W[INFO + HINTED] = 1.0
        return of_hint
    give_hint_up(W)
    return changes


@jit_inner
def settle(W: Vec, changes: float, limit: int) -> None:
    """Continue from a set that needs `changes` until one settles, at most `limit` of them.

    The first set counts towards the limit. The point of a settled set is stationary and feasible; the
    certificate shows whether it was found.
    """
    fewest, stalled, early = changes, False, EARLY
    while 0.0 < changes < STUCK and limit > 1:
        W[INFO + CHANGES] += changes
        changes = attempt(W, last_changed_stage(W), stalled, early > 0)
        stalled = stalled or changes >= fewest
        fewest, limit, early = changes, limit - 1, early - 1
