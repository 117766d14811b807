"""The LQ filter against derivations that know no Riccati equation."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import solve_continuous_lyapunov

from otolith.core.frames import GRAVITY
from otolith.cueing.washout.riccati import lq_problem
from otolith.cueing.washout.tuning import Optimal, load_tuning, tunings
from otolith.perception import Vestibular

KINDS = {"pair": (True, True), "yaw": (True, False), "heave": (False, True)}
EVERY = pytest.mark.parametrize("kind", KINDS)
OMEGA = np.array([0.02, 0.1, 0.5, 1.0, 3.0, 10.0, 40.0])


def shipped(name: str) -> Optimal:
    tuning = load_tuning(name).optimal
    assert tuning is not None
    return tuning


def problem(kind: str, name: str = "davsi"):
    rotates, translates = KINDS[kind]
    return lq_problem(shipped(name), Vestibular(), rotates=rotates, translates=translates)


@EVERY
def test_the_gain_factors_the_spectrum(kind: str) -> None:
    """(I + K Φ B)* R (I + K Φ B) = R + NᵀΦB + (NᵀΦB)* + (ΦB)* Q ΦB with Φ = (jωI − A)⁻¹ (Kalman, 1964)."""
    p = problem(kind)
    K = p.gain()
    for omega in OMEGA:
        Phi_B = np.linalg.solve(1j * omega * np.eye(len(p.A)) - p.A, p.B)
        left = np.eye(p.inputs) + K @ Phi_B
        right = p.R + p.N.T @ Phi_B + (p.N.T @ Phi_B).conj().T + Phi_B.conj().T @ p.Q @ Phi_B
        assert_allclose(left.conj().T @ p.R @ left, right, rtol=1e-6, atol=1e-9 * np.abs(right).max())


@EVERY
def test_w_is_the_feedback_solved_in_the_frequency_domain(kind: str) -> None:
    """u_s = −K (x, u_a) with x = (jω − A_xx)⁻¹ (A_xa u_a + B u_s), solved for u_s directly."""
    p = problem(kind)
    K, n = p.gain(), len(p.A) - p.inputs
    W = p.filter().frequency_response(OMEGA)
    for k, omega in enumerate(OMEGA):
        resolvent = np.linalg.inv(1j * omega * np.eye(n) - p.A[:n, :n])
        direct = np.linalg.solve(
            np.eye(p.inputs) + K[:, :n] @ resolvent @ p.B[:n], -K[:, :n] @ resolvent @ p.A[:n, n:] - K[:, n:]
        )
        assert_allclose(W[k], direct, rtol=1e-7, atol=1e-9)


@EVERY
def test_no_other_gain_costs_less(kind: str) -> None:
    """E J per second by Lyapunov's equation for the noise-driven loop, at K and around it."""
    p = problem(kind)
    K = p.gain()
    noise = np.zeros((len(p.A), p.inputs))
    noise[-p.inputs :] = np.eye(p.inputs)

    def cost(K):
        X = solve_continuous_lyapunov(p.A - p.B @ K, -noise @ noise.T)
        return np.trace(X @ (p.Q - p.N @ K - K.T @ p.N.T + K.T @ p.R @ K))

    rng = np.random.default_rng(1)
    at_optimum = cost(K)
    assert at_optimum > 0.0
    for _ in range(20):
        assert cost(K * (1 + 1e-3 * rng.normal(size=K.shape))) >= at_optimum * (1 - 1e-9)


def test_a_drive_that_the_platform_can_follow_is_felt_as_wanted() -> None:
    """When motion costs next to nothing, a force is felt as wanted, and yaw, which no force needs, too."""
    cheap = shipped("davsi").model_copy(
        update=dict.fromkeys(["integral", "position", "velocity", "tilt", "acceleration", "rate"], 1e-7)
    )
    omega = np.array([0.3, 1.0, 3.0])
    W = lq_problem(cheap, Vestibular(), rotates=True, translates=True).filter().frequency_response(omega)
    felt = W[:, 1, 1] + GRAVITY * W[:, 0, 1] / (1j * omega)  # rows: rate, acceleration
    assert_allclose(np.abs(felt), 1.0, atol=0.02)
    yaw = lq_problem(cheap, Vestibular(), rotates=True, translates=False).filter().frequency_response(omega)
    assert_allclose(np.abs(yaw), 1.0, atol=0.02)


@EVERY
@pytest.mark.parametrize("name", tunings())
def test_travel_comes_home_and_every_loop_of_the_grid_is_stable(kind: str, name: str) -> None:
    p = problem(kind, name)
    for alpha in np.linspace(0.0, shipped(name).largest_alpha_per_s, 9):
        closed = p.closed(p.gain(alpha))
        assert closed.poles.real.max() < -1e-3
        rest = np.linalg.solve(closed.A, closed.B)
        if "position" in p.rows:
            assert_allclose(rest[p.rows["position"]], 0.0, atol=1e-9 * np.abs(rest).max())


def test_alpha_speeds_the_excursion_up_and_leaves_the_organs_alone() -> None:
    p = problem("pair")
    slow, fast = (np.sort(p.closed(p.gain(alpha)).poles.real) for alpha in (0.0, 0.5))
    moved = slow - fast
    assert_allclose(moved[[0, -1]], 0.0, atol=0.1)  # the otolith's fast pole, the canals' slow one
    assert np.count_nonzero(moved > 0.3) == 4  # ∫s, s, v and tilt
