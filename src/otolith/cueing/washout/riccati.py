"""The LQ problem of the optimal washout, for an axis pair or a single axis, and its filter W(s).

Notation (thesis, eq. 2.5; Sivan et al., 1982; Telban & Cardullo, NASA CR-2005-213747): drive u_a and
simulator u_s are [rate, force] and [rate, acceleration]; θ tilt; v, s, ∫s travel. The driver in the car feels
u_a, the one in the simulator the rate and a + g θ. Both have the same canals and otoliths, so only the
difference x_e of their states matters. With e the difference of what is perceived,

    x_e' = A_v x_e + B_v (u_a − C_θ θ − u_s),   e = C_v x_e + D_v (u_a − C_θ θ − u_s),
    s' = v, v' = a, (∫s)' = s, θ' = ω,          u_a' = −Γ u_a + white noise,
    J = E ∫ eᵀQ e + x_dᵀ R_d x_d + u_sᵀ R u_s,  x_d = (∫s, s, v, θ).

In z = (x_e, x_d, u_a) this is LQ with a cross term. P solves its Riccati equation and u_s = −K z; since u_a
is the reference itself, K z is a filter from u_a to u_s: W(s). It is checked against the spectral
factorisation (return-difference identity), which uses no Riccati equation, and by perturbing K.

The nonlinear variant requires that the excursion decay faster by e^(−αt): A + αI replaces A for x_d (after
Anderson & Moore's prescribed degree of stability), and α grows with the excursion. The states of the organs
are unchanged. Shifting them too would require the platform to accelerate the adaptation of the canals, 1/80
s⁻¹ with Telban's: gains would grow without use from α = 0.05 on, a hundredfold at 0.3. With x_d alone, the
poles of the excursion move left by about α and the others stay. That every closed loop of the grid is stable
is checked, not implied by the theorem.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from scipy.linalg import block_diag, solve_continuous_are

from otolith.core.arrays import Mat
from otolith.core.frames import GRAVITY
from otolith.core.lti import StateSpace, diagonal
from otolith.cueing.washout.tuning import Optimal
from otolith.perception import Vestibular

TRAVEL: Final = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]])  # of (∫s, s, v)


@dataclass(frozen=True, slots=True, kw_only=True)
class LqProblem:
    """The system z' = A z + B u_s with z = (states, u_a), and the cost zᵀQz + 2 zᵀN u_s + u_sᵀR u_s."""

    A: Mat  # (n + m, n + m)
    B: Mat  # (n + m, m)
    Q: Mat  # (n + m, n + m)
    N: Mat  # (n + m, m)
    R: Mat  # (m, m)
    rows: dict[str, int]  # index of the states of the motion: "tilt", "integral", "position", "velocity"

    @property
    def inputs(self) -> int:
        """Return m: one for rotation and one for translation, if present."""
        return int(self.R.shape[0])

    def gain(self, alpha: float = 0.0) -> Mat:
        """Return K (m, n + m) of u_s = −K z, for a degree of stability α [1/s]."""
        shift = np.zeros(len(self.A))
        shift[list(self.rows.values())] = alpha
        P = solve_continuous_are(self.A + np.diag(shift), self.B, self.Q, self.R, s=self.N)
        return np.asarray(np.linalg.solve(self.R, self.B.T @ P + self.N.T), dtype=np.float64)

    def closed(self, K: Mat) -> StateSpace:
        """Return the closed loop from u_a (m,) to all states (n,) followed by u_s (m,)."""
        n = len(self.A) - self.inputs
        A = self.A[:n, :n] - self.B[:n] @ K[:, :n]
        B = self.A[:n, n:] - self.B[:n] @ K[:, n:]
        return StateSpace(
            A=A,
            B=B,
            C=np.vstack([np.eye(n), -K[:, :n]]),
            D=np.vstack([np.zeros((n, self.inputs)), -K[:, n:]]),
        )

    def filter(self, alpha: float = 0.0) -> StateSpace:
        """Return W(s), from u_a = [rate, force] to u_s = [rate, acceleration], or to the one that exists."""
        closed = self.closed(self.gain(alpha))
        n = closed.sizes[0]
        return replace(closed, C=closed.C[n:], D=closed.D[n:])


def lq_problem(tuning: Optimal, senses: Vestibular, *, rotates: bool, translates: bool) -> LqProblem:
    """Return the problem of an axis pair (both true), of yaw (rotates) or of heave (translates)."""
    organs = [senses.canal] * rotates + [senses.otolith] * translates
    head = diagonal(*organs)
    moving = [np.zeros((1, 1))] * rotates + [TRAVEL] * translates
    motion = block_diag(*moving)
    into = block_diag(*([np.ones((1, 1))] * rotates + [np.eye(3)[:, 2:]] * translates))
    m, n_e, n_d = len(organs), head.sizes[0], len(motion)
    tilting = np.zeros((m, n_d))  # C_θ: contribution of the tilt to what is felt
    if rotates and translates:
        tilting[1, 0] = GRAVITY

    A = np.zeros((n_e + n_d + m, n_e + n_d + m))
    A[:n_e] = np.hstack([head.A, -head.B @ tilting, head.B])
    A[n_e : n_e + n_d, n_e : n_e + n_d] = motion
    noise = [tuning.rate_noise_radps] * rotates + [tuning.force_noise_radps] * translates
    A[n_e + n_d :, n_e + n_d :] = -np.diag(noise)
    B = np.vstack([-head.B, into, np.zeros((m, m))])

    E = np.hstack([head.C, -head.D @ tilting, head.D])  # e = E z − D_v u_s
    weight = np.diag([tuning.sensed_rate] * rotates + [tuning.sensed_force] * translates)
    of_motion = [tuning.tilt] * rotates
    of_motion += [tuning.integral, tuning.position, tuning.velocity] * translates
    of_inputs = [tuning.rate] * rotates + [tuning.acceleration] * translates
    names = ["tilt"] * rotates + ["integral", "position", "velocity"] * translates
    return LqProblem(
        A=A,
        B=B,
        Q=E.T @ weight @ E + block_diag(np.zeros((n_e, n_e)), np.diag(of_motion), np.zeros((m, m))),
        N=-E.T @ weight @ head.D,
        R=np.diag(of_inputs) + head.D.T @ weight @ head.D,
        rows={name: n_e + i for i, name in enumerate(names)},
    )
