"""The Riccati recursion over a long horizon, compiled. Its time and memory grow linearly with N.

One Newton step of the interior-point method is a linear-quadratic problem without constraints,

    min Σ_k ½ [dx_k; du_k]ᵀ H_k [dx_k; du_k] + h_kᵀ [dx_k; du_k] + ½ dx_Nᵀ Q_N dx_N + q_Nᵀ dx_N
    s.t. dx_{k+1} = A dx_k + B du_k, dx_0 = 0,

which dynamic programming solves (Rao, Wright & Rawlings, 1998). With P the Hessian of the cost from x_{k+1}
on, F = R + BᵀPB = L Lᵀ and G = S + BᵀPA, the step is du = −F⁻¹ (G dx + …) and P ← Q + AᵀPA − GᵀF⁻¹G.
"""

import math

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.jit import jit_allocating, jit_entry


@jit_entry
def factorise(A: Mat, B: Mat, H: Mat, last: Mat, gains: Mat, factors: Mat) -> bool:
    """Write the gains F⁻¹G (N, nu, nx) and factors L (N, nu, nu); return False if some F is not positive.

    Parameters
    ----------
    H : (N, nx + nu, nx + nu) Hessians in (x_k, u_k).
    last : (nx, nx) Hessian in x_N.
    """
    nx, nu = B.shape
    P, PA, PB = last.copy(), np.empty((nx, nx)), np.empty((nx, nu))
    for k in range(len(H) - 1, -1, -1):
        for i in range(nx):
            for j in range(nx):
                PA[i, j] = 0.0
            for j in range(nu):
                PB[i, j] = 0.0
            for m in range(nx):
                value = P[i, m]
                for j in range(nx):
                    PA[i, j] += value * A[m, j]
                for j in range(nu):
                    PB[i, j] += value * B[m, j]
        L, K = factors[k], gains[k]
        for i in range(nu):
            for j in range(nx):
                total = H[k, nx + i, j]
                for m in range(nx):
                    total += B[m, i] * PA[m, j]
                K[i, j] = total  # G, for now
            for j in range(i + 1):
                total = H[k, nx + i, nx + j]
                for m in range(nx):
                    total += B[m, i] * PB[m, j]
                for m in range(j):
                    total -= L[i, m] * L[j, m]
                if i == j:
                    if not total > 0.0:
                        return False
                    L[i, i] = math.sqrt(total)
                else:
                    L[i, j] = total / L[j, j]
        for i in range(nu):  # L⁻¹G
            for j in range(nx):
                total = K[i, j]
                for m in range(i):
                    total -= L[i, m] * K[m, j]
                K[i, j] = total / L[i, i]
        for i in range(nx):
            for j in range(i + 1):
                total = H[k, i, j]
                for m in range(nx):
                    total += A[m, i] * PA[m, j]
                for m in range(nu):
                    total -= K[m, i] * K[m, j]
                P[i, j] = P[j, i] = total
        for i in range(nu - 1, -1, -1):  # F⁻¹G
            for j in range(nx):
                total = K[i, j]
                for m in range(i + 1, nu):
                    total -= L[m, i] * K[m, j]
                K[i, j] = total / L[i, i]
    return True


@jit_entry
def solve(A: Mat, B: Mat, gains: Mat, factors: Mat, h: Mat, last: Vec, dX: Mat, dU: Mat) -> None:
    """Write the step dX (N + 1, nx), dU (N, nu), from the factors of `factorise`.

    Parameters
    ----------
    h : (N, nx + nu) gradients in (x_k, u_k).
    last : (nx,) gradient in x_N.
    """
    nx, nu = B.shape
    p, of_u = last.copy(), np.empty(nu)
    before = np.empty(nx)
    for k in range(len(h) - 1, -1, -1):
        K, L = gains[k], factors[k]
        for i in range(nu):
            of_u[i] = h[k, nx + i]
            for m in range(nx):
                of_u[i] += B[m, i] * p[m]
        for j in range(nx):
            before[j] = h[k, j]
            for m in range(nx):
                before[j] += A[m, j] * p[m]
            for m in range(nu):
                before[j] -= K[m, j] * of_u[m]
        for j in range(nx):
            p[j] = before[j]
        for i in range(nu):
            for m in range(i):
                of_u[i] -= L[i, m] * of_u[m]
            of_u[i] /= L[i, i]
        for i in range(nu - 1, -1, -1):
            for m in range(i + 1, nu):
                of_u[i] -= L[m, i] * of_u[m]
            of_u[i] /= L[i, i]
        for i in range(nu):
            dU[k, i] = -of_u[i]
    for j in range(nx):
        dX[0, j] = 0.0
    for k in range(len(h)):
        for i in range(nu):
            for m in range(nx):
                dU[k, i] -= gains[k, i, m] * dX[k, m]
        move(A, B, dX[k], dU[k], dX[k + 1])


@jit_allocating
def move(A: Mat, B: Mat, x: Vec, u: Vec, after: Vec) -> None:
    """Write A x + B u."""
    for i in range(len(A)):
        total = 0.0
        for j in range(A.shape[1]):
            total += A[i, j] * x[j]
        for j in range(B.shape[1]):
            total += B[i, j] * u[j]
        after[i] = total


@jit_entry
def roll(A: Mat, B: Mat, U: Mat, X: Mat) -> None:
    """Write the states X (N + 1, nx) that follow from X[0] under the inputs U (N, nu)."""
    for k in range(len(U)):
        move(A, B, X[k], U[k], X[k + 1])
