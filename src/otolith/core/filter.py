"""Run a discrete-time system sample by sample; the filter keeps the state between samples."""

from typing import Self

import numpy as np

from otolith.core.arrays import Mat, Vec, frozen_array
from otolith.core.jit import kernel
from otolith.core.lti import StateSpace


class Filter:
    """A discrete-time system that processes samples one by one, or a whole series at once.

    At each sample y_k = C x_k + D u_k, then x_{k+1} = A x_k + B u_k. For a system made by
    `StateSpace.discretise`, y_k is therefore the continuous output at the sample's own instant.

    Examples
    --------
    >>> lag = StateSpace.from_polynomials([1.0], [0.5, 1.0]).discretise(0.01)
    >>> bool(abs(Filter(lag).at_rest(np.array([2.0])).step(np.array([2.0]))[0] - 2.0) < 1e-12)
    True
    """

    def __init__(self, system: StateSpace) -> None:
        if system.period is None:
            raise ValueError("a filter needs a discrete system: discretise it first")
        self._system = system
        self._x = np.zeros(system.sizes[0])

    @property
    def state(self) -> Vec:
        """A copy of the state (nx,)."""
        return self._x.copy()

    @state.setter
    def state(self, x: Vec) -> None:
        self._x = np.array(x, dtype=np.float64).reshape(self._x.shape)

    def reset(self, u: Vec | None = None) -> None:
        """Start from the zero state, or from the steady state under the constant input u (nu,).

        Raises
        ------
        NoSteadyState : the system integrates this input.
        """
        self._x = np.zeros_like(self._x) if u is None else self._system.steady_state(u)

    def at_rest(self, u: Vec) -> Self:
        """Reset to the steady state under the input u (nu,) and return the filter itself."""
        self.reset(u)
        return self

    def step(self, u: Vec) -> Vec:
        """Return the output (ny,) at this sample under the input u (nu,), and advance the state by one
        sample.
        """
        y = np.empty(len(self._system.D))
        s = self._system
        advance(s.A, s.B, s.C, s.D, self._x, frozen_array(u)[None, :], y[None, :])
        return y

    def simulate(self, u: Mat) -> Mat:
        """Return the outputs (n, ny) under the inputs u (n, nu); the result equals n calls of `step`."""
        y = np.empty((len(u), len(self._system.D)))
        s = self._system
        advance(s.A, s.B, s.C, s.D, self._x, frozen_array(u), y)
        return y


@kernel
def advance(A: Mat, B: Mat, C: Mat, D: Mat, x: Vec, u: Mat, y: Mat) -> None:
    """Write the outputs y (n, ny) under the inputs u (n, nu); x (nx,) is overwritten with the last state."""
    nx, ny, nu = x.shape[0], y.shape[1], u.shape[1]
    after = np.empty(nx)
    for k in range(u.shape[0]):
        for i in range(ny):
            total = 0.0
            for j in range(nx):
                total += C[i, j] * x[j]
            for j in range(nu):
                total += D[i, j] * u[k, j]
            y[k, i] = total
        for i in range(nx):
            total = 0.0
            for j in range(nx):
                total += A[i, j] * x[j]
            for j in range(nu):
                total += B[i, j] * u[k, j]
            after[i] = total
        for i in range(nx):
            x[i] = after[i]
