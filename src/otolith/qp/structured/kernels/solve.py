"""Solve one problem per call: check, try the current working set, exchange rows, fall back, certify.

The certificate alone decides what is an answer. Where many active rows nearly depend on each other, as a
limit and its braking rows may, multipliers never settle to the last digit, or sets exchange such rows for
ever, although the point at hand is optimal within the tolerance. Then this point is the answer, or else the
point of the interior method, whose sides the working set was guessed from.

The minimiser never depends on the working set that is tried first; only the time does. If a hint is available
on request, `solve` returns ASKING when the current set does not settle at once, and is called again with the
hint (reverse communication). So a hint that is not needed is never made.
"""

from otolith.core.arrays import Vec
from otolith.qp.structured.kernels.certify import certificate, impossible, well_posed
from otolith.qp.structured.kernels.interior import (
    CLOSE,
    CLOSER,
    approach,
    enter,
    guess_from_sides,
    net_multipliers,
)
from otolith.qp.structured.kernels.kernel_symbols import (
    INFO,
    INPUTS,
    INSIDE,
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
from otolith.qp.structured.kernels.working import STUCK, attempt_all, consider_hint, settle

STATUS = RESIDUAL = CHANGES = FACTORISATIONS = REFINEMENTS = ITERATIONS = HINTED = 0
TOLERANCE = EXCHANGES = POLISH = ITERATION_LIMIT = 0
OPTIMAL = INFEASIBLE = LIMIT = INVALID = ASKING = UNDECIDED = 0
ON_REQUEST = REFUSED = GIVEN = 0

# --- pasted into the generated module ---

ATTEMPTS = (
    3  # largest number of interior points, each closer to the optimum, from which a working set is guessed
)


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
    """Certify the current point and keep it if its certificate is below the tolerance."""
    residual = certificate(W)
    W[INFO + RESIDUAL] = residual
    if not residual < W[SETTING + TOLERANCE]:
        return False
    for i in range(N * INPUTS):
        W[PLAN + i] = W[U + i]
    return True


@jit_inlined
def search_inside(W: Vec) -> int:
    """Run the interior point, closer to the optimum each time neither its guess nor its own point is
    certified; return the status.
    """
    limit, polish = int(W[SETTING + ITERATION_LIMIT]), int(W[SETTING + POLISH])
    close, infeasibility = CLOSE, 1.0
    enter(W)
    for _ in range(ATTEMPTS):
        infeasibility, proved = approach(W, close, infeasibility, limit)
        if proved:
            return INFEASIBLE
        for i in range(N * INPUTS):
            W[INSIDE + i] = W[U + i]
        guess_from_sides(W)
        settle(W, attempt_all(W), polish)
        for own in range(2):
            if own == 1:
                net_multipliers(W)
                for i in range(N * INPUTS):
                    W[U + i] = W[INSIDE + i]
            if accept(W):
                return OPTIMAL
        close *= CLOSER
    return LIMIT


@jit_inlined
def begin(W: Vec) -> int:
    """Check a problem and try the current working set; NEEDED stores how many changes it needs."""
    W[INFO + CHANGES] = W[INFO + FACTORISATIONS] = W[INFO + REFINEMENTS] = W[INFO + ITERATIONS] = 0.0
    W[INFO + HINTED] = 0.0
    if not well_posed(W):
        return INVALID
    condense_blocks(W)
    W[NEEDED] = attempt_all(W) if W[SETTING + EXCHANGES] > 0.0 else STUCK
    return ASKING if W[OFFERED] == ON_REQUEST and 0.0 < W[NEEDED] < STUCK else UNDECIDED


@jit_inlined
def search(W: Vec) -> int:
    """Continue with a well-posed problem whose current working set has been tried; return the status."""
    exchanges = int(W[SETTING + EXCHANGES])
    if W[OFFERED] == GIVEN:
        W[NEEDED] = consider_hint(W, W[NEEDED])
    if exchanges > 0:
        settle(W, W[NEEDED], exchanges)
        if accept(W):
            return OPTIMAL
        if impossible(W):
            return INFEASIBLE
    return search_inside(W)


@kernel
def predict_plan(W: Vec) -> None:
    """Write the states of all steps under the plan to STEP_STATE, about which an extension linearises."""
    for i in range(N * INPUTS):
        W[U + i] = W[PLAN + i]
    rollout(W)
    states_within(W)


@kernel
def solve(W: Vec) -> int:
    """Solve the problem in the workspace; the answer is in U, X and MULTIPLIER, the effort in INFO.

    If it returns ASKING, the caller writes HINT and GIVEN, or REFUSED, and calls again. Without an answer the
    working set is forgotten, and the plan stays, with its states in X.
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
