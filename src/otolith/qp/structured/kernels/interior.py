"""Cold primal-dual interior point (Mehrotra, 1992), used when no guess of the working set settles.

Each row is split into two one-sided rows, or *sides*. With d the distance to the side (u − r or r − l),

    d = t − σ,   t λ = 0,   σ ν = 0,   λ + ν = w,   t, σ, λ, ν ≥ 0,

where σ is the violation of a soft row and w its penalty; a hard row has w = 1e10, which leaves σ no room.
Newton's method on this with t λ = m₁, σ ν = m₂ and dt, dσ, dν eliminated gives, at the new distance d⁺,

    dλ = δ (m₁/λ − m₂/ν − d⁺),   δ = 1 / (t/λ + σ/ν),
    dt = m₁/λ − t (1 + q),       dσ = m₂/ν − σ (1 − p),       q = dλ/λ,   p = dλ/ν,

so that a side enters the stage problem with weight δ and the gradient λ + δ (m₁/λ − m₂/ν − d⁺): the Riccati
recursion need not know whether a row is soft. Predictor: m₁ = m₂ = 0. Corrector: m₁ = τ − dt dλ, m₂ = τ − dσ
dν. In the workspace the upper sides of all rows come first, then the lower sides.
"""

from otolith.core.arrays import Vec
from otolith.qp.structured.kernels.certify import impossible
from otolith.qp.structured.kernels.kernel_symbols import (
    ACCUMULATOR,
    DELTA,
    DIAGONAL,
    DISTANCE,
    E1,
    E2,
    GRADIENT,
    HI,
    HUGE,
    INFO,
    INPUTS,
    INV_LAMBDA,
    INV_NU,
    LAMBDA,
    LANES,
    LO,
    MULTIPLIER,
    NU,
    PLAN,
    ROWS,
    SET,
    SIGMA,
    SOFT,
    VALUE,
    N,
    T,
    U,
    backward,
    factor,
    forward,
    jit_fused,
    jit_inlined,
    rollout,
    stationarity,
)
from otolith.qp.structured.kernels.reductions import clear_lanes, fold_maximum, fold_sum, largest, smallest

ITERATIONS = 0

# --- pasted into the generated module ---

SIDES = 2 * ROWS
MARGIN = 0.1  # smallest initial t, relative to the distance between the two sides
COMPLEMENTARITY = 0.1  # initial t λ for a problem whose multipliers are about one
TO_THE_WALL = 0.995  # part of the step to the boundary that is taken
CLOSE = 1e-7  # the iteration ends at this mean complementarity and part of the initial infeasibility
CLOSER = 1e-2  # factor on both, each time that a working set guessed from them does not settle
SHORT = 0.8  # shorter steps raise the question whether the problem is feasible at all


@jit_fused
def distances(W: Vec) -> None:
    """Compute the distances d of all sides from the rows' values."""
    for i in range(ROWS):
        W[DISTANCE + i] = W[HI + i] - W[VALUE + i]
    for i in range(ROWS):
        W[DISTANCE + ROWS + i] = W[VALUE + i] - W[LO + i]


@jit_fused
def start_sides(W: Vec, mu: float) -> None:
    """Initialise t, σ, λ, ν in the interior near the current point, with t λ and σ ν about µ."""
    distances(W)
    for side in range(2):
        for r in range(ROWS):
            i = side * ROWS + r
            margin = MARGIN * smallest(W[HI + r] - W[LO + r] + 1e-6, 2.0)
            t = largest(W[DISTANCE + i], margin)
            lam = smallest(mu / t, 0.5 * W[SOFT + r])
            nu = W[SOFT + r] - lam
            W[T + i], W[LAMBDA + i], W[NU + i] = t, lam, nu
            W[SIGMA + i] = mu / nu
            W[E1 + i] = 0.0
            W[E2 + i] = 0.0


@jit_fused
def weigh_sides(W: Vec) -> float:
    """Compute δ and the reciprocals for all sides, the sides' weights in the stage problem; return Σ t λ
    + σ ν.
    """
    clear_lanes(W)
    for block in range(SIDES // LANES):
        for j in range(LANES):
            i = block * LANES + j
            inv_lam, inv_nu = 1.0 / W[LAMBDA + i], 1.0 / W[NU + i]
            W[INV_LAMBDA + i], W[INV_NU + i] = inv_lam, inv_nu
            W[DELTA + i] = 1.0 / (W[T + i] * inv_lam + W[SIGMA + i] * inv_nu)
            W[ACCUMULATOR + LANES + j] += W[T + i] * W[LAMBDA + i] + W[SIGMA + i] * W[NU + i]
    for i in range(ROWS):
        W[DIAGONAL + i] = W[DELTA + i] + W[DELTA + ROWS + i]
    return fold_sum(W)


@jit_fused
def pull_of_sides(W: Vec, corrected: float) -> None:
    """Compute the rows' gradient at r = 0: λ + δ (e − d) of the upper sides minus that of the lower ones."""
    for i in range(ROWS):
        up = corrected * (W[E1 + i] - W[E2 + i]) - W[HI + i]
        down = corrected * (W[E1 + ROWS + i] - W[E2 + ROWS + i]) + W[LO + i]
        up = W[LAMBDA + i] + W[DELTA + i] * up
        down = W[LAMBDA + ROWS + i] + W[DELTA + ROWS + i] * down
        W[GRADIENT + i] = up - down


@jit_fused
def predict(W: Vec) -> tuple[float, float]:
    """Compute the affine step; return its largest relative decrease, and its sum of dt dλ + dσ dν."""
    distances(W)
    clear_lanes(W)
    for block in range(SIDES // LANES):
        for j in range(LANES):
            i = block * LANES + j
            dlam = -W[DELTA + i] * W[DISTANCE + i]
            q, p = dlam * W[INV_LAMBDA + i], dlam * W[INV_NU + i]
            worst = largest(largest(-q, 1.0 + q), largest(p, 1.0 - p))
            W[ACCUMULATOR + j] = largest(W[ACCUMULATOR + j], worst)
            tq, sp = W[T + i] * q * (1.0 + q), W[SIGMA + i] * p * (1.0 - p)
            W[E1 + i], W[E2 + i] = tq, -sp  # −dt dλ/λ and −dσ dν/ν
            W[ACCUMULATOR + LANES + j] += sp * W[NU + i] - tq * W[LAMBDA + i]
    return fold_maximum(W), fold_sum(W)


@jit_fused
def correct(W: Vec, tau: float) -> None:
    """Compute m₁/λ and m₂/ν with the centring parameter τ."""
    for i in range(SIDES):
        W[E1 + i] += tau * W[INV_LAMBDA + i]
        W[E2 + i] += tau * W[INV_NU + i]
    pull_of_sides(W, 1.0)


@jit_fused
def decrease(W: Vec) -> float:
    """Return the largest relative decrease of the full step; dλ is stored in the distances' SCRATCH."""
    distances(W)
    clear_lanes(W)
    for block in range(SIDES // LANES):
        for j in range(LANES):
            i = block * LANES + j
            dlam = W[DELTA + i] * (W[E1 + i] - W[E2 + i] - W[DISTANCE + i])
            q, p = dlam * W[INV_LAMBDA + i], dlam * W[INV_NU + i]
            of_t = 1.0 + q - W[E1 + i] / W[T + i]
            of_sigma = 1.0 - p - W[E2 + i] / W[SIGMA + i]
            worst = largest(largest(-q, of_t), largest(p, of_sigma))
            W[ACCUMULATOR + j] = largest(W[ACCUMULATOR + j], worst)
            W[DISTANCE + i] = dlam
    return fold_maximum(W)


@jit_fused
def advance(W: Vec, alpha: float) -> None:
    """Take a step of length α in t, σ, λ, ν."""
    for i in range(SIDES):
        dlam = W[DISTANCE + i]
        q, p = dlam * W[INV_LAMBDA + i], dlam * W[INV_NU + i]
        W[T + i] += alpha * (W[E1 + i] - W[T + i] * (1.0 + q))
        W[SIGMA + i] += alpha * (W[E2 + i] - W[SIGMA + i] * (1.0 - p))
        W[LAMBDA + i] += alpha * dlam
        W[NU + i] -= alpha * dlam


@jit_inlined
def newton(W: Vec, mu: float) -> float:
    """Take one predictor-corrector step and return its length."""
    pull_of_sides(W, 0.0)
    factor(W, N - 1)
    forward(W)
    steepest, second_order = predict(W)
    alpha = 1.0 / largest(steepest, 1.0)
    reached = (mu * (1.0 - alpha) + alpha * alpha * second_order) / mu
    correct(W, reached * reached * reached * mu / (2 * SIDES))
    backward(W, 0)
    forward(W)
    alpha = smallest(1.0, TO_THE_WALL / largest(decrease(W), 1e-300))
    advance(W, alpha)
    return alpha


@jit_fused
def guess_from_sides(W: Vec) -> None:
    """Guess working set and multipliers from the sides' values."""
    for i in range(ROWS):
        j = ROWS + i
        up = (2.0 if W[SIGMA + i] > W[NU + i] else 1.0) if W[LAMBDA + i] > W[T + i] else 0.0
        down = (2.0 if W[SIGMA + j] > W[NU + j] else 1.0) if W[LAMBDA + j] > W[T + j] else 0.0
        W[SET + i] = up if up > down else -down
        W[MULTIPLIER + i] = W[LAMBDA + i] if up > down else (-W[LAMBDA + j] if down > 0.0 else 0.0)


@jit_fused
def net_multipliers(W: Vec) -> None:
    """Compute the multipliers y = λ_upper − λ_lower of all rows."""
    for i in range(ROWS):
        W[MULTIPLIER + i] = W[LAMBDA + i] - W[LAMBDA + ROWS + i]


@jit_inlined
def enter(W: Vec) -> None:
    """Start in the interior near the plan; the cost's gradient there sets the scale of the multipliers."""
    for i in range(N * INPUTS):
        W[U + i] = W[PLAN + i]
    for i in range(ROWS):
        W[GRADIENT + i] = 0.0
    rollout(W)
    steepest, _, _ = stationarity(W)
    start_sides(W, COMPLEMENTARITY * largest(1.0, steepest))


@jit_inlined
def approach(W: Vec, close: float, infeasibility: float, limit: int) -> tuple[float, bool]:
    """Iterate until `close`; return the part of the initial infeasibility left, and whether infeasibility is
    proved.

    INFO counts the iterations, at most `limit` over all calls of one solve.
    """
    while W[INFO + ITERATIONS] < limit:
        mu = weigh_sides(W)
        if not mu < HUGE or (mu < close * 2 * SIDES and infeasibility < close):
            break
        alpha = newton(W, mu)
        infeasibility *= 1.0 - alpha
        W[INFO + ITERATIONS] += 1.0
        if alpha < SHORT:
            net_multipliers(W)
            if impossible(W):
                return infeasibility, True
    return infeasibility, False
