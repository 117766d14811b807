"""A small closed loop that records real-time-iteration problems, in 2 and 4 DOF; a helper of the tests.

Per pair x = [ω θ v s a_tran a_rot], u = [a_rot a_tran] commanded, lagging by 10 ms; outputs
f = a_tran + g sin θ_long and a_tran + g cos θ_long sin θ_lat; braking rows; in 4 DOF the limit circle
s_long² + s_lat² ≤ 0.5² m², linearised.
"""

from collections.abc import Callable, Iterator

import numpy as np
from scipy.linalg import block_diag

from otolith.core.arrays import Mat, Vec
from otolith.core.lti import zero_order_hold
from otolith.qp.stage import StageProblem, StageQp, StageSolution, rollout

G, PERIOD, LAG, DEG = 9.81, 0.01, 0.01, np.pi / 180.0
RATE, TILT, SPEED, POSITION, FORCE, TILT_FORCE = range(6)
RADIUS = 0.5  # [m]


def _pair() -> tuple[Mat, Mat]:
    A, B = np.zeros((6, 6)), np.zeros((6, 2))
    A[TILT, RATE] = A[POSITION, SPEED] = A[RATE, TILT_FORCE] = A[SPEED, FORCE] = 1.0
    A[FORCE, FORCE] = A[TILT_FORCE, TILT_FORCE] = -1.0 / LAG
    B[FORCE, 1] = B[TILT_FORCE, 0] = 1.0 / LAG
    return zero_order_hold(A, B, PERIOD)


def _rows(pair_has_position_row: bool, rate: float) -> tuple[Mat, Vec]:
    """Rows of one pair and their symmetric bounds."""
    on = [RATE, TILT, SPEED, FORCE] + ([POSITION] if pair_has_position_row else [])
    reach = [rate * DEG, 30 * DEG, 7.2, 9.81, RADIUS][: len(on)]
    braking = np.zeros((2, 6))
    braking[0, [POSITION, SPEED, FORCE]] = 1.0, 2.5, 0.5 * 0.45 * 2.5**2
    braking[1, [TILT, RATE, TILT_FORCE]] = 1.0, 0.5, 0.5 * 0.45 * 0.5**2
    return np.vstack([np.eye(6)[on], braking]), np.array([*reach, RADIUS, 30 * DEG])


def stage_problem(dofs: int, horizon: int, soft: float = np.inf) -> tuple[StageProblem, Vec]:
    """The structure, and the constant bounds (rows,) of one stage; `soft` is the penalty of its soft rows."""
    pairs = dofs // 2
    A, B = _pair()
    made = [_rows(pairs == 1, rate) for rate in (3.0, 2.6)[:pairs]]
    C = block_diag(*[rows for rows, _ in made])
    bounds = np.concatenate([b for _, b in made])
    circle = np.zeros((pairs - 1, 6 * pairs), dtype=np.bool_)
    output = np.zeros((pairs, 6 * pairs), dtype=np.bool_)
    output[0, [TILT, FORCE]] = True
    if pairs == 2:
        circle[0, [POSITION, 6 + POSITION]] = True
        output[1, [TILT, 6 + TILT, 6 + FORCE]] = True
    inputs = np.full(2 * pairs, 5.0)
    limit = np.concatenate([bounds, np.zeros(len(circle)), inputs])
    weak = np.full(len(limit), np.inf)
    weak[: len(bounds)] = np.where(np.isin(bounds, [7.2, 9.81]), np.inf, soft)
    weak[len(bounds) : len(limit) - len(inputs)] = soft
    problem = StageProblem(
        horizon=horizon,
        A=block_diag(*[A] * pairs),
        B=np.vstack([block_diag(*[B] * pairs)]),
        C=C,
        output=output,
        varying=circle,
        weighted=tuple(6 * p + i for p in range(pairs) for i in (RATE, POSITION)),
        control_weight=np.full(2 * pairs, 1e-3),
        penalty=weak,
    )
    return problem, limit


def linearise(problem: StageProblem, limit: Vec, x0: Vec, plan: Mat, wanted: Vec) -> StageQp:
    """One Gauss-Newton problem about the inputs `plan` (N, nu)."""
    N, pairs = problem.horizon, problem.inputs // 2
    blank = StageQp(
        problem=problem,
        x0=x0,
        output=np.zeros((N, *problem.output.shape)),
        error=np.zeros((N, pairs)),
        state_weight=np.tile(_washout(x0), (N, 1)),
        state_linear=np.zeros((N, 2 * pairs)),
        input_linear=np.zeros((N, 2 * pairs)),
        varying=np.zeros((N, *problem.varying.shape)),
        lower=np.tile(-limit, (N, 1)),
        upper=np.tile(limit, (N, 1)),
    )
    X = rollout(blank, plan)
    D, e = blank.output, blank.error
    long = X[:, TILT]
    D[:, 0, TILT], D[:, 0, FORCE] = G * np.cos(long), 1.0
    force = [X[:, FORCE] + G * np.sin(long)]
    if pairs == 2:
        side = X[:, 6 + TILT]
        D[:, 1, TILT], D[:, 1, 6 + TILT] = -G * np.sin(long) * np.sin(side), G * np.cos(long) * np.cos(side)
        D[:, 1, 6 + FORCE] = 1.0
        force.append(X[:, 6 + FORCE] + G * np.cos(long) * np.sin(side))
        s = X[:, [POSITION, 6 + POSITION]]
        blank.varying[:, 0, [POSITION, 6 + POSITION]] = 2.0 * s
        row = len(problem.C)
        blank.lower[:, row] = -np.inf
        blank.upper[:, row] = RADIUS**2 + np.sum(s**2, axis=1)
    e[:] = np.array(force).T - np.einsum("kyi,ki->ky", D, X) - wanted
    return blank


def _washout(x0: Vec) -> Vec:
    weights = []
    for x in x0.reshape(-1, 6):
        for of, scale, w in ((RATE, 3.0 * DEG, (1e-4, 0.7)), (POSITION, 0.5, (0.01, 20.0))):
            r = abs(x[of]) / scale
            weights.append(w[0] + w[1] * (r + r**2 + r**4))
    return np.array(weights)


def closed_loop(
    problem: StageProblem,
    limit: Vec,
    references: Mat,
    solve: Callable[[StageQp], StageSolution],
) -> Iterator[tuple[StageQp, StageSolution]]:
    """Every problem of a run from rest with its answer; the plant is the model with an exact hold."""
    x, plan = np.zeros(problem.states), np.zeros((problem.horizon, problem.inputs))
    for wanted in references:
        qp = linearise(problem, limit, x, plan, wanted)
        solution = solve(qp)
        yield qp, solution
        plan = solution.U
        x = problem.A @ x + problem.B @ plan[0]


def multisine(steps: int, pairs: int, seed: int, amplitude: float = 1.0) -> Mat:
    """(steps, pairs) smooth references with jumps."""
    rng, t = np.random.default_rng(seed), np.arange(steps) * PERIOD
    signal = np.zeros((steps, pairs))
    for p in range(pairs):
        for f in rng.uniform(0.05, 2.0, 6):
            signal[:, p] += rng.uniform(0.1, 0.8) * np.sin(2 * np.pi * f * t + rng.uniform(0, 6))
        signal[:, p] += rng.uniform(-1, 1) * (t > rng.uniform(0, t[-1]))
    return amplitude * signal


STEP_2 = '''
import math

@kernel
def step(W, wanted):
    """Linearise f = a_tran + g sin θ about the plan, weigh the washout, solve."""
    predict_plan(W)
    r, q = abs(W[START]) / 0.05235987755982989, abs(W[START + 3]) / 0.5
    for k in range(N):
        tilt = W[X + 6*k + 1]
        slope = 9.81 * math.cos(tilt)
        W[OUTPUT + 2*k] = slope
        W[OUTPUT + 2*k + 1] = 1.0
        W[ERROR + k] = 9.81 * math.sin(tilt) - slope * tilt - wanted
        W[STATE_WEIGHT + 2*k] = 1e-4 + 0.7 * (r + r*r + r*r*r*r)
        W[STATE_WEIGHT + 2*k + 1] = 0.01 + 20.0 * (q + q*q + q*q*q*q)
    return solve(W)
'''
