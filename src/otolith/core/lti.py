"""Linear time-invariant models: exact discretisation and prediction over a horizon.

Notation: ẋ = A x + B u; x⁺ = A_d x + B_d u with u held; N horizon; X = Φ x₀ + Γ U stacks
x_1 … x_N and u_0 … u_{N−1}, stage by stage.
"""

import numpy as np
from scipy.linalg import expm

from otolith.core.arrays import Mat


def zero_order_hold(A: Mat, B: Mat, period: float) -> tuple[Mat, Mat]:
    """Exact (A_d, B_d) for inputs held over `period` [s] (Van Loan, 1978).

    Parameters
    ----------
    A : (nx, nx); B : (nx, nu), of the continuous-time model.
    """
    nx, nu = B.shape
    exponential = expm(np.block([[A, B], [np.zeros((nu, nx + nu))]]) * period)
    return exponential[:nx, :nx].copy(), exponential[:nx, nx:].copy()


def condense(A: Mat, B: Mat, horizon: int) -> tuple[Mat, Mat]:
    """Prediction matrices Φ (N, nx, nx) and Γ (N, nx, N·nu) of x⁺ = A x + B u.

    Row k − 1 predicts x_k: x_k = Φ[k−1] x₀ + Γ[k−1] U with U (N·nu,) the inputs stage by stage.
    """
    nx, nu = B.shape
    Phi = np.empty((horizon, nx, nx))
    Gamma = np.zeros((horizon, nx, horizon, nu))
    power, response = np.eye(nx), B
    for k in range(horizon):
        for j in range(horizon - k):
            Gamma[j + k, :, j, :] = response  # Aᵏ B: the effect of u_j on x_{j+k+1}
        power, response = A @ power, A @ response
        Phi[k] = power
    return Phi, Gamma.reshape(horizon, nx, horizon * nu)
