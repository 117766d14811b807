"""One call per problem: check, try the working set at hand, exchange, fall back, certify.

The minimiser never depends on the working set that is tried first; the time does. Where a hint can be had
on request, `solve` returns ASKING when the set at hand does not settle at once, and is called again with
the answer (reverse communication): a hint that is not needed is never made.
"""

from otolith.core.arrays import Vec
from otolith.qp.structured.kernels.certify import certificate, impossible, well_posed
from otolith.qp.structured.kernels.interior import CLOSE, CLOSER, approach, enter, guess_from_sides
from otolith.qp.structured.kernels.kernel_symbols import (
    INFO,
    INPUTS,
    MULTIPLIER,
    NEEDED,
    OFFERED,
    PLAN,
    ROWS,
    SET,
    SETTING,
    N,
    U,
    condense_blocks,
    jit_inlined,
    kernel,
    rollout,
    states_within,
)
from otolith.qp.structured.kernels.working import STUCK, attempt, consider_hint, settle

STATUS = RESIDUAL = CHANGES = FACTORISATIONS = REFINEMENTS = ITERATIONS = HINTED = 0
TOLERANCE = EXCHANGES = POLISH = ITERATION_LIMIT = 0
OPTIMAL = INFEASIBLE = LIMIT = INVALID = ASKING = UNDECIDED = 0
ON_REQUEST = REFUSED = GIVEN = 0

# --- pasted into the generated module ---

ATTEMPTS = 3  # interior points, each closer, that a working set is guessed from


@kernel
def forget(W: Vec) -> None:
    """Forget working set, multipliers and plan."""
    for i in range(ROWS):
        W[SET + i] = 0.0
        W[MULTIPLIER + i] = 0.0
    for i in range(N * INPUTS):
        W[PLAN + i] = 0.0


@jit_inlined
def accept(W: Vec) -> bool:
    """Certify the point at hand and keep it when it is below the tolerance."""
    residual = certificate(W)
    W[INFO + RESIDUAL] = residual
    if not residual < W[SETTING + TOLERANCE]:
        return False
    for i in range(N * INPUTS):
        W[PLAN + i] = W[U + i]
    return True


@jit_inlined
def search_inside(W: Vec) -> int:
    """Status after the interior point, each time closer to the optimum when its guess does not settle."""
    limit, polish = int(W[SETTING + ITERATION_LIMIT]), int(W[SETTING + POLISH])
    close, infeasibility = CLOSE, 1.0
    enter(W)
    for _ in range(ATTEMPTS):
        infeasibility, proved = approach(W, close, infeasibility, limit)
        if proved:
            return INFEASIBLE
        guess_from_sides(W)
        if settle(W, attempt(W, N - 1, False), polish) and accept(W):
            return OPTIMAL
        close *= CLOSER
    return LIMIT


@jit_inlined
def begin(W: Vec) -> int:
    """Check a problem and try the set at hand, which leaves in NEEDED how many changes it needs."""
    W[INFO + CHANGES] = W[INFO + FACTORISATIONS] = W[INFO + REFINEMENTS] = W[INFO + ITERATIONS] = 0.0
    W[INFO + HINTED] = 0.0
    if not well_posed(W):
        return INVALID
    condense_blocks(W)
    W[NEEDED] = attempt(W, N - 1, False) if W[SETTING + EXCHANGES] > 0.0 else STUCK
    return ASKING if W[OFFERED] == ON_REQUEST and 0.0 < W[NEEDED] < STUCK else UNDECIDED


@jit_inlined
def search(W: Vec) -> int:
    """Status of a well-posed problem whose set at hand has been tried."""
    exchanges = int(W[SETTING + EXCHANGES])
    if W[OFFERED] == GIVEN:
        W[NEEDED] = consider_hint(W, W[NEEDED])
    if settle(W, W[NEEDED], exchanges) and accept(W):
        return OPTIMAL
    if exchanges > 0 and impossible(W):
        return INFEASIBLE
    return search_inside(W)


@kernel
def predict_plan(W: Vec) -> None:
    """Put the states of all steps under the plan into STEP_STATE: where an extension linearises."""
    for i in range(N * INPUTS):
        W[U + i] = W[PLAN + i]
    rollout(W)
    states_within(W)


@kernel
def solve(W: Vec) -> int:
    """Solve the problem in the workspace; the answer is U, X, MULTIPLIER, and INFO says what it cost.

    Where it returns ASKING, the caller writes HINT and GIVEN, or REFUSED, and calls again.
    Without an answer the working set is forgotten and the plan stays, with its states in X.
    """
    status = UNDECIDED if W[OFFERED] == GIVEN or W[OFFERED] == REFUSED else begin(W)
    if status == ASKING:
        return status
    if status == UNDECIDED:
        status = search(W)
    W[INFO + STATUS] = status
    W[OFFERED] = 0.0
    if status != OPTIMAL:
        for i in range(ROWS):
            W[SET + i] = 0.0
            W[MULTIPLIER + i] = 0.0
        predict_plan(W)
    return status
