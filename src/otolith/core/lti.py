"""Linear time-invariant systems: composition, exact discretisation, prediction over a horizon.

Notation: ẋ = A x + B u, y = C x + D u in continuous time; x⁺ = A x + B u, y = C x + D u in discrete
time; N horizon; X = Φ x₀ + Γ U stacks x_1 … x_N and u_0 … u_{N−1}, stage by stage.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, Self

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag, expm

from otolith.core.arrays import Mat, Vec, freeze
from otolith.core.errors import InputError, OtolithError

REST_TOLERANCE = 1e-9  # largest residual of a steady state, relative to the size of its terms

Complexes = NDArray[np.complex128]


class NoSteadyState(OtolithError):
    """The system integrates its input, so it has no steady state."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StateSpace:
    """A linear system with nx states, nu inputs and ny outputs, in continuous or discrete time.

    Examples
    --------
    >>> lag = StateSpace.from_polynomials([1.0], [0.5, 1.0])
    >>> lag.poles
    array([-2.+0.j])
    """

    A: Mat  # (nx, nx)
    B: Mat  # (nx, nu)
    C: Mat  # (ny, nx)
    D: Mat  # (ny, nu)
    period: float | None = None  # [s] sampling period; None for continuous time

    def __post_init__(self) -> None:
        nx, (ny, nu) = np.shape(self.A)[0], np.shape(self.D)
        freeze(self, A=(nx, nx), B=(nx, nu), C=(ny, nx), D=(ny, nu))
        if self.period is not None and not 0.0 < self.period < np.inf:
            raise InputError("the period", f"{self.period} s", "greater than 0 s and finite")

    @classmethod
    def from_polynomials(cls, numerator: Sequence[float], denominator: Sequence[float]) -> Self:
        """Make a single-input, single-output continuous system in controllable canonical form.

        Parameters
        ----------
        numerator, denominator : coefficients of s, highest power first.

        Raises
        ------
        InputError : a coefficient is not finite, the denominator is zero, or the system would differentiate
            (numerator of higher degree than the denominator).
        """
        b, a = _polynomial(numerator, "numerator"), _polynomial(denominator, "denominator")
        n = len(a) - 1
        if not a.any():
            raise InputError("the transfer function's denominator", "zero", "another polynomial")
        if len(b) > len(a):
            raise InputError("the numerator's degree", len(b) - 1, f"at most the denominator's, {n}")
        a, b = a / a[0], np.concatenate([np.zeros(len(a) - len(b)), b]) / a[0]
        A = np.eye(n, k=-1)
        A[:1] = -a[1:]
        return cls(A=A, B=np.eye(n, 1), C=(b[1:] - b[0] * a[1:])[None, :], D=b[None, :1])

    @classmethod
    def gain(cls, D: Mat) -> Self:
        """Make the continuous-time system y = D u without a state, D (ny, nu)."""
        ny, nu = np.shape(D)
        return cls(A=np.zeros((0, 0)), B=np.zeros((0, nu)), C=np.zeros((ny, 0)), D=D)

    @property
    def sizes(self) -> tuple[int, int, int]:
        """Numbers of states, inputs and outputs (nx, nu, ny)."""
        return (*self.B.shape, self.C.shape[0])

    @property
    def poles(self) -> Complexes:
        """Eigenvalues of A (nx,) [1/s, or per sample in discrete time]."""
        return np.linalg.eigvals(self.A).astype(np.complex128)

    def discretise(self, period: float, hold: Literal["zero", "first"] = "zero") -> "StateSpace":
        """Discretise exactly for inputs that are constant ("zero") or linear ("first") between the samples.

        With a first-order hold the state is x − B₁ u, where x is the continuous state and B₁ the effect of
        the input at a period's end, so that no step needs the next input (Franklin, Powell & Workman, Digital
        Control of Dynamic Systems, 1998, section 6.3.2, the triangle hold).

        Raises
        ------
        ValueError : the system is already discrete, or the hold is unknown.
        """
        if self.period is not None or hold not in ("zero", "first"):
            raise ValueError(f"cannot discretise with hold {hold!r} a system of period {self.period}")
        if hold == "zero":
            A, B = zero_order_hold(self.A, self.B, period)
            return replace(self, A=A, B=B, period=period)
        A, B0, B1 = first_order_hold(self.A, self.B, period)
        return StateSpace(A=A, B=B0 + A @ B1, C=self.C, D=self.D + self.C @ B1, period=period)

    def frequency_response(self, omega: Vec) -> Complexes:
        """Evaluate C (λ I − A)⁻¹ B + D at λ = jω, or at λ = e^{jωT} in discrete time.

        Parameters
        ----------
        omega : (n,) [rad/s].

        Returns
        -------
        (n, ny, nu), complex.
        """
        lam = (1j * np.asarray(omega)).astype(np.complex128)
        if self.period is not None:
            lam = np.exp(lam * self.period)
        resolvent: Complexes = lam[:, None, None] * np.eye(len(self.A)) - self.A  # (n, nx, nx)
        rhs = np.broadcast_to(self.B, (len(lam), *self.B.shape))
        return (self.C @ np.linalg.solve(resolvent, rhs) + self.D).astype(np.complex128)

    def steady_state(self, u: Vec) -> Vec:
        """Return the steady state (nx,) under the constant input u (nu,), the smallest if there are many.

        Raises
        ------
        NoSteadyState : the system integrates this input.
        """
        M = self.A if self.period is None else self.A - np.eye(len(self.A))  # 0 = M x + B u
        push = self.B @ np.asarray(u, dtype=np.float64)
        x: Vec = np.linalg.lstsq(M, -push, rcond=None)[0].astype(np.float64)
        terms = np.abs(M) @ np.abs(x) + np.abs(push)
        if np.max(np.abs(M @ x + push), initial=0.0) > REST_TOLERANCE * np.max(terms, initial=0.0):
            raise NoSteadyState(
                f"the system integrates the input {np.asarray(u).tolist()} and never rests under it"
            )
        return x


def series(*systems: StateSpace) -> StateSpace:
    """Connect systems in series: the outputs of each are the inputs of the next, left to right."""
    joined = systems[0]
    for after in systems[1:]:
        _same_period(joined, after)
        corner = np.zeros((joined.sizes[0], after.sizes[0]))
        joined = replace(
            joined,
            A=np.block([[joined.A, corner], [after.B @ joined.C, after.A]]),
            B=np.vstack([joined.B, after.B @ joined.D]),
            C=np.hstack([after.D @ joined.C, after.C]),
            D=after.D @ joined.D,
        )
    return joined


def parallel(*systems: StateSpace) -> StateSpace:
    """Connect systems in parallel: all have the same inputs, and their outputs are added."""
    _same_period(*systems)
    return replace(
        systems[0],
        A=block_diag(*(s.A for s in systems)),
        B=np.vstack([s.B for s in systems]),
        C=np.hstack([s.C for s in systems]),
        D=sum((s.D for s in systems[1:]), systems[0].D),
    )


def diagonal(*systems: StateSpace) -> StateSpace:
    """Combine systems block-diagonally: each keeps its own inputs and outputs, in the order given."""
    _same_period(*systems)
    A, B, C, D = (block_diag(*(getattr(system, name) for system in systems)) for name in "ABCD")
    return replace(systems[0], A=A, B=B, C=C, D=D)


def zero_order_hold(A: Mat, B: Mat, period: float) -> tuple[Mat, Mat]:
    """Discretise ẋ = A x + B u exactly for inputs held constant over `period` [s] (Van Loan, 1978).

    Parameters
    ----------
    A : (nx, nx) and B : (nx, nu) of the continuous-time model.

    Returns
    -------
    A_d (nx, nx), B_d (nx, nu).
    """
    nx, nu = B.shape
    exponential = expm(np.block([[A, B], [np.zeros((nu, nx + nu))]]) * period)
    return exponential[:nx, :nx].copy(), exponential[:nx, nx:].copy()


def first_order_hold(A: Mat, B: Mat, period: float) -> tuple[Mat, Mat, Mat]:
    """Discretise exactly for inputs that are linear over `period` [s]: x⁺ = A_d x + B_0 u + B_1 u⁺.

    Parameters
    ----------
    A : (nx, nx) and B : (nx, nu) of the continuous-time model.

    Returns
    -------
    A_d (nx, nx), B_0 and B_1 (nx, nu).
    """
    nx, nu = B.shape
    M = np.zeros((nx + 2 * nu, nx + 2 * nu))  # acts on [x, u, (u⁺ − u)/T]; the last part is the slope of u
    M[:nx, :nx], M[:nx, nx : nx + nu], M[nx : nx + nu, nx + nu :] = A, B, np.eye(nu)
    exponential = expm(M * period)
    B1 = exponential[:nx, nx + nu :] / period
    return exponential[:nx, :nx].copy(), exponential[:nx, nx : nx + nu] - B1, B1


def condense(A: Mat, B: Mat, horizon: int) -> tuple[Mat, Mat]:
    """Prediction matrices Φ (N, nx, nx) and Γ (N, nx, N·nu) of x⁺ = A x + B u.

    Entry k − 1 predicts x_k = Φ[k−1] x₀ + Γ[k−1] U, where U (N·nu,) stacks the inputs stage by stage.
    """
    nx, nu = B.shape
    Phi = np.empty((horizon, nx, nx))
    Gamma = np.zeros((horizon, nx, horizon, nu))
    power, response = np.eye(nx), B
    for k in range(horizon):
        j = np.arange(horizon - k)
        Gamma[j + k, :, j, :] = response  # Aᵏ B: the effect of u_j on x_{j+k+1}
        power, response = A @ power, A @ response
        Phi[k] = power
    return Phi, Gamma.reshape(horizon, nx, horizon * nu)


def _polynomial(coefficients: Sequence[float], what: str) -> Vec:
    """Return the coefficients without leading zeros; the zero polynomial keeps one zero."""
    values = np.asarray(coefficients, dtype=np.float64)
    if values.ndim != 1 or not len(values) or not np.isfinite(values).all():
        raise InputError(f"the transfer function's {what}", list(coefficients), "finite coefficients")
    first = int(np.argmax(values != 0.0))
    return values[first:] if values.any() else values[:1]


def _same_period(*systems: StateSpace) -> None:
    periods = {system.period for system in systems}
    if len(periods) > 1:
        raise ValueError(f"systems of different periods cannot be joined: {periods}")
