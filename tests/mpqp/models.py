"""Parametric QPs for the tests: the explicit 2 DOF model of the thesis, and tiny random problems."""

import numpy as np

from otolith.mpqp.problem import ParametricQp

GRAVITY = 9.81
DEG = np.pi / 180


def double_integrators(period: float) -> tuple[np.ndarray, np.ndarray]:
    """Exact zero-order hold of tilt'' = a_rot, position'' = a_tran; x = [rate, tilt, velocity, position]."""
    A, B = np.eye(4), np.zeros((4, 2))
    for i, rate in enumerate((0, 2)):
        A[rate + 1, rate] = period
        B[rate : rate + 2, i] = period, period**2 / 2
    return A, B


def blocks_of(horizon: int, blocks: int | None) -> np.ndarray:
    """Input k is variable min(k, blocks - 1): T (2·horizon, 2·blocks)."""
    count = min(blocks or horizon, horizon)
    T = np.zeros((2 * horizon, 2 * count))
    for k in range(horizon):
        j = min(k, count - 1)
        T[2 * k : 2 * k + 2, 2 * j : 2 * j + 2] = np.eye(2)
    return T


def surge_pitch(
    horizon: int = 5,
    *,
    period: float = 0.1,
    blocks: int | None = None,
    limits: tuple[float, float, float, float] = (3 * DEG, 30 * DEG, 7.2, 0.5),
    acceleration: float = 9.81,
    reference: float = 20.0,
) -> ParametricQp:
    """Explicit 2 DOF MPC of the thesis (eqs. 4.1 to 4.3); θ = [rate, tilt, velocity, position, y_ref]."""
    A, B = double_integrators(period)
    T = blocks_of(horizon, blocks)
    N, n = horizon, T.shape[1]
    Phi, Gamma = np.eye(4), np.zeros((4, 2 * N))
    H, F = 2e-3 * T.T @ T, np.zeros((n, 5))
    G, w, S = [], [], []
    for k in range(N):
        y_z = (GRAVITY * Gamma[1] + np.eye(2 * N)[2 * k + 1]) @ T
        y_theta = np.append(GRAVITY * Phi[1], -1.0)
        H += 2 * np.outer(y_z, y_z)
        F += 2 * np.outer(y_z, y_theta)
        held = np.zeros((4, 2 * N))
        held[:, 2 * k : 2 * k + 2] = B
        Phi, Gamma = A @ Phi, A @ Gamma + held
        for i in range(4):
            for sign in (1.0, -1.0):
                G.append(sign * Gamma[i] @ T)
                w.append(limits[i])
                S.append(np.append(-sign * Phi[i], 0.0))
    for j in range(n // 2):
        for sign in (1.0, -1.0):
            G.append(sign * np.eye(n)[2 * j + 1])
            w.append(acceleration)
            S.append(np.zeros(5))
    top = np.append(limits, reference)
    return ParametricQp(
        H=H, F=F, f=np.zeros(n), G=np.array(G), w=np.array(w), S=np.array(S), lower=-top, upper=top
    )


def saturated_line() -> ParametricQp:
    """min ½ (z - θ)² with |z| ≤ 1 and |θ| ≤ 2: three regions, z = -1, θ, 1."""
    one = np.ones((1, 1))
    return ParametricQp(
        H=one, F=-one, f=np.zeros(1), G=np.vstack([one, -one]), w=np.ones(2), S=np.zeros((2, 1)),
        lower=np.array([-2.0]), upper=np.array([2.0]),
    )  # fmt: skip


def random_problem(seed: int, n: int, m: int, p: int) -> ParametricQp:
    """A generic problem without symmetry, feasible at θ = 0 with z = 0 strictly inside."""
    rng = np.random.default_rng(seed)
    root = rng.standard_normal((n, n))
    return ParametricQp(
        H=root @ root.T + 0.1 * np.eye(n),
        F=rng.standard_normal((n, p)),
        f=rng.standard_normal(n),
        G=rng.standard_normal((m, n)),
        w=rng.uniform(0.2, 1.5, m),
        S=0.5 * rng.standard_normal((m, p)),
        lower=-rng.uniform(0.5, 1.5, p),
        upper=rng.uniform(0.5, 1.5, p),
    )
